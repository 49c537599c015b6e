//! Linking a leaf into the tree, and taking it out: the operations of an R-tree (Guttman 1984).

use bevy::math::bounding::{Aabb3d, BoundingVolume};
use smallvec::SmallVec;

use super::{AabbTree, NodeLink, Place, quality::area};
use crate::{
    geometry::aabb::{EMPTY, union},
    spatial::wide::{Child, LANES, NodeIndex, WideNode},
};

/// A node that overflows is split so that each half keeps at least this many.
const LEAST_FILL: usize = 3;

/// Leaves do not share nodes deeper than this, which is twice the depth of a full tree.
const MOST_SHARED: usize = 20;

/// A child with its box and its mask.
type Entry = (Aabb3d, u32, Child);

impl<K: Copy> AabbTree<K> {
    /// Puts a leaf that is not in the tree into it: from the root on, always down the child that grows least in area.
    ///
    /// Where that is a leaf, the new one goes beside it: into a free lane, or else into a node that the two share in the
    /// place of the one. To split the node, as an R-tree does, would make two of it and then of its parents, all full
    /// after a build: ten times as much area for each leaf that is inserted. Deep down it is split all the same, so that
    /// no order of insertions makes a list of the tree.
    pub(super) fn link(&mut self, leaf: u32, aabb: &Aabb3d, mask: u32) {
        let Some(mut node) = self.root else {
            let root = self.add_node();
            self.fill(root, &[(*aabb, mask, Child::Leaf(leaf))]);
            self.root = Some(root);
            return;
        };
        for depth in 0.. {
            self.links[node as usize].count = 0;
            let lanes = &self.nodes[node as usize];
            let (lane, child) = least_grown(lanes, aabb);
            let place = Place::new(node, lane);
            let grown = union(&lanes.aabb(lane), aabb);
            match child {
                Child::Node(child) => {
                    self.nodes[node as usize].masks[lane] |= mask;
                    self.fit(place, &grown);
                    node = child;
                }
                Child::Leaf(_) if lanes.is_full() && depth < MOST_SHARED => {
                    let sharing = [
                        (lanes.aabb(lane), lanes.masks[lane], child),
                        (*aabb, mask, Child::Leaf(leaf)),
                    ];
                    let shared = self.add_node();
                    let (aabb, mask, child) = self.fill(shared, &sharing);
                    self.quality.area += area(&aabb);
                    self.nodes[node as usize].set(lane, &aabb, mask, child);
                    self.set_place(child, place);
                    return;
                }
                Child::Leaf(_) => break,
            }
        }
        self.add_child(node, (*aabb, mask, Child::Leaf(leaf)));
    }

    /// Adds a child to a node, which is split if it is full. The boxes above the node hold the child already.
    fn add_child(&mut self, node: NodeIndex, (aabb, mask, child): Entry) {
        if let Child::Node(_) = child {
            self.quality.area += area(&aabb);
        }
        let lanes = &mut self.nodes[node as usize];
        if !lanes.is_full() {
            let lane = lanes.push(&aabb, mask, child);
            self.links[node as usize].formed_area = area(&lanes.bounds()) as f32;
            self.set_place(child, Place::new(node, lane));
            return;
        }

        // Share the children out among this node and a new one beside it.
        let mut children: SmallVec<[Entry; LANES + 1]> = (lanes.lanes().zip(lanes.masks))
            .map(|((aabb, child), mask)| (aabb, mask, child))
            .collect();
        children.push((aabb, mask, child));
        let second_half = split(&mut children);
        let beside = self.add_node();
        let node_entry = self.fill(node, &children[..second_half]);
        let beside_entry = self.fill(beside, &children[second_half..]);

        let place = self.links[node as usize].parent;
        if place.is_held() {
            let (aabb, mask, _) = node_entry;
            self.fit(place, &aabb);
            self.nodes[place.node() as usize].masks[place.lane()] = mask;
            self.add_child(place.node(), beside_entry);
        } else {
            let root = self.add_node();
            self.quality.area += area(&node_entry.0) + area(&beside_entry.0);
            self.fill(root, &[node_entry, beside_entry]);
            self.root = Some(root);
        }
    }

    /// Removes a child of a node, dissolves the node if fewer than two children are left, and mends everything above.
    pub(super) fn remove_child(&mut self, place: Place) {
        let node = place.node();
        self.break_slices(node);
        let lanes = &mut self.nodes[node as usize];
        lanes.swap_remove(place.lane());
        let len = lanes.len();
        if place.lane() < len {
            let moved = lanes.child(place.lane());
            self.set_place(moved, place);
        }

        let lanes = &self.nodes[node as usize];
        let parent = self.links[node as usize].parent;
        match len {
            0 => {
                self.root = None;
                self.free_node(node);
            }
            1 if parent.is_held() => {
                // The last child takes the place of the node.
                let (aabb, mask, child) = (lanes.aabb(0), lanes.masks[0], lanes.child(0));
                self.quality.area -= area(&self.aabb_at(parent));
                self.free_node(node);
                self.nodes[parent.node() as usize].set(parent.lane(), &aabb, mask, child);
                self.set_place(child, parent);
                self.refit_above(parent.node());
            }
            1 if let Child::Node(child) = lanes.child(0) => {
                self.quality.area -= area(&lanes.aabb(0));
                self.free_node(node);
                self.links[child as usize].parent = Place::NONE;
                self.root = Some(child);
            }
            _ => self.refit_above(node),
        }
    }

    /// Notes that the keys below a node, and so those below all its ancestors, are no slice any more.
    pub(super) fn break_slices(&mut self, node: NodeIndex) {
        let mut place = Place::new(node, 0);
        while place.is_held() {
            let link = &mut self.links[place.node() as usize];
            if link.count == 0 {
                return;
            }
            link.count = 0;
            place = link.parent;
        }
    }

    /// Gives a node these children and no others, and returns it as a child.
    fn fill(&mut self, node: NodeIndex, children: &[Entry]) -> Entry {
        self.nodes[node as usize] = WideNode::EMPTY;
        for (lane, (aabb, mask, child)) in children.iter().enumerate() {
            self.nodes[node as usize].push(aabb, *mask, *child);
            self.set_place(*child, Place::new(node, lane));
        }
        let lanes = &self.nodes[node as usize];
        let (aabb, mask) = (lanes.bounds(), lanes.mask());
        self.links[node as usize].formed_area = area(&aabb) as f32;
        (aabb, mask, Child::Node(node))
    }

    fn set_place(&mut self, child: Child, place: Place) {
        match child {
            Child::Node(node) => self.links[node as usize].parent = place,
            Child::Leaf(leaf) => self.leaves.set_place_at(leaf, place),
        }
    }

    /// An empty node without a parent.
    fn add_node(&mut self) -> NodeIndex {
        let link = NodeLink {
            parent: Place::NONE,
            first: 0,
            count: 0,
            formed_area: 0.0,
        };
        match self.free_nodes.pop() {
            Some(index) => {
                self.links[index as usize] = link;
                index
            }
            None => {
                self.nodes.push(WideNode::EMPTY);
                self.links.push(link);
                (self.nodes.len() - 1) as NodeIndex
            }
        }
    }

    fn free_node(&mut self, node: NodeIndex) {
        self.nodes[node as usize] = WideNode::EMPTY;
        self.free_nodes.push(node);
    }
}

/// The child of a node that grows least in area when it takes in `aabb`; of those that grow alike, the smaller one.
fn least_grown(lanes: &WideNode, aabb: &Aabb3d) -> (usize, Child) {
    let mut least = (f32::INFINITY, f32::INFINITY, 0);
    for lane in 0..lanes.len() {
        let lane_box = lanes.aabb(lane);
        let area = lane_box.visible_area();
        let growth = union(&lane_box, aabb).visible_area() - area;
        if (growth, area) < (least.0, least.1) {
            least = (growth, area, lane);
        }
    }
    (least.2, lanes.child(least.2))
}

/// Orders the children of an overflowing node so that those before and those after the returned index have the least
/// area between them, among all cuts across an axis.
fn split(children: &mut [Entry]) -> usize {
    let by_axis = |axis: usize| move |a: &Entry, b: &Entry| a.0.center()[axis].total_cmp(&b.0.center()[axis]);
    let area = |part: &[Entry]| {
        let bounds = part.iter().fold(EMPTY, |bounds, (aabb, ..)| union(&bounds, aabb));
        bounds.visible_area() * part.len() as f32
    };
    let mut best = (f32::INFINITY, 0, children.len() / 2);
    for axis in 0..3 {
        children.sort_by(by_axis(axis));
        for cut in LEAST_FILL..=children.len() - LEAST_FILL {
            let cost = area(&children[..cut]) + area(&children[cut..]);
            if cost < best.0 {
                best = (cost, axis, cut);
            }
        }
    }
    let (_, axis, cut) = best;
    children.sort_by(by_axis(axis));
    cut
}
