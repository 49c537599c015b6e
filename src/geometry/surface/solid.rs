//! Surfaces that are the boundary of a solid.

use bevy::math::{DVec3, bounding::Aabb3d};

use super::{
    SurfaceHit,
    span::{Crossing, Line},
};
use crate::geometry::{
    ray::{Ray, triangle::Backfaces},
    rounding,
};

/// A solid around the origin, in double precision.
pub trait Solid {
    /// What a point on the boundary needs to know of its place to get its normal.
    type Face: Copy;

    /// Half the size of the smallest box around the origin that contains the solid.
    fn half_size(&self) -> DVec3;

    /// The size of what is round about it, whose normals depend on the last digits of a point. Infinite if there is no
    /// such thing.
    fn round_size(&self) -> f64;

    /// Where the ray, whose line this is, first crosses the boundary inward, or with [`Backfaces::Include`] outward.
    fn first_crossing(&self, line: &Line, ray: &Ray, backfaces: Backfaces) -> Option<Crossing<Self::Face>>;

    /// The hit where a ray crosses the boundary.
    fn hit(&self, crossing: Crossing<Self::Face>) -> SurfaceHit;
}

/// Implements `Surface` for a primitive by the solid that a reference to it converts into.
macro_rules! surface_by_solid {
    ($primitive:ty, $solid:ty) => {
        fn aabb(&self) -> Option<bevy::math::bounding::Aabb3d> {
            let half_size = <$solid>::from(self).half_size();
            $crate::geometry::surface::solid::enclosing_box(-half_size, half_size)
        }

        #[inline]
        fn closest_hit(&self, ray: &Ray, backfaces: Backfaces) -> Option<SurfaceHit> {
            let solid = <$solid>::from(self);
            let line = Line::of(ray, solid.round_size());
            let crossing = solid.first_crossing(&line, ray, backfaces)?;
            Some(solid.hit(crossing))
        }

        #[inline]
        fn any_hit(&self, ray: &Ray, backfaces: Backfaces) -> bool {
            let solid = <$solid>::from(self);
            let line = Line::of(ray, solid.round_size());
            solid.first_crossing(&line, ray, backfaces).is_some()
        }

        $crate::geometry::surface::own_hull!();
    };
}
pub(super) use surface_by_solid;

/// The smallest box of `f32` around the box, or `None` if that is not finite.
pub fn enclosing_box(min: DVec3, max: DVec3) -> Option<Aabb3d> {
    let (min, max) = (rounding::down3(min), rounding::up3(max));
    (min.is_finite() && max.is_finite()).then_some(Aabb3d { min, max })
}
