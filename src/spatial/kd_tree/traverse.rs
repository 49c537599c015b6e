//! The queries.

use std::ops::ControlFlow;

use bevy::math::{Vec3A, bounding::Aabb3d};

use super::{
    KdTree,
    leaf::Leaves,
    nearest::Nearest,
    query::{InTheWay, Query},
    trace,
};
use crate::{
    geometry::ray::Ray,
    spatial::{
        Neighbour, Region, SpatialQueries, Sweep, Trace, Visit,
        lanes::{Entering, Growing},
        region::{Outline, limit_squared},
        simd::{Simd, Task, dispatch},
    },
};

impl<K: Copy, L: Leaves<K>> SpatialQueries<K> for KdTree<K, L> {
    fn len(&self) -> usize {
        self.leaves.len()
    }

    fn bounds(&self) -> Option<Aabb3d> {
        self.hierarchy.bounds()
    }

    fn memory(&self) -> usize {
        self.hierarchy.memory() + self.leaves.memory()
    }

    fn visit_all(&self, mut visit: impl FnMut(K, &Aabb3d)) {
        for leaf in 0..self.hierarchy.slots.len() as u32 {
            self.leaves.visit_all(leaf, self.hierarchy.aabb(leaf), &mut visit);
        }
    }

    fn visit_ray(&self, ray: &Ray, visit: impl FnMut(K, f32) -> Visit) {
        visit_in_order(self, Entering::new(ray), ray.t_max(), shortening(visit));
    }

    fn trace_ray(&self, ray: &Ray, visit: impl FnMut(K, f32) -> Visit) -> Trace<K> {
        trace::trace_ray(self, ray, visit)
    }

    fn visit_sweep<S: Sweep>(&self, sweep: &S, visit: impl FnMut(K, f32) -> Visit) {
        visit_in_order(self, InTheWay::of(sweep), sweep.ray().t_max(), shortening(visit));
    }

    fn visit_region<R: Region>(&self, region: &R, visit: impl FnMut(K) -> ControlFlow<()>) {
        dispatch(Touching {
            tree: self,
            outline: region.outline(),
            region,
            visit,
        });
    }

    fn visit_near(&self, point: Vec3A, max_distance: f32, visit: impl FnMut(K, f32) -> Visit) {
        visit_in_order(
            self,
            Growing { center: point },
            limit_squared(point, max_distance),
            shortening(visit),
        );
    }

    fn visit_pairs(&self, visit: impl FnMut(K, K) -> ControlFlow<()>) {
        dispatch(Pairs { tree: self, visit });
    }

    fn k_nearest(&self, point: Vec3A, k: usize, max_distance: f32, nearest: &mut Vec<Neighbour<K>>)
    where
        K: Ord,
    {
        nearest.clear();
        if k == 0 {
            return;
        }
        let mut nearest = Nearest::new(nearest, k);
        visit_in_order(
            self,
            Growing { center: point },
            limit_squared(point, max_distance),
            |key, distance_squared, limit| {
                nearest.offer(key, distance_squared, limit);
                ControlFlow::Continue(())
            },
        );
    }
}

/// Visits what a query meets, nearest first, as far as to `limit`, which `visit` may lower.
#[inline]
fn visit_in_order<K: Copy, L: Leaves<K>>(
    tree: &KdTree<K, L>,
    query: impl Query,
    limit: f32,
    visit: impl FnMut(K, f32, &mut f32) -> ControlFlow<()>,
) {
    dispatch(InOrder {
        tree,
        query,
        limit,
        visit,
    });
}

/// A visitor of the trait as one that lowers the limit itself.
#[inline(always)]
fn shortening<K>(mut visit: impl FnMut(K, f32) -> Visit) -> impl FnMut(K, f32, &mut f32) -> ControlFlow<()> {
    move |key, at, limit| {
        match visit(key, at) {
            Visit::Continue => {}
            Visit::Shorten(to) => *limit = limit.min(to),
            Visit::Stop => return ControlFlow::Break(()),
        }
        ControlFlow::Continue(())
    }
}

struct InOrder<'a, K, L, Q, F> {
    tree: &'a KdTree<K, L>,
    query: Q,
    limit: f32,
    visit: F,
}

impl<K, L, Q, F> Task for InOrder<'_, K, L, Q, F>
where
    L: Leaves<K>,
    Q: Query,
    F: FnMut(K, f32, &mut f32) -> ControlFlow<()>,
{
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let KdTree { hierarchy, leaves, .. } = self.tree;
        hierarchy.visit_in_order(
            simd,
            &self.query,
            self.limit,
            |_| {},
            |leaf| leaves.announce(leaf),
            |leaf, at, limit| {
                let aabb = || hierarchy.aabb(leaf);
                leaves.visit_met(simd, (leaf, at), aabb, &self.query, limit, &mut self.visit)
            },
        );
    }
}

struct Touching<'a, K, L, R, F> {
    tree: &'a KdTree<K, L>,
    outline: Outline,
    region: &'a R,
    visit: F,
}

impl<K, L, R, F> Task for Touching<'_, K, L, R, F>
where
    L: Leaves<K>,
    R: Region,
    F: FnMut(K) -> ControlFlow<()>,
{
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let KdTree { hierarchy, leaves, .. } = self.tree;
        hierarchy.visit_touching(simd, &self.outline.0, |leaf, aabb| {
            leaves.visit_touching(simd, (leaf, aabb), &self.outline, self.region, &mut self.visit)
        });
    }
}

struct Pairs<'a, K, L, F> {
    tree: &'a KdTree<K, L>,
    visit: F,
}

impl<K, L, F> Task for Pairs<'_, K, L, F>
where
    L: Leaves<K>,
    F: FnMut(K, K) -> ControlFlow<()>,
{
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let KdTree { hierarchy, leaves, .. } = self.tree;
        hierarchy.visit_pairs(simd, |a, b| leaves.visit_pairs(simd, [a, b], &mut self.visit));
    }
}
