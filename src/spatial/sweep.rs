//! Shapes that move along a ray, as structures are asked for what they touch.

use bevy::math::{Vec3A, bounding::Aabb3d};

use crate::geometry::{
    ray::Ray,
    sweep::{AabbSweep, SphereSweep, SweepIntersection},
    tolerance,
};

/// A shape that moves along a ray: structures find the boxes that it touches on its way.
///
/// A [`SphereSweep`] touches a box with its round surface, an [`AabbSweep`] with its faces; as exactly as
/// [`SweepIntersection`] tells.
pub trait Sweep: SweepIntersection<Aabb3d> {
    /// The path of the centre.
    fn ray(&self) -> &Ray;

    /// How far the shape reaches from its centre along each axis.
    fn reach(&self) -> Vec3A;

    /// This shape, moving no farther than to the parameter `t_max`.
    #[must_use]
    fn with_t_max(self, t_max: f32) -> Self
    where
        Self: Sized;
}

impl Sweep for SphereSweep {
    fn ray(&self) -> &Ray {
        self.ray()
    }

    fn reach(&self) -> Vec3A {
        Vec3A::splat(self.radius())
    }

    fn with_t_max(self, t_max: f32) -> Self {
        Self::new(self.ray().with_t_max(t_max), self.radius()).expect("the radius of a sweep")
    }
}

impl Sweep for AabbSweep {
    fn ray(&self) -> &Ray {
        self.ray()
    }

    fn reach(&self) -> Vec3A {
        self.half_size()
    }

    fn with_t_max(self, t_max: f32) -> Self {
        Self::new(self.ray().with_t_max(t_max), self.half_size()).expect("the half size of a sweep")
    }
}

/// A box that the ray enters before `sweep` can touch anything in `aabb`.
pub(crate) fn grown(aabb: &Aabb3d, reach: Vec3A) -> Aabb3d {
    let (min, max) = (aabb.min - reach, aabb.max + reach);
    let contact = aabb.min.abs().max(aabb.max.abs()).max_element() * CONTACT;
    Aabb3d {
        min: min - min.abs() * f32::EPSILON - contact,
        max: max + max.abs() * f32::EPSILON + contact,
    }
}

/// What counts as contact, as a fraction of the largest coordinate of a box: twice that of the point where it is touched.
pub(crate) const CONTACT: f32 = 2.0 * tolerance::SWEEP_CONTACT as f32;

/// How far boxes must be [`grown`] for a sweep: its reach, and what counts as contact.
pub(crate) fn slack_reach(sweep: &impl Sweep) -> Vec3A {
    let largest = sweep.ray().origin().abs().max(sweep.reach());
    sweep.reach() * (1.0 + f32::EPSILON) + Vec3A::splat(largest.max_element() * tolerance::SWEEP_REACH)
}
