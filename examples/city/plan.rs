//! Where everything stands: a plan of the city, the same on every run.

use std::f32::consts::{FRAC_PI_2, PI};

use bevy::prelude::*;
use rand::{Rng, SeedableRng, seq::IndexedRandom};
use rand_chacha::ChaCha8Rng;

/// From the middle of one street to that of the next, in metres.
pub const PITCH: f32 = 84.0;
/// The width of a street between the pavements.
pub const STREET: f32 = 12.0;
/// From the kerb to the lots.
pub const PAVEMENT: f32 = 6.0;
/// How many blocks of a district are not alike.
pub const DESIGNS: u32 = 256;

/// One thing in the city: the name of its model, and where it stands.
pub struct Placement {
    pub model: &'static str,
    pub transform: Transform,
    /// The number of its block.
    pub block: u32,
}

/// What a block is used for.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub enum District {
    Downtown,
    Midtown,
    Houses,
    Works,
    Park,
}

/// A city of square blocks around the origin.
pub struct Plan {
    pub blocks: u32,
}

impl Plan {
    /// Half the side of the city, to the middle of the outermost streets.
    pub fn half_size(&self) -> f32 {
        self.blocks as f32 * PITCH / 2.0
    }

    /// The centre of each block with its use, in a fixed order.
    pub fn districts(&self) -> impl Iterator<Item = (Vec3, District)> + '_ {
        (0..self.blocks * self.blocks).map(|index| {
            let cell = Vec2::new((index % self.blocks) as f32, (index / self.blocks) as f32);
            let center = (cell + 0.5) * PITCH - self.half_size();
            let mut rng = ChaCha8Rng::seed_from_u64(u64::from(index));
            let from_center = center.length() / self.half_size() + rng.random_range(-0.08..0.08);
            let district = match from_center {
                _ if rng.random_bool(0.08) => District::Park,
                d if d < 0.35 => District::Downtown,
                d if d < 0.7 => District::Midtown,
                d if d > 1.0 && rng.random_bool(0.4) => District::Works,
                _ => District::Houses,
            };
            (Vec3::new(center.x, 0.0, center.y), district)
        })
    }

    /// Everything that does not move.
    pub fn placements(&self) -> Vec<Placement> {
        let mut placements = Vec::new();
        for (number, (center, district)) in (0..).zip(self.districts()) {
            let mut block = Block {
                number,
                center,
                rng: ChaCha8Rng::seed_from_u64(u64::from(1000 + number % DESIGNS)),
                placements: &mut placements,
            };
            block.build(district);
            block.furnish_pavement();
        }
        placements
    }
}

/// A block that is being filled.
struct Block<'a> {
    number: u32,
    center: Vec3,
    rng: ChaCha8Rng,
    placements: &'a mut Vec<Placement>,
}

/// Half the side of a block between the kerbs, and between the pavements.
const KERB: f32 = (PITCH - STREET) / 2.0;
const LOTS: f32 = KERB - PAVEMENT;

impl Block<'_> {
    fn put(&mut self, model: &'static str, x: f32, z: f32, yaw: f32) {
        self.put_scaled(model, x, z, yaw, Vec3::ONE);
    }

    fn put_scaled(&mut self, model: &'static str, x: f32, z: f32, yaw: f32, scale: Vec3) {
        self.placements.push(Placement {
            model,
            transform: Transform {
                translation: self.center + Vec3::new(x, 0.15, z),
                rotation: Quat::from_rotation_y(yaw),
                scale,
            },
            block: self.number,
        });
    }

    fn any(&mut self, models: &[&'static str]) -> &'static str {
        models.choose(&mut self.rng).expect("a list of models")
    }

    /// A model on each of `n` x `n` lots, facing the nearer street, with a scale drawn from `heights` upward.
    fn fill_lots(&mut self, n: u32, models: &[&'static str], heights: std::ops::Range<f32>) {
        let lot = 2.0 * LOTS / n as f32;
        for index in 0..n * n {
            let x = ((index % n) as f32 + 0.5) * lot - LOTS;
            let z = ((index / n) as f32 + 0.5) * lot - LOTS;
            let model = self.any(models);
            let height = self.rng.random_range(heights.clone());
            let yaw = if z < 0.0 { PI } else { 0.0 };
            self.put_scaled(model, x, z, yaw, Vec3::new(1.0, height, 1.0));
        }
    }

    fn build(&mut self, district: District) {
        match district {
            District::Downtown => self.fill_lots(
                2,
                &["tower_round", "tower_twisted", "tower_stepped", "tower_glass"],
                0.7..1.5,
            ),
            District::Midtown => self.fill_lots(
                2,
                &[
                    "office_block",
                    "apartment_block",
                    "apartment_block",
                    "corner_shop",
                    "tower_glass",
                ],
                0.8..1.15,
            ),
            District::Houses => self.build_houses(),
            District::Works => {
                self.fill_lots(2, &["warehouse"], 0.9..1.3);
                self.put("water_tower", 0.0, 0.0, 0.0);
            }
            District::Park => self.build_park(),
        }
    }

    /// Two rows of houses with their backs to each other, and gardens between.
    fn build_houses(&mut self) {
        for row in [-1.0, 1.0] {
            for house in 0..6 {
                let x = (house as f32 - 2.5) * 9.6;
                let model = if house == 0 { "corner_shop" } else { "row_house" };
                let z = if house == 0 { LOTS - 10.0 } else { LOTS - 6.0 };
                self.put(model, x, row * z, if row < 0.0 { PI } else { 0.0 });
            }
            for _ in 0..7 {
                let (x, z) = (
                    self.rng.random_range(-26.0..26.0),
                    row * self.rng.random_range(3.0..13.0),
                );
                self.plant(x, z);
            }
        }
    }

    fn build_park(&mut self) {
        let (model, scale) = match self.rng.random_range(0..5) {
            0 => ("statue", 2.0),
            1 => ("fountain", 1.3),
            2 => ("pavilion_dome", 1.3),
            3 => ("arch_gate", 1.0),
            _ => ("church", 1.1),
        };
        self.put_scaled(model, 0.0, 0.0, 0.0, Vec3::splat(scale));
        self.put("bridge_arch", 0.0, 22.0, 0.0);
        for _ in 0..40 {
            let angle = self.rng.random_range(0.0..2.0 * PI);
            let (sin, cos) = angle.sin_cos();
            let distance = self.rng.random_range(17.0..LOTS);
            if (sin * distance - 22.0).abs() > 7.0 {
                self.plant(cos * distance, sin * distance);
            }
        }
        for side in 0..4 {
            let yaw = side as f32 * FRAC_PI_2;
            let place = Quat::from_rotation_y(yaw) * Vec3::new(0.0, 0.0, 14.0);
            self.put("bench", place.x, place.z, yaw + PI);
        }
    }

    fn plant(&mut self, x: f32, z: f32) {
        let model = self.any(&["tree_oak", "tree_oak", "tree_pine"]);
        let yaw = self.rng.random_range(0.0..2.0 * PI);
        let scale = self.rng.random_range(0.7..1.25);
        self.put_scaled(model, x, z, yaw, Vec3::splat(scale));
    }

    /// Lamps, trees and the rest along the four kerbs.
    fn furnish_pavement(&mut self) {
        for side in 0..4 {
            let yaw = side as f32 * FRAC_PI_2;
            let along = Quat::from_rotation_y(yaw);
            let put = |block: &mut Self, model, x: f32, from_kerb: f32, turn: f32| {
                let place = along * Vec3::new(x, 0.0, KERB - from_kerb);
                block.put(model, place.x, place.z, yaw + turn);
            };
            for i in 0..4 {
                let x = (i as f32 - 1.5) * 17.0;
                put(self, "lamp_street", x, 1.0, 0.0);
                put(self, "tree_oak", x + 6.0, 2.2, i as f32);
            }
            put(self, "traffic_light", KERB - 1.0, 1.0, 0.0);
            put(self, "bench", -5.0, 4.0, 0.0);
            put(self, "hydrant", 10.0, 1.2, 0.0);
            if side == 0 {
                put(self, "bus_stop", 2.0, 2.5, 0.0);
            }
        }
    }
}
