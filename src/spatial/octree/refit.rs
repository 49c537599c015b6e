//! How bounds follow boxes that move and stay in their nodes.

use bevy::math::bounding::Aabb3d;

use super::{
    super::{
        LeafId, UnsoundBox, UpdateError,
        simd::{Simd, Task, dispatch},
        wide::{Child, NodeIndex, WideNode},
    },
    Octree,
    cell::{Cell, Place, Spot},
};
use crate::geometry::aabb::Aabb3dExt;

impl<K: Copy> Octree<K> {
    /// Fits the bounds above a node to what is in it, as far up as that makes a difference.
    pub(super) fn refit(&mut self, node: NodeIndex) {
        dispatch(Refit {
            nodes: &mut self.nodes,
            cells: &self.cells,
            root: self.root,
            node,
        });
    }

    /// Gives many leaves new boxes: those that stay in their nodes first, then all bounds, then the others.
    ///
    /// The others are all taken out before the first is put back: nothing is inserted where boxes do not belong.
    pub(super) fn move_many(&mut self, updates: &[(LeafId, Aabb3d)]) -> Vec<(LeafId, UpdateError)> {
        let mut refused = Vec::new();
        for &(id, aabb) in updates {
            let place = match self.leaves.place(id) {
                Ok(place) => place,
                Err(why) => {
                    refused.push((id, why.into()));
                    continue;
                }
            };
            if !aabb.is_sound() {
                refused.push((id, UnsoundBox(aabb).into()));
                continue;
            }
            let node = place.node();
            self.nodes[node as usize].set_aabb(place.lane(), &aabb);
            self.mark_stale(node);
            if !self.cells[node as usize].accepts(&Spot::of(&aabb)) {
                self.leavers.push((id.index, aabb));
            }
        }
        self.refit_stale();
        let mut leavers = std::mem::take(&mut self.leavers);
        leavers.retain_mut(|(leaf, aabb)| {
            let place = self.leaves.place_at(*leaf);
            // Another update of the same leaf may have brought it back, or it may be out already.
            if place == Place::NOWHERE {
                return false;
            }
            *aabb = self.aabb_at(place);
            let leaves = !self.cells[place.node() as usize].accepts(&Spot::of(aabb));
            if leaves {
                self.remove_at(place);
                self.leaves.set_place_at(*leaf, Place::NOWHERE);
            }
            leaves
        });
        for (leaf, aabb) in leavers.drain(..) {
            self.insert_leaf(leaf, &aabb);
        }
        self.leavers = leavers;
        refused
    }

    /// Notes that the bounds of a node, and of those above, are to be fitted.
    fn mark_stale(&mut self, mut node: NodeIndex) {
        while Some(node) != self.root {
            let place = self.cells[node as usize].parent;
            node = place.node();
            let stale = &mut self.cells[node as usize].stale;
            let above_is_marked = *stale != 0;
            *stale |= 1 << place.lane();
            if above_is_marked {
                return;
            }
        }
    }

    /// Fits all bounds that are to be, those below first.
    fn refit_stale(&mut self) {
        self.stale.clear();
        self.stale.extend(self.root);
        let mut next = 0;
        while let Some(&node) = self.stale.get(next) {
            next += 1;
            let mut lanes = std::mem::take(&mut self.cells[node as usize].stale);
            while lanes != 0 {
                let lane = lanes.trailing_zeros() as usize;
                lanes &= lanes - 1;
                if let Child::Node(child) = self.nodes[node as usize].child(lane) {
                    self.stale.push(child);
                }
            }
        }
        dispatch(RefitAll {
            nodes: &mut self.nodes,
            cells: &self.cells,
            // The root has no bounds above it.
            order: self.stale.get(1..).unwrap_or_default(),
        });
    }
}

struct Refit<'a> {
    nodes: &'a mut [WideNode],
    cells: &'a [Cell],
    root: Option<NodeIndex>,
    node: NodeIndex,
}

impl Task for Refit<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let mut node = self.node;
        while Some(node) != self.root {
            let bounds = self.nodes[node as usize].bounds_with(simd);
            let place = self.cells[node as usize].parent;
            node = place.node();
            let above = &mut self.nodes[node as usize];
            if above.aabb(place.lane()) == bounds {
                return;
            }
            above.set_aabb(place.lane(), &bounds);
        }
    }
}

struct RefitAll<'a> {
    nodes: &'a mut [WideNode],
    cells: &'a [Cell],
    /// Each node before those above it, from the end.
    order: &'a [NodeIndex],
}

impl Task for RefitAll<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        for &node in self.order.iter().rev() {
            let bounds = self.nodes[node as usize].bounds_with(simd);
            let place = self.cells[node as usize].parent;
            self.nodes[place.node() as usize].set_aabb(place.lane(), &bounds);
        }
    }
}
