//! Spheres against points, boxes and each other, and whatever knows its closest point (Ericson, *Real-Time Collision
//! Detection*, 2005, §5.2.5).

use bevy::math::{
    DVec3,
    bounding::{Aabb3d, BoundingSphere},
};

use super::exact::sum_sign;
use crate::geometry::tolerance::DOUBLE;

/// The square of a difference of two `f32`, as terms that are exact.
fn squared_difference(a: f64, b: f64) -> [f64; 3] {
    [a * a, -2.0 * a * b, b * b]
}

/// Exactly whether the distance of two points, given in `f32`, is at most `a + b`, which must not be negative.
pub(crate) fn within(from: DVec3, to: DVec3, [a, b]: [f64; 2]) -> bool {
    if a + b == f64::INFINITY {
        return true;
    }
    let [x, y, z] = [0, 1, 2].map(|axis| squared_difference(from[axis], to[axis]));
    let terms = [
        x[0],
        x[1],
        x[2],
        y[0],
        y[1],
        y[2],
        z[0],
        z[1],
        z[2],
        -a * a,
        -2.0 * a * b,
        -b * b,
    ];
    sum_sign(terms) <= 0.0
}

/// Exact.
pub(crate) fn touches_sphere(a: &BoundingSphere, b: &BoundingSphere) -> bool {
    within(
        a.center.as_dvec3(),
        b.center.as_dvec3(),
        [a.radius().into(), b.radius().into()],
    )
}

/// Exact.
pub(crate) fn touches_point(sphere: &BoundingSphere, point: DVec3) -> bool {
    within(sphere.center.as_dvec3(), point, [sphere.radius().into(), 0.0])
}

/// Exact: the closest point of the box has coordinates of the box and of the centre.
pub(crate) fn touches_aabb(sphere: &BoundingSphere, aabb: &Aabb3d) -> bool {
    touches_point(sphere, sphere.center.max(aabb.min).min(aabb.max).as_dvec3())
}

/// Whether a point that rounding may have moved is in the sphere, or could be: `stretch_squared` bounds how far the
/// square of its distance is above the true one, and `magnitude` the largest coordinate of the other shape.
pub(crate) fn reaches(sphere: &BoundingSphere, closest: DVec3, magnitude: f64, stretch_squared: f64) -> bool {
    let reach = reach(sphere, magnitude);
    sphere.center.as_dvec3().distance_squared(closest) <= reach * reach * stretch_squared
}

/// The radius, and a little more for the rounding of closest points of a shape with coordinates up to `magnitude`.
pub(crate) fn reach(sphere: &BoundingSphere, magnitude: f64) -> f64 {
    let largest = f64::from(sphere.center.abs().max_element()).max(magnitude);
    f64::from(sphere.radius()) * (1.0 + DOUBLE) + DOUBLE * largest
}
