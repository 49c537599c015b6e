//! Building the whole tree at once.

use bevy::math::bounding::Aabb3d;

use super::{AabbTree, LeafId, Place};
use crate::spatial::{
    UnsoundBox,
    binned_sah::BuildItem,
    wide::{self, Child},
};

impl<K: Copy> AabbTree<K> {
    /// Adds many leaves, and returns for each its id, or why it was refused.
    ///
    /// Builds the whole tree anew where that is cheaper than to insert one by one: when at least half of the leaves
    /// are new.
    pub fn insert_many(&mut self, leaves: impl IntoIterator<Item = (K, Aabb3d)>) -> Vec<Result<LeafId, UnsoundBox>> {
        let present = self.leaves.len() - self.free_leaves.len();
        let mut new = Vec::new();
        let ids: Vec<_> = leaves
            .into_iter()
            .map(|(key, aabb)| {
                let id = self.add_leaf(key, &aabb)?;
                new.push(BuildItem { aabb, index: id.index });
                Ok(id)
            })
            .collect();
        if new.len() >= present {
            new.extend(self.items());
            self.build(new);
        } else {
            for item in new {
                self.link(item.index, &item.aabb);
            }
        }
        ids
    }

    /// Builds the whole tree anew over the leaves that it has, at the best quality that this tree knows.
    pub fn rebuild(&mut self) {
        self.build(self.items().collect());
    }

    /// All leaves that are in the tree.
    fn items(&self) -> impl Iterator<Item = BuildItem> + '_ {
        self.linked_leaves().map(|index| {
            let place = self.leaves[index as usize].place.expect("a linked leaf");
            BuildItem {
                aabb: self.nodes[place.node as usize].aabb(place.lane as usize),
                index,
            }
        })
    }

    /// Replaces all nodes by a hierarchy over the given leaves.
    fn build(&mut self, mut items: Vec<BuildItem>) {
        let leaves = &mut self.leaves;
        self.nodes = wide::build(&mut items, 1, |items, _, node, lane| {
            let index = items[0].index;
            leaves[index as usize].place = Some(Place {
                node,
                lane: lane as u32,
            });
            index
        });
        self.free_nodes.clear();
        self.root = (!self.nodes.is_empty()).then_some(0);
        self.parents = vec![None; self.nodes.len()];
        for (node, lanes) in (0..).zip(&self.nodes) {
            for (lane, (_, child)) in (0..).zip(lanes.lanes()) {
                if let Child::Node(child) = child {
                    self.parents[child as usize] = Some(Place { node, lane });
                }
            }
        }
    }
}
