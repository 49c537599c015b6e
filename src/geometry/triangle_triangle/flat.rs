//! Triangles in one plane, and degenerate triangles.
//!
//! A triangle is reduced to its extreme points: three, the two ends of a segment, or one. What two convex sets in one
//! plane have in common is the convex hull of the extreme points of each that are in the other, and of the points where
//! an edge of one crosses an edge of the other between the ends of both. Which these are is decided by signs; where
//! the crossings are is computed after that.

use std::cmp::Ordering;

use bevy::math::{DVec2, DVec3};
use smallvec::{SmallVec, smallvec};

use super::{
    edges::{crosses, line_pierces},
    predicates::{Plane, orient2d, orient3d},
};

/// The extreme points of a convex set, in order around it.
pub(super) type Corners = SmallVec<[DVec3; 6]>;

/// The extreme points of a triangle: one, two or three.
type Extremes = SmallVec<[DVec3; 3]>;

/// Whether two triangles have a point in common, of which one is degenerate or both are in one plane.
#[cold]
pub(super) fn intersect(a: [DVec3; 3], b: [DVec3; 3]) -> bool {
    match Meeting::of(a, b) {
        Meeting::Apart => false,
        Meeting::Pierced { .. } => true,
        Meeting::Planar(points) => Planar::new(points).corners().next().is_some(),
    }
}

/// The extreme points of what two triangles have in common, of which one is degenerate or both are in one plane.
#[cold]
pub(super) fn corners(a: [DVec3; 3], b: [DVec3; 3]) -> Corners {
    match Meeting::of(a, b) {
        Meeting::Apart => Corners::new(),
        Meeting::Pierced {
            segment: [p, q],
            triangle,
        } => smallvec![crossing(&Plane::through(triangle), p, q)],
        Meeting::Planar(points) => {
            let pair = Planar::new(points);
            in_order(pair.corners().collect())
                .map(|corner| pair.position(corner.site))
                .collect()
        }
    }
}

/// Where the segment crosses the plane; its ends are not on one side of it, nor both on it.
pub(super) fn crossing(plane: &Plane, p: DVec3, q: DVec3) -> DVec3 {
    between(p, q, plane.crossing(p, q))
}

/// The point with these weights, computed from the nearer end, so that a weight of 1 gives that end.
fn between(p: DVec3, q: DVec3, [weight_p, weight_q]: [f64; 2]) -> DVec3 {
    if weight_p >= weight_q {
        p + (q - p) * weight_q
    } else {
        q + (p - q) * weight_p
    }
}

/// How two triangles meet, of which one is degenerate or both are in one plane.
enum Meeting {
    Apart,
    /// One is a segment, not in the plane of the other, and meets it in a point.
    Pierced {
        segment: [DVec3; 2],
        triangle: [DVec3; 3],
    },
    /// They are in one plane, with these extreme points, and may be apart.
    Planar([Extremes; 2]),
}

impl Meeting {
    fn of(a: [DVec3; 3], b: [DVec3; 3]) -> Self {
        let [points_a, points_b] = [a, b].map(extreme_points);
        let outside_plane = match (&points_a[..], &points_b[..]) {
            (&[p, q], [_, _, _]) => Self::outside_plane([p, q], b),
            ([_, _, _], &[p, q]) => Self::outside_plane([p, q], a),
            (&[p], [_, _, _]) => Self::outside_plane([p, p], b),
            ([_, _, _], &[p]) => Self::outside_plane([p, p], a),
            (&[p, q], &[r, s]) if orient3d(p, q, r, s) != 0.0 => Some(Self::Apart),
            _ => None,
        };
        outside_plane.unwrap_or(Self::Planar([points_a, points_b]))
    }

    /// How a segment and a triangle meet, unless the segment is in the plane of the triangle.
    fn outside_plane([p, q]: [DVec3; 2], triangle: [DVec3; 3]) -> Option<Self> {
        let plane = Plane::through(triangle);
        let sides = (plane.side(p), plane.side(q));
        if sides == (0.0, 0.0) {
            None
        } else if crosses(sides.0, sides.1) && line_pierces(p, q, triangle) {
            Some(Self::Pierced {
                segment: [p, q],
                triangle,
            })
        } else {
            Some(Self::Apart)
        }
    }
}

/// Three points, or the ends of the segment that they are on, or the point that they are.
fn extreme_points([p, q, r]: [DVec3; 3]) -> Extremes {
    if (0..3).any(|axis| orient2d(without(axis, p), without(axis, q), without(axis, r)) != 0.0) {
        return smallvec![p, q, r];
    }
    // On a line, the order of the first coordinate in which the points differ is the order along the line.
    let first = |p, q| if along_line(p, q).is_le() { p } else { q };
    let last = |p, q| if along_line(p, q).is_gt() { p } else { q };
    let (first, last) = (first(first(p, q), r), last(last(p, q), r));
    if first == last {
        smallvec![first]
    } else {
        smallvec![first, last]
    }
}

fn along_line(p: DVec3, q: DVec3) -> Ordering {
    p.to_array().partial_cmp(&q.to_array()).unwrap_or(Ordering::Equal)
}

/// The projection of the point along an axis.
fn without(axis: usize, point: DVec3) -> DVec2 {
    DVec2::new(point[(axis + 1) % 3], point[(axis + 2) % 3])
}

/// The extreme points of two convex sets in one plane.
struct Planar {
    points: [Extremes; 2],
    /// Their projections along an axis that is not in the plane.
    projected: [SmallVec<[DVec2; 3]>; 2],
    /// Of each set, by edge: the sides on it of the extreme points of the other set.
    sides: [[[f64; 3]; 3]; 2],
}

/// An extreme point of what two sets have in common.
#[derive(Clone, Copy)]
struct Corner {
    site: Site,
    /// The edges that it is on: edge `i` of set `s` is the bit `3 * s + i`.
    edges: u8,
}

#[derive(Clone, Copy)]
enum Site {
    /// This extreme point of this set.
    Vertex(usize, usize),
    /// Where these edges of the first and the second set cross.
    Crossing(usize, usize),
}

impl Planar {
    fn new(points: [Extremes; 2]) -> Self {
        let all: SmallVec<[DVec3; 6]> = points.iter().flatten().copied().collect();
        let axis = projection_axis(&all);
        let projected = points
            .each_ref()
            .map(|points| points.iter().map(|&point| without(axis, point)).collect());
        let mut pair = Self {
            points,
            projected,
            sides: [[[0.0; 3]; 3]; 2],
        };
        for set in [0, 1] {
            for i in 0..pair.edge_count(set) {
                let [p, q] = pair.edge(set, i);
                for (j, &point) in pair.projected[1 - set].iter().enumerate() {
                    pair.sides[set][i][j] = orient2d(p, q, point);
                }
            }
        }
        pair
    }

    /// The extreme points of what the sets have in common, in no order.
    fn corners(&self) -> impl Iterator<Item = Corner> {
        let vertices = [0, 1].into_iter().flat_map(move |set| {
            let own = self.points[set].iter().enumerate();
            let new = own.filter(move |(_, point)| set == 0 || !self.points[0].contains(point));
            new.filter_map(move |(i, _)| {
                let edges = self.edges_at(1 - set, i)? | edges_of_vertex(set, i);
                let site = Site::Vertex(set, i);
                Some(Corner { site, edges })
            })
        });
        let edges = (0..self.edge_count(0)).flat_map(|i| (0..self.edge_count(1)).map(move |j| (i, j)));
        let crossings = edges
            .filter(|&(i, j)| self.edge_separates(0, i, j) && self.edge_separates(1, j, i))
            .map(|(i, j)| Corner {
                site: Site::Crossing(i, j),
                edges: 1 << i | 1 << (3 + j),
            });
        vertices.chain(crossings)
    }

    /// Whether edge `i` of the set has the ends of edge `j` of the other set on different sides, and neither on its line.
    fn edge_separates(&self, set: usize, i: usize, j: usize) -> bool {
        let sides = &self.sides[set][i];
        let (p, q) = (sides[j], sides[(j + 1) % self.points[1 - set].len()]);
        (p > 0.0 && q < 0.0) || (p < 0.0 && q > 0.0)
    }

    fn position(&self, site: Site) -> DVec3 {
        match site {
            Site::Vertex(set, i) => self.points[set][i],
            Site::Crossing(i, j) => {
                let ([p, q], [r, s]) = (self.edge(0, i), self.edge(1, j));
                // The plane that stands on the edge of the second set. Its height may be any number that is exact.
                let height = (s - r).abs().max_element();
                let plane = Plane::through([r.extend(0.0), s.extend(0.0), r.extend(height)]);
                let weights = plane.crossing(p.extend(0.0), q.extend(0.0));
                let points = &self.points[0];
                between(points[i], points[(i + 1) % points.len()], weights)
            }
        }
    }

    /// The edges of the set that point `i` of the other set is on, if it is in the set.
    fn edges_at(&self, set: usize, i: usize) -> Option<u8> {
        let point = self.points[1 - set][i];
        let sides = self.sides[set].map(|sides| sides[i]);
        let inside = match self.points[set][..] {
            [only] => only == point,
            [p, q] => sides[0] == 0.0 && p.min(q).cmple(point).all() && point.cmple(p.max(q)).all(),
            _ => sides.iter().all(|&side| side >= 0.0) || sides.iter().all(|&side| side <= 0.0),
        };
        let on_edge = |edge: usize| u8::from(sides[edge] == 0.0) << (3 * set + edge);
        inside.then(|| (0..self.edge_count(set)).map(on_edge).sum())
    }

    fn edge_count(&self, set: usize) -> usize {
        match self.points[set].len() {
            3 => 3,
            points => points - 1,
        }
    }

    fn edge(&self, set: usize, i: usize) -> [DVec2; 2] {
        let points = &self.projected[set];
        [points[i], points[(i + 1) % points.len()]]
    }
}

/// The edges of a triangle that its vertex `i` is on.
fn edges_of_vertex(set: usize, i: usize) -> u8 {
    let next = 1 << (3 * set + i);
    let previous = 1 << (3 * set + (i + 2) % 3);
    next | previous
}

/// An axis along which the plane through the points can be projected without falling into a line. If there is no one
/// plane, because the points are on a line, any axis does.
fn projection_axis(points: &[DVec3]) -> usize {
    for (k, &r) in points.iter().enumerate() {
        for (j, &q) in points[..k].iter().enumerate() {
            for &p in &points[..j] {
                let steepest = (q - p).cross(r - p).abs().max_position();
                let axes = [steepest, (steepest + 1) % 3, (steepest + 2) % 3];
                let spans = |&axis: &usize| orient2d(without(axis, p), without(axis, q), without(axis, r)) != 0.0;
                if let Some(axis) = axes.into_iter().find(spans) {
                    return axis;
                }
            }
        }
    }
    0
}

/// The corners in order around the polygon that they are of: from one to another on the same edge.
fn in_order(mut corners: SmallVec<[Corner; 6]>) -> impl Iterator<Item = Corner> {
    for i in 1..corners.len() {
        let edges = corners[i - 1].edges;
        if let Some(next) = (i..corners.len()).find(|&next| corners[next].edges & edges != 0) {
            corners.swap(i, next);
        }
    }
    corners.into_iter()
}
