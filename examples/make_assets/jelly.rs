//! A jelly that hops in place, by morph targets: no joint is in it.

use crate::color::*;
use crate::math::{Vec3, cos_sin, vec3};
use crate::morph::{Morph, WeightClip};
use crate::shape::Shape;

pub fn morph() -> Morph {
    let base = jelly(|p| p);
    let targets = vec![
        ("squash", jelly(|p| vec3(p.x * 1.28, p.y * 0.62, p.z * 1.28))),
        ("stretch", jelly(|p| vec3(p.x * 0.8, p.y * 1.5, p.z * 0.8))),
        (
            "lean",
            jelly(|p| vec3(p.x + 0.55 * p.y * p.y, p.y - 0.1 * p.y * p.y, p.z)),
        ),
    ];
    // Squashed twice in the time in which it leans to either side once.
    let weights = |phase: f32| {
        let (beat, _) = cos_sin(2.0 * phase);
        let (_, side) = cos_sin(phase);
        vec![beat.max(0.0), (-beat).max(0.0), 0.6 * side]
    };
    const STEPS: usize = 48;
    let clip = WeightClip {
        name: "hop",
        seconds: 1.6,
        weights: (0..=STEPS)
            .map(|i| weights((i % STEPS) as f32 / STEPS as f32))
            .collect(),
    };
    Morph { base, targets, clip }
}

/// The jelly with every point of it moved.
fn jelly(moved: impl Fn(Vec3) -> Vec3) -> Shape {
    // A ball that sits on its flat side.
    let sits = |p: Vec3| vec3(p.x, (p.y + 0.36).max(0.0), p.z);
    let body = Shape::blob(3, |_| 0.5).moved(sits).moved(&moved).smooth();
    let body = body.painted_by(|p| TEAL.mix(GREEN, (p.y * 1.1).clamp(0.0, 1.0)));
    let ball = |radius: f32| Shape::blob(1, |_| radius);
    let eyes = ball(0.075).scaled(0.75, 1.0, 0.6).at(0.15, 0.48, 0.425).both_sides();
    let glints = ball(0.02).at(0.17, 0.51, 0.468).both_sides();
    let face = eyes.moved(&moved).smooth().painted(INK) + glints.moved(&moved).smooth().painted(Color::WHITE);
    let path: Vec<(Vec3, f32)> = (0..=6)
        .map(|i| (i as f32 - 3.0) / 3.0)
        .map(|x| (vec3(0.09 * x, 0.345 + 0.03 * x * x, 0.492 - 0.012 * x * x), 0.012))
        .collect();
    let mouth = Shape::tube(&path, 6).moved(&moved).smooth();
    body + face + mouth.painted(INK)
}
