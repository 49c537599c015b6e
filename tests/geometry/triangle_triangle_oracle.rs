//! What two triangles have in common, in exact arithmetic: the first is clipped by the half-spaces of which the second
//! is the intersection. Unlike the tests of the crate, this constructs points, and knows no case but the rank of the
//! second triangle.

use std::array;

use bevy::math::DVec3;
use num_bigint::BigInt;
use num_rational::{BigRational, Ratio};
use num_traits::{Num, Signed, ToPrimitive};

/// A number with exact arithmetic.
pub trait Exact: Num + Signed + Clone + PartialOrd {}
impl<T: Num + Signed + Clone + PartialOrd> Exact for T {}

pub type Point<T> = [T; 3];

/// The extreme points of what two triangles have in common, without repetition: none, one, the two ends of a segment,
/// or the corners of a polygon in order.
pub fn common_points<T: Exact>(a: &[Point<T>; 3], b: &[Point<T>; 3]) -> Vec<Point<T>> {
    let mut walk = a.to_vec();
    for (normal, offset) in half_spaces(b) {
        walk = clip(&walk, &normal, &offset);
    }
    extreme_points(walk)
}

/// The half-spaces `normal · x >= offset` whose intersection is the triangle.
fn half_spaces<T: Exact>(triangle: &[Point<T>; 3]) -> Vec<(Point<T>, T)> {
    let mut spaces = Vec::new();
    let mut above = |normal: Point<T>, point: &Point<T>| {
        let offset = dot(&normal, point);
        spaces.push((normal, offset));
    };
    let [p, q, r] = triangle;
    let normal = cross(&sub(q, p), &sub(r, p));
    let direction = [sub(q, p), sub(r, p)].into_iter().find(|d| !is_zero(d));
    if !is_zero(&normal) {
        above(normal.clone(), p);
        above(neg(&normal), p);
        for (from, to) in [(p, q), (q, r), (r, p)] {
            above(cross(&normal, &sub(to, from)), from);
        }
    } else if let Some(direction) = direction {
        for axis in axes() {
            let across = cross(&direction, &axis);
            above(neg(&across), p);
            above(across, p);
        }
        let along = |point: &&Point<T>| dot(&direction, point);
        let order = |x: &&Point<T>, y: &&Point<T>| along(x).partial_cmp(&along(y)).expect("numbers");
        above(direction.clone(), triangle.iter().min_by(order).expect("three points"));
        above(neg(&direction), triangle.iter().max_by(order).expect("three points"));
    } else {
        for axis in axes() {
            above(neg(&axis), p);
            above(axis, p);
        }
    }
    spaces
}

/// The closed walk around a convex set, clipped (Sutherland and Hodgman).
fn clip<T: Exact>(walk: &[Point<T>], normal: &Point<T>, offset: &T) -> Vec<Point<T>> {
    let heights: Vec<T> = walk.iter().map(|point| dot(normal, point) - offset.clone()).collect();
    let mut clipped = Vec::new();
    for (i, point) in walk.iter().enumerate() {
        let j = (i + 1) % walk.len();
        let (here, there) = (&heights[i], &heights[j]);
        if !here.is_negative() {
            clipped.push(point.clone());
        }
        if (here.is_negative() && there.is_positive()) || (here.is_positive() && there.is_negative()) {
            let t = here.clone() / (here.clone() - there.clone());
            let step = sub(&walk[j], point);
            clipped.push(array::from_fn(|k| point[k].clone() + t.clone() * step[k].clone()));
        }
    }
    clipped
}

fn extreme_points<T: Exact>(mut walk: Vec<Point<T>>) -> Vec<Point<T>> {
    let Some(first) = walk.first().cloned() else {
        return walk;
    };
    let directions: Vec<_> = walk.iter().map(|p| sub(p, &first)).filter(|d| !is_zero(d)).collect();
    let Some(direction) = directions.first() else {
        return vec![first];
    };
    if directions.iter().all(|d| is_zero(&cross(direction, d))) {
        let order = |x: &Point<T>, y: &Point<T>| dot(direction, x).partial_cmp(&dot(direction, y)).expect("numbers");
        walk.sort_by(order);
        return vec![walk[0].clone(), walk[walk.len() - 1].clone()];
    }
    // Between its neighbours, or equal to one.
    let idle = |walk: &[Point<T>]| {
        (0..walk.len()).find(|&i| {
            let (previous, next) = (&walk[(i + walk.len() - 1) % walk.len()], &walk[(i + 1) % walk.len()]);
            is_zero(&cross(&sub(&walk[i], previous), &sub(next, &walk[i])))
        })
    };
    while let Some(i) = idle(&walk) {
        walk.remove(i);
    }
    walk
}

/// The vertices in whole multiples of a power of two, and the exponent of that power.
pub fn to_integers<const N: usize>(triangles: [[DVec3; 3]; N]) -> ([[Point<BigRational>; 3]; N], i32) {
    let parts = |x: f64| num_traits::Float::integer_decode(x);
    let exponent = triangles
        .iter()
        .flatten()
        .flat_map(DVec3::to_array)
        .filter(|&x| x != 0.0)
        .map(|x| i32::from(parts(x).1))
        .min()
        .unwrap_or(0);
    let integer = |x: f64| {
        let (mantissa, own, sign) = parts(x);
        let shift = if x == 0.0 { 0 } else { i32::from(own) - exponent };
        BigRational::from_integer((BigInt::from(mantissa) * i32::from(sign)) << shift)
    };
    let triangles = triangles.map(|triangle| triangle.map(|point| point.to_array().map(integer)));
    (triangles, exponent)
}

/// In multiples of two to the `exponent`.
pub fn to_rational(x: f64, exponent: i32) -> BigRational {
    let whole = BigRational::from_float(x).expect("a finite coordinate");
    let power = BigRational::from_integer(BigInt::from(1) << exponent.unsigned_abs());
    if exponent < 0 { whole * power } else { whole / power }
}

/// What two triangles have in common, with the exponent of the unit of the points.
pub fn common_points_of(a: [DVec3; 3], b: [DVec3; 3]) -> (Vec<Point<BigRational>>, i32) {
    let ([a, b], exponent) = to_integers([a, b]);
    (common_points(&a, &b), exponent)
}

/// The same for small whole coordinates, faster.
pub fn common_points_on_lattice(a: [DVec3; 3], b: [DVec3; 3]) -> Vec<Point<Ratio<i128>>> {
    let [a, b] = [a, b].map(|triangle| {
        triangle.map(|point| {
            point
                .to_array()
                .map(|x| Ratio::from_integer(x.to_i128().expect("whole")))
        })
    });
    common_points(&a, &b)
}

fn axes<T: Exact>() -> [Point<T>; 3] {
    array::from_fn(|i| array::from_fn(|j| if i == j { T::one() } else { T::zero() }))
}

fn sub<T: Exact>(p: &Point<T>, q: &Point<T>) -> Point<T> {
    array::from_fn(|i| p[i].clone() - q[i].clone())
}

fn neg<T: Exact>(p: &Point<T>) -> Point<T> {
    array::from_fn(|i| -p[i].clone())
}

fn dot<T: Exact>(p: &Point<T>, q: &Point<T>) -> T {
    (0..3).fold(T::zero(), |sum, i| sum + p[i].clone() * q[i].clone())
}

fn cross<T: Exact>(p: &Point<T>, q: &Point<T>) -> Point<T> {
    array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        p[j].clone() * q[k].clone() - p[k].clone() * q[j].clone()
    })
}

fn is_zero<T: Exact>(p: &Point<T>) -> bool {
    p.iter().all(T::is_zero)
}
