//! What is raced: the queries that ours and the peers answer, and the answers.

use std::ops::ControlFlow;

use bevy::math::Vec3A;
use bevy_sightline::{
    geometry::ray::Ray,
    spatial::{Neighbour, SpatialQueries, Visit},
};

use super::probes::Probe;

/// A set of keys, by what is the same in any order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Found {
    count: u32,
    sum: u64,
}

impl Found {
    #[inline]
    pub fn add(&mut self, key: u32) {
        self.count += 1;
        self.sum += u64::from(key);
    }

    #[inline]
    pub fn add_pair(&mut self, a: u32, b: u32) {
        self.count += 1;
        self.sum = (self.sum).wrapping_add((u64::from(a.min(b)) << 32 | u64::from(a.max(b))).wrapping_mul(0x9e37_79b9));
    }
}

/// Queries along rays.
pub(crate) trait RayQueries {
    /// The parameter at which the ray enters the first box: zero if it starts in one.
    fn closest(&self, ray: &Ray) -> Option<f32>;

    /// Whether the ray meets any box.
    fn any(&self, ray: &Ray) -> bool;

    /// All boxes that the ray meets.
    fn all(&self, ray: &Ray) -> Found;
}

/// Whether two rays have met the same box, or one as near: what starts in several boxes meets any of them first.
pub(crate) fn same_parameter(a: &Option<f32>, b: &Option<f32>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => (a - b).abs() <= 1e-4 * a.abs().max(1.0),
        (a, b) => a.is_none() && b.is_none(),
    }
}

/// Queries for regions of space.
pub(crate) trait RegionQueries {
    /// All boxes that touch the region.
    fn find<P: Probe>(&self, probe: &P) -> Found;
}

/// Queries for pairs.
pub(crate) trait PairQueries {
    /// All pairs of boxes that touch.
    fn pairs(&self) -> Found;
}

/// Queries for what is near.
pub(crate) trait NearQueries {
    /// The squared distances of the nearest boxes from a point, in ascending order.
    fn nearest<const N: usize>(&self, point: Vec3A, scratch: &mut Scratch) -> [f32; N];
}

/// Whether distances are the same up to the rounding of their squares.
pub(crate) fn same_distances<const N: usize>(a: &[f32; N], b: &[f32; N]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-4 * a.abs().max(1e-3))
}

/// Memory that a query may use again.
pub(crate) type Scratch = Vec<Neighbour<u32>>;

impl<T: SpatialQueries<u32>> RayQueries for T {
    fn closest(&self, ray: &Ray) -> Option<f32> {
        self.closest_box(ray).map(|(_, t)| t)
    }

    fn any(&self, ray: &Ray) -> bool {
        self.any_hit(ray, |_, _| true)
    }

    fn all(&self, ray: &Ray) -> Found {
        let mut found = Found::default();
        self.visit_ray(ray, |key, _| {
            found.add(key);
            Visit::Continue
        });
        found
    }
}

impl<T: SpatialQueries<u32>> RegionQueries for T {
    fn find<P: Probe>(&self, probe: &P) -> Found {
        let mut found = Found::default();
        self.visit_region(probe.region(), |key| {
            found.add(key);
            ControlFlow::Continue(())
        });
        found
    }
}

impl<T: SpatialQueries<u32>> PairQueries for T {
    fn pairs(&self) -> Found {
        let mut found = Found::default();
        self.visit_pairs(|a, b| {
            found.add_pair(a, b);
            ControlFlow::Continue(())
        });
        found
    }
}

impl<T: SpatialQueries<u32>> NearQueries for T {
    fn nearest<const N: usize>(&self, point: Vec3A, scratch: &mut Scratch) -> [f32; N] {
        self.k_nearest(point, N, f32::INFINITY, scratch);
        std::array::from_fn(|i| scratch[i].distance_squared)
    }
}

/// The squared distance of a point from a box.
#[inline]
pub(crate) fn distance_squared(point: Vec3A, min: Vec3A, max: Vec3A) -> f32 {
    (min - point).max(point - max).max(Vec3A::ZERO).length_squared()
}
