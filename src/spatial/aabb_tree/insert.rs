//! Linking a leaf into the tree, and taking it out: the operations of an R-tree (Guttman 1984).

use bevy::math::bounding::{Aabb3d, BoundingVolume};
use smallvec::SmallVec;

use super::{AabbTree, Place};
use crate::{
    geometry::aabb::{EMPTY, union},
    spatial::wide::{Child, LANES, NodeIndex, WideNode},
};

/// A node that overflows is split so that each half keeps at least this many.
const LEAST_FILL: usize = 3;

impl<K: Copy> AabbTree<K> {
    /// Puts a leaf that is not in the tree into it, with the box `aabb`.
    pub(super) fn link(&mut self, leaf: u32, aabb: &Aabb3d) {
        let node = match self.root {
            Some(root) => self.choose_node(root, aabb),
            None => {
                let root = self.add_node();
                self.root = Some(root);
                root
            }
        };
        self.add_child(node, aabb, Child::Leaf(leaf));
    }

    /// The node to put a box into: from the root on, always down the child that grows least in area, as far as that
    /// is a node.
    fn choose_node(&self, root: NodeIndex, aabb: &Aabb3d) -> NodeIndex {
        let mut node = root;
        loop {
            let least_grown = self.nodes[node as usize]
                .lanes()
                .map(|(child_aabb, child)| {
                    let area = child_aabb.visible_area();
                    let growth = union(&child_aabb, aabb).visible_area() - area;
                    (growth, area, child)
                })
                .min_by(|a, b| (a.0.total_cmp(&b.0)).then(a.1.total_cmp(&b.1)));
            match least_grown {
                Some((_, _, Child::Node(child))) => node = child,
                _ => return node,
            }
        }
    }

    /// Adds a child to a node, which is split if it is full, and mends everything above.
    fn add_child(&mut self, node: NodeIndex, aabb: &Aabb3d, child: Child) {
        if !self.nodes[node as usize].is_full() {
            let lane = self.nodes[node as usize].push(aabb, child);
            self.set_place(
                child,
                Place {
                    node,
                    lane: lane as u32,
                },
            );
            self.refit_above(node);
            return;
        }

        // Share the children out among this node and a new one beside it.
        let mut children: SmallVec<[(Aabb3d, Child); LANES + 1]> = self.nodes[node as usize].lanes().collect();
        children.push((*aabb, child));
        let second_half = split(&mut children);
        let beside = self.add_node();
        self.fill(node, &children[..second_half]);
        self.fill(beside, &children[second_half..]);

        let beside_bounds = self.nodes[beside as usize].bounds();
        match self.parents[node as usize] {
            Some(parent) => {
                self.refit_above(node);
                self.add_child(parent.node, &beside_bounds, Child::Node(beside));
            }
            None => {
                let node_bounds = self.nodes[node as usize].bounds();
                let root = self.add_node();
                self.fill(
                    root,
                    &[(node_bounds, Child::Node(node)), (beside_bounds, Child::Node(beside))],
                );
                self.root = Some(root);
            }
        }
    }

    /// Takes a leaf out of the tree.
    pub(super) fn unlink(&mut self, leaf: u32) {
        let place = self.leaves[leaf as usize]
            .place
            .take()
            .expect("only a leaf in the tree is unlinked");
        self.remove_child(place);
    }

    /// Removes a child of a node, and dissolves the node if fewer than two children are left.
    fn remove_child(&mut self, Place { node, lane }: Place) {
        let lanes = &mut self.nodes[node as usize];
        lanes.swap_remove(lane as usize);
        if (lane as usize) < lanes.len() {
            let moved = lanes.child(lane as usize);
            self.set_place(moved, Place { node, lane });
        }

        let lanes = &self.nodes[node as usize];
        match (lanes.len(), self.parents[node as usize]) {
            (0, None) => {
                self.root = None;
                self.free_nodes.push(node);
            }
            (1, Some(parent)) => {
                // The last child takes the place of the node.
                let (aabb, child) = (lanes.aabb(0), lanes.child(0));
                self.free_nodes.push(node);
                self.nodes[parent.node as usize].set(parent.lane as usize, &aabb, child);
                self.set_place(child, parent);
                self.refit_above(parent.node);
            }
            (1, None) if let Child::Node(child) = lanes.child(0) => {
                self.free_nodes.push(node);
                self.parents[child as usize] = None;
                self.root = Some(child);
            }
            _ => self.refit_above(node),
        }
    }

    /// Gives a node these children and no others.
    fn fill(&mut self, node: NodeIndex, children: &[(Aabb3d, Child)]) {
        self.nodes[node as usize] = WideNode::EMPTY;
        for (lane, (aabb, child)) in (0..).zip(children) {
            self.nodes[node as usize].push(aabb, *child);
            self.set_place(*child, Place { node, lane });
        }
    }

    fn set_place(&mut self, child: Child, place: Place) {
        match child {
            Child::Node(node) => self.parents[node as usize] = Some(place),
            Child::Leaf(leaf) => self.leaves[leaf as usize].place = Some(place),
        }
    }

    /// An empty node without a parent.
    fn add_node(&mut self) -> NodeIndex {
        match self.free_nodes.pop() {
            Some(index) => {
                self.nodes[index as usize] = WideNode::EMPTY;
                self.parents[index as usize] = None;
                index
            }
            None => {
                self.nodes.push(WideNode::EMPTY);
                self.parents.push(None);
                (self.nodes.len() - 1) as NodeIndex
            }
        }
    }
}

/// Orders the children of an overflowing node so that those before and those after the returned index have the least
/// area between them, among all cuts across an axis.
fn split(children: &mut [(Aabb3d, Child)]) -> usize {
    let by_axis =
        |axis: usize| move |a: &(Aabb3d, Child), b: &(Aabb3d, Child)| a.0.center()[axis].total_cmp(&b.0.center()[axis]);
    let area = |part: &[(Aabb3d, Child)]| {
        let bounds = part.iter().fold(EMPTY, |bounds, (aabb, _)| union(&bounds, aabb));
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
