//! A city to hide things in: streets in a grid, buildings on both sides, and small things before and behind them.

use std::f32::consts::{FRAC_PI_2, TAU};

use bevy::prelude::*;
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use crate::common::*;

/// From the middle of one street to that of the next, in metres.
pub const PITCH: f32 = 60.0;
/// From house to house across a street.
const STREET: f32 = 16.0;
/// Things in a block.
const PER_BLOCK: usize = 40;

/// What a thing in the city is.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    Ground,
    Building,
    Lamp,
    Car,
    Crate,
}

/// The meshes of the city, which its things share.
struct Models {
    buildings: Vec<Mesh3d>,
    lamp: Mesh3d,
    car: Mesh3d,
    crates: Vec<Mesh3d>,
}

/// Where things in a city are.
pub struct City {
    /// Blocks on a side.
    pub blocks: u32,
}

impl City {
    /// Builds a city of so many things, and the ground under it: the same for the same seed. Call [`settle`] before
    /// asking it anything.
    pub fn build(app: &mut App, things: usize, seed: u64) -> Self {
        let mut rng = rng(seed);
        let blocks = (things.div_ceil(PER_BLOCK) as f32).sqrt().ceil() as u32;
        let city = Self { blocks };
        let models = Models::new(app, &mut rng);
        let side = 2.0 * city.half_size() + 2.0 * STREET;
        let ground = add_mesh(app, Plane3d::default().mesh().size(side, side));
        app.world_mut().spawn((Part::Ground, Mesh3d(ground)));
        let mut left = things;
        for block in 0..blocks * blocks {
            let cell = Vec2::new((block % blocks) as f32, (block / blocks) as f32);
            let center = (cell + 0.5) * PITCH - city.half_size();
            for (part, mesh, place) in models.furnish(&mut rng).into_iter().take(left) {
                left -= 1;
                let center = Transform::from_xyz(center.x, 0.0, center.y);
                app.world_mut().spawn((part, mesh, center * place));
            }
        }
        city
    }

    /// Half the side, to the middle of the outermost streets.
    pub fn half_size(&self) -> f32 {
        self.blocks as f32 * PITCH / 2.0
    }

    /// Somewhere to look from: by turns in a street along it, on a crossing anywhere, on a pavement close to a wall,
    /// and over the roofs.
    pub fn view(&self, number: u32, rng: &mut ChaCha8Rng) -> Transform {
        let mut street = || rng.random_range(0..=self.blocks) as f32 * PITCH - self.half_size();
        let (x, z) = (street(), street());
        let (along, yaw) = (rng.random_range(-0.5..0.5) * PITCH, rng.random_range(0.0..TAU));
        let (place, yaw, pitch) = match number % 4 {
            0 => {
                let yaw = if rng.random() { 0.0 } else { std::f32::consts::PI };
                (Vec3::new(x, 1.7, z + along), yaw + rng.random_range(-0.1..0.1), 0.0)
            }
            1 => (Vec3::new(x, 1.7, z), yaw, rng.random_range(-0.1..0.2)),
            2 => (Vec3::new(x + STREET / 2.0 - 0.4, 1.7, z + along), yaw, 0.1),
            _ => (Vec3::new(x, 70.0, z + along), yaw, rng.random_range(-0.6..-0.2)),
        };
        Transform::from_translation(place).with_rotation(Quat::from_euler(EulerRot::YXZ, yaw, pitch, 0.0))
    }
}

impl Models {
    fn new(app: &mut App, rng: &mut ChaCha8Rng) -> Self {
        let mut mesh = |mesh: Mesh| Mesh3d(add_mesh(app, mesh));
        // They stand on the ground where they are put.
        let standing = |size: Vec3| Mesh::from(Cuboid::from_size(size)).translated_by(Vec3::Y * size.y / 2.0);
        let buildings = (0..12)
            .map(|_| {
                let height = 8.0 + 50.0 * rng.random::<f32>().powi(3);
                let (width, depth) = (rng.random_range(13.0..19.5), rng.random_range(13.0..19.5));
                mesh(standing(Vec3::new(width, height, depth)))
            })
            .collect();
        let joined = |parts: [Mesh; 2]| {
            let [mut whole, part] = parts;
            whole.merge(&part).expect("both have the same attributes");
            whole
        };
        let pole = Mesh::from(Cylinder::new(0.08, 5.0)).translated_by(Vec3::Y * 2.5);
        let head = Mesh::from(Cuboid::new(0.3, 0.15, 0.9)).translated_by(Vec3::new(0.0, 5.0, 0.4));
        let body = standing(Vec3::new(1.8, 0.9, 4.4));
        let cabin = standing(Vec3::new(1.6, 0.6, 2.2)).translated_by(Vec3::Y * 0.9);
        Self {
            buildings,
            lamp: mesh(joined([pole, head])),
            car: mesh(joined([body, cabin])),
            crates: [0.5, 0.9, 1.4].map(|size| mesh(standing(Vec3::splat(size)))).into(),
        }
    }

    /// What stands on a block, seen from its middle.
    fn furnish(&self, rng: &mut ChaCha8Rng) -> Vec<(Part, Mesh3d, Transform)> {
        let mut things = Vec::with_capacity(PER_BLOCK);
        let kerb = (PITCH - STREET) / 2.0;
        let at = |x: f32, z: f32, yaw: f32| Transform::from_xyz(x, 0.0, z).with_rotation(Quat::from_rotation_y(yaw));
        for lot in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            let mesh = &self.buildings[rng.random_range(0..self.buildings.len())];
            // Some askew, so that not every wall is along an axis.
            let yaw = if rng.random_bool(0.2) {
                rng.random_range(-0.15..0.15)
            } else {
                0.0
            };
            let turns = f32::from(rng.random_range(0..4_u8)) * FRAC_PI_2;
            things.push((
                Part::Building,
                mesh.clone(),
                at(lot.0 * kerb / 2.0, lot.1 * kerb / 2.0, yaw + turns),
            ));
        }
        for side in 0..4 {
            let turn = Quat::from_rotation_y(f32::from(side as u8) * FRAC_PI_2);
            let mut put = |part, mesh: &Mesh3d, place: Transform| {
                things.push((part, mesh.clone(), Transform::from_rotation(turn) * place));
            };
            for x in [-14.0, 14.0] {
                put(Part::Lamp, &self.lamp, at(x, kerb + 1.0, 0.0));
            }
            for _ in 0..2 {
                let x = rng.random_range(-kerb..kerb);
                let yaw = FRAC_PI_2 + rng.random_range(-0.1..0.1);
                put(Part::Car, &self.car, at(x, kerb + 3.6, yaw));
            }
            let mut any = |put: &mut dyn FnMut(Part, &Mesh3d, Transform), x, z| {
                let mesh = &self.crates[rng.random_range(0..self.crates.len())];
                put(Part::Crate, mesh, at(x, z, rng.random_range(0.0..TAU)));
            };
            // On the pavement, in the lane between two buildings, and in the yard behind.
            any(&mut put, 10.0 * f32::from(side as u8) - 15.0, kerb + 0.8);
            for z in [16.0, 11.0, 6.0, 1.0] {
                any(&mut put, 0.2 * z - 1.0, z);
            }
        }
        things
    }
}

#[test]
fn a_city_has_as_many_things_as_are_asked_for_and_is_the_same_every_time() {
    let places = |things, seed| {
        let mut app = headless_app();
        City::build(&mut app, things, seed);
        let mut parts = app.world_mut().query::<(&Part, &Transform)>();
        let parts = parts.iter(app.world());
        parts.map(|(&part, &place)| (part, place)).collect::<Vec<_>>()
    };
    let city = places(1000, 1);
    assert_eq!(city.len(), 1001, "and the ground");
    assert_eq!(city, places(1000, 1));
    assert_ne!(city, places(1000, 2));
    for part in [Part::Building, Part::Lamp, Part::Car, Part::Crate] {
        assert!(
            city.iter().filter(|(other, _)| *other == part).count() >= 100,
            "{part:?}"
        );
    }
}
