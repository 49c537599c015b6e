//! Ray against axis-aligned box: the slab test.

use bevy::math::{Vec3A, bounding::Aabb3d};

use super::Ray;
use crate::geometry::tolerance;

impl Ray {
    /// The parameter at which the ray enters `aabb`, in the space of both, or `None` if it misses.
    ///
    /// Zero where the ray starts inside. Conservative: never misses a box that the exact ray touches, whatever the
    /// zeros in its direction, and may report one that it misses by [`tolerance::SLAB`]; the parameter is never too
    /// large. Source: Kay and Kajiya 1986, with the robust interval of Ize 2013.
    #[inline]
    pub fn aabb_intersection_at(&self, aabb: &Aabb3d) -> Option<f32> {
        let forward = self.direction_recip.cmpge(Vec3A::ZERO);
        let near = (Vec3A::select(forward, aabb.min, aabb.max) - self.origin) * self.direction_recip;
        let far = (Vec3A::select(forward, aabb.max, aabb.min) - self.origin) * self.direction_recip;
        // In a slab that the ray runs parallel to, both are infinite, or NaN where the ray runs in the very plane of
        // the face: no bound. The constant comes second because `min` and `max` return the second for a NaN.
        let enter = near.max(Vec3A::ZERO).max_element() * (1.0 - tolerance::SLAB);
        let leave = far.min(Vec3A::INFINITY).min_element() * (1.0 + tolerance::SLAB);
        // Outside of such a slab the ray enters at infinity: hence the strict upper bound.
        (enter <= leave && enter <= self.t_max && enter < f32::INFINITY).then_some(enter)
    }
}
