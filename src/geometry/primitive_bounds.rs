//! The support mappings of Bevy's solid primitives, in closed form, from which their boxes follow:
//! [`Aabb3dExt::of`](super::aabb::Aabb3dExt::of).
//!
//! Each is in the space of the primitive, as Bevy's meshes are: cylinders, capsules, cones and frusta stand along y,
//! with the base of a cone at `-height / 2`; a torus lies in the xz plane; an extrusion has its base in the xy plane.
//! Formulae: Ericson, *Real-Time Collision Detection*, 2005, §9.5.4; van den Bergen, *Collision Detection in Interactive 3D
//! Environments*, 2003, §4.3.

use bevy::math::{
    DQuat, DVec2, DVec3, Quat, Vec2, Vec3,
    primitives::{
        Annulus, Arc2d, Capsule2d, Capsule3d, Circle, CircularSector, CircularSegment, Cone, ConicalFrustum,
        ConvexPolygon, Cuboid, Cylinder, Ellipse, Extrusion, Plane3d, Polygon, Polyline2d, Polyline3d, Primitive2d,
        Rectangle, RegularPolygon, Rhombus, Ring, Segment2d, Sphere, Tetrahedron, Torus, Triangle2d,
    },
};

use super::support::{Support, unit};

impl Support for Sphere {
    fn support_point(&self, direction: DVec3) -> DVec3 {
        unit(direction) * f64::from(self.radius)
    }
}

impl Support for Cuboid {
    fn support_point(&self, direction: DVec3) -> DVec3 {
        self.half_size.as_dvec3() * direction.signum()
    }
}

impl Support for Cylinder {
    fn support_point(&self, direction: DVec3) -> DVec3 {
        disc(direction, self.radius) + DVec3::Y * f64::from(self.half_height) * direction.y.signum()
    }
}

impl Support for Capsule3d {
    fn support_point(&self, direction: DVec3) -> DVec3 {
        unit(direction) * f64::from(self.radius) + DVec3::Y * f64::from(self.half_length) * direction.y.signum()
    }
}

impl Support for Cone {
    fn support_point(&self, direction: DVec3) -> DVec3 {
        frustum(direction, 0.0, self.radius, self.height)
    }
}

impl Support for ConicalFrustum {
    fn support_point(&self, direction: DVec3) -> DVec3 {
        frustum(direction, self.radius_top, self.radius_bottom, self.height)
    }
}

/// Of its convex hull.
impl Support for Torus {
    fn support_point(&self, direction: DVec3) -> DVec3 {
        disc(direction, self.major_radius) + unit(direction) * f64::from(self.minor_radius)
    }
}

impl Support for Tetrahedron {
    fn support_point(&self, direction: DVec3) -> DVec3 {
        farthest(self.vertices.map(Vec3::as_dvec3), direction)
    }
}

/// Of the rectangle, which Bevy's mesh turns from the xz plane by the shortest arc from +y to the normal.
impl Support for Plane3d {
    fn support_point(&self, direction: DVec3) -> DVec3 {
        let turn: DQuat = Quat::from_rotation_arc(Vec3::Y, *self.normal).as_dquat().normalize();
        let sides = (turn.inverse() * direction).signum();
        turn * DVec3::new(
            f64::from(self.half_size.x) * sides.x,
            0.0,
            f64::from(self.half_size.y) * sides.z,
        )
    }
}

/// Of its convex hull; NaN if it has no vertices.
impl Support for Polyline3d {
    fn support_point(&self, direction: DVec3) -> DVec3 {
        farthest(self.vertices.iter().map(|vertex| vertex.as_dvec3()), direction)
    }
}

impl<Base: Support2d + Primitive2d> Support for Extrusion<Base> {
    fn support_point(&self, direction: DVec3) -> DVec3 {
        let base = self.base_shape.support_point_2d(direction.truncate());
        base.extend(f64::from(self.half_depth) * direction.z.signum())
    }
}

/// A convex shape in the plane that knows its farthest point in any direction; of one that is not convex, its convex
/// hull. The bases of [`Extrusion`]s.
pub trait Support2d {
    /// A point of the shape that is farthest along `direction`, which may have any finite length; any point where that
    /// is zero.
    fn support_point_2d(&self, direction: DVec2) -> DVec2;
}

impl Support2d for Circle {
    fn support_point_2d(&self, direction: DVec2) -> DVec2 {
        unit_2d(direction) * f64::from(self.radius)
    }
}

impl Support2d for Annulus {
    fn support_point_2d(&self, direction: DVec2) -> DVec2 {
        self.outer_circle.support_point_2d(direction)
    }
}

impl Support2d for Ellipse {
    fn support_point_2d(&self, direction: DVec2) -> DVec2 {
        let half_size = self.half_size.as_dvec2();
        half_size * unit_2d(half_size * unit_2d(direction))
    }
}

impl Support2d for Rectangle {
    fn support_point_2d(&self, direction: DVec2) -> DVec2 {
        self.half_size.as_dvec2() * direction.signum()
    }
}

impl Support2d for Capsule2d {
    fn support_point_2d(&self, direction: DVec2) -> DVec2 {
        unit_2d(direction) * f64::from(self.radius) + DVec2::Y * f64::from(self.half_length) * direction.y.signum()
    }
}

impl Support2d for Rhombus {
    fn support_point_2d(&self, direction: DVec2) -> DVec2 {
        let half = self.half_diagonals.as_dvec2();
        farthest_2d(
            [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y].map(|tip| tip * half),
            direction,
        )
    }
}

impl Support2d for Segment2d {
    fn support_point_2d(&self, direction: DVec2) -> DVec2 {
        farthest_2d(self.vertices.map(Vec2::as_dvec2), direction)
    }
}

impl Support2d for Triangle2d {
    fn support_point_2d(&self, direction: DVec2) -> DVec2 {
        farthest_2d(self.vertices.map(Vec2::as_dvec2), direction)
    }
}

impl Support2d for CircularSector {
    fn support_point_2d(&self, direction: DVec2) -> DVec2 {
        farthest_2d([arc(self.arc, direction), DVec2::ZERO], direction)
    }
}

impl Support2d for CircularSegment {
    fn support_point_2d(&self, direction: DVec2) -> DVec2 {
        arc(self.arc, direction)
    }
}

impl Support2d for ConvexPolygon {
    fn support_point_2d(&self, direction: DVec2) -> DVec2 {
        farthest_2d(self.vertices().iter().map(|vertex| vertex.as_dvec2()), direction)
    }
}

/// NaN if it has no vertices.
impl Support2d for Polyline2d {
    fn support_point_2d(&self, direction: DVec2) -> DVec2 {
        farthest_2d(self.vertices.iter().map(|vertex| vertex.as_dvec2()), direction)
    }
}

/// NaN if it has no vertices.
impl Support2d for Polygon {
    fn support_point_2d(&self, direction: DVec2) -> DVec2 {
        farthest_2d(self.vertices.iter().map(|vertex| vertex.as_dvec2()), direction)
    }
}

/// Of the vertices as Bevy computes them.
impl Support2d for RegularPolygon {
    fn support_point_2d(&self, direction: DVec2) -> DVec2 {
        farthest_2d(self.vertices(0.0).into_iter().map(Vec2::as_dvec2), direction)
    }
}

impl<Outer: Support2d + Primitive2d> Support2d for Ring<Outer> {
    fn support_point_2d(&self, direction: DVec2) -> DVec2 {
        self.outer_shape.support_point_2d(direction)
    }
}

/// The farthest point of an arc around the origin that reaches equally far to either side of the +y axis.
fn arc(arc: Arc2d, direction: DVec2) -> DVec2 {
    let (radius, half_angle) = (f64::from(arc.radius).abs(), f64::from(arc.half_angle).abs());
    let (sin, cos) = half_angle.min(std::f64::consts::PI).sin_cos();
    let toward = unit_2d(direction);
    if toward.y >= cos {
        return toward * radius;
    }
    let ends = [DVec2::new(sin, cos), DVec2::new(-sin, cos)];
    farthest_2d(ends.map(|end| end * radius), direction)
}

/// The farthest point of a disc around the y axis.
fn disc(direction: DVec3, radius: f32) -> DVec3 {
    unit(DVec3::new(direction.x, 0.0, direction.z)) * f64::from(radius)
}

/// The farthest point of a cone without its tip, along y, around the origin.
fn frustum(direction: DVec3, radius_top: f32, radius_bottom: f32, height: f32) -> DVec3 {
    let half = DVec3::Y * (0.5 * f64::from(height));
    farthest(
        [
            disc(direction, radius_top) + half,
            disc(direction, radius_bottom) - half,
        ],
        direction,
    )
}

/// The farthest of the points: one that is NaN if there is one, so that it is not hidden by the others, or if there are
/// none.
fn farthest(points: impl IntoIterator<Item = DVec3>, direction: DVec3) -> DVec3 {
    let along = |point: DVec3| point.dot(direction);
    let farther = |a, b| {
        if along(a) >= along(b) || along(a).is_nan() {
            a
        } else {
            b
        }
    };
    points.into_iter().reduce(farther).unwrap_or(DVec3::NAN)
}

fn farthest_2d(points: impl IntoIterator<Item = DVec2>, direction: DVec2) -> DVec2 {
    let points = points.into_iter().map(|point| point.extend(0.0));
    farthest(points, direction.extend(0.0)).truncate()
}

fn unit_2d(vector: DVec2) -> DVec2 {
    unit(vector.extend(0.0)).truncate()
}
