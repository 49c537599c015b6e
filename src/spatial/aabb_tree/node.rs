//! How the tree lies in memory.

use bevy::math::bounding::Aabb3d;

/// An index into the nodes of a tree.
pub(super) type NodeIndex = u32;

#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    /// Contains the boxes of the children, or the box of the leaf and its margin.
    pub aabb: Aabb3d,
    pub kind: NodeKind,
    /// `None` at the root.
    pub parent: Option<NodeIndex>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum NodeKind {
    Inner([NodeIndex; 2]),
    /// The index of a leaf.
    Leaf(u32),
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf<K> {
    pub key: K,
    /// The box as it was last given: what queries see.
    pub aabb: Aabb3d,
    /// `None` while the leaf is not in the tree.
    pub node: Option<NodeIndex>,
    pub generation: u32,
}
