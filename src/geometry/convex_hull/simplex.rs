//! What a hull starts from: as many affinely independent points as there are.

use bevy::math::DVec3;

use super::predicates::{collinear, orient3d};

/// One to four points, by their indices, that span what all `points` span, decided exactly, and lie far apart. The first
/// two are extreme along an axis.
pub(super) fn spanning_simplex(points: &[DVec3]) -> Vec<u32> {
    let (min, max) = bounds(points);
    let axis = (max - min).max_position();
    let (a, b) = (farthest(points, |p| -p[axis]), farthest(points, |p| p[axis]));
    let (pa, pb) = (points[a], points[b]);
    if pa[axis] == pb[axis] {
        return vec![a as u32];
    }
    let area = |p: DVec3| (pb - pa).cross(p - pa).length_squared();
    let Some(c) = farthest_with(points, area, |p| !collinear([pa, pb, p])) else {
        return vec![a as u32, b as u32];
    };
    let normal = (pb - pa).cross(points[c] - pa);
    let volume = |p: DVec3| normal.dot(p - pa).abs();
    let Some(d) = farthest_with(points, volume, |p| orient3d([pa, pb, points[c]], p) != 0.0) else {
        return vec![a as u32, b as u32, c as u32];
    };
    vec![a as u32, b as u32, c as u32, d as u32]
}

/// The corners of the box around `points`.
pub(super) fn bounds(points: &[DVec3]) -> (DVec3, DVec3) {
    (points.iter()).fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), &p| {
        (min.min(p), max.max(p))
    })
}

/// The index of a point with the largest measure.
pub(super) fn farthest(points: &[DVec3], measure: impl Fn(DVec3) -> f64) -> usize {
    let mut best = (0, f64::NEG_INFINITY);
    for (index, &point) in points.iter().enumerate() {
        let measured = measure(point);
        if measured > best.1 {
            best = (index, measured);
        }
    }
    best.0
}

/// The index of a point that satisfies the exact test: the one with the largest measure, unless rounding made that up.
fn farthest_with(points: &[DVec3], measure: impl Fn(DVec3) -> f64, exact: impl Fn(DVec3) -> bool) -> Option<usize> {
    let best = farthest(points, measure);
    if exact(points[best]) {
        return Some(best);
    }
    points.iter().position(|&point| exact(point))
}
