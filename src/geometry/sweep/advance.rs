//! Conservative advancement along a straight line.
//!
//! The distance from a moving point to a convex set is a convex function of time. Where the set lies behind a plane, the
//! contact is no earlier than that with the plane: stepping from plane to plane is Newton's method from the left, which
//! cannot overshoot (van den Bergen, *Ray Casting against General Convex Objects with Application to Continuous Collision
//! Detection*, 2004; Mirtich, *Impulse-based Dynamic Simulation of Rigid Body Systems*, 1996, §2.3).

use bevy::math::DVec3;

use crate::geometry::{
    intersection::{gjk::Separation, polyhedron::Line},
    ray::Ray,
    tolerance::{DOUBLE, SWEEP_CONTACT},
};

use super::round_within;

/// A proof that the moving shape and the other are apart.
#[derive(Clone, Copy, Debug)]
pub(super) struct Apart {
    /// How far apart they are at least.
    distance: f64,
    /// The unit vector along which they are, towards the moving shape.
    normal: DVec3,
    /// How far the normal may be off, as an angle.
    tilt: f64,
}

impl Apart {
    /// Of a moving point, and the point of the other shape closest to it.
    pub(super) fn by_closest_point(point: DVec3, closest: DVec3) -> Self {
        let gap = point - closest;
        let distance = gap.length();
        Self {
            distance,
            normal: gap.normalize_or_zero(),
            tilt: (DOUBLE * point.abs().max(closest.abs()).max_element() / distance).min(1.0),
        }
    }
}

impl From<Separation> for Apart {
    fn from(separation: Separation) -> Self {
        Self {
            distance: separation.bound,
            normal: separation.normal,
            tilt: 0.0,
        }
    }
}

/// A tangential contact is a double root, where the steps halve the remaining time: enough for all digits. What is still
/// on its way then has come too close to tell, and counts as touching.
const STEPS: usize = 128;

/// The first parameter at which the moving shape, whose extent around the ray is `size`, is within `radius` of the other;
/// `apart` tells how far it is when it has come to a point of the ray.
pub(super) fn first_contact(ray: &Ray, size: f64, radius: f64, apart: impl Fn(DVec3) -> Apart) -> Option<f32> {
    let line = Line::from(ray);
    let speed = line.direction.length();
    let mut t = line.interval.first;
    let belongs = |t: f64| t <= line.interval.last;
    if !belongs(t) {
        return None;
    }
    for _ in 0..STEPS {
        let position = line.origin + line.direction * t;
        let apart = apart(position);
        let contact = SWEEP_CONTACT * (position.abs().max_element() + size + radius);
        let ahead = apart.distance - radius - contact;
        if ahead <= 0.0 {
            break;
        }
        let closing = (apart.tilt + DOUBLE) * speed - apart.normal.dot(line.direction);
        if closing <= 0.0 {
            return None;
        }
        // Into the middle of the zone that counts as contact.
        t += (ahead + contact / 2.0) / closing;
        if !belongs(t) {
            return None;
        }
    }
    Some(round_within(t, ray))
}
