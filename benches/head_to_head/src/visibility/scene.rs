//! What both sides look at.

use std::f32::consts::TAU;

use bevy::prelude::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The share of the world that a camera in its middle sees, whichever way it looks along an axis.
const SEEN: f32 = 0.1;

/// Unit cubes in a cube around the origin, so that their density does not depend on their number.
pub(super) struct Scene {
    pub(super) places: Vec<Transform>,
    pub(super) side: f32,
}

impl Scene {
    pub(super) fn new(n: usize) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(n as u64);
        let side = 4.0 * (n as f32).cbrt();
        let places = (0..n).map(|_| Transform {
            translation: point(&mut rng) * side / 2.0,
            rotation: Quat::from_rotation_y(rng.random_range(0.0..TAU)),
            scale: Vec3::ONE,
        });
        Self {
            places: places.collect(),
            side,
        }
    }

    /// A cube that moves does so by some 5 cm a frame, along wide curves.
    pub(super) fn place(&self, index: usize, frame: usize) -> Vec3 {
        let phase = index as f32 + 0.01 * frame as f32;
        self.places[index].translation + 5.0 * Vec3::new(phase.sin(), (1.3 * phase).cos(), (0.7 * phase).sin())
    }

    /// The pyramid of a camera in the middle holds a third of its half angle's tangent squared, halved.
    pub(super) fn projection(&self) -> Projection {
        let tangent = (6.0 * SEEN).sqrt();
        Projection::from(PerspectiveProjection {
            fov: 2.0 * tangent.atan(),
            far: self.side,
            ..default()
        })
    }
}

/// A point in the cube from -1 to 1.
pub(super) fn point(rng: &mut ChaCha8Rng) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)))
}
