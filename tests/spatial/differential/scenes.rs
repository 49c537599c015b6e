//! Scenes of every kind that a structure may find hard.

use bevy::math::{Vec3A, bounding::Aabb3d};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use crate::common::random_point;

/// How boxes lie, and how large they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scene {
    /// Spread evenly, of similar sizes.
    Uniform,
    /// In a few heaps, far apart.
    Clustered,
    /// On a plane, higher than wide.
    City,
    /// Sizes from 1e-3 to 1e7, some of them flat, about as far from the origin as they are large.
    Mixed,
    /// All the same.
    Coincident,
    /// Along a line that is no axis.
    Collinear,
    /// Of the cells of a grid, so that neighbours touch exactly in faces, edges and corners.
    Grid,
    /// Without extent, on a coarse lattice at times, so that some coincide.
    Points,
    /// Coordinates from 1e-20 to 1e37, of both signs, and the limits of `f32`.
    Extreme,
}

impl Scene {
    pub const ALL: [Self; 9] = [
        Self::Uniform,
        Self::Clustered,
        Self::City,
        Self::Mixed,
        Self::Coincident,
        Self::Collinear,
        Self::Grid,
        Self::Points,
        Self::Extreme,
    ];

    /// A box of such a scene.
    pub fn aabb(self, rng: &mut ChaCha8Rng) -> Aabb3d {
        let mut half = |largest: f32| Vec3A::from_array([(); 3].map(|()| rng.random_range(0.0..largest)));
        match self {
            Self::Uniform => {
                let half = half(2.0);
                Aabb3d::new(random_point(rng, 20.0), half)
            }
            Self::Clustered => {
                let half = half(0.3);
                let heap = [[900.0, 0.0, 0.0], [-500.0, 40.0, 3.0], [0.0; 3], [0.0, -300.0, 999.0]];
                let heap = Vec3A::from_array(heap[rng.random_range(0..heap.len())]);
                Aabb3d::new(heap + Vec3A::from(random_point(rng, 2.0)), half)
            }
            Self::City => {
                let size = half(6.0) * Vec3A::new(1.0, 4.0, 1.0);
                let at = random_point(rng, 100.0);
                let min = Vec3A::new(at.x, 0.0, at.z);
                Aabb3d { min, max: min + size }
            }
            Self::Mixed => {
                let mut half = half(1.0);
                if rng.random_bool(0.2) {
                    half[rng.random_range(0..3)] = 0.0;
                }
                let scale = 10f32.powf(rng.random_range(-3.0..7.0));
                Aabb3d::new(random_point(rng, scale), half * scale)
            }
            Self::Coincident => Aabb3d::new(Vec3A::new(3.0, -4.0, 5.0), Vec3A::splat(0.5)),
            Self::Collinear => {
                let at = rng.random_range(-50.0f32..50.0);
                Aabb3d::new(Vec3A::new(at, at * 0.5, -at), Vec3A::splat(0.25))
            }
            Self::Grid => {
                let min = Vec3A::from_array([(); 3].map(|()| f32::from(rng.random_range(-4i8..4))));
                Aabb3d { min, max: min + 1.0 }
            }
            Self::Points => {
                let mut at = Vec3A::from(random_point(rng, 10.0));
                if rng.random_bool(0.5) {
                    at = (at * 0.2).round();
                }
                Aabb3d { min: at, max: at }
            }
            Self::Extreme => {
                let [a, b] = [(); 2].map(|()| Vec3A::from_array([(); 3].map(|()| extreme_coordinate(rng))));
                Aabb3d {
                    min: a.min(b),
                    max: if rng.random_bool(0.2) { a.min(b) } else { a.max(b) },
                }
            }
        }
    }

    /// The same box, moved a little for such a scene, and grown or shrunk.
    pub fn nudged(self, aabb: &Aabb3d, rng: &mut ChaCha8Rng) -> Aabb3d {
        let size = (aabb.max - aabb.min).max_element().min(1e6) + if self == Self::Points { 0.5 } else { 0.0 };
        let step = match self {
            Self::Grid => Vec3A::from_array([(); 3].map(|()| f32::from(rng.random_range(-1i8..=1)))),
            _ => Vec3A::from(random_point(rng, 1.0)) * size * 0.3,
        };
        let grown = if rng.random_bool(0.1) {
            (aabb.max - aabb.min) * 0.5
        } else {
            Vec3A::ZERO
        };
        let moved = Aabb3d {
            min: aabb.min + step,
            max: aabb.max + step + grown,
        };
        if moved.max.is_finite() && moved.min.is_finite() {
            moved
        } else {
            *aabb
        }
    }
}

fn extreme_coordinate(rng: &mut ChaCha8Rng) -> f32 {
    let size = match rng.random_range(0..10) {
        0 => 0.0,
        1 => f32::MAX,
        2 => f32::MIN_POSITIVE,
        3 => f32::from_bits(1),
        _ => 10f32.powf(rng.random_range(-20.0..37.0)),
    };
    if rng.random_bool(0.5) { size } else { -size }
}

/// Boxes that no structure stores.
pub fn unsound(rng: &mut ChaCha8Rng) -> Aabb3d {
    let mut aabb = Aabb3d::new(Vec3A::ZERO, Vec3A::ONE);
    let axis = rng.random_range(0..3);
    match rng.random_range(0..5) {
        0 => aabb.min[axis] = f32::NAN,
        1 => aabb.max[axis] = f32::NAN,
        2 => aabb.max[axis] = f32::INFINITY,
        3 => aabb.min[axis] = f32::NEG_INFINITY,
        _ => std::mem::swap(&mut aabb.min, &mut aabb.max),
    }
    aabb
}
