//! Rays, and one file for each shape that a ray is tested against.

pub mod aabb;
pub mod convex_hull;
pub mod obb;
pub mod sphere;
pub mod triangle;

use bevy::math::{DAffine3, DVec3, Ray3d, Vec3, Vec3A};

/// A ray or a segment: the points `origin + t * direction` for `t_min <= t <= t_max`, where `t_min` is zero unless
/// [`with_interval`](Ray::with_interval) has moved it.
///
/// Unlike [`Ray3d`], the direction may have any length, so that a ray keeps its parameter `t` under every affine
/// transform: a hit found in the local space of a mesh is a hit in the world at the same `t`. A ray from
/// [`Ray::from_ray3d`] has a unit direction, and `t` is the distance in the units of its space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    origin: Vec3A,
    direction: Vec3A,
    /// `1 / direction`: infinite where that is zero.
    direction_recip: Vec3A,
    t_min: f32,
    t_max: f32,
}

impl Ray {
    /// The ray from `origin` along `direction`, up to and including the parameter `t_max`.
    ///
    /// Returns `None` if the direction is zero, if a coordinate is NaN or infinite, or if `t_max` is negative or NaN.
    /// `t_max` may be infinite. Coordinates of the direction below [`f32::MIN_POSITIVE`], whose reciprocals overflow, are
    /// taken for zero.
    pub fn new(origin: impl Into<Vec3A>, direction: impl Into<Vec3A>, t_max: f32) -> Option<Self> {
        let (origin, direction): (Vec3A, Vec3A) = (origin.into(), direction.into());
        let vanishes = direction.abs().cmplt(Vec3A::splat(f32::MIN_POSITIVE));
        let direction = Vec3A::select(vanishes, Vec3A::ZERO, direction);
        let sound = origin.is_finite() && direction.is_finite() && direction != Vec3A::ZERO && t_max >= 0.0;
        sound.then(|| Self {
            origin,
            direction,
            direction_recip: direction.recip(),
            t_min: 0.0,
            t_max,
        })
    }

    /// The ray along `ray`, up to `max_distance`, with `t` the distance.
    ///
    /// Returns `None` where [`Ray::new`] does.
    pub fn from_ray3d(ray: Ray3d, max_distance: f32) -> Option<Self> {
        Self::new(ray.origin, ray.direction.as_vec3(), max_distance)
    }

    /// The segment between two points, with `t` from 0 at `from` to 1 at `to`.
    ///
    /// Returns `None` if the points coincide, or if a coordinate is NaN or infinite.
    pub fn segment(from: Vec3, to: Vec3) -> Option<Self> {
        Self::new(from, to - from, 1.0)
    }

    /// The start of the ray.
    #[inline]
    pub fn origin(&self) -> Vec3A {
        self.origin
    }

    /// The direction, of any length but zero.
    #[inline]
    pub fn direction(&self) -> Vec3A {
        self.direction
    }

    /// `1 / direction`: infinite where that is zero.
    #[inline]
    pub(crate) fn direction_recip(&self) -> Vec3A {
        self.direction_recip
    }

    /// The axes along which the ray enters boxes through their maximum, bit by bit.
    #[inline]
    pub(crate) fn backward(&self) -> u32 {
        self.direction_recip.cmplt(Vec3A::ZERO).bitmask()
    }

    /// The smallest parameter that belongs to the ray; never negative.
    #[inline]
    pub fn t_min(&self) -> f32 {
        self.t_min
    }

    /// The largest parameter that belongs to the ray; may be infinite.
    #[inline]
    pub fn t_max(&self) -> f32 {
        self.t_max
    }

    /// Whether `t` is finite and belongs to the ray.
    #[inline]
    pub fn has_parameter(&self, t: f32) -> bool {
        t >= self.t_min && t <= self.t_max && t < f32::INFINITY
    }

    /// The point at the parameter `t`.
    #[inline]
    pub fn at(&self, t: f32) -> Vec3A {
        self.origin + self.direction * t
    }

    /// This ray, ending at `t_max`, which must not be negative or NaN.
    #[inline]
    #[must_use]
    pub fn with_t_max(self, t_max: f32) -> Self {
        debug_assert!(t_max >= 0.0);
        Self { t_max, ..self }
    }

    /// The part of this line from `t_min` to `t_max`, which must not be negative or NaN. Nothing is in it if
    /// `t_min > t_max`.
    #[inline]
    #[must_use]
    pub fn with_interval(self, t_min: f32, t_max: f32) -> Self {
        debug_assert!(t_min >= 0.0 && t_max >= 0.0);
        Self { t_min, t_max, ..self }
    }

    /// The same points under `transform`, with the same parameters.
    ///
    /// In double precision: a ray that starts far from the origin of the world, and close to the mesh into whose space
    /// it is taken, keeps the digits that it has. Returns `None` if the direction becomes zero or a coordinate
    /// overflows.
    #[inline]
    pub fn transformed_by(&self, transform: &DAffine3) -> Option<Self> {
        let (origin, direction) = self.exactly_under(transform);
        let ray = Self::new(origin.as_vec3(), direction.as_vec3(), self.t_max)?;
        Some(Self {
            t_min: self.t_min,
            ..ray
        })
    }

    /// The parameter `t` of a hit on a triangle in the space that `transform` leads to, right to the last digit.
    ///
    /// What a test after [`transformed_by`](Self::transformed_by) finds is off by the rounding of the coordinates there:
    /// a micrometre for a mesh of some metres, which is much for a ray that starts a millimetre before it. The plane of
    /// the triangle decides, within the extent of the triangle along the ray: of a triangle that is seen edge-on, the
    /// plane is met anywhere.
    pub fn refined_under(&self, transform: &DAffine3, triangle: [Vec3; 3], t: f32) -> f32 {
        let (origin, direction) = self.exactly_under(transform);
        let [a, b, c] = triangle.map(|corner| corner.as_dvec3() - origin);
        let normal = (b - a).cross(c - a);
        let exact = normal.dot(a) / normal.dot(direction);
        let along = DVec3::new(a.dot(direction), b.dot(direction), c.dot(direction)) / direction.length_squared();
        if !exact.is_finite() || !along.is_finite() {
            return t;
        }
        exact.clamp(along.min_element(), along.max_element()) as f32
    }

    fn exactly_under(&self, transform: &DAffine3) -> (DVec3, DVec3) {
        let origin = Vec3::from(self.origin).as_dvec3();
        let direction = Vec3::from(self.direction).as_dvec3();
        (
            transform.transform_point3(origin),
            transform.transform_vector3(direction),
        )
    }
}
