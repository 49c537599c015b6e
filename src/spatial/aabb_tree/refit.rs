//! Moving leaves: fitting the boxes above, and finding those that have left their nodes.

use bevy::math::bounding::Aabb3d;

use super::{AabbTree, Place, Scratch, quality::area};
use crate::{
    geometry::aabb::{Aabb3dExt, EMPTY, union},
    spatial::{
        LeafId, UnsoundBox, UpdateError,
        simd::{LANES, Simd, Task, dispatch, prefetch},
        wide::{Child, NodeIndex, WideNode},
    },
};

/// A node holds on to its leaves until its area is this many times what it was when it was formed.
const STRETCH: f32 = 2.0;

/// How far ahead of its update a leaf is fetched.
const AHEAD: usize = 8;

impl<K: Copy> AabbTree<K> {
    /// Fits the boxes and masks above a node to what is below; stops where nothing changes any more.
    pub(super) fn refit_above(&mut self, mut node: NodeIndex) {
        loop {
            let place = self.links[node as usize].parent;
            if !place.is_held() {
                return;
            }
            let lanes = &self.nodes[node as usize];
            let (aabb, mask) = (lanes.bounds(), lanes.mask());
            let held_mask = &mut self.nodes[place.node() as usize].masks[place.lane()];
            let same_mask = std::mem::replace(held_mask, mask) == mask;
            if same_mask && self.aabb_at(place) == aabb {
                return;
            }
            self.fit(place, &aabb);
            node = place.node();
        }
    }

    /// Gives a leaf a new box.
    pub(super) fn refit(&mut self, place: Place, aabb: &Aabb3d) {
        let node = place.node();
        self.nodes[node as usize].set_aabb(place.lane(), aabb);
        self.refit_above(node);
        let link = self.links[node as usize];
        if link.parent.is_held() && area(&self.aabb_at(link.parent)) > f64::from(link.formed_area * STRETCH) {
            self.note_strays(node);
            self.reinsert_strays();
        }
    }

    /// Gives leaves new boxes, and returns those that were refused.
    pub(super) fn refit_many(&mut self, updates: &[(LeafId, Aabb3d)]) -> Vec<(LeafId, UpdateError)> {
        let mut refused = Vec::new();
        self.scratch.dirty.resize(self.nodes.len().div_ceil(64), 0);
        for (index, &(id, aabb)) in updates.iter().enumerate() {
            if let Some((next, _)) = updates.get(index + 2 * AHEAD) {
                self.leaves.prefetch(*next);
            }
            if let Some((next, _)) = updates.get(index + AHEAD)
                && let Ok(place) = self.leaves.place(*next)
            {
                prefetch(&self.nodes[place.node() as usize]);
            }
            match self.leaves.place(id) {
                Err(why) => refused.push((id, why.into())),
                Ok(_) if !aabb.is_sound() => refused.push((id, UnsoundBox(aabb).into())),
                Ok(place) => {
                    self.nodes[place.node() as usize].set_aabb(place.lane(), &aabb);
                    self.scratch.mark(place.node());
                }
            }
        }
        dispatch(RefitDirty(self));
        self.reinsert_strays();
        refused
    }

    /// Notes the leaves that stretch their node, where it has become much larger than it was when it was formed.
    pub(super) fn note_strays(&mut self, node: NodeIndex) {
        let limit = f64::from(self.links[node as usize].formed_area * STRETCH);
        let lanes = &self.nodes[node as usize];
        let mut stays: u32 = (1 << lanes.len()) - 1;
        let most = lanes.len() / 2;
        let area_of = |stays: u32| {
            let bounds = (0..LANES)
                .filter(|lane| stays >> lane & 1 != 0)
                .fold(EMPTY, |bounds, lane| union(&bounds, &lanes.aabb(lane)));
            area(&bounds)
        };
        for _ in 0..most {
            let without = |lane: usize| (stays & !(1 << lane), lane);
            let leaves =
                (0..lanes.len()).filter(|&lane| stays >> lane & 1 != 0 && matches!(lanes.child(lane), Child::Leaf(_)));
            let Some((area, lane)) = leaves
                .map(|lane| (area_of(without(lane).0), lane))
                .min_by(|a, b| a.0.total_cmp(&b.0))
            else {
                break;
            };
            stays &= !(1 << lane);
            if let Child::Leaf(leaf) = lanes.child(lane) {
                self.scratch.strays.push(leaf);
            }
            if area <= limit {
                break;
            }
        }
        // Not again before it has grown as much once more.
        self.links[node as usize].formed_area = area_of(u32::MAX) as f32;
    }

    /// Inserts the leaves that were noted anew.
    pub(super) fn reinsert_strays(&mut self) {
        while let Some(leaf) = self.scratch.strays.pop() {
            let place = self.leaves.place_at(leaf);
            let aabb = self.aabb_at(place);
            let mask = self.nodes[place.node() as usize].masks[place.lane()];
            self.remove_child(place);
            self.link(leaf, &aabb, mask);
        }
    }
}

impl Scratch {
    #[inline]
    fn mark(&mut self, node: NodeIndex) {
        self.dirty[node as usize / 64] |= 1 << (node % 64);
    }
}

/// Fits all marked nodes, and what is above them, to their children.
///
/// From the last node to the first: a build puts parents before their children, so that each node is fitted once. Where
/// later changes have put a parent behind, another round follows.
struct RefitDirty<'a, K>(&'a mut AabbTree<K>);

impl<K: Copy> Task for RefitDirty<'_, K> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let tree = self.0;
        let mut is_done = false;
        while !is_done {
            is_done = true;
            for word in (0..tree.scratch.dirty.len()).rev() {
                while tree.scratch.dirty[word] != 0 {
                    let bit = 63 - tree.scratch.dirty[word].leading_zeros();
                    tree.scratch.dirty[word] &= !(1 << bit);
                    let node = word as u32 * 64 + bit;
                    let lanes: &WideNode = &tree.nodes[node as usize];
                    let aabb = lanes.bounds_with(simd);
                    let link = tree.links[node as usize];
                    if !link.parent.is_held() {
                        continue;
                    }
                    if area(&aabb) > f64::from(link.formed_area * STRETCH) {
                        tree.note_strays(node);
                    }
                    if tree.aabb_at(link.parent) != aabb {
                        tree.fit(link.parent, &aabb);
                        let parent = link.parent.node();
                        tree.scratch.mark(parent);
                        is_done &= parent < node;
                    }
                }
            }
        }
    }
}
