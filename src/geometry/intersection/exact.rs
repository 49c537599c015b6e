//! Tests that are exact: they decide by the signs of determinants, which the `robust` crate gets right whatever the
//! rounding (Shewchuk, *Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates*, 1997).
//!
//! Points, segments, rays and triangles touch each other by coincidence only, so that a rounded answer would mean
//! nothing. What is coplanar or collinear is decided in the three projections along the axes: shapes in one plane touch
//! if and only if all three of their projections do, because at least one of those is one-to-one.

use bevy::math::{
    DVec2, DVec3, Vec3,
    primitives::{Segment3d, Triangle3d},
};
use robust::{Coord, Coord3D};

use crate::geometry::ray::Ray;

/// The sum of the terms with the right sign, zero included.
///
/// Source: Shewchuk 1997, `Grow-Expansion` after a floating-point filter.
pub(crate) fn sum_sign<const N: usize>(terms: [f64; N]) -> f64 {
    let sum: f64 = terms.iter().sum();
    let magnitude: f64 = terms.iter().map(|term| term.abs()).sum();
    if sum.abs() > magnitude * f64::EPSILON * N as f64 || !magnitude.is_finite() {
        return sum;
    }
    let mut expansion = [0.0; N];
    for (used, &term) in terms.iter().enumerate() {
        let mut carry = term;
        for part in &mut expansion[..used] {
            (carry, *part) = two_sum(carry, *part);
        }
        expansion[used] = carry;
    }
    expansion.iter().rfind(|&&part| part != 0.0).copied().unwrap_or(0.0)
}

/// The rounded sum, and what rounding took from it.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let from_b = sum - a;
    (sum, (a - (sum - from_b)) + (b - from_b))
}

/// Positive, zero or negative as `d` is below, in or above the plane in which `a`, `b` and `c` run counter-clockwise.
fn orientation(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    let coord = |p: DVec3| Coord3D { x: p.x, y: p.y, z: p.z };
    robust::orient3d(coord(a), coord(b), coord(c), coord(d))
}

/// A point, with weight 1, or the point at infinity in a direction, with weight 0.
#[derive(Clone, Copy)]
struct Homogeneous {
    xyz: DVec3,
    w: f64,
}

impl Homogeneous {
    fn point(xyz: DVec3) -> Self {
        Self { xyz, w: 1.0 }
    }

    fn direction(xyz: DVec3) -> Self {
        Self { xyz, w: 0.0 }
    }

    /// A point from which on, seen from `pivot`, lies this one.
    fn seen_from(self, pivot: DVec3) -> DVec3 {
        if self.w == 0.0 { pivot + self.xyz } else { self.xyz }
    }

    /// The projection along one axis, in homogeneous coordinates.
    fn flat(self, dropped: usize) -> DVec3 {
        project(self.xyz, dropped).extend(self.w)
    }
}

fn project(point: DVec3, dropped: usize) -> DVec2 {
    DVec2::new(point[(dropped + 1) % 3], point[(dropped + 2) % 3])
}

/// On which side of the line through `line` the `point` is, in the projection along one axis.
fn side(line: [Homogeneous; 2], point: Homogeneous, dropped: usize) -> f64 {
    orientation(
        line[0].flat(dropped),
        line[1].flat(dropped),
        point.flat(dropped),
        DVec3::ZERO,
    )
}

/// A segment or a ray.
pub(crate) struct Stretch {
    /// Two points of its line.
    line: [Homogeneous; 2],
    /// Where it ends: the first a point, the second a point or at infinity.
    ends: [Homogeneous; 2],
}

impl Stretch {
    /// `None` if nothing is in the ray.
    ///
    /// Ends that the ray has by its parameters are rounded to double precision; its line is exact.
    pub(crate) fn of_ray(ray: &Ray) -> Option<Self> {
        let (origin, direction) = (ray.origin().as_dvec3(), ray.direction().as_dvec3());
        let at = |t: f32| Homogeneous::point(origin + direction * f64::from(t));
        let last = if ray.t_max().is_finite() {
            at(ray.t_max())
        } else {
            Homogeneous::direction(direction)
        };
        (ray.t_min() <= ray.t_max() && ray.t_min().is_finite()).then(|| Self {
            line: [Homogeneous::point(origin), Homogeneous::direction(direction)],
            ends: [at(ray.t_min()), last],
        })
    }

    pub(crate) fn of_segment(segment: &Segment3d) -> Self {
        Self::between(segment.vertices.map(Vec3::as_dvec3))
    }

    fn between(ends: [DVec3; 2]) -> Self {
        let ends = ends.map(Homogeneous::point);
        Self { line: ends, ends }
    }

    fn point_of_line(&self) -> DVec3 {
        self.line[0].xyz
    }

    /// Another one than [`point_of_line`](Self::point_of_line), unless both ends are the same.
    fn second_point_of_line(&self) -> DVec3 {
        self.line[1].seen_from(self.line[0].xyz)
    }

    /// The sides of the ends of `other` seen from this line. The side at infinity of what runs parallel is that on which
    /// it runs.
    fn sides(&self, other: &Self, dropped: usize) -> [f64; 2] {
        let [first, last] = other.ends.map(|end| side(self.line, end, dropped));
        [
            first,
            if other.ends[1].w == 0.0 && last == 0.0 {
                first
            } else {
                last
            },
        ]
    }

    /// The least and largest coordinate on an axis.
    fn span(&self, axis: usize) -> (f64, f64) {
        let [first, last] = self.ends.map(|end| end.xyz[axis]);
        if self.ends[1].w == 1.0 || last == 0.0 {
            let last = if self.ends[1].w == 1.0 { last } else { first };
            (first.min(last), first.max(last))
        } else if last > 0.0 {
            (first, f64::INFINITY)
        } else {
            (f64::NEG_INFINITY, first)
        }
    }

    fn touches_in_projection(&self, other: &Self, dropped: usize) -> bool {
        let (of_other, of_self) = (self.sides(other, dropped), other.sides(self, dropped));
        let crosses = |[first, last]: [f64; 2]| !(first > 0.0 && last > 0.0 || first < 0.0 && last < 0.0);
        let collinear = of_other == [0.0; 2] && of_self == [0.0; 2];
        crosses(of_other)
            && crosses(of_self)
            && (!collinear || (0..3).all(|axis| axis == dropped || self.overlaps(other, axis)))
    }

    fn overlaps(&self, other: &Self, axis: usize) -> bool {
        let ((min, max), (other_min, other_max)) = (self.span(axis), other.span(axis));
        min <= other_max && other_min <= max
    }

    pub(crate) fn touches(&self, other: &Self) -> bool {
        let coplanar = orientation(
            self.second_point_of_line(),
            other.point_of_line(),
            other.second_point_of_line(),
            self.point_of_line(),
        ) == 0.0;
        coplanar && (0..3).all(|dropped| self.touches_in_projection(other, dropped))
    }

    /// Möller and Trumbore's question by determinants: does the line pass all edges on one side, and do the ends lie on
    /// both sides of the plane (Ericson, *Real-Time Collision Detection*, 2005, §5.3.4)?
    pub(crate) fn touches_triangle(&self, triangle: &Triangle3d) -> bool {
        let [a, b, c] = triangle.vertices.map(Vec3::as_dvec3);
        let first = orientation(a, b, c, self.ends[0].xyz);
        let last = if self.ends[1].w == 1.0 {
            orientation(a, b, c, self.ends[1].xyz)
        } else {
            let seen_from_plane = orientation(a, b, c, self.ends[1].seen_from(c));
            if seen_from_plane == 0.0 { first } else { seen_from_plane }
        };
        if first > 0.0 && last > 0.0 || first < 0.0 && last < 0.0 {
            return false;
        }
        if first == 0.0 && last == 0.0 {
            let edges = [[a, b], [b, c], [c, a]];
            return point_in_triangle(self.ends[0].xyz, [a, b, c])
                || edges.iter().any(|&edge| self.touches(&Self::between(edge)));
        }
        let (from, to) = (self.point_of_line(), self.second_point_of_line());
        let sides = [
            orientation(from, to, a, b),
            orientation(from, to, b, c),
            orientation(from, to, c, a),
        ];
        sides.iter().all(|&side| side >= 0.0) || sides.iter().all(|&side| side <= 0.0)
    }

    fn has_on_its_line(&self, point: DVec3) -> bool {
        (0..3).all(|dropped| side(self.line, Homogeneous::point(point), dropped) == 0.0)
    }
}

pub(crate) fn point_on_segment(point: DVec3, segment: &Segment3d) -> bool {
    let stretch = Stretch::of_segment(segment);
    let within = |axis: usize| {
        let (min, max) = stretch.span(axis);
        min <= point[axis] && point[axis] <= max
    };
    stretch.has_on_its_line(point) && (0..3).all(within)
}

pub(crate) fn point_on_ray(point: DVec3, ray: &Ray) -> bool {
    let (origin, direction) = (ray.origin().as_dvec3(), ray.direction().as_dvec3());
    // Products of two `f32` are exact, and so is the sign of the sum.
    let beyond = |t: f32, axis: usize| {
        let forward = if direction[axis] < 0.0 { -1.0 } else { 1.0 };
        sum_sign([point[axis], -origin[axis], -direction[axis] * f64::from(t)]) * forward
    };
    let within = |axis: usize| {
        beyond(ray.t_min(), axis) >= 0.0
            && if direction[axis] == 0.0 {
                point[axis] == origin[axis]
            } else {
                ray.t_max() == f32::INFINITY || beyond(ray.t_max(), axis) <= 0.0
            }
    };
    Stretch::of_ray(ray).is_some_and(|stretch| stretch.has_on_its_line(point)) && (0..3).all(within)
}

pub(crate) fn point_in_triangle(point: DVec3, [a, b, c]: [DVec3; 3]) -> bool {
    let in_projection = |dropped: usize| {
        let coord = |p: DVec3| {
            let p = project(p, dropped);
            Coord { x: p.x, y: p.y }
        };
        let side = |from: DVec3, to: DVec3| robust::orient2d(coord(from), coord(to), coord(point));
        let sides = [side(a, b), side(b, c), side(c, a)];
        let (min, max) = (a.min(b).min(c), a.max(b).max(c));
        // The bounds matter where the projection is a segment, whose line the point may be on.
        let bounded = (0..3).all(|axis| axis == dropped || (min[axis] <= point[axis] && point[axis] <= max[axis]));
        bounded && (sides.iter().all(|&side| side >= 0.0) || sides.iter().all(|&side| side <= 0.0))
    };
    orientation(a, b, c, point) == 0.0 && (0..3).all(in_projection)
}
