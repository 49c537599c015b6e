//! Convex shapes by their support mapping: the point that is farthest in a direction.

use bevy::math::{
    DVec3, Vec3, Vec3A,
    bounding::{Aabb3d, BoundingSphere},
    primitives::{Segment3d, Triangle3d},
};

use super::{convex_hull::ConvexHull, intersection::polyhedron::ObbFrame, obb::Obb};

/// A convex shape that knows its farthest point in any direction (Ericson, *Real-Time Collision Detection*, 2005,
/// §3.3.1). Of a shape that is not convex, as a torus, it is the convex hull that this describes.
///
/// In double precision, so that what is built on it can round once, outward, at its end.
pub trait Support {
    /// A point of the shape that is farthest along `direction`, which may have any finite length but zero; in the space
    /// of the shape.
    fn support_point(&self, direction: DVec3) -> DVec3;
}

impl<S: Support + ?Sized> Support for &S {
    fn support_point(&self, direction: DVec3) -> DVec3 {
        (**self).support_point(direction)
    }
}

/// The point itself.
impl Support for DVec3 {
    fn support_point(&self, _direction: DVec3) -> DVec3 {
        *self
    }
}

/// The point itself.
impl Support for Vec3A {
    fn support_point(&self, _direction: DVec3) -> DVec3 {
        self.as_dvec3()
    }
}

impl Support for Segment3d {
    fn support_point(&self, direction: DVec3) -> DVec3 {
        farthest(self.vertices.map(Vec3::as_dvec3), direction)
    }
}

impl Support for Triangle3d {
    fn support_point(&self, direction: DVec3) -> DVec3 {
        farthest(self.vertices.map(Vec3::as_dvec3), direction)
    }
}

impl Support for BoundingSphere {
    fn support_point(&self, direction: DVec3) -> DVec3 {
        self.center.as_dvec3() + unit(direction) * f64::from(self.radius())
    }
}

impl Support for Aabb3d {
    fn support_point(&self, direction: DVec3) -> DVec3 {
        DVec3::select(direction.cmpge(DVec3::ZERO), self.max.as_dvec3(), self.min.as_dvec3())
    }
}

impl Support for Obb {
    fn support_point(&self, direction: DVec3) -> DVec3 {
        ObbFrame::from(self).support_point(direction)
    }
}

impl Support for ConvexHull {
    fn support_point(&self, direction: DVec3) -> DVec3 {
        let corner = farthest(self.vertices().iter().map(|vertex| vertex.as_dvec3()), direction);
        match self.margin() {
            0.0 => corner,
            margin => corner + unit(direction) * f64::from(margin),
        }
    }
}

/// The vector at unit length, or zero if that is zero. In two steps, because squares overflow and underflow.
pub(crate) fn unit(vector: DVec3) -> DVec3 {
    (vector / vector.abs().max_element()).normalize_or_zero()
}

/// The point that is farthest along `direction`; the origin if there are none.
pub(crate) fn farthest(points: impl IntoIterator<Item = DVec3>, direction: DVec3) -> DVec3 {
    let mut farthest = (f64::NEG_INFINITY, DVec3::ZERO);
    for point in points {
        let along = point.dot(direction);
        if along > farthest.0 {
            farthest = (along, point);
        }
    }
    farthest.1
}
