//! Ways to walk, around and around.

use bevy::prelude::*;

/// How far ahead and behind corners are rounded, in metres.
const ROUNDING: f32 = 0.8;

/// A closed way over the ground: x and z of its corners.
#[derive(Clone, Debug)]
pub struct Walk(pub Vec<Vec2>);

impl Walk {
    /// Where one is after some metres, and in which direction one walks there.
    pub fn at(&self, along: f32) -> (Vec2, Vec2) {
        const STEPS: i32 = 4;
        let mut place = Vec2::ZERO;
        for step in -STEPS..=STEPS {
            place += self.corner_to_corner(along + ROUNDING * step as f32 / STEPS as f32);
        }
        let ahead = self.corner_to_corner(along + ROUNDING) - self.corner_to_corner(along - ROUNDING);
        (place / (2 * STEPS + 1) as f32, ahead.normalize_or(Vec2::Y))
    }

    fn corner_to_corner(&self, along: f32) -> Vec2 {
        let sides = || self.0.iter().zip(self.0.iter().cycle().skip(1));
        let length: f32 = sides().map(|(from, to)| from.distance(*to)).sum();
        let mut left = along.rem_euclid(length);
        for (from, to) in sides() {
            let side = from.distance(*to);
            if left <= side {
                return from.lerp(*to, left / side);
            }
            left -= side;
        }
        self.0[0]
    }
}

/// The angle around y by which something that faces +z faces in a direction over the ground.
pub fn yaw_of(direction: Vec2) -> f32 {
    direction.x.atan2(direction.y)
}
