//! A dynamic loose octree.
//!
//! Each box is in one node, that of a cube around its centre which is no smaller than the box: found from its centre
//! and its size alone (Ulrich, *Loose Octrees*, Game Programming Gems, 2000; Ericson, *Real-Time Collision Detection*,
//! 2005, §7.3.2). Three things differ from the textbook:
//!
//! - **Room for eight.** A node holds up to eight things side by side, boxes and smaller nodes, which one step tests all
//!   at once. Only when there are more do those that share an octant get a node of their own, of the smallest cell that
//!   they have in common, however many levels below (a compressed octree: Clarkson, *Fast Algorithms for the All Nearest
//!   Neighbors Problem*, 1983). When few are left, they go back.
//! - **Tight bounds.** Queries go by the exact bounds of what is below a node, not by its cell: a cell twice as large as
//!   its boxes costs nothing.
//! - **No bounds of the world.** Cells are whole multiples of powers of two, everywhere: a box far outside makes the root
//!   grow, in one step, and the root shrinks when it is gone. The depth is limited by the precision of `f32`, and
//!   logarithmic among boxes in one place.
//!
//! What needs no insertion order, as streaming and levels of detail do not want one, can go by the cells: see
//! [`Octree::visit_nodes`].

mod build;
mod cell;
mod insert;
mod nodes;
mod query;
mod refit;
mod remove;
mod validate;

pub use super::query::Descend;
pub use nodes::OctreeNode;
pub use validate::BrokenInvariant;

use bevy::math::bounding::Aabb3d;

use super::{
    LeafId, NoSuchLeaf, SpatialUpdates, UnsoundBox, UpdateError,
    leaves::Leaves,
    wide::{Child, EVERY_MASK, NodeIndex, WideNode},
};
use crate::geometry::aabb::Aabb3dExt;
use cell::{Cell, Place, Spot};

/// A dynamic loose octree of axis-aligned boxes, each with a key of type `K`. See the [module](self).
///
/// Holds up to 2²⁹ leaves.
#[derive(Clone, Debug)]
pub struct Octree<K> {
    nodes: Vec<WideNode>,
    /// Of each node; apart, for queries do not need it.
    cells: Vec<Cell>,
    free: Vec<NodeIndex>,
    root: Option<NodeIndex>,
    leaves: Leaves<K, Place>,
    /// Leaves that have left their nodes, and their new boxes, while many are moved.
    leavers: Vec<(u32, Aabb3d)>,
    /// Nodes to be fitted, while many leaves are moved.
    stale: Vec<NodeIndex>,
}

impl<K> Default for Octree<K> {
    fn default() -> Self {
        Self {
            nodes: Vec::new(),
            cells: Vec::new(),
            free: Vec::new(),
            root: None,
            leaves: Leaves::default(),
            leavers: Vec::new(),
            stale: Vec::new(),
        }
    }
}

impl<K: Copy> Octree<K> {
    /// No boxes.
    pub fn new() -> Self {
        Self::default()
    }

    fn new_node(&mut self, cell: Cell) -> NodeIndex {
        match self.free.pop() {
            Some(node) => {
                self.cells[node as usize] = cell;
                node
            }
            None => {
                self.nodes.push(WideNode::EMPTY);
                self.cells.push(cell);
                (self.nodes.len() - 1) as NodeIndex
            }
        }
    }

    fn free_node(&mut self, node: NodeIndex) {
        self.nodes[node as usize] = WideNode::EMPTY;
        self.free.push(node);
    }

    /// Puts a child into a lane, and notes there where it is now.
    fn set_lane(&mut self, place: Place, aabb: &Aabb3d, child: Child) {
        let (node, lane) = (place.node() as usize, place.lane());
        self.nodes[node].set(lane, aabb, EVERY_MASK, child);
        match child {
            Child::Leaf(leaf) => self.leaves.set_place_at(leaf, place),
            Child::Node(child) => self.cells[child as usize].parent = place,
        }
        self.note_branch(place);
    }

    /// Notes what the child in a lane is for.
    fn note_branch(&mut self, place: Place) {
        let (node, lane) = (place.node() as usize, place.lane());
        self.cells[node].branches[lane] = match self.nodes[node].child(lane) {
            Child::Leaf(_) => None,
            Child::Node(child) => Some(self.cells[node].branch_of_child(&self.cells[child as usize])),
        };
    }

    /// Adds a child to a node that is not full.
    fn push_lane(&mut self, node: NodeIndex, aabb: &Aabb3d, child: Child) {
        let lane = self.nodes[node as usize].len();
        self.set_lane(Place::new(node, lane), aabb, child);
    }

    /// Removes a child from its lane, which the last one takes.
    fn take_lane(&mut self, place: Place) {
        let (node, lane) = (place.node() as usize, place.lane());
        let last = self.nodes[node].len() - 1;
        if lane < last {
            let (aabb, child) = (self.nodes[node].aabb(last), self.nodes[node].child(last));
            self.set_lane(place, &aabb, child);
        }
        self.nodes[node].swap_remove(last);
        self.cells[node].branches[last] = None;
    }

    fn aabb_at(&self, place: Place) -> Aabb3d {
        self.nodes[place.node() as usize].aabb(place.lane())
    }
}

impl<K: Copy> SpatialUpdates<K> for Octree<K> {
    fn insert(&mut self, key: K, aabb: Aabb3d) -> Result<LeafId, UnsoundBox> {
        if !aabb.is_sound() {
            return Err(UnsoundBox(aabb));
        }
        let id = self.leaves.add(key, Place::NOWHERE);
        self.insert_leaf(id.index, &aabb);
        Ok(id)
    }

    fn insert_many(&mut self, leaves: impl IntoIterator<Item = (K, Aabb3d)>) -> Vec<Result<LeafId, UnsoundBox>> {
        self.insert_or_build(leaves)
    }

    fn remove(&mut self, id: LeafId) -> Result<K, NoSuchLeaf> {
        let (key, place) = self.leaves.remove(id)?;
        self.remove_at(place);
        Ok(key)
    }

    fn update(&mut self, id: LeafId, aabb: Aabb3d) -> Result<(), UpdateError> {
        let place = self.leaves.place(id)?;
        if !aabb.is_sound() {
            return Err(UnsoundBox(aabb).into());
        }
        self.nodes[place.node() as usize].set_aabb(place.lane(), &aabb);
        if self.cells[place.node() as usize].accepts(&Spot::of(&aabb)) {
            self.refit(place.node());
        } else {
            self.relocate(id.index);
        }
        Ok(())
    }

    fn update_many(&mut self, updates: &[(LeafId, Aabb3d)]) -> Vec<(LeafId, UpdateError)> {
        self.move_many(updates)
    }

    fn clear(&mut self) {
        self.nodes.clear();
        self.cells.clear();
        self.free.clear();
        self.root = None;
        self.leaves.clear();
    }

    fn key(&self, id: LeafId) -> Option<K> {
        self.leaves.key(id)
    }

    fn aabb(&self, id: LeafId) -> Option<Aabb3d> {
        self.leaves.place(id).ok().map(|place| self.aabb_at(place))
    }
}
