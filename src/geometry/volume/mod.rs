//! What the kinds of bounding volume have in common.

mod any;
mod tightness;

pub use any::{AnyVolume, BoundingKind};
pub use tightness::Tightness;

use bevy::math::{Affine3A, DMat3, DVec3, Vec3A, bounding::Aabb3d};

use super::{ray::Ray, tolerance};

/// A convex bounding volume: [`BoundingSphere`](bevy::math::bounding::BoundingSphere), [`Aabb3d`],
/// [`Obb`](super::obb::Obb) or [`ConvexHull`](super::convex_hull::ConvexHull).
///
/// **The promise:** a volume [contains](Volume::contains_point) every point that it was built from, every point of the
/// volumes that it was merged from, and after [`transformed_by_affine`](Volume::transformed_by_affine) the image of
/// every point that it contained, as [`Affine3A::transform_point3a`] computes it: rounding included. Every ray that
/// meets the exact volume is reported.
///
/// What overflows `f32` on the way, or is not a number, ends as a volume without end: it contains every point and every
/// ray enters it at its start, so that nothing is culled by it.
pub trait Volume: Sized {
    /// A volume of this kind around all `points`, in their space.
    ///
    /// # Errors
    ///
    /// If there are no points, if one has a NaN or infinite coordinate, or if they lie so far apart that the volume
    /// would overflow.
    fn enclosing(points: impl IntoIterator<Item = Vec3A>) -> Result<Self, UnboundablePoints>;

    /// A volume of this kind around both, in the space of both.
    fn merged(&self, other: &Self) -> Self;

    /// A volume of this kind around the image of this one under `transform`, which may rotate, scale, mirror, shear and
    /// flatten.
    fn transformed_by_affine(&self, transform: &Affine3A) -> Self;

    /// A volume of this kind around everything within `amount` of this one, in the units of its space. `amount` must not
    /// be negative or NaN.
    fn grown(&self, amount: f32) -> Self;

    /// Whether the volume contains the point, boundary included. Conservative: true of every point that the exact
    /// volume contains, and possibly of one that is outside by rounding.
    fn contains_point(&self, point: Vec3A) -> bool;

    /// The parameter at which the ray enters the volume, in the space of both, its
    /// [`t_min`](Ray::t_min) where it starts inside, or `None` if it misses. Conservative: see [`Volume`].
    fn ray_intersection_at(&self, ray: &Ray) -> Option<f32>;

    /// The axis-aligned box around the volume.
    fn aabb(&self) -> Aabb3d;

    /// The volume in cubic units of its space; zero if it is flat.
    fn volume(&self) -> f32;

    /// The surface area in square units of its space: four times the mean projected area (Cauchy's formula for convex
    /// bodies), which is what a random ray is hit by. Of a flat volume, both sides.
    fn surface_area(&self) -> f32;
}

/// Why there is no bounding volume around some points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum UnboundablePoints {
    /// There are no points.
    #[error("there are no points to bound")]
    Empty,
    /// A point has a coordinate that is NaN or infinite.
    #[error("point {index} has a NaN or infinite coordinate")]
    NotFinite {
        /// The number of the first such point.
        index: usize,
    },
    /// The points are finite, and so far out or apart that the volume overflows.
    #[error("the points lie too far out or apart: their bounding volume overflows")]
    Overflow,
}

/// The points, if there are any and all are finite.
pub(crate) fn finite(points: impl IntoIterator<Item = Vec3A>) -> Result<Vec<Vec3A>, UnboundablePoints> {
    let points: Vec<_> = points.into_iter().collect();
    match points.iter().position(|point| !point.is_finite()) {
        Some(index) => Err(UnboundablePoints::NotFinite { index }),
        None if points.is_empty() => Err(UnboundablePoints::Empty),
        None => Ok(points),
    }
}

/// An affine transform in double precision, and what [`Affine3A::transform_point3a`] rounds by.
pub(crate) struct ExactAffine {
    pub matrix: DMat3,
    pub translation: DVec3,
}

impl ExactAffine {
    pub fn new(transform: &Affine3A) -> Self {
        let matrix = transform.matrix3;
        Self {
            matrix: DMat3::from_cols(
                matrix.x_axis.as_dvec3(),
                matrix.y_axis.as_dvec3(),
                matrix.z_axis.as_dvec3(),
            ),
            translation: transform.translation.as_dvec3(),
        }
    }

    pub fn transform_point(&self, point: DVec3) -> DVec3 {
        self.matrix * point + self.translation
    }

    /// How far, along each axis, the image of a point whose coordinates are no larger than `reach` may be off in single
    /// precision. Infinite if that may overflow on its way.
    pub fn rounding(&self, reach: DVec3) -> DVec3 {
        let magnitude = self.matrix.abs() * reach + self.translation.abs();
        if magnitude.cmple(DVec3::splat(f32::MAX.into())).all() {
            magnitude * tolerance::TRANSFORMED_POINT + f64::from(tolerance::UNDERFLOW)
        } else {
            DVec3::INFINITY
        }
    }
}
