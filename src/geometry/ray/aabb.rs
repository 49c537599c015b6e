//! Ray against axis-aligned box: the slab test.

use bevy::math::bounding::Aabb3d;

use super::Ray;
use crate::geometry::tolerance;

impl Ray {
    /// The parameter at which the ray enters `aabb`, in the space of both, or `None` if it misses.
    ///
    /// Its [`t_min`](Ray::t_min) where the ray starts inside. Conservative: never misses a box that the exact ray touches,
    /// whatever the zeros in its direction, and may report one that it misses by [`tolerance::SLAB`]; the parameter is
    /// never too large. Of a box whose coordinates differ from those of the origin by more than [`f32::MAX`] it tells
    /// nothing. Source: Kay and Kajiya 1986, with the robust interval of Ize 2013.
    #[inline]
    pub fn aabb_intersection_at(&self, aabb: &Aabb3d) -> Option<f32> {
        let ray = self.slab_ray();
        let (mut enter, mut leave) = (ray.t_min, ray.t_max);
        for axis in 0..3 {
            let (near, far) = if ray.forward[axis] {
                (aabb.min[axis], aabb.max[axis])
            } else {
                (aabb.max[axis], aabb.min[axis])
            };
            let near = (near - ray.origin[axis]) * ray.direction_recip[axis];
            let far = (far - ray.origin[axis]) * ray.direction_recip[axis];
            // In a slab that the ray runs parallel to, both are infinite, or NaN where the ray runs in the very plane
            // of the face: no bound. A NaN compares false and changes nothing.
            enter = if near > enter { near } else { enter };
            leave = if far < leave { far } else { leave };
        }
        let (enter, leave) = ray.widen(enter, leave);
        // Outside of such a slab the ray enters at infinity: hence the strict upper bound.
        (enter <= leave && enter <= ray.t_max && enter < f32::INFINITY).then_some(enter)
    }

    /// What the slab test needs of the ray.
    #[inline]
    pub(crate) fn slab_ray(&self) -> SlabRay {
        let direction_recip = self.direction_recip.to_array();
        SlabRay {
            origin: self.origin.to_array(),
            direction_recip,
            forward: direction_recip.map(|recip| recip >= 0.0),
            t_min: self.t_min,
            t_max: self.t_max,
        }
    }
}

/// A ray prepared for many boxes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SlabRay {
    pub origin: [f32; 3],
    /// Infinite where the direction is zero.
    pub direction_recip: [f32; 3],
    /// Whether the ray enters through the minimum of each axis.
    pub forward: [bool; 3],
    pub t_min: f32,
    pub t_max: f32,
}

impl SlabRay {
    /// Moves the two ends of the interval in a box outward by their rounding, but not to before the start of the ray.
    #[inline]
    pub(crate) fn widen(&self, enter: f32, leave: f32) -> (f32, f32) {
        let enter = enter * (1.0 - tolerance::SLAB);
        (
            if enter > self.t_min { enter } else { self.t_min },
            leave * (1.0 + tolerance::SLAB),
        )
    }
}
