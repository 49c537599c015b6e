//! What must hold between any two calls.

use super::{AabbTree, NodeLink, Place};
use crate::{
    geometry::aabb::Aabb3dExt,
    spatial::wide::{Child, NodeIndex, WideNode},
};

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
    /// The mask of an inner node is not that of its children.
    #[error("the mask of node {0} is not that of its children")]
    WrongMask(u32),
    /// A node has fewer than two children and is not a root with leaves.
    #[error("node {0} has too few children")]
    ThinNode(u32),
    /// A stored box is not sound.
    #[error("a box in node {0} is not sound")]
    UnsoundBox(u32),
    /// The slice of the keys below a node is not as long as there are leaves, or not inside of that of its parent.
    #[error("the slice of node {0} is not what is below it")]
    WrongSlice(u32),
    /// A node that is free has children.
    #[error("the free node {0} has children")]
    FreeNodeInUse(u32),
    /// What is in the tree and what is in the free lists is not all there is.
    #[error("some nodes or leaves are neither in the tree nor free, or both")]
    Lost,
    /// Work was left over.
    #[error("nodes are marked, or leaves are noted, that should have been dealt with")]
    Unfinished,
}

impl<K: Copy> AabbTree<K> {
    /// Checks every invariant, in O(n log n).
    ///
    /// # Errors
    ///
    /// The first invariant that does not hold.
    pub fn validate(&self) -> Result<(), BrokenInvariant> {
        if let Some(root) = self.root
            && self.links[root as usize].parent.is_held()
        {
            return Err(BrokenInvariant::RootHasParent);
        }
        let (mut nodes, mut leaves) = (0, 0);
        for (node, _) in self.linked_nodes() {
            nodes += 1;
            if nodes > self.nodes.len() {
                // A cycle: without this the walk would not end.
                return Err(BrokenInvariant::Lost);
            }
            leaves += self.validate_node(node)?;
        }
        for &free in &self.free_nodes {
            if self.nodes[free as usize].len() != 0 {
                return Err(BrokenInvariant::FreeNodeInUse(free));
            }
        }
        let no_node_lost = nodes + self.free_nodes.len() == self.nodes.len() && self.links.len() == self.nodes.len();
        let no_leaf_lost = leaves == self.leaves.len() && leaves == self.leaves.live().count();
        if !no_node_lost || !no_leaf_lost || !self.leaves.is_whole() {
            return Err(BrokenInvariant::Lost);
        }
        if self.scratch.strays.is_empty() && self.scratch.dirty.iter().all(|&word| word == 0) {
            Ok(())
        } else {
            Err(BrokenInvariant::Unfinished)
        }
    }

    /// Checks the lanes of one node, and returns how many of them are leaves.
    fn validate_node(&self, node: NodeIndex) -> Result<usize, BrokenInvariant> {
        let lanes = &self.nodes[node as usize];
        let mut leaves = 0;
        for (lane, (aabb, child)) in lanes.lanes().enumerate() {
            if !aabb.is_sound() {
                return Err(BrokenInvariant::UnsoundBox(node));
            }
            let named = match child {
                Child::Node(child) => {
                    let below: &WideNode = &self.nodes[child as usize];
                    if aabb != below.bounds() {
                        return Err(BrokenInvariant::LooseNode(child));
                    }
                    if lanes.masks[lane] != below.mask() {
                        return Err(BrokenInvariant::WrongMask(child));
                    }
                    self.validate_slice(node, child)?;
                    self.links[child as usize].parent
                }
                Child::Leaf(leaf) => {
                    leaves += 1;
                    self.leaves.place_at(leaf)
                }
            };
            if named != Place::new(node, lane) {
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

    /// Checks the slice of a node against that of the node that holds it.
    fn validate_slice(&self, parent: NodeIndex, node: NodeIndex) -> Result<(), BrokenInvariant> {
        let [outer, inner] = [parent, node].map(|node| self.links[node as usize]);
        let end = |link: NodeLink| link.first + link.count;
        let is_inside = outer.first <= inner.first && end(inner) <= end(outer) && inner.count > 0;
        if outer.count > 0 && !is_inside || inner.count > 0 && end(inner) as usize > self.ordered.len() {
            return Err(BrokenInvariant::WrongSlice(node));
        }
        Ok(())
    }
}
