//! Where two triangles meet.

use bevy::math::DVec3;
use smallvec::SmallVec;

use super::{
    flat,
    intervals::{Position, Straddling},
    predicates::Plane,
};

/// What two triangles have in common, in their space.
///
/// Which variant it is, and how many corners a polygon has, is exact; the points are rounded, so that points which are
/// different may become equal.
#[derive(Clone, Debug, PartialEq)]
pub enum TriangleContact {
    /// One point.
    Point(DVec3),
    /// A segment, by its ends; in no particular order.
    Segment([DVec3; 2]),
    /// A convex polygon, by its three to six corners in order around it, one way or the other. The triangles are in one
    /// plane.
    Polygon(SmallVec<[DVec3; 6]>),
}

impl TriangleContact {
    /// The point, the ends of the segment or the corners of the polygon.
    pub fn points(&self) -> &[DVec3] {
        match self {
            Self::Point(point) => std::slice::from_ref(point),
            Self::Segment(ends) => ends,
            Self::Polygon(corners) => corners,
        }
    }

    /// The same with every point replaced by its image under `place`.
    #[must_use]
    pub fn map(self, place: impl Fn(DVec3) -> DVec3) -> Self {
        match self {
            Self::Point(point) => Self::Point(place(point)),
            Self::Segment(ends) => Self::Segment(ends.map(place)),
            Self::Polygon(corners) => Self::Polygon(corners.into_iter().map(place).collect()),
        }
    }
}

/// What two triangles have in common, or `None` if they are apart: just where
/// [`intersect_by_intervals`](super::intersect_by_intervals) is false.
///
/// A vertex that is a corner of the contact is given as it is. Any other corner is a point where an edge of one triangle
/// crosses the plane, or an edge, of the other. Each of its coordinates is within 2⁻⁴⁰ of the length of that edge, and
/// 2⁻⁵⁰ of the largest coordinate of the triangles, of the exact point, however thin the triangles are and however flat
/// they meet. Coordinates must be less than 2¹⁰²² in magnitude, or the points may overflow.
///
/// The contact does not depend on the order of the triangles and their vertices, but for rounding within these bounds
/// and the order of its points.
pub fn contact(a: [DVec3; 3], b: [DVec3; 3]) -> Option<TriangleContact> {
    match Position::of(a, b) {
        Position::Apart => None,
        Position::Straddling(pair) => pair.contact(),
        Position::Flat => {
            let corners = flat::corners(a, b);
            match corners[..] {
                [] => None,
                [point] => Some(TriangleContact::Point(point)),
                [p, q] => Some(TriangleContact::Segment([p, q])),
                _ => Some(TriangleContact::Polygon(corners)),
            }
        }
    }
}

impl Straddling {
    fn contact(&self) -> Option<TriangleContact> {
        let (end_to_start, start_to_end) = (self.compare(1, 1), self.compare(2, 2));
        let meet = end_to_start <= 0.0 && start_to_end >= 0.0;
        if !meet {
            return None;
        }
        if self.a_touches {
            return Some(TriangleContact::Point(self.a[0]));
        }
        if self.b_touches {
            return Some(TriangleContact::Point(self.b[0]));
        }
        let (plane_a, plane_b) = (Plane::through(self.a), Plane::through(self.b));
        let on_a = |end: usize| flat::crossing(&plane_b, self.a[0], self.a[end]);
        let on_b = |end: usize| flat::crossing(&plane_a, self.b[0], self.b[end]);

        let start = if self.compare(2, 1) > 0.0 { on_b(1) } else { on_a(2) };
        if end_to_start == 0.0 || start_to_end == 0.0 {
            return Some(TriangleContact::Point(start));
        }
        let end = if self.compare(1, 2) < 0.0 { on_b(2) } else { on_a(1) };
        Some(TriangleContact::Segment([start, end]))
    }
}
