//! How a box finds its node, and what happens when there is no room.

use std::iter;

use bevy::math::bounding::Aabb3d;

use super::{
    super::wide::{Child, LANES, NodeIndex},
    Octree,
    cell::{Branch, Cell, Kind, Level, POINT, Place, Spot},
};
use crate::geometry::aabb::{EMPTY, union};

/// Lanes of one node, one bit each.
type Lanes = u32;

const ALL_LANES: Lanes = (1 << LANES) - 1;

impl<K: Copy> Octree<K> {
    /// Inserts a leaf that is nowhere yet.
    pub(super) fn insert_leaf(&mut self, leaf: u32, aabb: &Aabb3d) {
        let spot = Spot::of(aabb);
        let root = match self.root {
            None => self.new_node(Cell::around(&spot)),
            Some(root) if !self.cells[root as usize].accepts(&spot) => self.new_root(root, &spot),
            Some(root) => root,
        };
        self.root = Some(root);
        self.insert_below(root, leaf, aabb);
    }

    /// A root that accepts such a box: the old one with a larger cell if that makes no difference to what is in it, or one
    /// above it.
    fn new_root(&mut self, root: NodeIndex, spot: &Spot) -> NodeIndex {
        let below = &self.cells[root as usize];
        let mut cell = Cell::containing([below.as_member(), (*spot, POINT)].into_iter());
        cell.count = below.count;
        let has_only_boxes = below.branches.iter().all(Option::is_none);
        if has_only_boxes && !self.nodes[root as usize].is_full() {
            self.cells[root as usize] = cell;
            return root;
        }
        let new = self.new_node(cell);
        let bounds = self.nodes[root as usize].bounds();
        self.push_lane(new, &bounds, Child::Node(root));
        new
    }

    /// Inserts a leaf that is nowhere yet below a node that accepts it. Counts it there and below.
    pub(super) fn insert_below(&mut self, mut node: NodeIndex, leaf: u32, aabb: &Aabb3d) {
        let spot = Spot::of(aabb);
        self.cells[node as usize].count += 1;
        loop {
            if let Some(child) = self.child_for(node, &spot) {
                node = child;
                self.cells[node as usize].count += 1;
            } else if self.nodes[node as usize].is_full() {
                self.make_room(node, &spot);
            } else {
                break;
            }
        }
        self.push_lane(node, aabb, Child::Leaf(leaf));
        self.grow(node, aabb);
    }

    /// The child of a node into which such a box goes.
    fn child_for(&self, node: NodeIndex, spot: &Spot) -> Option<NodeIndex> {
        let cell = &self.cells[node as usize];
        if cell.kind == Kind::Crowd && cell.level == POINT {
            return self.emptiest_child(node);
        }
        let lane = cell.lane_of(cell.branch(spot))?;
        let Child::Node(child) = self.nodes[node as usize].child(lane) else {
            unreachable!("only nodes have branches");
        };
        self.cells[child as usize].accepts(spot).then_some(child)
    }

    /// Of a full node whose boxes nothing tells apart, and which has no two of them to gather: the child with the fewest.
    fn emptiest_child(&self, node: NodeIndex) -> Option<NodeIndex> {
        let boxes = self.cells[node as usize]
            .branches
            .iter()
            .filter(|branch| branch.is_none());
        if boxes.count() > 1 {
            return None;
        }
        let children = self.nodes[node as usize].lanes().filter_map(|(_, child)| match child {
            Child::Leaf(_) => None,
            Child::Node(child) => Some(child),
        });
        children.min_by_key(|&child| self.cells[child as usize].count)
    }

    /// Lets the bounds above a node contain a box.
    fn grow(&mut self, mut node: NodeIndex, aabb: &Aabb3d) {
        while Some(node) != self.root {
            let place = self.cells[node as usize].parent;
            let old = self.aabb_at(place);
            let new = union(&old, aabb);
            if new == old {
                return;
            }
            node = place.node();
            self.nodes[node as usize].set_aabb(place.lane(), &new);
        }
    }

    /// Makes room in a full node, or a child of it that accepts the box that wants in.
    fn make_room(&mut self, node: NodeIndex, spot: &Spot) {
        // Boxes that have moved may have come to where a child takes them.
        for lane in 0..LANES {
            let (aabb, child) = (
                self.nodes[node as usize].aabb(lane),
                self.nodes[node as usize].child(lane),
            );
            if let Child::Leaf(leaf) = child
                && let Some(child) = self.child_for(node, &Spot::of(&aabb))
            {
                self.take_lane(Place::new(node, lane));
                self.insert_below(child, leaf, &aabb);
                return;
            }
        }
        let (lanes, cell) = self.group(node, spot);
        if lanes == ALL_LANES && cell.accepts(spot) {
            self.narrow(node, cell);
        } else {
            self.gather(node, lanes, cell);
        }
    }

    /// Which lanes of a full node to gather in a child of their own, and its cell.
    fn group(&self, node: NodeIndex, spot: &Spot) -> (Lanes, Cell) {
        let cell = &self.cells[node as usize];
        if cell.kind == Kind::Crowd && cell.level == POINT {
            let is_leaf = |lane: &usize| cell.branches[*lane].is_none();
            let count = (0..LANES).filter(is_leaf).count();
            let half = (0..LANES).filter(is_leaf).take((count / 2).max(2));
            return (
                half.fold(0, |lanes, lane| lanes | 1 << lane),
                cell.child(Branch::Large, iter::once(cell.as_member())),
            );
        }

        let mut groups: [Lanes; Branch::COUNT] = [0; Branch::COUNT];
        let mut branches = [Branch::Small; LANES];
        for (lane, of_lane) in branches.iter_mut().enumerate() {
            let branch =
                cell.branches[lane].unwrap_or_else(|| cell.branch(&Spot::of(&self.nodes[node as usize].aabb(lane))));
            groups[branch.index()] |= 1 << lane;
            *of_lane = branch;
        }
        let wanted = cell.branch(spot);
        let size = |branch: Branch| groups[branch.index()].count_ones() + u32::from(branch == wanted);
        let largest = (branches.into_iter()).fold(wanted, |a, b| if size(b) > size(a) { b } else { a });
        let branch = if size(largest) > 1 { largest } else { Branch::Small };

        let is_small = |lane: &usize| matches!(branches[*lane], Branch::Octant(_));
        let lanes = match branch {
            Branch::Small => (0..LANES).filter(is_small).fold(0, |lanes, lane| lanes | 1 << lane),
            _ => groups[branch.index()],
        };
        let in_lanes = (0..LANES).filter(|lane| lanes >> lane & 1 == 1);
        let members = in_lanes.map(|lane| self.member(node, lane));
        let wanting = (branch == wanted).then_some((*spot, POINT));
        (lanes, cell.child(branch, members.chain(wanting)))
    }

    /// Where that belongs which is in a lane, and the level of its own cell.
    fn member(&self, node: NodeIndex, lane: usize) -> (Spot, Level) {
        match self.nodes[node as usize].child(lane) {
            Child::Leaf(_) => (Spot::of(&self.nodes[node as usize].aabb(lane)), POINT),
            Child::Node(child) => self.cells[child as usize].as_member(),
        }
    }

    /// Lets a node have a smaller cell, which all that is in it fits into.
    fn narrow(&mut self, node: NodeIndex, cell: Cell) {
        let old = &self.cells[node as usize];
        let (parent, count) = (old.parent, old.count);
        self.cells[node as usize] = Cell { parent, count, ..cell };
        for lane in 0..LANES {
            self.note_branch(Place::new(node, lane));
        }
        if Some(node) != self.root {
            self.note_branch(parent);
        }
    }

    /// Moves some lanes of a node into a new child.
    fn gather(&mut self, node: NodeIndex, lanes: Lanes, cell: Cell) {
        let new = self.new_node(cell);
        let (mut bounds, mut count) = (EMPTY, 0);
        for lane in (0..LANES).rev().filter(|lane| lanes >> lane & 1 == 1) {
            let (aabb, child) = (
                self.nodes[node as usize].aabb(lane),
                self.nodes[node as usize].child(lane),
            );
            self.take_lane(Place::new(node, lane));
            self.push_lane(new, &aabb, child);
            bounds = union(&bounds, &aabb);
            count += match child {
                Child::Leaf(_) => 1,
                Child::Node(child) => self.cells[child as usize].count,
            };
        }
        self.cells[new as usize].count = count;
        self.push_lane(node, &bounds, Child::Node(new));
    }
}
