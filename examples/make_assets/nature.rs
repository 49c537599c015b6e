//! Trees and people.

use crate::Level;
use crate::color::*;
use crate::math::{Vec3, cos_sin, noise, vec3};
use crate::outline::arched;
use crate::shape::Shape;

/// A broad crown of ragged clumps on a forked trunk.
pub fn tree_oak(level: Level) -> Shape {
    let clumps = [
        (vec3(0.0, 6.0, 0.0), 2.1),
        (vec3(1.9, 4.9, 0.5), 1.7),
        (vec3(-1.7, 5.1, 0.9), 1.8),
        (vec3(0.3, 4.7, -1.9), 1.75),
        (vec3(-1.2, 4.1, -1.4), 1.3),
        (vec3(0.9, 4.3, 1.9), 1.4),
        (vec3(1.0, 6.6, -0.9), 1.2),
    ];
    let clumps = &clumps[..level.pick(7, 6, 4)];
    let mut tree = Shape::default();
    for (i, &(center, radius)) in clumps.iter().enumerate() {
        let radius = radius * level.pick(1.0, 1.03, 1.12);
        let ragged = |way: Vec3| radius * (1.0 + 0.2 * noise(way * 2.3 + center, i as u32));
        let clump = Shape::blob(level.pick(2, 1, 1), ragged).scaled(1.0, 0.82, 1.0);
        tree += clump.at(center.x, center.y, center.z);
    }
    let tree = tree.painted_by(|p| {
        let light = (p.y - 3.0) / 5.0 + 0.25 * noise(p * 1.7, 9);
        SHADE_LEAF.mix(LEAF, light.clamp(0.0, 1.0))
    });
    let round = level.pick(9, 5, 4);
    let foot = [
        (vec3(0.0, 0.0, 0.0), 0.62),
        (vec3(0.0, 0.5, 0.0), 0.4),
        (vec3(0.1, 2.6, 0.0), 0.32),
    ];
    let mut trunk = Shape::tube(&foot, round);
    let limbs = &clumps[..level.pick(6, 4, 0)];
    for &(tip, _) in limbs {
        trunk += Shape::tube(&[(vec3(0.1, 2.2, 0.0), 0.24), (tip, 0.08)], level.pick(6, 4, 3));
    }
    if limbs.is_empty() {
        trunk += Shape::tube(&[(vec3(0.1, 2.5, 0.0), 0.3), (vec3(0.0, 4.6, 0.0), 0.2)], 3);
    }
    tree + trunk.painted(BARK)
}

/// Ragged skirts of needles, smaller and lighter towards the top.
pub fn tree_pine(level: Level) -> Shape {
    let skirts = level.pick(8, 5, 4);
    let points = level.pick(22, 12, 8);
    let mut tree = Shape::tube(&[(Vec3::ZERO, 0.34), (vec3(0.0, 7.4, 0.0), 0.08)], level.pick(8, 5, 3));
    tree = tree.painted(BARK);
    for skirt in 0..skirts {
        let t = skirt as f32 / (skirts - 1) as f32;
        let (y, radius) = (1.3 + 5.9 * t, 2.1 - 1.55 * t);
        let height = level.pick(1.5, 2.0, 2.5) * (1.15 - 0.35 * t);
        let rim = |reach: f32, rise: f32| -> Vec<Vec3> {
            let point = |i| {
                let (cos, sin) = cos_sin((i as f32 + 0.37 * skirt as f32) / points as f32);
                let ragged = noise(vec3(4.0 * cos, y * 3.0, 4.0 * sin), 5);
                let tip = if i % 2 == 0 { 1.0 } else { level.pick(0.72, 0.78, 0.85) };
                let reach = reach * tip * (1.0 + 0.12 * ragged);
                vec3(reach * sin, y + rise - 0.18 * reach * tip, reach * cos)
            };
            (0..points).map(point).collect()
        };
        let mut rings = vec![rim(0.15, 0.35), rim(radius, 0.0)];
        if level == Level::Full {
            rings.push(rim(radius * 0.55, height * 0.36));
        }
        rings.push(vec![vec3(0.0, y + height, 0.0); points]);
        let shade = |p: Vec3| {
            let out = (p.x * p.x + p.z * p.z).sqrt() / radius;
            SHADE_NEEDLE.mix(NEEDLE, (0.25 + 0.45 * out + 0.3 * t).clamp(0.0, 1.0))
        };
        tree += Shape::loft(&rings).painted_by(shade);
    }
    tree
}

/// Someone in a coat, walking.
pub fn person(level: Level) -> Shape {
    let round = level.pick(12, 8, 4);
    let limb = |path: &[(Vec3, f32)]| Shape::tube(path, level.pick(10, 5, 3));
    let mut person = Shape::default();
    for (side, stride) in [(0.1, 0.26), (-0.1, -0.26)] {
        let bend = if stride > 0.0 { 0.2 } else { -0.02 };
        let (hip, knee, ankle) = (vec3(side, 0.88, 0.0), vec3(side, 0.48, bend), vec3(side, 0.08, stride));
        let leg = [(hip, 0.095), (knee, 0.07), (ankle, 0.05)];
        person += limb(&leg).painted(DENIM);
        let sole: Vec<_> = arched(0.11, 0.29, level.pick(8, 4, 2))
            .iter()
            .map(|&[x, z]| [x, z - 0.09])
            .collect();
        person += Shape::prism(&sole, 0.09).painted(RUBBER).at(side, 0.0, stride);

        let (collar, shoulder) = (vec3(side * 1.1, 1.44, 0.0), vec3(side * 1.95, 1.37, 0.0));
        let elbow = vec3(side * 2.4, 1.14, -stride * 0.35 - 0.03);
        let hand = vec3(side * 2.2, 0.92, -stride * 0.9 + 0.06);
        let sleeve = [(collar, 0.045), (shoulder, 0.07), (elbow, 0.056), (hand, 0.042)];
        person += limb(&sleeve).painted(COAT);
        if level != Level::Far {
            let palm = Shape::blob(level.pick(1, 0, 0), |_| 0.055).smooth().painted(SKIN);
            person += palm.scaled(0.8, 1.3, 1.0).at(hand.x, hand.y - 0.04, hand.z);
        }
    }
    let coat = [
        [0.2, 0.66],
        [0.19, 0.8],
        [0.155, 1.02],
        [0.2, 1.3],
        [0.19, 1.42],
        [0.07, 1.5],
    ];
    let coat = match level {
        Level::Full => Shape::lathe(&coat, round),
        Level::Middle | Level::Far => Shape::lathe(&[coat[0], coat[2], coat[3], coat[5]], round),
    };
    person += coat.scaled(1.0, 1.0, 0.68).painted(COAT);
    person += Shape::cylinder(0.055, 0.14, level.pick(8, 5, 3))
        .painted(SKIN)
        .at(0.0, 1.44, 0.0);
    let ball = |splits: usize| Shape::blob(splits, |_| 1.0).smooth();
    person += ball(level.pick(2, 1, 0))
        .scaled(0.092, 0.118, 0.1)
        .painted(SKIN)
        .at(0.0, 1.625, 0.01);
    person += ball(level.pick(2, 1, 0))
        .scaled(0.1, 0.1, 0.105)
        .painted(HAIR)
        .at(0.0, 1.66, -0.022);
    if level == Level::Full {
        person += Shape::cone(0.02, 0.05, 6)
            .painted(SKIN)
            .turned_x(0.2)
            .at(0.0, 1.61, 0.1);
        let scarf = [[0.07, 0.0], [0.105, 0.02], [0.105, 0.07], [0.07, 0.09]];
        person += Shape::lathe(&scarf, 14).painted(AMBER).at(0.0, 1.45, 0.0);
        person += Shape::cuboid(0.07, 0.3, 0.025).painted(AMBER).at(0.05, 1.18, 0.135);
        person += Shape::cuboid(0.12, 0.34, 0.3).painted(WOOD).at(-0.25, 0.78, -0.08);
        let strap = [(vec3(-0.25, 1.08, -0.08), 0.014), (vec3(0.1, 1.47, -0.06), 0.014)];
        person += Shape::tube(&strap, 4).painted(WOOD);
        let button = Shape::blob(0, |_| 0.014).painted(BRASS);
        person += button.copied([0.85, 1.0, 1.13].map(|y| [0.0, y, 0.117]));
    }
    person
}
