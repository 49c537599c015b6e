//! The peers, each with the best that a user in a default build can make of it.

pub(crate) mod avian;
pub(crate) mod bvh;
pub(crate) mod kiddo;
pub(crate) mod obvhs;
pub(crate) mod parry;
pub(crate) mod rapier;
pub(crate) mod rebuilt;
pub(crate) mod rstar;

use bevy::math::{Vec3A, bounding::Aabb3d};
use bevy_sightline::geometry::ray::Ray;

/// A ray prepared for many boxes.
#[derive(Clone, Copy)]
pub(crate) struct Slabs {
    origin: Vec3A,
    direction_recip: Vec3A,
}

impl Slabs {
    pub fn new(ray: &Ray) -> Self {
        Self {
            origin: ray.origin(),
            direction_recip: ray.direction().recip(),
        }
    }

    /// The parameter at which the ray enters the box, infinite if it misses.
    #[inline]
    pub fn enter(&self, min: Vec3A, max: Vec3A) -> f32 {
        let a = (min - self.origin) * self.direction_recip;
        let b = (max - self.origin) * self.direction_recip;
        let enter = a.min(b).max_element().max(0.0);
        let leave = a.max(b).min_element();
        if enter <= leave { enter } else { f32::INFINITY }
    }
}

/// The nearest so far, in ascending order.
pub(crate) struct Nearest<const N: usize> {
    keys: [u32; N],
    pub distances_squared: [f32; N],
}

impl<const N: usize> Nearest<N> {
    pub fn new() -> Self {
        Self {
            keys: [u32::MAX; N],
            distances_squared: [f32::INFINITY; N],
        }
    }

    /// What is farther is not among them.
    #[inline]
    pub fn limit(&self) -> f32 {
        self.distances_squared[N - 1]
    }

    /// Adds a box, if it is near enough.
    #[inline]
    pub fn add(&mut self, key: u32, distance_squared: f32) {
        if distance_squared >= self.limit() {
            return;
        }
        let mut place = N - 1;
        while place > 0 && self.distances_squared[place - 1] > distance_squared {
            self.distances_squared[place] = self.distances_squared[place - 1];
            self.keys[place] = self.keys[place - 1];
            place -= 1;
        }
        self.distances_squared[place] = distance_squared;
        self.keys[place] = key;
    }
}

/// The box as two arrays.
fn corners(aabb: &Aabb3d) -> [[f32; 3]; 2] {
    [aabb.min.to_array(), aabb.max.to_array()]
}
