//! Oriented bounding boxes.

mod fit;
mod rectangle;
mod transform;

use bevy::math::{
    Affine3A, DMat3, DVec3, Mat3A, Quat, Vec3A,
    bounding::{Aabb3d, BoundingVolume},
};

use self::fit::Measure;
use super::{
    aabb,
    ray::Ray,
    rounding, tolerance,
    volume::{UnboundablePoints, Volume, finite},
};

/// A box with axes of its own.
///
/// Exactly, it is the points whose offset from the centre has a product with each axis no larger than the half size
/// there. Its axes being orthonormal only up to rounding, its [`corners`](Obb::corners) are those of this set up to a
/// few units in the last place of their distance from the centre; what is built by [`Volume`] is padded so that it
/// keeps its promise by either definition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obb {
    center: Vec3A,
    /// Half of its extent along each of its axes; never negative.
    half_size: Vec3A,
    /// Its axes as columns: orthonormal and right-handed, up to rounding.
    axes: Mat3A,
}

/// The same box, rounded outward.
impl From<Aabb3d> for Obb {
    fn from(aabb: Aabb3d) -> Self {
        let (min, max) = (aabb.min.as_dvec3(), aabb.max.as_dvec3());
        let center = min.midpoint(max).as_vec3a();
        let half_size = (max - center.as_dvec3()).max(center.as_dvec3() - min);
        Self::sound(center, half_size, Mat3A::IDENTITY)
    }
}

impl Obb {
    /// The box around `center` that reaches `half_size` along each of its axes, which are those of the space turned by
    /// `rotation`.
    ///
    /// Returns `None` if a number is NaN or infinite, if a half size is negative, or if the rotation is zero; one of
    /// another length is normalized.
    pub fn new(center: Vec3A, half_size: Vec3A, rotation: Quat) -> Option<Self> {
        let sound = center.is_finite() && half_size.is_finite() && half_size.cmpge(Vec3A::ZERO).all();
        let rotation = rotation.as_dquat().normalize();
        (sound && rotation.is_finite()).then(|| Self {
            center,
            half_size: half_size.abs(),
            axes: rounded_axes(DMat3::from_quat(rotation)),
        })
    }

    /// The centre.
    #[inline]
    pub fn center(&self) -> Vec3A {
        self.center
    }

    /// Half of the extent along each of the axes.
    #[inline]
    pub fn half_size(&self) -> Vec3A {
        self.half_size
    }

    /// The axes, as columns: unit vectors at right angles, right-handed.
    #[inline]
    pub fn axes(&self) -> Mat3A {
        self.axes
    }

    /// The eight corners: bit 0 of the index says which side along the first axis, bit 1 along the second, bit 2 along
    /// the third.
    pub fn corners(&self) -> [Vec3A; 8] {
        std::array::from_fn(|corner| {
            let side = |bit: usize| if corner >> bit & 1 == 0 { -1.0 } else { 1.0 };
            self.center + self.axes * (self.half_size * Vec3A::new(side(0), side(1), side(2)))
        })
    }

    /// The twelve edges, by their ends.
    pub fn edges(&self) -> [[Vec3A; 2]; 12] {
        let corners = self.corners();
        std::array::from_fn(|edge| {
            // Four edges along each axis, each from a corner without its bit to that with it.
            let (bit, place) = (1 << (edge / 4), edge % 4);
            let from = (place % bit) | (place / bit * bit * 2);
            [corners[from], corners[from | bit]]
        })
    }

    /// The box without end.
    const EVERYTHING: Self = Self {
        center: Vec3A::ZERO,
        half_size: Vec3A::INFINITY,
        axes: Mat3A::IDENTITY,
    };

    /// The smallest box with these axes around the points, up to rounding; infinite if it overflows.
    fn around(points: &[DVec3], axes: DMat3) -> Self {
        let axes = rounded_axes(axes);
        let exact = exact_axes(&axes);
        let [min, max] = extent(points, &exact);
        let center = (exact * min.midpoint(max)).as_vec3a();
        let half_size = points.iter().fold(DVec3::ZERO, |most, point| {
            most.max(exact.transpose() * (point - center.as_dvec3()))
                .max(exact.transpose() * (center.as_dvec3() - point))
        });
        Self::sound(center, half_size + skew(&exact, half_size), axes)
    }

    /// The box whose half sizes were computed in double precision, or, if a number is not finite, the box without end.
    fn sound(center: Vec3A, half_size: DVec3, axes: Mat3A) -> Self {
        let half_size = rounding::up3(half_size);
        if center.is_finite() && half_size.is_finite() && axes.is_finite() {
            Self {
                center,
                half_size,
                axes,
            }
        } else {
            Self::EVERYTHING
        }
    }

    /// The three vectors from the centre to the middles of the faces of the parallelepiped that contains this set,
    /// whether by the planes or by the corners: the points are the centre and sums of parts of them, from -1 to 1.
    fn generators(&self) -> DMat3 {
        let (axes, half_size) = (exact_axes(&self.axes), self.half_size.as_dvec3());
        axes * DMat3::from_diagonal(half_size + skew(&axes, half_size))
    }

    fn exact_corners(&self) -> [DVec3; 8] {
        let (center, generators) = (self.center.as_dvec3(), self.generators());
        std::array::from_fn(|corner| {
            let side = |bit: usize| if corner >> bit & 1 == 0 { -1.0 } else { 1.0 };
            center + generators * DVec3::new(side(0), side(1), side(2))
        })
    }

    /// The smallest box around the points with axes of the space, with the `others`, or with those of a search.
    fn fitted(points: &[DVec3], others: &[DMat3]) -> Self {
        let measure = Measure::among(points);
        let size = |obb: &Self| 2.0 * obb.half_size.as_dvec3();
        [fit::axes(points)]
            .iter()
            .chain(others)
            .map(|&axes| Self::around(points, axes))
            .fold(Self::around(points, DMat3::IDENTITY), |best, next| {
                if measure.of(size(&next)) < measure.of(size(&best)) {
                    next
                } else {
                    best
                }
            })
    }
}

/// How far a point with these coordinates, as products with the axes, may lie beyond the corners, and the reverse, because
/// the rounded axes are not quite at right angles: the inverse of `axesᵀ · axes` is `1 - (axesᵀ · axes - 1)` up to the
/// square of what these differ by.
fn skew(axes: &DMat3, half_size: DVec3) -> DVec3 {
    let off = (axes.transpose() * *axes - DMat3::IDENTITY).abs();
    off * half_size * (1.0 + f64::from(f32::EPSILON) * 8.0)
}

/// The products of the points with the axes: the least and the greatest.
fn extent(points: &[DVec3], axes: &DMat3) -> [DVec3; 2] {
    let rows = axes.transpose();
    points
        .iter()
        .map(|&point| rows * point)
        .fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[min, max], local| {
            [min.min(local), max.max(local)]
        })
}

fn exact_axes(axes: &Mat3A) -> DMat3 {
    DMat3::from_cols(axes.x_axis.as_dvec3(), axes.y_axis.as_dvec3(), axes.z_axis.as_dvec3())
}

/// The axes in single precision. What is smaller in them than the rounding of 1 is dropped, so that a box along a plane
/// or an axis of the space is so exactly.
fn rounded_axes(axes: DMat3) -> Mat3A {
    let rounded = |axis: DVec3| {
        let noise = axis.abs().cmplt(DVec3::splat(f64::from(f32::EPSILON) / 2.0));
        DVec3::select(noise, DVec3::ZERO, axis).as_vec3a()
    };
    Mat3A::from_cols(rounded(axes.x_axis), rounded(axes.y_axis), rounded(axes.z_axis))
}

impl Volume for Obb {
    /// A tight box: as a rule within a few percent of the smallest in volume, and never larger than the axis-aligned
    /// one, up to the rounding of its centre to `f32`. Of points that fill a box, and of its corners, that box up to
    /// rounding. Sets that are flat up to the rounding of their coordinates are fitted by area, and those on a line by
    /// length.
    ///
    /// The points are gone through some forty times; what is searched is a sample of them: see the source for how.
    fn enclosing(points: impl IntoIterator<Item = Vec3A>) -> Result<Self, UnboundablePoints> {
        let points: Vec<_> = finite(points)?.into_iter().map(Vec3A::as_dvec3).collect();
        let obb = Self::fitted(&points, &[]);
        if obb.is_endless() {
            Err(UnboundablePoints::Overflow)
        } else {
            Ok(obb)
        }
    }

    /// A tight box around both: the one that contains the other if one does, else fitted as by
    /// [`enclosing`](Volume::enclosing) around the corners of both.
    fn merged(&self, other: &Self) -> Self {
        let contains = |outer: &Self, inner: &Self| {
            let half_size = outer.half_size.as_dvec3() * (1.0 - tolerance::DOUBLE);
            let corners = inner.exact_corners();
            corners
                .iter()
                .all(|&corner| outer.local(corner).abs().cmple(half_size).all())
        };
        if self.is_endless() || other.is_endless() {
            return Self::EVERYTHING;
        }
        if self == other || contains(self, other) {
            return *self;
        }
        if contains(other, self) {
            return *other;
        }
        let corners = [self.exact_corners(), other.exact_corners()].concat();
        Self::fitted(&corners, &[exact_axes(&self.axes), exact_axes(&other.axes)])
    }

    /// A box around the image, which under a shear is no box. The tightest, up to rounding, where the transform keeps
    /// the axes at right angles: rotations, mirrors, uniform scales, and any scale along the axes of the box.
    fn transformed_by_affine(&self, transform: &Affine3A) -> Self {
        transform::transformed(self, transform)
    }

    fn grown(&self, amount: f32) -> Self {
        // The axes are orthonormal up to rounding, and so are the slabs between them as wide as their half sizes.
        let amount = f64::from(amount) * (1.0 + 4.0 * f64::from(f32::EPSILON));
        Self::sound(self.center, self.half_size.as_dvec3() + amount, self.axes)
    }

    fn contains_point(&self, point: Vec3A) -> bool {
        let local = self.local(point.as_dvec3());
        let slack = tolerance::DOUBLE * (point.as_dvec3() - self.center.as_dvec3()).abs().element_sum();
        local.abs().cmple(self.half_size.as_dvec3() + slack).all()
    }

    #[inline]
    fn ray_intersection_at(&self, ray: &Ray) -> Option<f32> {
        ray.obb_intersection_at(self)
    }

    fn aabb(&self) -> Aabb3d {
        if self.is_endless() {
            return aabb::EVERYTHING;
        }
        let (center, generators) = (self.center.as_dvec3(), self.generators().abs());
        let half_size = generators * DVec3::ONE * (1.0 + tolerance::DOUBLE);
        Aabb3d {
            min: rounding::down3(center - half_size),
            max: rounding::up3(center + half_size),
        }
    }

    fn volume(&self) -> f32 {
        (8.0 * self.half_size.as_dvec3().element_product()) as f32
    }

    fn surface_area(&self) -> f32 {
        let half = self.half_size.as_dvec3();
        (8.0 * half.dot(DVec3::new(half.y, half.z, half.x))) as f32
    }
}

impl Obb {
    /// The offset of a point from the centre, as its products with the axes.
    fn local(&self, point: DVec3) -> DVec3 {
        exact_axes(&self.axes).transpose() * (point - self.center.as_dvec3())
    }

    fn is_endless(&self) -> bool {
        *self == Self::EVERYTHING
    }
}

/// What Bevy asks of a bounding volume, rounded outward where it moves. A box does not become unsound by it: half sizes
/// that would become negative become zero.
impl BoundingVolume for Obb {
    type Translation = Vec3A;
    type Rotation = Quat;
    type HalfSize = Vec3A;

    fn center(&self) -> Vec3A {
        self.center
    }

    fn half_size(&self) -> Vec3A {
        self.half_size
    }

    fn visible_area(&self) -> f32 {
        self.surface_area() / 2.0
    }

    fn contains(&self, other: &Self) -> bool {
        self.is_endless() || !other.is_endless() && other.corners().iter().all(|&corner| self.contains_point(corner))
    }

    fn merge(&self, other: &Self) -> Self {
        self.merged(other)
    }

    fn grow(&self, amount: impl Into<Vec3A>) -> Self {
        self.with_half_size(self.half_size.as_dvec3() + amount.into().as_dvec3())
    }

    fn shrink(&self, amount: impl Into<Vec3A>) -> Self {
        self.with_half_size(self.half_size.as_dvec3() - amount.into().as_dvec3())
    }

    fn scale_around_center(&self, scale: impl Into<Vec3A>) -> Self {
        self.with_half_size(self.half_size.as_dvec3() * scale.into().as_dvec3().abs())
    }

    fn translate_by(&mut self, translation: impl Into<Vec3A>) {
        *self = self.transformed_by_affine(&Affine3A::from_translation(translation.into().into()));
    }

    fn rotate_by(&mut self, rotation: impl Into<Quat>) {
        *self = self.transformed_by_affine(&Affine3A::from_quat(rotation.into()));
    }
}

impl Obb {
    fn with_half_size(&self, half_size: DVec3) -> Self {
        Self::sound(
            self.center,
            DVec3::select(half_size.cmplt(DVec3::ZERO), DVec3::ZERO, half_size),
            self.axes,
        )
    }
}
