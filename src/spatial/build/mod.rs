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
mod progress;
mod radix_sort;
mod reinsert;
mod tagged_box;
#[cfg(test)]
mod tests;
mod top_down;
mod workers;
mod z_order;

use std::{mem, ops::Range};

pub(crate) use cost::sah_cost;
pub use progress::BuildProgress;
pub(crate) use progress::{Cancelled, Stage};
pub(crate) use tagged_box::BuildItem;
pub(crate) use workers::{Alone, Errand, Workers};

use self::{
    collapse::Collapse,
    plan::Plan,
    ploc::Ploc,
    reinsert::Reinsertion,
    tagged_box::BinaryNode,
    top_down::{Split, TopDown},
    z_order::ZOrder,
};
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
/// Where nodes are then moved, [`Reinsertion`](Self::Reinsertion) costs 42.7 / 6.24 / 171 and rays visit 0.95, 0.95 and 0.77 of
/// the nodes that they visit after [`BinnedSah`](Self::BinnedSah); it takes 3 to 20 times
/// as long to build.
///
/// So clustering is the default. What is built once, and beside the use of what it replaces, is worth moving
/// nodes.
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
    /// As [`BinnedSah`](Self::BinnedSah), and then node by node is moved to where it costs least (Meister and Bittner, *Parallel
    /// Reinsertion for Bounding Volume Hierarchy Optimization*, 2018).
    Reinsertion,
}

/// What leaves hold, and what they cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Leaves {
    /// The most items in one.
    pub most: u32,
    /// So many items are tested at once, as a packet.
    pub packet: u32,
    /// What a packet costs that is started, where a node costs one.
    pub packet_cost: f32,
}

impl Leaves {
    /// Each item is a leaf, whose box tells all.
    pub(crate) const SINGLE: Self = Self {
        most: 1,
        packet: 1,
        packet_cost: 0.0,
    };
}

impl Default for Leaves {
    fn default() -> Self {
        Self::SINGLE
    }
}

/// Builds hierarchies, and keeps its buffers: a second build of the same size allocates nothing.
#[derive(Clone, Debug, Default)]
pub(crate) struct Builder {
    sorted: Vec<BuildItem>,
    z_order: ZOrder,
    ploc: Ploc,
    tree: Vec<BinaryNode>,
    rings: Vec<u32>,
    reinsertion: Reinsertion,
    plan: Plan,
}

/// How a hierarchy is to be built, and by whom.
#[derive(Clone, Copy)]
pub(crate) struct Order<'a> {
    pub strategy: BuildStrategy,
    pub leaves: Leaves,
    pub workers: &'a dyn Workers,
    pub progress: Option<&'a BuildProgress>,
}

impl Order<'_> {
    /// By the calling thread, which nothing stops.
    pub(crate) fn new(strategy: BuildStrategy, leaves: Leaves) -> Self {
        Self {
            strategy,
            leaves,
            workers: &Alone,
            progress: None,
        }
    }
}

impl Builder {
    /// The bytes of memory that the buffers take.
    pub(crate) fn memory(&self) -> usize {
        self.sorted.capacity() * size_of::<BuildItem>()
            + self.z_order.memory()
            + self.ploc.memory()
            + self.tree.capacity() * size_of::<BinaryNode>()
            + self.rings.capacity() * size_of::<u32>()
            + self.reinsertion.memory()
            + self.plan.memory()
    }

    /// Replaces `nodes` by a hierarchy over `items`, whose boxes must be sound, with leaves as told.
    /// The root is node 0, the children of a node stand side by side, and behind them comes all that is below the first.
    /// There are no nodes if there are no items, and a root with one leaf if there is one item.
    ///
    /// The items come back in the order of the leaves: those below a node, or a lane, are a slice. `leaf` gets each
    /// leaf in turn: its items, where they begin, and its node and lane; it returns the number of the leaf. `node` gets
    /// each node in turn, by index: where it is held, and its range of items.
    ///
    /// Takes O(n log n), and the hierarchy has O(log n) levels, whatever the input: each round of clustering leaves
    /// 15/16 of the clusters or less, or else the next half of them. It is the same for any number of workers.
    ///
    /// # Errors
    ///
    /// If the build was called off. Then nodes and items are of no use.
    pub(crate) fn build(
        &mut self,
        order: &Order,
        items: &mut Vec<BuildItem>,
        nodes: &mut Vec<WideNode>,
        leaf: impl FnMut(&[BuildItem], usize, NodeIndex, usize) -> u32,
        node: impl FnMut(NodeIndex, Option<(NodeIndex, usize)>, Range<usize>),
    ) -> Result<(), Cancelled> {
        nodes.clear();
        if items.is_empty() {
            return Ok(());
        }
        let Self {
            sorted,
            z_order,
            ploc,
            tree,
            rings,
            reinsertion,
            plan,
        } = self;
        let &Order {
            strategy,
            leaves,
            workers,
            progress,
        } = order;
        let count = items.len();
        // Before and behind comes what the caller does.
        let stage = |from: f32, to: f32, steps| Stage::new(progress, 0.05 + 0.9 * from, 0.05 + 0.9 * to, steps);
        // In whatever order, eight leaves of one item fill a node.
        let mut bag_size = if leaves.most == 1 { LANES as u32 } else { leaves.most };
        let split: Option<Split> = match strategy {
            BuildStrategy::MiddleSplit => Some(top_down::at_middle),
            BuildStrategy::MedianSplit => Some(top_down::at_median),
            BuildStrategy::BinnedSah | BuildStrategy::Reinsertion => Some(top_down::at_least_cost),
            BuildStrategy::Ploc => None,
        };
        let optimises = strategy == BuildStrategy::Reinsertion;
        if optimises {
            bag_size = 1;
        }
        let mut root = if let Some(split) = split {
            mem::swap(items, sorted);
            let stage = stage(0.0, if optimises { 0.2 } else { 0.8 }, count);
            let top_down = TopDown {
                split,
                bag_size,
                workers,
                stage: &stage,
            };
            top_down.build(sorted, tree, rings)?
        } else {
            z_order.sort(items, sorted, &stage(0.0, 0.3, count))?;
            ploc.build(sorted, bag_size, tree, rings, workers, &stage(0.3, 0.7, count))?
        };
        if optimises {
            let stage = stage(0.2, 0.9, reinsert::steps(tree.len()));
            let done = reinsertion.run(&mut root, tree, bag_size, workers, &stage);
            reinsertion.clear();
            done?;
        }
        plan.make(&root, tree, split.is_none(), leaves, bag_size);
        items.clear();
        let stage = stage(if split.is_none() { 0.7 } else { 0.9 }, 1.0, count);
        Collapse {
            plan,
            tree,
            rings,
            unordered: sorted,
            leaf_size: leaves.most,
            items,
            nodes,
            leaf,
            node,
            stage: &stage,
        }
        .run(&root)
    }
}
