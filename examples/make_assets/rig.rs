//! Skeletons, skins and poses over time.

use crate::math::{Vec3, cos_sin, vec3};
use crate::shape::Shape;

/// A joint in the pose in which the skin was made; there no joint is turned.
#[derive(Clone, Debug)]
pub struct Joint {
    pub name: String,
    /// Its number in the rig; parents come before their children.
    pub parent: Option<usize>,
    pub at: Vec3,
    /// Where what it moves ends: about where its child is.
    pub end: Vec3,
}

/// A part of the skin, and the joints that may move it.
pub struct Part {
    pub shape: Shape,
    pub joints: Vec<usize>,
}

/// A skeleton with its skin and what it can do.
pub struct Rig {
    pub joints: Vec<Joint>,
    pub skin: Vec<Part>,
    pub clips: Vec<Clip>,
}

/// How a vertex follows up to four joints: their numbers, and weights that sum to 255.
pub type Influences = ([u8; 4], [u8; 4]);

impl Rig {
    /// Follows the bones of the part nearest to a point, the nearer the more.
    pub fn influences(&self, part: &Part, point: Vec3) -> Influences {
        // Metres within which bones are equally near, so that skin over a joint bends and does not break.
        const SOFT: f32 = 0.02;
        let mut near: Vec<(f32, usize)> = part
            .joints
            .iter()
            .map(|&number| {
                let joint = &self.joints[number];
                let away = from_segment(point, joint.at, joint.end);
                let near = 1.0 / (away * away + SOFT * SOFT);
                (near * near, number)
            })
            .collect();
        near.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        near.truncate(4);
        let sum: f32 = near.iter().map(|(weight, _)| weight).sum();
        let (mut joints, mut weights) = ([0; 4], [0; 4]);
        for (i, (weight, number)) in near.into_iter().enumerate() {
            weights[i] = (weight / sum * 255.0) as u8;
            joints[i] = if weights[i] > 0 { number as u8 } else { 0 };
        }
        // What rounding down has left over.
        weights[0] += 255 - weights.iter().sum::<u8>();
        (joints, weights)
    }
}

fn from_segment(point: Vec3, from: Vec3, to: Vec3) -> f32 {
    let (way, off) = (to - from, point - from);
    let t = (off.dot(way) / way.dot(way)).clamp(0.0, 1.0);
    (off - way * t).length()
}

/// Poses at equal times, the last as the first.
pub struct Clip {
    pub name: &'static str,
    pub seconds: f32,
    pub poses: Vec<Pose>,
}

/// The turn of each joint against its parent, and where the first joint is.
#[derive(Clone, Debug)]
pub struct Pose {
    pub root: Vec3,
    pub turns: Vec<Turn>,
}

/// A rotation as a unit quaternion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    pub axis: Vec3,
    pub w: f32,
}

impl Turn {
    pub const NONE: Self = Self {
        axis: Vec3::ZERO,
        w: 1.0,
    };

    /// About the x axis, from +y towards +z, by an angle in whole turns.
    pub fn nod(turns: f32) -> Self {
        let (w, sin) = cos_sin(turns / 2.0);
        Self {
            axis: vec3(sin, 0.0, 0.0),
            w,
        }
    }

    /// About the y axis, from +z towards +x.
    pub fn shake(turns: f32) -> Self {
        let (w, sin) = cos_sin(turns / 2.0);
        Self {
            axis: vec3(0.0, sin, 0.0),
            w,
        }
    }

    /// About the z axis, from +x towards +y.
    pub fn tilt(turns: f32) -> Self {
        let (w, sin) = cos_sin(turns / 2.0);
        Self {
            axis: vec3(0.0, 0.0, sin),
            w,
        }
    }

    /// About the x axis, from one direction to another, both square to it and less than half a turn apart.
    pub fn between(from: Vec3, to: Vec3) -> Self {
        let (from, to) = (from.normalized(), to.normalized());
        let half = (from + to).normalized();
        Self {
            axis: vec3(from.cross(half).x, 0.0, 0.0),
            w: from.dot(half),
        }
    }

    /// First `other`, then this.
    pub fn after(self, other: Self) -> Self {
        Self {
            axis: other.axis * self.w + self.axis * other.w + self.axis.cross(other.axis),
            w: self.w * other.w - self.axis.dot(other.axis),
        }
    }

    pub fn inverse(self) -> Self {
        Self {
            axis: -self.axis,
            w: self.w,
        }
    }

    pub fn apply(self, v: Vec3) -> Vec3 {
        let twice = self.axis.cross(v) * 2.0;
        v + twice * self.w + self.axis.cross(twice)
    }
}
