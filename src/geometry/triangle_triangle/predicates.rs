//! On which side of a line or plane a point lies, decided exactly.
//!
//! Each predicate returns a number of which only the sign is meant, as in Shewchuk, *Adaptive Precision Floating-Point
//! Arithmetic and Fast Robust Geometric Predicates*, 1997. It is first computed in plain `f64`; a value within its
//! error bound is left to the `robust` crate, a transcript of Shewchuk's code. If a coordinate is infinite or NaN the
//! result is NaN, so that no comparison with it holds.

use bevy::math::{DVec2, DVec3};
use robust::{Coord, Coord3D};

use super::determinant::{Entry, determinant};
use crate::geometry::tolerance::{ORIENTATION, ORIENTATION_UNDERFLOW, WELL_CONDITIONED};

/// Positive if the points run counter-clockwise, negative if clockwise, zero if they are collinear.
#[inline]
pub(super) fn orient2d(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let (u, v) = (a - c, b - c);
    let (left, right) = (u.x * v.y, u.y * v.x);
    let area = left - right;
    if area.abs() > ORIENTATION * (left.abs() + right.abs()) + ORIENTATION_UNDERFLOW {
        area
    } else {
        orient2d_exact([a, b, c])
    }
}

/// The side of `d` on the plane through `a`, `b` and `c`; see [`Plane::side`].
#[inline]
pub(super) fn orient3d(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    Plane::through([a, b, c]).side(d)
}

/// The plane through three points. If they are collinear, every point is on it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    points: [DVec3; 3],
    normal: DVec3,
    /// The normal with the magnitudes of its products added up.
    magnitude: DVec3,
}

impl Plane {
    #[inline]
    pub(super) fn through(points: [DVec3; 3]) -> Self {
        let [a, b, c] = points;
        let (u, v) = (b - a, c - a);
        let left = DVec3::new(u.y * v.z, u.z * v.x, u.x * v.y);
        let right = DVec3::new(u.z * v.y, u.x * v.z, u.y * v.x);
        Self {
            points,
            normal: left - right,
            magnitude: left.abs() + right.abs() + ORIENTATION_UNDERFLOW,
        }
    }

    /// Positive if `point` is on the side from which the three points are seen to run counter-clockwise, negative if it
    /// is on the other, zero if it is on the plane.
    #[inline]
    pub(super) fn side(&self, point: DVec3) -> f64 {
        let (height, magnitude) = self.height(point);
        if height.abs() > ORIENTATION * magnitude + ORIENTATION_UNDERFLOW {
            height
        } else {
            orient3d_exact(self.points, point)
        }
    }

    /// The sides of all three.
    #[inline]
    pub(super) fn sides(&self, points: [DVec3; 3]) -> [f64; 3] {
        points.map(|point| self.side(point))
    }

    /// Where the line through `p` and `q` crosses the plane, as weights of the two; they must not be on one side of it,
    /// nor both on it. The weights add up to 1, and each is right to 2⁻⁴⁰ of itself.
    pub(super) fn crossing(&self, p: DVec3, q: DVec3) -> [f64; 2] {
        let accurate = |point| {
            let (height, magnitude) = self.height(point);
            (height.abs() > WELL_CONDITIONED * magnitude + ORIENTATION_UNDERFLOW).then_some(height)
        };
        let (p, q) = match (accurate(p), accurate(q)) {
            (Some(p), Some(q)) => (p, q),
            _ => self.exact_heights(p, q),
        };
        [q / (q - p), p / (p - q)]
    }

    /// The height of the point in multiples of the length of the normal, and the sum of the magnitudes in it.
    #[inline]
    fn height(&self, point: DVec3) -> (f64, f64) {
        let d = point - self.points[0];
        (self.normal.dot(d), self.magnitude.dot(d.abs()))
    }

    /// The heights of both in one unit, rounded once.
    #[cold]
    fn exact_heights(&self, p: DVec3, q: DVec3) -> (f64, f64) {
        let [a, b, c] = self.points;
        let Some([a, b, c, p, q]) = in_range([a, b, c, p, q]) else {
            return (f64::NAN, f64::NAN);
        };
        let row = |point: DVec3| [0, 1, 2].map(|axis| Entry::difference(point[axis], a[axis]));
        let height = |point| determinant([row(b), row(c), row(point)]);
        (height(p), height(q))
    }
}

#[cold]
fn orient2d_exact(points: [DVec2; 3]) -> f64 {
    in_range(points.map(|point| point.extend(0.0))).map_or(f64::NAN, |points| {
        let [a, b, c] = points.map(|DVec3 { x, y, .. }| Coord { x, y });
        robust::orient2d(a, b, c)
    })
}

#[cold]
fn orient3d_exact([a, b, c]: [DVec3; 3], d: DVec3) -> f64 {
    let Some(points) = in_range([a, b, c, d]) else {
        return f64::NAN;
    };
    // What meshes have most of: triangles that share vertices, and planes across an axis.
    let repeated = a == d || b == d || c == d || a == b || b == c || c == a;
    let across_axis = (a.cmpeq(d) & b.cmpeq(d) & c.cmpeq(d)).any();
    if repeated || across_axis {
        return 0.0;
    }
    let [a, b, c, d] = points.map(|DVec3 { x, y, z }| Coord3D { x, y, z });
    // Shewchuk's sign is positive below the plane.
    -robust::orient3d(a, b, c, d)
}

/// The points, scaled by a power of two if their determinants might otherwise overflow or underflow; `None` if one is
/// not finite.
///
/// A determinant of third degree is exact if the coordinates are multiples of 2⁻³⁵⁸ (its terms are then multiples of
/// 2⁻¹⁰⁷⁴) and less than 2³³⁹.
fn in_range<const N: usize>(points: [DVec3; N]) -> Option<[DVec3; N]> {
    const MAX_EXPONENT: i32 = 338;
    const MIN_EXPONENT: i32 = -306;

    let exponent = |x: f64| ((x.to_bits() >> 52) & 0x7ff) as i32 - 1023;
    let (mut min, mut max) = (i32::MAX, i32::MIN);
    for x in points.iter().flat_map(DVec3::to_array) {
        if !x.is_finite() {
            return None;
        }
        if x != 0.0 {
            min = min.min(exponent(x));
            max = max.max(exponent(x));
        }
    }
    if min >= MIN_EXPONENT && max <= MAX_EXPONENT {
        return Some(points);
    }
    // In two steps: the whole factor may not be a number.
    let shift = MAX_EXPONENT - max;
    let (half, rest) = (2f64.powi(shift / 2), 2f64.powi(shift - shift / 2));
    Some(points.map(|point| point * half * rest))
}
