//! Moving leaves: fitting the boxes above, and finding those that have left their nodes.

use bevy::math::bounding::Aabb3d;

use super::{AabbTree, Place, Scratch, quality::area};
use crate::{
    geometry::aabb::{Aabb3dExt, union},
    spatial::{
        LeafId, UnsoundBox, UpdateError,
        build::BuildItem,
        simd::{Simd, Task, dispatch, prefetch},
        wide::{NodeIndex, WideNode},
    },
};

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
        let parent = self.links[node as usize].parent;
        if parent.is_held() {
            self.note_strays(node, &self.aabb_at(parent), &self.nodes[node as usize].bounds());
        }
        self.refit_above(node);
        self.reinsert_strays();
    }

    /// Gives leaves new boxes, and returns those that were refused.
    pub(crate) fn refit_parts<'a>(
        &mut self,
        parts: impl Iterator<Item = &'a [(LeafId, Aabb3d)]>,
    ) -> Vec<(LeafId, UpdateError)> {
        let mut refused = Vec::new();
        self.scratch.dirty.resize(self.nodes.len().div_ceil(64), 0);
        for part in parts {
            self.store_boxes(part, &mut refused);
        }
        dispatch(RefitDirty(self));
        self.reinsert_strays();
        refused
    }

    /// Stores the boxes of leaves, and marks their nodes.
    fn store_boxes(&mut self, updates: &[(LeafId, Aabb3d)], refused: &mut Vec<(LeafId, UpdateError)>) {
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
    }

    /// Fits all nodes to their children.
    pub(super) fn refit_all(&mut self) {
        self.scratch.dirty.clear();
        self.scratch.dirty.resize(self.nodes.len() / 64, u64::MAX);
        self.scratch.dirty.push((1 << (self.nodes.len() % 64)) - 1);
        dispatch(RefitDirty(self));
        self.reinsert_strays();
    }

    /// Notes the leaves that have left the box of their node by far, `old`, if the node has become much larger than when
    /// it was formed.
    #[inline]
    fn note_strays(&mut self, node: NodeIndex, old: &Aabb3d, new: &Aabb3d) {
        let limit = self.quality.limit(self.links[node as usize].formed_area);
        if area(new) as f32 <= limit {
            return;
        }
        let limit = limit.max(area(old) as f32);
        let lanes = &self.nodes[node as usize];
        for (lane, child) in lanes.children.iter().enumerate() {
            if let Some(leaf) = child.leaf()
                && area(&union(old, &lanes.aabb(lane))) as f32 > limit
            {
                self.scratch.strays.push(leaf);
            }
        }
    }

    /// Inserts the leaves that were noted anew: when all are out, for the nodes that they have left reach as far as they
    /// have gone.
    fn reinsert_strays(&mut self) {
        let mut strays = std::mem::take(&mut self.scratch.strays);
        let mut items = std::mem::take(&mut self.scratch.items);
        items.clear();
        for leaf in strays.drain(..) {
            let place = self.leaves.place_at(leaf);
            let lanes = &self.nodes[place.node() as usize];
            items.push(BuildItem::new(
                &lanes.aabb(place.lane()),
                lanes.masks[place.lane()],
                leaf,
            ));
            self.remove_child(place);
        }
        for item in &items {
            self.link(item.index(), &item.aabb(), item.mask());
        }
        self.scratch.strays = strays;
        self.scratch.items = items;
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
                    let old = tree.aabb_at(link.parent);
                    if old != aabb {
                        tree.note_strays(node, &old, &aabb);
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
