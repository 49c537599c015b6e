//! How nodes that have become too empty go away.

use super::{
    super::wide::{Child, LANES, NodeIndex},
    Octree,
    cell::{Place, Spot},
};

/// A node is dissolved into its parent if that then holds no more than this: less than there is room for, so that what
/// comes and goes does not split and merge nodes every time.
const MERGED: usize = LANES - 2;

impl<K: Copy> Octree<K> {
    /// Removes what is in a lane of leaves.
    pub(super) fn remove_at(&mut self, place: Place) {
        let mut node = place.node();
        self.take_lane(place);
        self.cells[node as usize].count -= 1;
        while Some(node) != self.root {
            node = self.cells[node as usize].parent.node();
            self.cells[node as usize].count -= 1;
        }
        self.refit(place.node());
        self.tidy(place.node());
    }

    /// Takes a leaf whose box does not belong into its node any more to where it does.
    pub(super) fn relocate(&mut self, leaf: u32) {
        let place = self.leaves.place_at(leaf);
        let aabb = self.aabb_at(place);
        let spot = Spot::of(&aabb);
        self.take_lane(place);
        let mut node = place.node();
        loop {
            self.cells[node as usize].count -= 1;
            if self.cells[node as usize].accepts(&spot) {
                self.refit(place.node());
                self.insert_below(node, leaf, &aabb);
                break;
            }
            if Some(node) == self.root {
                self.refit(place.node());
                if self.cells[node as usize].count == 0 {
                    self.tidy(node);
                }
                self.insert_leaf(leaf, &aabb);
                break;
            }
            node = self.cells[node as usize].parent.node();
        }
        self.tidy(place.node());
    }

    /// Makes a node that has lost a child, or all of them, as small as it can be.
    fn tidy(&mut self, node: NodeIndex) {
        let len = self.nodes[node as usize].len();
        let is_root = Some(node) == self.root;
        if len == 0 {
            self.free_node(node);
            self.root = None;
        } else if len == 1 && is_root {
            if let Child::Node(child) = self.nodes[node as usize].child(0) {
                self.free_node(node);
                self.root = Some(child);
            }
        } else if is_root || !self.dissolve(node) {
            let in_node = |lane: usize| match self.nodes[node as usize].child(lane) {
                Child::Leaf(_) => None,
                Child::Node(child) => Some(child),
            };
            if len < MERGED
                && let Some(child) = (0..len)
                    .filter_map(in_node)
                    .find(|&child| self.nodes[child as usize].len() < MERGED)
            {
                self.dissolve(child);
            }
        }
    }

    /// Puts what is in a node into its parent, if there is enough room.
    ///
    /// Two children may be for one branch of the parent: no more than one is taken.
    fn dissolve(&mut self, node: NodeIndex) -> bool {
        let place = self.cells[node as usize].parent;
        let parent = place.node();
        let len = self.nodes[node as usize].len();
        let children = self.cells[node as usize].branches.iter().flatten().count();
        let fits = self.nodes[parent as usize].len() - 1 + len <= MERGED;
        if len > 1 && !(fits && children <= 1) {
            return false;
        }
        for lane in 0..len {
            let (aabb, child) = (
                self.nodes[node as usize].aabb(lane),
                self.nodes[node as usize].child(lane),
            );
            if lane == 0 {
                self.set_lane(place, &aabb, child);
            } else {
                self.push_lane(parent, &aabb, child);
            }
        }
        self.free_node(node);
        true
    }
}
