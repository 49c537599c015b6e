//! The boxes that are divided, and rays through them.

use std::f32::consts::TAU;

use bevy::{
    math::{Vec3A, bounding::Aabb3d},
    prelude::*,
};
use bevy_sightline::geometry::ray::Ray;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::structure::{Kind, Structure};

/// How thick the boxes are that are seen from above.
const THICKNESS: f32 = 0.5;

/// The same boxes in two dimensions or in three.
#[derive(Clone, Debug)]
pub struct Boxes {
    pub three_d: bool,
    pub boxes: Vec<Aabb3d>,
}

impl Boxes {
    /// Half of them spread evenly, half in heaps, of different sizes.
    pub fn new(count: u32, seed: u32, three_d: bool) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed.into());
        let size = Self::size_of(three_d);
        let heaps: [Vec3; 3] = std::array::from_fn(|_| size * fractions(&mut rng, 0.15..0.85));
        let boxes = (0..count).map(|number| {
            let center = match number % 6 {
                0..3 => size * fractions(&mut rng, 0.02..0.98),
                heap => heaps[heap as usize - 3] + size * 0.2 * fractions(&mut rng, -0.5..0.5),
            };
            let half = fractions(&mut rng, 0.5..1.0) * if number % 12 == 0 { 2.6 } else { 0.95 };
            let half = half.with_z(if three_d { half.z } else { THICKNESS });
            // In the plane all have one centre above it.
            let center = if three_d { center } else { center.with_z(THICKNESS) };
            Aabb3d::new(center, half)
        });
        Self {
            three_d,
            boxes: boxes.collect(),
        }
    }

    /// From the origin to this corner: room for all centres.
    pub fn size(&self) -> Vec3 {
        Self::size_of(self.three_d)
    }

    fn size_of(three_d: bool) -> Vec3 {
        if three_d {
            Vec3::new(64.0, 40.0, 64.0)
        } else {
            Vec3::new(64.0, 64.0, 2.0 * THICKNESS)
        }
    }

    /// The ray that is shown first: of some that begin at the edge, the one that goes farthest before it hits a box.
    pub fn first_ray(&self) -> Ray {
        let list = Structure::new(Kind::List, &self.boxes);
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let candidates = std::iter::repeat_with(|| {
            let [from, to] = [-0.04, 0.8].map(|x| self.level(self.size() * fractions(&mut rng, 0.1..0.9).with_x(x)));
            ray(from, to - from).expect("two different points")
        });
        let way = |ray: &Ray| list.closest(ray).map_or(0.0, |(_, at)| at);
        let farthest = candidates.take(200).max_by(|a, b| way(a).total_cmp(&way(b)));
        farthest.expect("there are candidates")
    }

    /// The point, or in two dimensions the one in the plane.
    fn level(&self, point: Vec3) -> Vec3 {
        if self.three_d { point } else { point.with_z(THICKNESS) }
    }

    /// A ray from anywhere to anywhere.
    pub fn random_ray(&self, rng: &mut ChaCha8Rng) -> Ray {
        let from = self.size() * fractions(rng, -0.1..1.1);
        let to = if self.three_d {
            self.size() * fractions(rng, 0.0..1.0)
        } else {
            let (y, x) = rng.random_range(0.0..TAU).sin_cos();
            from + Vec3::new(x, y, 0.0)
        };
        let (from, to) = (self.level(from), self.level(to));
        ray(from, to - from).unwrap_or_else(|| self.first_ray())
    }
}

/// A ray without end, if there is a direction.
pub fn ray(from: Vec3, direction: Vec3) -> Option<Ray> {
    Ray::new(Vec3A::from(from), direction.try_normalize()?, f32::INFINITY)
}

fn fractions(rng: &mut ChaCha8Rng, range: std::ops::Range<f32>) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| rng.random_range(range.clone())))
}
