//! Building wide hierarchies over many boxes at once.
//!
//! In two steps: a binary hierarchy, from the root down or from the leaves up, and its
//! collapse into nodes of eight children, along a plan of what costs least. At the bottom of a binary
//! hierarchy a few items lie in a bag, untold apart: they become one leaf, or the eight lanes of one node.

mod binned_sah;
mod collapse;
mod cost;
mod extents;
mod morton;
mod nearest;
mod plan;
mod ploc;
mod radix_sort;
mod tagged_box;
#[cfg(test)]
mod tests;
mod top_down;
mod z_order;

use std::{mem, ops::Range};

pub(crate) use cost::sah_cost;
pub(crate) use tagged_box::BuildItem;

use self::{collapse::Collapse, plan::Plan, ploc::Ploc, tagged_box::BinaryNode, top_down::Split, z_order::ZOrder};
use super::wide::{LANES, NodeIndex, WideNode};

/// How a hierarchy is built: all give the same answers, some of them sooner.
///
/// Measured over 100 000 boxes on one thread, uniform / a flat and clustered city / sizes from 0.01 to 10: the time to build, the
/// surface area cost (the areas of all boxes over that of the whole), and the nodes that a random ray visits to find the closest box.
///
/// | strategy | build, ns a box | cost | visits |
/// |---|---|---|---|
/// | [`MiddleSplit`](Self::MiddleSplit) | 58 / 66 / 61 | 47.3 / 6.98 / 231 | 19.8 / 9.1 / 25.0 |
/// | [`MedianSplit`](Self::MedianSplit) | 104 / 101 / 105 | 49.3 / 8.45 / 229 | 20.5 / 11.1 / 24.6 |
/// | [`BinnedSah`](Self::BinnedSah) | 437 / 380 / 409 | 45.3 / 6.63 / 208 | 19.0 / 8.0 / 21.5 |
/// | [`Ploc`](Self::Ploc) | 64 / 73 / 86 | 46.8 / 6.68 / 179 | 19.6 / 8.4 / 18.4 |
///
/// So clustering is the default. The binned heuristic is worth its time where a hierarchy is built once, of boxes of
/// similar sizes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum BuildStrategy {
    /// From the root down: cut at the middle of the longest side of the bounds of the boxes' centers (Ericson,
    /// *Real-Time Collision Detection*, 2005, §6.2.1).
    MiddleSplit,
    /// From the root down: half of the boxes on either side of a cut across the longest side (Ericson, §6.2.1).
    MedianSplit,
    /// From the root down: cut where the surface area heuristic says, among some cuts along all three axes (Wald, *On fast
    /// Construction of SAH-based Bounding Volume Hierarchies*, 2007).
    BinnedSah,
    /// From the leaves up: those merge that are nearest to each other (Meister and Bittner, *Parallel Locally-Ordered
    /// Clustering for Bounding Volume Hierarchy Construction*, 2018).
    #[default]
    Ploc,
}

/// Builds hierarchies, and keeps its buffers: a second build of the same size allocates nothing.
#[derive(Clone, Debug, Default)]
pub(crate) struct Builder {
    sorted: Vec<BuildItem>,
    z_order: ZOrder,
    ploc: Ploc,
    tree: Vec<BinaryNode>,
    rings: Vec<u32>,
    plan: Plan,
}

impl Builder {
    /// The bytes of memory that the buffers take.
    pub(crate) fn memory(&self) -> usize {
        self.sorted.capacity() * size_of::<BuildItem>()
            + self.z_order.memory()
            + self.ploc.memory()
            + self.tree.capacity() * size_of::<BinaryNode>()
            + self.rings.capacity() * size_of::<u32>()
            + self.plan.memory()
    }

    /// Replaces `nodes` by a hierarchy over `items`, whose boxes must be sound, with up to `leaf_size` of them in a leaf.
    /// The root is node 0, the children of a node stand side by side, and behind them comes all that is below the first.
    /// There are no nodes if there are no items, and a root with one leaf if there is one item.
    ///
    /// The items come back in the order of the leaves: those below a node, or a lane, are a slice. `leaf` gets each
    /// leaf in turn: its items, where they begin, and its node and lane; it returns the number of the leaf. `node` gets
    /// each node in turn, by index: where it is held, and its range of items.
    ///
    /// Takes O(n log n), and the hierarchy has O(log n) levels, whatever the input: each round of clustering leaves
    /// 15/16 of the clusters or less, or else the next half of them.
    pub(crate) fn build(
        &mut self,
        strategy: BuildStrategy,
        leaf_size: usize,
        items: &mut Vec<BuildItem>,
        nodes: &mut Vec<WideNode>,
        leaf: impl FnMut(&[BuildItem], usize, NodeIndex, usize) -> u32,
        node: impl FnMut(NodeIndex, Option<(NodeIndex, usize)>, Range<usize>),
    ) {
        nodes.clear();
        if items.is_empty() {
            return;
        }
        let Self {
            sorted,
            z_order,
            ploc,
            tree,
            rings,
            plan,
        } = self;
        // In whatever order, eight leaves of one item fill a node.
        let bag_size = if leaf_size == 1 { LANES } else { leaf_size } as u32;
        let split: Option<Split> = match strategy {
            BuildStrategy::MiddleSplit => Some(top_down::at_middle),
            BuildStrategy::MedianSplit => Some(top_down::at_median),
            BuildStrategy::BinnedSah => Some(top_down::at_least_cost),
            BuildStrategy::Ploc => None,
        };
        let root = if let Some(split) = split {
            mem::swap(items, sorted);
            top_down::build(split, sorted, bag_size, tree, rings)
        } else {
            z_order.sort(items, sorted);
            ploc.build(sorted, bag_size, tree, rings)
        };
        plan.make(&root, tree, split.is_none(), leaf_size as u32, bag_size);
        items.clear();
        Collapse {
            plan,
            tree,
            rings,
            unordered: sorted,
            leaf_size: leaf_size as u32,
            items,
            nodes,
            leaf,
            node,
        }
        .run(&root);
    }
}
