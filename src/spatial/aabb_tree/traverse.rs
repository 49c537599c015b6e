//! The queries.

use std::ops::ControlFlow;

use bevy::math::{Vec3A, bounding::Aabb3d};

use super::{AabbTree, NodeLink, Place};
use crate::{
    geometry::ray::Ray,
    spatial::{
        Region, SpatialQueries, Sweep, Trace, Visit,
        lanes::{Entering, Growing},
        region::limit_squared,
        trace::trace_in_order,
        traverse::{self, Descent, Found, Part},
        wide::{Child, EVERY_MASK, LANES, NodeIndex, WideNode},
    },
};

impl<K: Copy> SpatialQueries<K> for AabbTree<K> {
    fn len(&self) -> usize {
        self.leaves.len()
    }

    fn bounds(&self) -> Option<Aabb3d> {
        self.root.map(|root| self.nodes[root as usize].bounds())
    }

    fn memory(&self) -> usize {
        self.nodes.capacity() * size_of::<WideNode>()
            + self.links.capacity() * size_of::<NodeLink>()
            + self.free_nodes.capacity() * size_of::<NodeIndex>()
            + self.ordered.capacity() * size_of::<K>()
            + self.leaves.memory()
            + self.scratch.memory()
    }

    fn visit_all(&self, mut visit: impl FnMut(K, &Aabb3d)) {
        for index in self.leaves.live() {
            visit(self.leaves.key_at(index), &self.aabb_at(self.leaves.place_at(index)));
        }
    }

    #[inline]
    fn visit_ray(&self, ray: &Ray, visit: impl FnMut(K, f32) -> Visit) {
        self.visit_ray_masked(EVERY_MASK, ray, visit);
    }

    fn trace_ray(&self, ray: &Ray, visit: impl FnMut(K, f32) -> Visit) -> Trace<K> {
        self.trace_ray_masked(EVERY_MASK, ray, visit)
    }

    fn visit_sweep<S: Sweep>(&self, sweep: &S, visit: impl FnMut(K, f32) -> Visit) {
        self.visit_sweep_masked(EVERY_MASK, sweep, visit);
    }

    #[inline]
    fn visit_region<R: Region>(&self, region: &R, visit: impl FnMut(K) -> ControlFlow<()>) {
        self.visit_region_masked(EVERY_MASK, region, visit);
    }

    #[inline]
    fn visit_near(&self, point: Vec3A, max_distance: f32, visit: impl FnMut(K, f32) -> Visit) {
        self.visit_near_masked(EVERY_MASK, point, max_distance, visit);
    }

    fn visit_pairs(&self, visit: impl FnMut(K, K) -> ControlFlow<()>) {
        self.visit_pairs_masked(EVERY_MASK, visit);
    }

    #[inline]
    fn any_hit(&self, ray: &Ray, test: impl FnMut(K, &Ray) -> bool) -> bool {
        self.any_hit_masked(EVERY_MASK, ray, test)
    }
}

impl<K: Copy> AabbTree<K> {
    pub(super) fn visit_all_masked(&self, mask: u32, mut visit: impl FnMut(K, &Aabb3d)) {
        for (node, _) in self.linked_nodes() {
            let node = &self.nodes[node as usize];
            for lane in (0..LANES).filter(|&lane| node.masks[lane] & mask != 0) {
                if let Child::Leaf(leaf) = node.child(lane) {
                    visit(self.leaves.key_at(leaf), &node.aabb(lane));
                }
            }
        }
    }

    #[inline]
    pub(super) fn visit_ray_masked(&self, mask: u32, ray: &Ray, mut visit: impl FnMut(K, f32) -> Visit) {
        let Some(root) = self.root else { return };
        traverse::visit_in_order(&self.nodes, root, mask, ray.t_max(), Entering::new(ray), |leaf, t| {
            visit(self.leaves.key_at(leaf), t)
        });
    }

    pub(super) fn trace_ray_masked(&self, mask: u32, ray: &Ray, mut visit: impl FnMut(K, f32) -> Visit) -> Trace<K> {
        let key_of = |leaf| self.leaves.key_at(leaf);
        self.root.map_or_else(Trace::default, |root| {
            trace_in_order(&self.nodes, root, mask, ray, key_of, |leaf, t| visit(key_of(leaf), t))
        })
    }

    #[inline]
    pub(super) fn any_hit_masked(&self, mask: u32, ray: &Ray, mut test: impl FnMut(K, &Ray) -> bool) -> bool {
        let Some(root) = self.root else { return false };
        let mut found = false;
        traverse::visit_any(
            &self.nodes,
            root,
            mask,
            ray.t_max(),
            Entering::new(ray),
            |leaf, _: f32| {
                found = test(self.leaves.key_at(leaf), ray);
                if found { Visit::Stop } else { Visit::Continue }
            },
        );
        found
    }

    pub(super) fn visit_sweep_masked<S: Sweep>(&self, mask: u32, sweep: &S, mut visit: impl FnMut(K, f32) -> Visit) {
        let Some(root) = self.root else { return };
        let aabb_of = |leaf| self.aabb_at(self.leaves.place_at(leaf));
        traverse::visit_sweep(&self.nodes, root, mask, sweep, aabb_of, |leaf, t| {
            visit(self.leaves.key_at(leaf), t)
        });
    }

    #[inline]
    pub(super) fn visit_region_masked<R: Region>(
        &self,
        mask: u32,
        region: &R,
        mut visit: impl FnMut(K) -> ControlFlow<()>,
    ) {
        let Some(root) = self.root else { return };
        traverse::visit_region(&self.nodes, root, mask, region, |found| match found {
            Found::Leaf(leaf) => visit(self.leaves.key_at(leaf)),
            Found::Whole(node) => self.visit_whole(node, mask, &mut visit),
        });
    }

    /// Visits the keys of all leaves with a bit of `mask` of which `part_of` does not say that nothing is in the region,
    /// with what it says of their boxes.
    ///
    /// `part_of` must say that all of a box is in the region only where it would say so of every box inside.
    pub(super) fn visit_parts_masked(
        &self,
        mask: u32,
        mut part_of: impl FnMut(&Aabb3d) -> Part,
        mut visit: impl FnMut(K, Part),
    ) {
        let Some(root) = self.root else { return };
        traverse::descend(&self.nodes, root, mask, |aabb, child| {
            match (part_of(aabb), child) {
                (Part::None, _) => return Descent::Skip,
                (part, Child::Leaf(leaf)) => visit(self.leaves.key_at(leaf), part),
                (Part::Some, Child::Node(_)) => return Descent::Enter,
                (Part::All, Child::Node(node)) => {
                    let _ = self.visit_whole(node, mask, &mut |key| {
                        visit(key, Part::All);
                        ControlFlow::Continue(())
                    });
                }
            }
            Descent::Skip
        });
    }

    /// Visits the keys of all leaves below a node that have a bit of `mask`: one slice if nothing was inserted or removed
    /// there since the last build, and all that is there has.
    #[inline]
    fn visit_whole(&self, node: NodeIndex, mask: u32, visit: &mut impl FnMut(K) -> ControlFlow<()>) -> ControlFlow<()> {
        let NodeLink { first, count, .. } = self.links[node as usize];
        let has_others = self.nodes[node as usize].mask() & !mask != 0;
        if count == 0 || has_others {
            return traverse::visit_leaves(&self.nodes, node, mask, |leaf| visit(self.leaves.key_at(leaf)));
        }
        self.ordered[first as usize..][..count as usize]
            .iter()
            .try_for_each(|&key| visit(key))
    }

    #[inline]
    pub(super) fn visit_near_masked(
        &self,
        mask: u32,
        point: Vec3A,
        max_distance: f32,
        mut visit: impl FnMut(K, f32) -> Visit,
    ) {
        let Some(root) = self.root else { return };
        let limit = limit_squared(point, max_distance);
        traverse::visit_in_order(
            &self.nodes,
            root,
            mask,
            limit,
            Growing { center: point },
            |leaf, distance| visit(self.leaves.key_at(leaf), distance),
        );
    }

    pub(super) fn visit_pairs_masked(&self, mask: u32, mut visit: impl FnMut(K, K) -> ControlFlow<()>) {
        let Some(root) = self.root else { return };
        traverse::visit_pairs((&self.nodes, root), None, mask, |a, b| {
            visit(self.leaves.key_at(a), self.leaves.key_at(b))
        });
    }

    /// Visits every pair of a key of this tree and one of another whose boxes touch, in no promised order.
    ///
    /// Goes down both trees at once: faster than [`visit_pairs_with`](SpatialQueries::visit_pairs_with), which asks one
    /// structure for every box of the other.
    pub fn visit_pairs_with_tree<L: Copy>(&self, other: &AabbTree<L>, mut visit: impl FnMut(K, L) -> ControlFlow<()>) {
        let (Some(root), Some(other_root)) = (self.root, other.root) else {
            return;
        };
        traverse::visit_pairs(
            (&self.nodes, root),
            Some((&other.nodes, other_root)),
            EVERY_MASK,
            |a, b| visit(self.leaves.key_at(a), other.leaves.key_at(b)),
        );
    }
}

impl Place {
    /// Whether this is the place of a node or leaf that is held by a node.
    pub(super) fn is_held(self) -> bool {
        self != Self::NONE
    }
}
