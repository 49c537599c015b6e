//! Axis-aligned bounding boxes: what [`Aabb3d`] lacks.

use bevy::math::{
    Affine3A, Mat3A, Vec3A,
    bounding::{Aabb3d, BoundingVolume},
};

use super::tolerance;

/// More operations on [`Aabb3d`].
pub trait Aabb3dExt: Sized {
    /// The smallest box that contains all `points`, or `None` if there are none.
    ///
    /// NaN coordinates are ignored.
    fn enclosing(points: impl IntoIterator<Item = Vec3A>) -> Option<Self>;

    /// Whether all six bounds are finite and `min <= max` on every axis.
    ///
    /// Everything else in this crate expects boxes that are sound.
    fn is_sound(&self) -> bool;

    /// The box of this box under `transform`, which may rotate, scale, mirror and shear.
    ///
    /// Contains the exact image of every point of this box, rounding included, and is the tightest such box up to
    /// [`tolerance::BOX_TRANSFORM`]. Source: Arvo, *Transforming Axis-Aligned Bounding Boxes*, Graphics Gems, 1990, in
    /// the form for centre and half extents (Ericson, *Real-Time Collision Detection*, 2005, §4.2.6).
    fn transformed_by_affine(&self, transform: &Affine3A) -> Self;
}

impl Aabb3dExt for Aabb3d {
    fn enclosing(points: impl IntoIterator<Item = Vec3A>) -> Option<Self> {
        let around = points.into_iter().fold(EMPTY, |around, point| Self {
            // The accumulator comes second: where one operand is NaN, `min` and `max` return the second.
            min: point.min(around.min),
            max: point.max(around.max),
        });
        (around.min.cmple(around.max).all()).then_some(around)
    }

    fn is_sound(&self) -> bool {
        self.min.is_finite() && self.max.is_finite() && self.min.cmple(self.max).all()
    }

    fn transformed_by_affine(&self, transform: &Affine3A) -> Self {
        let absolute = Mat3A::from_cols(
            transform.matrix3.x_axis.abs(),
            transform.matrix3.y_axis.abs(),
            transform.matrix3.z_axis.abs(),
        );
        let (center, half_size) = (self.center(), self.half_size());
        let new_center = transform.transform_point3a(center);
        let magnitude = absolute * (center.abs() + half_size) + transform.translation.abs();
        let new_half_size = absolute * half_size + magnitude * tolerance::BOX_TRANSFORM;
        Self {
            min: new_center - new_half_size,
            max: new_center + new_half_size,
        }
    }
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
