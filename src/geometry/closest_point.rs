//! The point of a shape that is closest to a point (Ericson, *Real-Time Collision Detection*, 2005, §5.1).

use bevy::math::{
    DVec3, Vec3A,
    bounding::{Aabb3d, BoundingSphere},
    primitives::{Segment3d, Triangle3d},
};

use super::{
    convex_hull::ConvexHull,
    intersection::{gjk, polyhedron::ObbFrame, simplex::closest_to_origin},
    obb::Obb,
};

/// Shapes that know their point closest to another point. Boxes, spheres and hulls are solid: a point inside is its own
/// closest point.
pub trait ClosestPoint {
    /// The point of the shape closest to `point`, in the space of both; in double precision, so that what is built on it
    /// can round once, at its end.
    fn closest_point_f64(&self, point: DVec3) -> DVec3;

    /// The point of the shape closest to `point`, in the space of both: on the shape and closest up to the rounding of
    /// its coordinates.
    fn closest_point(&self, point: Vec3A) -> Vec3A {
        self.closest_point_f64(point.as_dvec3()).as_vec3a()
    }

    /// The distance from `point` to the shape, in units of the space of both: zero inside a solid shape, elsewhere rounded
    /// once from double precision.
    fn distance_to_point(&self, point: Vec3A) -> f32 {
        let point = point.as_dvec3();
        self.closest_point_f64(point).distance(point) as f32
    }
}

impl ClosestPoint for Segment3d {
    fn closest_point_f64(&self, point: DVec3) -> DVec3 {
        let relative = self.vertices.map(|vertex| vertex.as_dvec3() - point);
        point + closest_to_origin(&relative).point
    }
}

/// Triangles without area, too, which are segments or points.
impl ClosestPoint for Triangle3d {
    fn closest_point_f64(&self, point: DVec3) -> DVec3 {
        let relative = self.vertices.map(|vertex| vertex.as_dvec3() - point);
        point + closest_to_origin(&relative).point
    }
}

impl ClosestPoint for BoundingSphere {
    fn closest_point_f64(&self, point: DVec3) -> DVec3 {
        let (center, radius) = (self.center.as_dvec3(), f64::from(self.radius()));
        let distance = center.distance(point);
        if distance <= radius {
            point
        } else {
            center + (point - center) * (radius / distance)
        }
    }
}

/// Exact.
impl ClosestPoint for Aabb3d {
    fn closest_point_f64(&self, point: DVec3) -> DVec3 {
        point.max(self.min.as_dvec3()).min(self.max.as_dvec3())
    }
}

/// The point is of the box; its distance may exceed the smallest by as much as the axes are off their right angles, some
/// 10⁻⁷ of itself.
impl ClosestPoint for Obb {
    fn closest_point_f64(&self, point: DVec3) -> DVec3 {
        ObbFrame::from(self).closest_point(point)
    }
}

/// By [GJK](gjk), on the convex hull of the vertices.
impl ClosestPoint for ConvexHull {
    fn closest_point_f64(&self, point: DVec3) -> DVec3 {
        let separation = gjk::distance(&point, self);
        if separation.distance == 0.0 {
            point
        } else {
            separation.points[1]
        }
    }
}
