//! A tree of which only some leaves are seen.

use std::ops::ControlFlow;

use bevy::math::{Vec3A, bounding::Aabb3d};

use super::AabbTree;
use crate::{
    geometry::{aabb::union, ray::Ray},
    spatial::{Region, SpatialQueries, Sweep, Trace, Visit, traverse::Part},
};

/// The leaves of an [`AabbTree`] that have a bit of a mask; see [`AabbTree::masked`].
#[derive(Debug)]
pub struct Masked<'a, K> {
    pub(super) tree: &'a AabbTree<K>,
    pub(super) mask: u32,
}

impl<K: Copy> Masked<'_, K> {
    /// Visits the keys of all leaves of which `part_of` does not say that nothing is in the region that it knows, with what
    /// it says of their boxes. What it says of a box that is wholly in the region counts for all that is inside.
    pub(crate) fn visit_parts(&self, part_of: impl FnMut(&Aabb3d) -> Part, visit: impl FnMut(K, Part)) {
        self.tree.visit_parts_masked(self.mask, part_of, visit);
    }
}

/// [`len`](Self::len) and [`bounds`](Self::bounds) visit every leaf.
impl<K: Copy> SpatialQueries<K> for Masked<'_, K> {
    fn len(&self) -> usize {
        let mut len = 0;
        self.visit_all(|_, _| len += 1);
        len
    }

    fn bounds(&self) -> Option<Aabb3d> {
        let mut bounds: Option<Aabb3d> = None;
        self.visit_all(|_, aabb| bounds = Some(bounds.map_or(*aabb, |bounds| union(&bounds, aabb))));
        bounds
    }

    fn memory(&self) -> usize {
        self.tree.memory()
    }

    fn visit_all(&self, visit: impl FnMut(K, &Aabb3d)) {
        self.tree.visit_all_masked(self.mask, visit);
    }

    #[inline]
    fn visit_ray(&self, ray: &Ray, visit: impl FnMut(K, f32) -> Visit) {
        self.tree.visit_ray_masked(self.mask, ray, visit);
    }

    fn trace_ray(&self, ray: &Ray, visit: impl FnMut(K, f32) -> Visit) -> Trace<K> {
        self.tree.trace_ray_masked(self.mask, ray, visit)
    }

    fn visit_sweep<S: Sweep>(&self, sweep: &S, visit: impl FnMut(K, f32) -> Visit) {
        self.tree.visit_sweep_masked(self.mask, sweep, visit);
    }

    #[inline]
    fn visit_region<R: Region>(&self, region: &R, visit: impl FnMut(K) -> ControlFlow<()>) {
        self.tree.visit_region_masked(self.mask, region, visit);
    }

    #[inline]
    fn visit_near(&self, point: Vec3A, max_distance: f32, visit: impl FnMut(K, f32) -> Visit) {
        self.tree.visit_near_masked(self.mask, point, max_distance, visit);
    }

    fn visit_pairs(&self, visit: impl FnMut(K, K) -> ControlFlow<()>) {
        self.tree.visit_pairs_masked(self.mask, visit);
    }

    #[inline]
    fn any_hit(&self, ray: &Ray, test: impl FnMut(K, &Ray) -> bool) -> bool {
        self.tree.any_hit_masked(self.mask, ray, test)
    }
}
