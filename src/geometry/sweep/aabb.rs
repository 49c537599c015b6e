//! Moving axis-aligned boxes.

use bevy::math::{
    DMat3, DVec3, Vec3A,
    bounding::{Aabb3d, BoundingSphere},
    primitives::{Segment3d, Triangle3d},
};

use super::{
    SweepIntersection,
    advance::{Apart, first_contact},
    round_within,
};
use crate::geometry::{
    convex_hull::ConvexHull,
    intersection::{
        gjk,
        polyhedron::{Line, ObbFrame},
        sat::{self, Polytope},
    },
    obb::Obb,
    ray::Ray,
};

/// An axis-aligned box whose centre moves along a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AabbSweep {
    ray: Ray,
    half_size: Vec3A,
}

impl AabbSweep {
    /// The box that reaches `half_size` from its centre along each axis, in units of the space of the ray.
    ///
    /// Returns `None` if a coordinate of the half size is negative, NaN or infinite.
    pub fn new(ray: Ray, half_size: impl Into<Vec3A>) -> Option<Self> {
        let half_size = half_size.into();
        (half_size.cmpge(Vec3A::ZERO).all() && half_size.is_finite()).then_some(Self { ray, half_size })
    }

    /// The path of the centre.
    pub fn ray(&self) -> &Ray {
        &self.ray
    }

    /// Half of the extent along each axis.
    pub fn half_size(&self) -> Vec3A {
        self.half_size
    }

    /// The box with its centre at a point.
    fn around(&self, center: DVec3) -> ObbFrame {
        ObbFrame {
            center,
            half_size: self.half_size.as_dvec3(),
            axes: DMat3::IDENTITY,
        }
    }

    /// By the intervals of time in which no axis separates the two.
    fn at_polytope(&self, shape: &impl Polytope) -> Option<f32> {
        let path = Line::from(&self.ray);
        let interval = sat::touch_while_moving(&self.around(path.origin), path.direction, shape, path.interval);
        (!interval.is_empty()).then(|| round_within(interval.first, &self.ray))
    }
}

impl SweepIntersection<Vec3A> for AabbSweep {
    fn intersection_at(&self, point: &Vec3A) -> Option<f32> {
        self.at_polytope(&Aabb3d {
            min: *point,
            max: *point,
        })
    }
}

impl SweepIntersection<Segment3d> for AabbSweep {
    fn intersection_at(&self, segment: &Segment3d) -> Option<f32> {
        self.at_polytope(segment)
    }
}

impl SweepIntersection<BoundingSphere> for AabbSweep {
    fn intersection_at(&self, sphere: &BoundingSphere) -> Option<f32> {
        let (standing, half_size) = (sphere.center.as_dvec3(), self.half_size.as_dvec3());
        let size = half_size.max_element();
        first_contact(&self.ray, size, sphere.radius().into(), |center| {
            // The closest point of the box, as seen from its centre, moves with it.
            let closest = center + (standing - center).clamp(-half_size, half_size);
            Apart::by_closest_point(closest, standing)
        })
    }
}

impl SweepIntersection<Aabb3d> for AabbSweep {
    fn intersection_at(&self, aabb: &Aabb3d) -> Option<f32> {
        self.at_polytope(aabb)
    }
}

impl SweepIntersection<Obb> for AabbSweep {
    fn intersection_at(&self, obb: &Obb) -> Option<f32> {
        self.at_polytope(&ObbFrame::from(obb))
    }
}

/// By [GJK](gjk), step by step: a hull has too many edges for separating axes.
impl SweepIntersection<ConvexHull> for AabbSweep {
    fn intersection_at(&self, hull: &ConvexHull) -> Option<f32> {
        let size = f64::from(self.half_size.max_element());
        first_contact(&self.ray, size, 0.0, |center| {
            gjk::distance(&self.around(center), hull).into()
        })
    }
}

impl SweepIntersection<Triangle3d> for AabbSweep {
    fn intersection_at(&self, triangle: &Triangle3d) -> Option<f32> {
        self.at_polytope(triangle)
    }
}
