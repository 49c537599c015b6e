//! Smallest rectangles around points in the plane.

use bevy::math::DVec2;

use super::fit::Measure;

/// The direction of a side of the smallest rectangle around the points, and its size: those of the points on a line lie
/// along it.
///
/// One side runs along an edge of the convex hull (Freeman and Shapira, *Determining the Minimum-Area Encasing Rectangle
/// for an Arbitrary Closed Curve*, CACM 18(7), 1975), of which every one is tried. Sorts the points.
pub fn smallest(points: &mut [DVec2], measure: &Measure) -> (DVec2, DVec2) {
    let hull = hull(points);
    let edges = hull.iter().zip(hull.iter().cycle().skip(1)).map(|(a, b)| b - a);
    edges
        .filter_map(DVec2::try_normalize)
        .chain([DVec2::X])
        .map(|side| (side, size(&hull, side)))
        .min_by(|(_, a), (_, b)| measure.of_rectangle(*a).total_cmp(&measure.of_rectangle(*b)))
        .unwrap_or_default()
}

/// The extents along `side` and at a right angle to it.
fn size(points: &[DVec2], side: DVec2) -> DVec2 {
    let [min, max] = (points.iter())
        .map(|point| DVec2::new(side.dot(*point), side.perp_dot(*point)))
        .fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[min, max], point| {
            [min.min(point), max.max(point)]
        });
    max - min
}

/// The corners of the convex hull, in order. Source: Andrew, *Another Efficient Algorithm for Convex Hulls in Two
/// Dimensions*, Information Processing Letters 9(5), 1979.
fn hull(points: &mut [DVec2]) -> Vec<DVec2> {
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut hull: Vec<DVec2> = Vec::with_capacity(points.len() + 1);
    let mut chain = |points: &mut dyn Iterator<Item = &DVec2>| {
        let start = hull.len();
        for &point in points {
            while let [.., a, b] = hull[start..]
                && (b - a).perp_dot(point - a) <= 0.0
            {
                hull.pop();
            }
            hull.push(point);
        }
        // It is where the other chain starts.
        hull.pop();
    };
    chain(&mut points.iter());
    chain(&mut points.iter().rev());
    if hull.is_empty() {
        hull.extend(points.first());
    }
    hull
}
