//! Moving spheres: a ray against the other shape, grown by the radius (Ericson, *Real-Time Collision Detection*, 2005,
//! §5.5).

use bevy::math::{
    Vec3A,
    bounding::{Aabb3d, BoundingSphere},
    primitives::{Segment3d, Triangle3d},
};

use super::{
    SweepIntersection,
    advance::{Apart, first_contact},
};
use crate::geometry::{
    closest_point::ClosestPoint, convex_hull::ConvexHull, intersection::gjk, obb::Obb, ray::Ray, support::Support,
};

/// A sphere whose centre moves along a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereSweep {
    ray: Ray,
    radius: f32,
}

impl SphereSweep {
    /// The sphere of this radius, in units of the space of the ray.
    ///
    /// Returns `None` if the radius is negative, NaN or infinite.
    pub fn new(ray: Ray, radius: f32) -> Option<Self> {
        (radius >= 0.0 && radius.is_finite()).then_some(Self { ray, radius })
    }

    /// The path of the centre.
    pub fn ray(&self) -> &Ray {
        &self.ray
    }

    /// The radius.
    pub fn radius(&self) -> f32 {
        self.radius
    }

    fn at_closest_point(&self, shape: &impl ClosestPoint) -> Option<f32> {
        first_contact(&self.ray, 0.0, self.radius.into(), |center| {
            Apart::by_closest_point(center, shape.closest_point_f64(center))
        })
    }

    fn at_support(&self, shape: &impl Support) -> Option<f32> {
        first_contact(&self.ray, 0.0, self.radius.into(), |center| {
            gjk::distance(&center, shape).into()
        })
    }
}

impl SweepIntersection<Vec3A> for SphereSweep {
    fn intersection_at(&self, point: &Vec3A) -> Option<f32> {
        let point = point.as_dvec3();
        first_contact(&self.ray, 0.0, self.radius.into(), |center| {
            Apart::by_closest_point(center, point)
        })
    }
}

impl SweepIntersection<Segment3d> for SphereSweep {
    fn intersection_at(&self, segment: &Segment3d) -> Option<f32> {
        self.at_closest_point(segment)
    }
}

impl SweepIntersection<BoundingSphere> for SphereSweep {
    fn intersection_at(&self, sphere: &BoundingSphere) -> Option<f32> {
        let (standing, radii) = (
            sphere.center.as_dvec3(),
            f64::from(self.radius) + f64::from(sphere.radius()),
        );
        first_contact(&self.ray, 0.0, radii, |center| {
            Apart::by_closest_point(center, standing)
        })
    }
}

impl SweepIntersection<Aabb3d> for SphereSweep {
    fn intersection_at(&self, aabb: &Aabb3d) -> Option<f32> {
        self.at_closest_point(aabb)
    }
}

impl SweepIntersection<Obb> for SphereSweep {
    fn intersection_at(&self, obb: &Obb) -> Option<f32> {
        self.at_support(obb)
    }
}

impl SweepIntersection<ConvexHull> for SphereSweep {
    fn intersection_at(&self, hull: &ConvexHull) -> Option<f32> {
        self.at_support(hull)
    }
}

impl SweepIntersection<Triangle3d> for SphereSweep {
    fn intersection_at(&self, triangle: &Triangle3d) -> Option<f32> {
        self.at_closest_point(triangle)
    }
}
