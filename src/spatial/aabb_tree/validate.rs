//! What must hold between any two calls.

use super::{AabbTree, Place};
use crate::{
    geometry::aabb::Aabb3dExt,
    spatial::{
        SpatialQueries,
        wide::{Child, NodeIndex},
    },
};
use bevy::math::bounding::BoundingVolume;

/// An invariant of the tree that does not hold: a bug in this crate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BrokenInvariant {
    /// The root has a parent.
    #[error("the root has a parent")]
    RootHasParent,
    /// A child is held by one node and names another place.
    #[error("a child of node {0} names another place")]
    WrongPlace(u32),
    /// The box of an inner node is not the box around its children.
    #[error("node {0} does not fit its children")]
    LooseNode(u32),
    /// A leaf is outside of the box in which it may move.
    #[error("a leaf in node {0} has moved too far")]
    LeafOutsideAllowance(u32),
    /// A node has fewer than two children and is not a root with leaves.
    #[error("node {0} has too few children")]
    ThinNode(u32),
    /// A stored box is not sound.
    #[error("a box in node {0} is not sound")]
    UnsoundBox(u32),
    /// What is in the tree and what is in the free lists is not all there is.
    #[error("some nodes or leaves are neither in the tree nor free, or both")]
    Lost,
}

impl<K: Copy> AabbTree<K> {
    /// Checks every invariant, in O(n).
    ///
    /// # Errors
    ///
    /// The first invariant that does not hold.
    pub fn validate(&self) -> Result<(), BrokenInvariant> {
        if let Some(root) = self.root
            && self.parents[root as usize].is_some()
        {
            return Err(BrokenInvariant::RootHasParent);
        }
        let (mut nodes, mut leaves) = (0, 0);
        for node in self.linked_nodes() {
            nodes += 1;
            if nodes > self.nodes.len() {
                // A cycle: without this the walk would not end.
                return Err(BrokenInvariant::Lost);
            }
            leaves += self.validate_node(node)?;
        }
        let no_node_lost = nodes + self.free_nodes.len() == self.nodes.len();
        let no_leaf_lost = leaves == self.len() && leaves == self.linked_leaves().count();
        if no_node_lost && no_leaf_lost {
            Ok(())
        } else {
            Err(BrokenInvariant::Lost)
        }
    }

    /// Checks the lanes of one node, and returns how many of them are leaves.
    fn validate_node(&self, node: NodeIndex) -> Result<usize, BrokenInvariant> {
        let lanes = &self.nodes[node as usize];
        let mut leaves = 0;
        for (lane, (aabb, child)) in (0..).zip(lanes.lanes()) {
            if !aabb.is_sound() {
                return Err(BrokenInvariant::UnsoundBox(node));
            }
            let named = match child {
                Child::Node(child) => {
                    if aabb != self.nodes[child as usize].bounds() {
                        return Err(BrokenInvariant::LooseNode(child));
                    }
                    self.parents[child as usize]
                }
                Child::Leaf(leaf) => {
                    leaves += 1;
                    let leaf = &self.leaves[leaf as usize];
                    if !leaf.allowance.contains(&aabb) {
                        return Err(BrokenInvariant::LeafOutsideAllowance(node));
                    }
                    leaf.place
                }
            };
            if named != Some(Place { node, lane }) {
                return Err(BrokenInvariant::WrongPlace(node));
            }
        }
        let is_thin = match (lanes.len(), Some(node) == self.root) {
            (0, _) | (1, false) => true,
            (1, true) => leaves == 0,
            _ => false,
        };
        if is_thin {
            return Err(BrokenInvariant::ThinNode(node));
        }
        Ok(leaves)
    }
}
