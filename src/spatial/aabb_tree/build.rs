//! Building the whole tree at once.

use super::{
    AabbTree, LeafId,
    node::{Node, NodeIndex, NodeKind},
};
use crate::spatial::{
    UnsoundBox,
    binned_sah::{self, BuildItem},
};
use bevy::math::bounding::Aabb3d;

impl<K: Copy> AabbTree<K> {
    /// Adds many leaves, and returns for each its id, or why it was refused.
    ///
    /// Builds the whole tree anew where that is cheaper than to insert one by one: when at least half of the leaves
    /// are new.
    pub fn insert_many(&mut self, leaves: impl IntoIterator<Item = (K, Aabb3d)>) -> Vec<Result<LeafId, UnsoundBox>> {
        let present = self.leaves.len() - self.free_leaves.len();
        let ids: Vec<_> = leaves.into_iter().map(|(key, aabb)| self.add_leaf(key, aabb)).collect();
        let added = ids.iter().flatten();
        if ids.len() >= present {
            let old = (0..self.leaves.len() as u32).filter_map(|index| self.id(index));
            let all: Vec<u32> = old.chain(added.copied()).map(|id| id.index).collect();
            self.build(&all);
        } else {
            for id in added {
                self.link(id.index, self.leaves[id.index as usize].aabb);
            }
        }
        ids
    }

    /// Builds the whole tree anew over the leaves that it has: tight boxes, and the best quality that this tree knows.
    pub fn rebuild(&mut self) {
        let all: Vec<u32> = (0..self.leaves.len() as u32)
            .filter(|&index| self.id(index).is_some())
            .collect();
        self.build(&all);
    }

    /// Replaces all nodes by a tree over the given leaves, top down by the binned surface area heuristic.
    fn build(&mut self, leaves: &[u32]) {
        self.nodes.clear();
        self.free_nodes.clear();
        self.root = None;
        let mut items: Vec<BuildItem> = leaves
            .iter()
            .map(|&index| BuildItem {
                aabb: self.leaves[index as usize].aabb,
                index,
            })
            .collect();
        if items.is_empty() {
            return;
        }

        let end = items.len();
        let mut ranges: Vec<(std::ops::Range<usize>, Option<NodeIndex>)> = vec![(0..end, None)];
        while let Some((range, parent)) = ranges.pop() {
            let items = &mut items[range.clone()];
            let node = self.nodes.len() as NodeIndex;
            let kind = if let [item] = items {
                self.leaves[item.index as usize].node = Some(node);
                NodeKind::Leaf(item.index)
            } else {
                let middle = range.start + binned_sah::partition(items);
                ranges.push((middle..range.end, Some(node)));
                ranges.push((range.start..middle, Some(node)));
                // The children put themselves in place when their turn comes: the first follows at once.
                NodeKind::Inner([node + 1; 2])
            };
            self.nodes.push(Node {
                aabb: binned_sah::bounds(items),
                kind,
                parent,
            });
            if let Some(parent) = parent
                && parent + 1 != node
                && let NodeKind::Inner(children) = &mut self.nodes[parent as usize].kind
            {
                children[1] = node;
            }
        }
        self.root = Some(0);
    }
}
