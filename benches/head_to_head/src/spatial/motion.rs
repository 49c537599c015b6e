//! Scenes in motion.

use bevy::math::{Vec3A, bounding::Aabb3d};
use rand::{Rng, seq::index};
use rand_chacha::ChaCha8Rng;

use super::scenes::{Scene, direction, rng, vector};

/// A box moves: its index, and where it is then.
pub(crate) type Move = (u32, Aabb3d);

/// How the boxes of a scene move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Motion {
    /// A share of the boxes drifts, always the same, each at its own speed of half a centimetre to five a frame.
    Drift(f32),
    /// A share of the boxes jumps, in each frame other ones, to anywhere at the same height.
    Teleport(f32),
}

/// A scene in motion.
pub(crate) struct Movement {
    motion: Motion,
    boxes: Vec<Aabb3d>,
    bounds: Aabb3d,
    /// What drifts, and where to.
    drifting: Vec<(u32, Vec3A)>,
    rng: ChaCha8Rng,
}

impl Movement {
    pub fn new(scene: &Scene, motion: Motion) -> Self {
        let mut rng = rng(scene.boxes.len(), 20);
        let drifting = match motion {
            Motion::Drift(share) => sample(scene.boxes.len(), share, &mut rng)
                .map(|index| (index, direction(&mut rng) * rng.random_range(0.005..0.05)))
                .collect(),
            Motion::Teleport(_) => Vec::new(),
        };
        Self {
            motion,
            boxes: scene.boxes.clone(),
            bounds: scene.bounds,
            drifting,
            rng,
        }
    }

    /// Where the boxes are now.
    pub fn boxes(&self) -> &[Aabb3d] {
        &self.boxes
    }

    /// What moves in the next frame.
    pub fn frame(&mut self) -> Vec<Move> {
        match self.motion {
            Motion::Drift(_) => self.drift(),
            Motion::Teleport(share) => self.teleport(share),
        }
    }

    fn drift(&mut self) -> Vec<Move> {
        let mut moves = Vec::with_capacity(self.drifting.len());
        for (index, velocity) in &mut self.drifting {
            let aabb = &mut self.boxes[*index as usize];
            // What leaves the scene turns back.
            let out = (aabb.min + *velocity).cmplt(self.bounds.min) | (aabb.max + *velocity).cmpgt(self.bounds.max);
            *velocity = Vec3A::select(out, -*velocity, *velocity);
            *aabb = Aabb3d {
                min: aabb.min + *velocity,
                max: aabb.max + *velocity,
            };
            moves.push((*index, *aabb));
        }
        moves
    }

    fn teleport(&mut self, share: f32) -> Vec<Move> {
        let indices: Vec<u32> = sample(self.boxes.len(), share, &mut self.rng).collect();
        let moves = indices.into_iter().map(|index| {
            let aabb = &mut self.boxes[index as usize];
            let size = aabb.max - aabb.min;
            let room = (self.bounds.max - self.bounds.min - size).max(Vec3A::ZERO);
            // The height stays: what stands on the ground goes on doing so.
            let min = (self.bounds.min + room * (vector(&mut self.rng) / 2.0 + 0.5)).with_y(aabb.min.y);
            *aabb = Aabb3d { min, max: min + size };
            (index, *aabb)
        });
        moves.collect()
    }
}

fn sample(n: usize, share: f32, rng: &mut ChaCha8Rng) -> impl Iterator<Item = u32> + use<> {
    let amount = ((n as f32 * share) as usize).max(1);
    index::sample(rng, n, amount).into_iter().map(|index| index as u32)
}
