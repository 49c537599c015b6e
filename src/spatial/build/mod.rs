//! Building wide hierarchies over many boxes at once.
mod binned_sah;
mod collapse;
mod cost;
mod tagged_box;
mod top_down;

use std::{mem, ops::Range};

pub(crate) use cost::sah_cost;
pub(crate) use tagged_box::BuildItem;

use self::{collapse::Collapse, tagged_box::BinaryNode};
use super::wide::{NodeIndex, WideNode};

/// How a hierarchy is built.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum BuildStrategy {
    /// Top down, split at the middle of the longest axis.
    MiddleSplit,
    /// Top down.
    MedianSplit,
    /// Top down.
    #[default]
    BinnedSah,
    /// Bottom up.
    Ploc,
}

/// Builds hierarchies, and keeps its buffers: a second build of the same size allocates nothing.
#[derive(Clone, Debug, Default)]
pub(crate) struct Builder {
    tree: Vec<BinaryNode>,
    ordered: Vec<BuildItem>,
}

impl Builder {
    /// The bytes of memory that the buffers take.
    pub(crate) fn memory(&self) -> usize {
        self.tree.capacity() * size_of::<BinaryNode>() + self.ordered.capacity() * size_of::<BuildItem>()
    }

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
        match strategy {
            BuildStrategy::MiddleSplit => top_down::build(top_down::at_middle, items, leaf_size, &mut self.tree),
            BuildStrategy::MedianSplit => top_down::build(top_down::at_median, items, leaf_size, &mut self.tree),
            BuildStrategy::BinnedSah | BuildStrategy::Ploc => {
                top_down::build(top_down::at_least_cost, items, leaf_size, &mut self.tree)
            }
        }
        self.ordered.clear();
        Collapse {
            tree: &self.tree,
            unordered: items,
            leaf_size,
            items: &mut self.ordered,
            nodes,
            leaf,
            node,
        }
        .run();
        mem::swap(items, &mut self.ordered);
    }
}
