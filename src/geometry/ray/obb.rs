//! Ray against oriented box: the slab test in the axes of the box.

use bevy::math::DVec3;

use super::Ray;
use crate::geometry::{obb::Obb, tolerance};

impl Ray {
    /// The parameter at which the ray enters `obb`, in the space of both, or `None` if it misses.
    ///
    /// Its [`t_min`](Ray::t_min) where the ray starts inside. Conservative: never misses a box that the exact ray
    /// touches, whatever the zeros in its direction and however far off it starts, and may report one that it misses by
    /// [`tolerance::DOUBLE`] of its distance; the parameter is never too large. Source: Kay and Kajiya 1986, in double
    /// precision.
    #[inline]
    pub fn obb_intersection_at(&self, obb: &Obb) -> Option<f32> {
        let axes = obb.axes();
        let from_center = self.origin.as_dvec3() - obb.center().as_dvec3();
        let direction = self.direction.as_dvec3();
        let half_size = obb.half_size().as_dvec3();
        // Until the ray has left the box it goes no farther than this. It covers what the products with the axes round.
        let reach = from_center.abs().element_sum() + half_size.element_sum();
        let half_size = half_size + tolerance::DOUBLE * reach;

        let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
        for (axis, half) in [axes.x_axis, axes.y_axis, axes.z_axis]
            .into_iter()
            .zip(half_size.to_array())
        {
            let axis: DVec3 = axis.as_dvec3();
            let (start, recip) = (axis.dot(from_center), axis.dot(direction).recip());
            let (a, b) = ((-half - start) * recip, (half - start) * recip);
            let (near, far) = if recip >= 0.0 { (a, b) } else { (b, a) };
            // In a slab that the ray runs parallel to, both are infinite; a NaN, where all is infinite or all is zero,
            // compares false and is no bound.
            enter = if near > enter { near } else { enter };
            leave = if far < leave { far } else { leave };
        }
        self.entered(enter, leave)
    }
}
