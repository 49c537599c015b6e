//! Where everything stands: the same on every run.

use std::f32::consts::{FRAC_PI_2, PI};

use bevy::prelude::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::house::STYLES;

/// From the middle of one street to that of the next, in metres.
pub const PITCH: f32 = 76.0;
/// The width of a street between the kerbs.
pub const STREET: f32 = 12.0;
/// How high the ground of a block is above the street.
pub const KERB: f32 = 0.15;

/// From the middle of a block to that of a row of houses, and from house to house in it.
const ROW: f32 = 20.0;
const LOT: f32 = 10.6;
const HOUSES: u32 = 5;

/// A city of square blocks around the origin.
#[derive(Clone, Copy)]
pub struct Plan {
    pub blocks: u32,
}

/// A block, with where things stand relative to its middle.
pub struct Block {
    pub center: Vec3,
    /// With the number of the style of each.
    pub houses: Vec<(usize, Transform)>,
    pub garden_trees: Vec<Transform>,
    pub street_trees: Vec<Transform>,
    pub lamps: Vec<Transform>,
}

impl Plan {
    /// Half the side of the city, to the middle of the outermost streets.
    pub fn half_size(&self) -> f32 {
        self.blocks as f32 * PITCH / 2.0
    }

    /// The middle of the street that is nearest to that of the city.
    pub fn main_street(&self) -> f32 {
        (self.blocks / 2) as f32 * PITCH - self.half_size()
    }

    /// All blocks, in a fixed order.
    pub fn blocks(self) -> impl Iterator<Item = Block> {
        (0..self.blocks * self.blocks).map(move |number| {
            let cell = Vec2::new((number % self.blocks) as f32, (number / self.blocks) as f32);
            let center = (cell + 0.5) * PITCH - self.half_size();
            let mut rng = ChaCha8Rng::seed_from_u64(u64::from(number));
            Block::new(Vec3::new(center.x, KERB, center.y), &mut rng)
        })
    }
}

impl Block {
    fn new(center: Vec3, rng: &mut ChaCha8Rng) -> Self {
        let mut houses = Vec::new();
        for (row, yaw) in [(ROW, 0.0), (-ROW, PI)] {
            for house in 0..HOUSES {
                let x = (house as f32 - (HOUSES - 1) as f32 / 2.0) * LOT;
                let place = Vec3::new(x, 0.0, row + rng.random_range(-0.6..0.6));
                let style = rng.random_range(0..STYLES.len());
                houses.push((
                    style,
                    Transform::from_translation(place).with_rotation(Quat::from_rotation_y(yaw)),
                ));
            }
        }
        let mut plant = |place: Vec3| Transform {
            translation: place,
            rotation: Quat::from_rotation_y(rng.random_range(0.0..2.0 * PI)),
            scale: Vec3::splat(rng.random_range(0.75..1.2)),
        };
        let along_kerb = |x: f32, side: u32| {
            let turn = Quat::from_rotation_y(side as f32 * FRAC_PI_2);
            (turn, turn * Vec3::new(x, 0.0, (PITCH - STREET) / 2.0 - 1.2))
        };
        let garden_trees = (0..8).map(|tree| {
            let x = (tree as f32 - 3.5) * 6.8;
            plant(Vec3::new(x, 0.0, if tree % 2 == 0 { 4.5 } else { -4.5 }))
        });
        let garden_trees = garden_trees.collect();
        let street_trees = (0..8).map(|tree| plant(along_kerb([-9.0, 9.0][tree as usize % 2], tree / 2).1));
        let street_trees = street_trees.collect();
        let lamps = (0..8).map(|lamp| {
            let (turn, place) = along_kerb([-20.0, 20.0][lamp as usize % 2], lamp / 2);
            Transform::from_translation(place).with_rotation(turn)
        });
        Self {
            center,
            houses,
            garden_trees,
            street_trees,
            lamps: lamps.collect(),
        }
    }
}
