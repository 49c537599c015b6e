//! Axis-aligned bounding boxes: what [`Aabb3d`] lacks.

use bevy::math::{
    Affine3A, DVec3, Mat3A, Vec3A,
    bounding::{Aabb3d, BoundingVolume},
};

use super::{
    ray::Ray,
    rounding,
    support::Support,
    tolerance,
    volume::{ExactAffine, UnboundablePoints, Volume},
};

/// More operations on [`Aabb3d`].
pub trait Aabb3dExt: Sized {
    /// The box of a shape under `transform`, which may rotate, scale, mirror, shear and flatten, from the support
    /// points of the shape.
    ///
    /// Contains the image of every point of the shape, as [`Affine3A::transform_point3a`] computes it, and is the
    /// tightest such box up to that rounding. `None` if a bound is not finite, or beyond its opposite, as of a sphere of
    /// negative radius.
    fn of(shape: &(impl Support + ?Sized), transform: &Affine3A) -> Option<Self>;

    /// Whether all six bounds are finite and `min <= max` on every axis.
    ///
    /// Everything else in this crate expects boxes that are sound.
    fn is_sound(&self) -> bool;
}

impl Aabb3dExt for Aabb3d {
    fn of(shape: &(impl Support + ?Sized), transform: &Affine3A) -> Option<Self> {
        let transform = ExactAffine::new(transform);
        let [min, max] = extent(shape, DVec3::AXES);
        let rounding = transform.rounding(min.abs().max(max.abs()));
        let rows = transform.matrix.transpose();
        let [image_min, image_max] = extent(shape, [rows.x_axis, rows.y_axis, rows.z_axis]);
        let image = Self {
            min: rounding::down3(image_min + transform.translation - rounding),
            max: rounding::up3(image_max + transform.translation + rounding),
        };
        (image.is_sound() && min.cmple(max).all()).then_some(image)
    }

    fn is_sound(&self) -> bool {
        self.min.is_finite() && self.max.is_finite() && self.min.cmple(self.max).all()
    }
}

/// The least and the greatest of the products of the shape's points with each of the directions.
fn extent(shape: &(impl Support + ?Sized), directions: [DVec3; 3]) -> [DVec3; 2] {
    let farthest = |direction: DVec3| {
        // The mapping wants a direction; a shape that is flattened along this one reaches nowhere.
        if direction == DVec3::ZERO {
            0.0
        } else {
            direction.dot(shape.support_point(direction))
        }
    };
    [
        DVec3::from_array(directions.map(|direction| -farthest(-direction))),
        DVec3::from_array(directions.map(farthest)),
    ]
}

impl Volume for Aabb3d {
    /// The smallest box. Never overflows: its bounds are coordinates of the points, though its size may be infinite in
    /// `f32`.
    fn enclosing(points: impl IntoIterator<Item = Vec3A>) -> Result<Self, UnboundablePoints> {
        let mut around = EMPTY;
        for (index, point) in points.into_iter().enumerate() {
            if !point.is_finite() {
                return Err(UnboundablePoints::NotFinite { index });
            }
            around = union(&around, &Self { min: point, max: point });
        }
        if around.is_sound() {
            Ok(around)
        } else {
            Err(UnboundablePoints::Empty)
        }
    }

    fn merged(&self, other: &Self) -> Self {
        union(self, other)
    }

    /// Contains the exact image of every point of this box, rounding included, and is the tightest such box up to
    /// [`tolerance::BOX_TRANSFORM`]. Source: Arvo, *Transforming Axis-Aligned Bounding Boxes*, Graphics Gems, 1990, in
    /// the form for centre and half extents (Ericson, *Real-Time Collision Detection*, 2005, §4.2.6).
    fn transformed_by_affine(&self, transform: &Affine3A) -> Self {
        let absolute = Mat3A::from_cols(
            transform.matrix3.x_axis.abs(),
            transform.matrix3.y_axis.abs(),
            transform.matrix3.z_axis.abs(),
        );
        // What is exactly zero underflows nowhere: a size, or a row of the transform.
        let underflow = Vec3A::splat(tolerance::UNDERFLOW);
        let underflow_in_row = underflow.min(absolute.x_axis + absolute.y_axis + absolute.z_axis);
        let (center, half_size) = (self.center(), self.half_size());
        let half_size = half_size + underflow.min(half_size);
        let new_center = transform.transform_point3a(center);
        let magnitude = absolute * (center.abs() + half_size) + transform.translation.abs();
        let new_half_size = absolute * half_size + magnitude * tolerance::BOX_TRANSFORM + underflow_in_row;
        let (min, max) = (new_center - new_half_size, new_center + new_half_size);
        Self {
            min: Vec3A::select(min.is_nan_mask(), Vec3A::NEG_INFINITY, min),
            max: Vec3A::select(max.is_nan_mask(), Vec3A::INFINITY, max),
        }
    }

    fn grown(&self, amount: f32) -> Self {
        Self {
            min: rounding::down3(self.min.as_dvec3() - f64::from(amount)),
            max: rounding::up3(self.max.as_dvec3() + f64::from(amount)),
        }
    }

    fn contains_point(&self, point: Vec3A) -> bool {
        point.cmpge(self.min).all() && point.cmple(self.max).all()
    }

    #[inline]
    fn ray_intersection_at(&self, ray: &Ray) -> Option<f32> {
        ray.aabb_intersection_at(self)
    }

    fn aabb(&self) -> Aabb3d {
        *self
    }

    fn volume(&self) -> f32 {
        size(self).element_product() as f32
    }

    fn surface_area(&self) -> f32 {
        let size = size(self);
        (2.0 * size.dot(DVec3::new(size.y, size.z, size.x))) as f32
    }
}

fn size(aabb: &Aabb3d) -> DVec3 {
    aabb.max.as_dvec3() - aabb.min.as_dvec3()
}

/// The box that contains both `a` and `b`.
#[inline]
pub(crate) fn union(a: &Aabb3d, b: &Aabb3d) -> Aabb3d {
    Aabb3d {
        min: a.min.min(b.min),
        max: a.max.max(b.max),
    }
}

/// The box that contains nothing: the neutral element of [`union`]. Not sound, and never handed out.
pub(crate) const EMPTY: Aabb3d = Aabb3d {
    min: Vec3A::INFINITY,
    max: Vec3A::NEG_INFINITY,
};

/// The box without end.
pub(crate) const EVERYTHING: Aabb3d = Aabb3d {
    min: Vec3A::NEG_INFINITY,
    max: Vec3A::INFINITY,
};
