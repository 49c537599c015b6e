//! Ray against axis-aligned box: the slab test.

use bevy::math::bounding::Aabb3d;

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
        let to_min = (aabb.min - self.origin) * self.direction_recip;
        let to_max = (aabb.max - self.origin) * self.direction_recip;
        let enter = to_min.min(to_max).max_element().max(0.0) * (1.0 - tolerance::SLAB);
        let leave = to_min.max(to_max).min_element() * (1.0 + tolerance::SLAB);
        // A ray parallel to a slab and outside of it enters at infinity: hence the strict upper bound.
        (enter <= leave && enter <= self.t_max && enter < f32::INFINITY).then_some(enter)
    }
}
