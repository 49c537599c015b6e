//! Ray against sphere.

use bevy::math::bounding::BoundingSphere;

use super::Ray;
use crate::geometry::{rounding, tolerance};

impl Ray {
    /// The parameter at which the ray enters `sphere`, in the space of both, or `None` if it misses.
    ///
    /// Its [`t_min`](Ray::t_min) where the ray starts inside. Conservative: never misses a sphere that the exact ray
    /// touches, however far off the ray starts, and may report one that it misses by [`tolerance::DOUBLE`] of the
    /// distance between the origin and the centre; the parameter is never too large. Source: Haines, Günther and
    /// Akenine-Möller, *Precision Improvements for Ray/Sphere Intersection*, Ray Tracing Gems, 2019, in double precision.
    #[inline]
    pub fn sphere_intersection_at(&self, sphere: &BoundingSphere) -> Option<f32> {
        let to_center = sphere.center.as_dvec3() - self.origin.as_dvec3();
        let direction = self.direction.as_dvec3();
        let length_squared = direction.length_squared();
        let closest = to_center.dot(direction) / length_squared;
        // The discriminant by the distance between the line and the centre, which does not cancel.
        let from_line = to_center - direction * closest;
        let slack = tolerance::DOUBLE * to_center.abs().element_sum();
        let radius = f64::from(sphere.radius()) + slack;
        let discriminant = radius * radius - from_line.length_squared();
        if discriminant < 0.0 {
            return None;
        }
        let half_chord = (discriminant.sqrt() + slack) / length_squared.sqrt();
        self.entered(closest - half_chord, closest + half_chord)
    }

    /// The start of what the ray and an interval that was computed in double precision have in common.
    #[inline]
    pub(crate) fn entered(&self, enter: f64, leave: f64) -> Option<f32> {
        let (t_min, t_max) = (f64::from(self.t_min), f64::from(self.t_max));
        let enter = enter * (1.0 - tolerance::DOUBLE);
        let leave = leave * (1.0 + tolerance::DOUBLE);
        let touches = enter <= leave && enter <= t_max && leave >= t_min && t_min <= t_max;
        touches.then(|| rounding::down(enter).max(self.t_min))
    }
}
