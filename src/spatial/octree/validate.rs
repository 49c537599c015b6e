//! What must hold of an octree.

use super::{
    super::wide::{Child, NodeIndex},
    Octree,
    cell::{Kind, Place, Spot, common_level},
};
use crate::geometry::aabb::Aabb3dExt;

/// What does not hold of an [`Octree`], though it should.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BrokenInvariant {
    /// There are boxes and no root, or the other way round.
    #[error("a root and boxes are there together, or neither")]
    Root,
    /// A node does not know where it is, or a leaf does not.
    #[error("lane {lane} of node {node} holds what believes to be elsewhere")]
    Place {
        /// The node.
        node: u32,
        /// The lane of the node.
        lane: usize,
    },
    /// A box is not in the cell of its node, or too large for it.
    #[error("the box in lane {lane} of node {node} does not belong there")]
    Misplaced {
        /// The node.
        node: u32,
        /// The lane of the node.
        lane: usize,
    },
    /// A cell is not within the one that it is below, or as large without need.
    #[error("the cell of node {child} is not within that of node {node}")]
    Cell {
        /// The node.
        node: u32,
        /// The child of it.
        child: u32,
    },
    /// The branch of a lane is not noted, or two children are for one.
    #[error("the branches of node {0} are wrong")]
    Branches(u32),
    /// The bounds of a node are not those of what is in it.
    #[error("the bounds in lane {lane} of node {node} are not tight")]
    Bounds {
        /// The node.
        node: u32,
        /// The lane of the node.
        lane: usize,
    },
    /// A node has fewer than two children and is not the root.
    #[error("node {0} should be none")]
    TooEmpty(u32),
    /// A node does not know the number of boxes below.
    #[error("the count of node {0} is wrong")]
    Count(u32),
    /// A node is marked as not yet fitted.
    #[error("node {0} is still marked")]
    Stale(u32),
    /// A node is neither below the root nor free, or it is both.
    #[error("nodes are lost")]
    LostNodes,
    /// The table of leaves is damaged, or does not hold as many as there are boxes.
    #[error("the table of leaves is wrong")]
    Leaves,
}

impl<K: Copy> Octree<K> {
    /// Whether all invariants hold. For tests: looks at everything.
    ///
    /// # Errors
    ///
    /// The first invariant that is broken.
    pub fn validate(&self) -> Result<(), BrokenInvariant> {
        if self.root.is_some() != (self.leaves.len() > 0) {
            return Err(BrokenInvariant::Root);
        }
        if !self.leaves.is_whole() {
            return Err(BrokenInvariant::Leaves);
        }
        // Each node before those below it.
        let mut order: Vec<NodeIndex> = self.root.into_iter().collect();
        let mut next = 0;
        while let Some(&node) = order.get(next) {
            next += 1;
            order.extend(self.children_of_valid(node)?);
            if order.len() > self.nodes.len() {
                return Err(BrokenInvariant::LostNodes);
            }
        }
        if order.len() + self.free.len() != self.nodes.len() {
            return Err(BrokenInvariant::LostNodes);
        }
        let mut counts = vec![0; self.nodes.len()];
        for &node in order.iter().rev() {
            let below = self.nodes[node as usize].lanes().map(|(_, child)| match child {
                Child::Leaf(_) => 1,
                Child::Node(child) => counts[child as usize],
            });
            let count = below.sum();
            if self.cells[node as usize].count != count {
                return Err(BrokenInvariant::Count(node));
            }
            counts[node as usize] = count;
        }
        let count = self.root.map_or(0, |root| counts[root as usize]);
        let all_there = count as usize == self.leaves.len();
        all_there.then_some(()).ok_or(BrokenInvariant::Leaves)
    }

    /// The nodes within one, if all is right with it.
    fn children_of_valid(&self, node: NodeIndex) -> Result<Vec<NodeIndex>, BrokenInvariant> {
        let cell = &self.cells[node as usize];
        let len = self.nodes[node as usize].len();
        if len < 2 && !(Some(node) == self.root && len == 1 && cell.count == 1) {
            return Err(BrokenInvariant::TooEmpty(node));
        }
        if cell.stale != 0 {
            return Err(BrokenInvariant::Stale(node));
        }
        let mut children = Vec::new();
        for (lane, (aabb, child)) in self.nodes[node as usize].lanes().enumerate() {
            let place = Place::new(node, lane);
            let known_place = match child {
                Child::Leaf(leaf) => self.leaves.place_at(leaf),
                Child::Node(child) => self.cells[child as usize].parent,
            };
            if known_place != place {
                return Err(BrokenInvariant::Place { node, lane });
            }
            match child {
                Child::Leaf(leaf) => {
                    if !self.leaves.is_live(leaf) || !aabb.is_sound() || !cell.accepts(&Spot::of(&aabb)) {
                        return Err(BrokenInvariant::Misplaced { node, lane });
                    }
                }
                Child::Node(child) => {
                    self.validate_child(node, child)?;
                    if self.nodes[child as usize].bounds() != aabb {
                        return Err(BrokenInvariant::Bounds { node, lane });
                    }
                    children.push(child);
                }
            }
            let branch = match child {
                Child::Leaf(_) => None,
                Child::Node(child) => Some(cell.branch_of_child(&self.cells[child as usize])),
            };
            let told_apart = cell.kind == Kind::Cell || cell.level > super::cell::POINT;
            let is_only = branch.is_none() || !told_apart || cell.lane_of(branch.expect("a branch")) == Some(lane);
            if cell.branches[lane] != branch || !is_only {
                return Err(BrokenInvariant::Branches(node));
            }
        }
        Ok(children)
    }

    fn validate_child(&self, node: NodeIndex, child: NodeIndex) -> Result<(), BrokenInvariant> {
        let (cell, below) = (&self.cells[node as usize], &self.cells[child as usize]);
        let is_within = common_level(cell.point, below.point) <= cell.level && below.level <= cell.level;
        let is_smaller = match (cell.kind, below.kind) {
            (Kind::Cell, Kind::Cell) => below.size <= cell.size && (below.level < cell.level || below.size < cell.size),
            (Kind::Cell, Kind::Crowd) => below.size <= cell.size,
            (Kind::Crowd, Kind::Cell) => false,
            (Kind::Crowd, Kind::Crowd) => {
                below.size == cell.size && (below.level < cell.level || cell.level == super::cell::POINT)
            }
        };
        (is_within && is_smaller)
            .then_some(())
            .ok_or(BrokenInvariant::Cell { node, child })
    }
}
