//! Trees and lamps, from the finest level on; after the last there is nothing.

use bevy::prelude::*;

use crate::solid::Solid;

const BARK: Srgba = Srgba::rgb(0.60, 0.48, 0.38);
const LEAVES: [Srgba; 3] = [
    Srgba::rgb(0.50, 0.68, 0.38),
    Srgba::rgb(0.56, 0.74, 0.42),
    Srgba::rgb(0.46, 0.64, 0.40),
];
const METAL: Srgba = Srgba::rgb(0.55, 0.57, 0.60);
const LIGHT: Srgba = Srgba::rgb(1.0, 0.96, 0.82);

/// A trunk with three balls of leaves, of which the coarsest level has one.
pub fn tree() -> [Solid; 3] {
    let crowns = [
        (Vec3::new(0.0, 4.6, 0.0), Vec3::new(1.7, 1.8, 1.7)),
        (Vec3::new(0.9, 3.7, 0.4), Vec3::new(1.3, 1.2, 1.3)),
        (Vec3::new(-0.8, 3.6, -0.4), Vec3::new(1.4, 1.2, 1.4)),
    ];
    let with_crowns = |sides: u32, splits: u32, count: usize| {
        let mut solid = Solid::default();
        solid.pole(Vec3::ZERO, 0.22, 3.4, sides, BARK);
        for ((center, radii), color) in crowns.into_iter().zip(LEAVES).take(count) {
            solid.ball(center, radii, splits, color);
        }
        solid
    };
    let mut coarse = Solid::default();
    coarse.pole(Vec3::ZERO, 0.22, 3.4, 3, BARK);
    coarse.ball(Vec3::new(0.0, 4.3, 0.0), Vec3::new(2.0, 2.1, 2.0), 0, LEAVES[0]);
    [with_crowns(10, 2, 3), with_crowns(5, 0, 3), coarse]
}

/// A post with two arms.
pub fn lamp() -> [Solid; 2] {
    let mut fine = Solid::default();
    fine.pole(Vec3::ZERO, 0.16, 0.7, 12, METAL);
    fine.pole(Vec3::ZERO, 0.07, 4.9, 12, METAL);
    fine.ball(Vec3::Y * 4.95, Vec3::splat(0.12), 1, METAL);
    fine.cuboid(Vec3::new(-0.9, 4.7, -0.03), Vec3::new(0.9, 4.78, 0.03), METAL);
    for side in [-0.9, 0.9] {
        fine.ball(Vec3::new(side, 4.5, 0.0), Vec3::splat(0.22), 2, LIGHT);
        fine.pole(Vec3::new(side, 4.66, 0.0), 0.2, 0.08, 10, METAL);
    }
    let mut coarse = Solid::default();
    coarse.pole(Vec3::ZERO, 0.08, 4.7, 3, METAL);
    coarse.cuboid(Vec3::new(-1.1, 4.35, -0.12), Vec3::new(1.1, 4.7, 0.12), LIGHT);
    [fine, coarse]
}
