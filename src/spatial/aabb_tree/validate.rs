//! What must hold between any two calls.

use bevy::math::bounding::BoundingVolume;

use super::{
    AabbTree,
    node::{NodeIndex, NodeKind},
};
use crate::{
    geometry::aabb::{Aabb3dExt, union},
    spatial::SpatialQueries,
};

/// An invariant of the tree that does not hold: a bug in this crate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BrokenInvariant {
    /// The root has a parent.
    #[error("the root has a parent")]
    RootHasParent,
    /// A child does not name its parent.
    #[error("node {child} is a child of node {parent}, but names another parent")]
    WrongParent {
        /// The parent that has the child.
        parent: u32,
        /// The child.
        child: u32,
    },
    /// An inner node is not the box around its children.
    #[error("node {0} does not fit its children")]
    LooseNode(u32),
    /// A node does not contain its leaf.
    #[error("node {0} does not contain its leaf")]
    LeafOutsideNode(u32),
    /// A stored box is not sound.
    #[error("the box of node {0} is not sound")]
    UnsoundNode(u32),
    /// A leaf does not name its node.
    #[error("node {0} holds a leaf that names another node")]
    WrongLeaf(u32),
    /// The nodes or leaves in the tree and those in the free lists are not all there are.
    #[error("some nodes or leaves are neither in the tree nor free, or both")]
    LostNodes,
}

impl<K: Copy> AabbTree<K> {
    /// Checks every invariant, in O(n).
    ///
    /// # Errors
    ///
    /// The first invariant that does not hold.
    pub fn validate(&self) -> Result<(), BrokenInvariant> {
        if let Some(root) = self.root
            && self.nodes[root as usize].parent.is_some()
        {
            return Err(BrokenInvariant::RootHasParent);
        }
        let (mut nodes, mut leaves) = (0, 0);
        for index in self.linked_nodes() {
            nodes += 1;
            if nodes > self.nodes.len() {
                // A cycle: without this the walk would not end.
                return Err(BrokenInvariant::LostNodes);
            }
            leaves += usize::from(self.validate_node(index)?);
        }
        let all_nodes = nodes + self.free_nodes.len() == self.nodes.len();
        if all_nodes && leaves == self.len() {
            Ok(())
        } else {
            Err(BrokenInvariant::LostNodes)
        }
    }

    /// Checks one node against its children or its leaf, and tells whether it is a leaf.
    fn validate_node(&self, index: NodeIndex) -> Result<bool, BrokenInvariant> {
        let node = &self.nodes[index as usize];
        if !node.aabb.is_sound() {
            return Err(BrokenInvariant::UnsoundNode(index));
        }
        match node.kind {
            NodeKind::Inner([first, second]) => {
                for child in [first, second] {
                    if self.nodes[child as usize].parent != Some(index) {
                        return Err(BrokenInvariant::WrongParent { parent: index, child });
                    }
                }
                if node.aabb != union(self.aabb_of(first), self.aabb_of(second)) {
                    return Err(BrokenInvariant::LooseNode(index));
                }
                Ok(false)
            }
            NodeKind::Leaf(leaf) => {
                let leaf = &self.leaves[leaf as usize];
                if leaf.node != Some(index) {
                    return Err(BrokenInvariant::WrongLeaf(index));
                }
                if !node.aabb.contains(&leaf.aabb) {
                    return Err(BrokenInvariant::LeafOutsideNode(index));
                }
                Ok(true)
            }
        }
    }
}
