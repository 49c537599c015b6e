//! The invariants.

use bevy::math::bounding::Aabb3d;

use super::{
    KdTree,
    hierarchy::{ROOT, Slot},
    leaf::Leaves,
};
use crate::{
    geometry::aabb::{Aabb3dExt, EMPTY, union},
    spatial::wide::{Child, NodeIndex},
};

/// What is wrong with a tree. A bug of this crate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BrokenInvariant {
    /// There are nodes without leaves, or leaves without nodes.
    #[error("there are {nodes} nodes and {leaves} leaves")]
    NodesWithoutLeaves {
        /// The number of nodes.
        nodes: usize,
        /// The number of leaves.
        leaves: usize,
    },
    /// A node is not met in its turn on the way through the tree: not once, or not after its parent and what is below
    /// the lanes before it.
    #[error("node {node} is out of turn")]
    NodeOutOfTurn {
        /// The node.
        node: u32,
    },
    /// A leaf is not met in its turn, or the table tells another lane for it.
    #[error("leaf {leaf} is out of turn")]
    LeafOutOfTurn {
        /// The leaf.
        leaf: u32,
    },
    /// The box of a lane is not the smallest around what is below it.
    #[error("the box of lane {lane} of node {node} does not fit")]
    BoxDoesNotFit {
        /// The node.
        node: u32,
        /// The lane.
        lane: u32,
    },
    /// The leaves do not hold as many boxes or points as the tree says.
    #[error("the leaves hold {held} of {len}")]
    WrongLength {
        /// What the leaves hold.
        held: usize,
        /// What the tree says.
        len: usize,
    },
}

#[expect(private_bounds, reason = "the two kinds of leaves that there are implement it")]
impl<K: Copy, L: Leaves<K>> KdTree<K, L> {
    /// Checks every invariant of the tree, in a time that grows with its size.
    ///
    /// # Errors
    ///
    /// The first that is broken, which is a bug of this crate.
    pub fn validate(&self) -> Result<(), BrokenInvariant> {
        let (nodes, leaves) = (self.hierarchy.nodes.len(), self.hierarchy.slots.len());
        if (nodes == 0) != (leaves == 0) {
            return Err(BrokenInvariant::NodesWithoutLeaves { nodes, leaves });
        }
        let mut next = (ROOT, 0);
        if nodes > 0 {
            self.validate_node(ROOT, &mut next)?;
        }
        if next.0 as usize != nodes {
            return Err(BrokenInvariant::NodeOutOfTurn { node: next.0 });
        }
        if next.1 as usize != leaves {
            return Err(BrokenInvariant::LeafOutOfTurn { leaf: next.1 });
        }
        let (held, len) = ((0..next.1).map(|leaf| self.leaves.count(leaf)).sum(), self.leaves.len());
        if held != len {
            return Err(BrokenInvariant::WrongLength { held, len });
        }
        Ok(())
    }

    /// Checks what is below a node, which must be the next, and returns the box around it.
    fn validate_node(&self, node: NodeIndex, next: &mut (NodeIndex, u32)) -> Result<Aabb3d, BrokenInvariant> {
        if node != next.0 || node as usize >= self.hierarchy.nodes.len() {
            return Err(BrokenInvariant::NodeOutOfTurn { node });
        }
        next.0 += 1;
        let mut bounds = EMPTY;
        for (lane, (aabb, child)) in (0..).zip(self.hierarchy.nodes[node as usize].lanes()) {
            let below = match child {
                Child::Node(child) => self.validate_node(child, next)?,
                Child::Leaf(leaf) => {
                    if leaf != next.1 || self.hierarchy.slots.get(leaf as usize) != Some(&Slot { node, lane }) {
                        return Err(BrokenInvariant::LeafOutOfTurn { leaf });
                    }
                    next.1 += 1;
                    let mut below = EMPTY;
                    self.leaves.visit_all(leaf, aabb, |_, aabb| below = union(&below, aabb));
                    below
                }
            };
            if !below.is_sound() || below != aabb {
                return Err(BrokenInvariant::BoxDoesNotFit { node, lane });
            }
            bounds = union(&bounds, &aabb);
        }
        Ok(bounds)
    }
}
