//! Triangle against triangle by their intervals on the line in which their planes meet.

use std::array;

use bevy::math::DVec3;

use super::{
    flat,
    predicates::{Plane, orient3d},
};

/// Whether two triangles have a point in common, by comparing their intervals on the line in which their planes meet.
///
/// The course of the test is that of Möller, *A Fast Triangle-Triangle Intersection Test*, 1997: triangles are apart if
/// one lies on one side of the plane of the other; else each meets the line that the planes share in an interval, and
/// the triangles meet if the intervals do. The ends of the intervals are not computed, but compared by the sides on
/// which vertices lie, as by Guigue and Devillers, *Fast and Robust Triangle-Triangle Overlap Test Using Orientation
/// Predicates*, 2003. Triangles whose boxes are apart are rejected before.
///
/// Exact, in the range that is told [there](super#exactness); false if a coordinate is NaN or infinite. Triangles in
/// one plane, and degenerate ones, are tested as what they are: polygons, segments or points.
#[inline]
pub fn intersect_by_intervals(a: [DVec3; 3], b: [DVec3; 3]) -> bool {
    match Position::of(a, b) {
        Position::Apart => false,
        Position::Flat => flat::intersect(a, b),
        Position::Straddling(pair) => pair.intersect(),
    }
}

/// How two triangles lie to the planes of each other.
pub(super) enum Position {
    /// They do not meet.
    Apart,
    /// Both lie in one plane, or one is a segment or a point.
    Flat,
    /// Each has points on both sides of the plane of the other, or on it.
    Straddling(Straddling),
}

impl Position {
    #[inline]
    pub(super) fn of(a: [DVec3; 3], b: [DVec3; 3]) -> Self {
        if boxes_apart(&a, &b) {
            return Self::Apart;
        }
        let sides_b = Plane::through(a).sides(b);
        if on_one_side(sides_b) {
            return Self::Apart;
        }
        if sides_b == [0.0; 3] {
            return Self::Flat;
        }
        let sides_a = Plane::through(b).sides(a);
        if on_one_side(sides_a) {
            return Self::Apart;
        }
        if sides_a == [0.0; 3] {
            return Self::Flat;
        }
        Self::Straddling(Straddling::new(a, sides_a, b, sides_b))
    }
}

/// Two triangles whose vertices are in the order of Guigue and Devillers: the first of each lies alone on the side of
/// the plane of the other from which that other is seen to run counter-clockwise (or in the plane, with both others
/// below it).
///
/// Along the line in which the planes meet, directed by the cross product of the normals of `a` and `b`, the interval of
/// `a` begins on its edge from `a[0]` to `a[2]` and ends on that to `a[1]`; the interval of `b` begins on the edge from
/// `b[0]` to `b[1]` and ends on that to `b[2]`.
pub(super) struct Straddling {
    pub(super) a: [DVec3; 3],
    pub(super) b: [DVec3; 3],
    /// Whether the interval of `a` is the point `a[0]`.
    pub(super) a_touches: bool,
    /// Whether the interval of `b` is the point `b[0]`.
    pub(super) b_touches: bool,
}

impl Straddling {
    #[inline]
    fn new(a: [DVec3; 3], sides_a: [f64; 3], b: [DVec3; 3], sides_b: [f64; 3]) -> Self {
        let (apex_a, flip_b) = apex(sides_a);
        let (apex_b, flip_a) = apex(sides_b);
        Self {
            a: starting_at(a, apex_a, flip_a),
            b: starting_at(b, apex_b, flip_b),
            a_touches: sides_a[apex_a] == 0.0,
            b_touches: sides_b[apex_b] == 0.0,
        }
    }

    #[inline]
    fn intersect(&self) -> bool {
        self.compare(1, 1) <= 0.0 && self.compare(2, 2) >= 0.0
    }

    /// Where the edge from `b[0]` to `b[end_b]` meets the line, seen from where the edge from `a[0]` to `a[end_a]` does:
    /// negative if before, positive if after, zero if there.
    #[inline]
    pub(super) fn compare(&self, end_a: usize, end_b: usize) -> f64 {
        orient3d(self.a[0], self.a[end_a], self.b[0], self.b[end_b])
    }
}

/// Which vertex lies alone on its side, and whether that is the side below.
#[inline]
fn apex(sides: [f64; 3]) -> (usize, bool) {
    let [p, q, r] = sides;
    let alone = |side: fn(f64) -> bool| match [side(p), side(q), side(r)] {
        [true, false, false] => Some(0),
        [false, true, false] => Some(1),
        [false, false, true] => Some(2),
        _ => None,
    };
    if let Some(above) = alone(|side| side > 0.0) {
        (above, false)
    } else if let Some(below) = alone(|side| side < 0.0) {
        (below, true)
    } else {
        // One is in the plane and the others are on one side of it.
        let touching = alone(|side| side == 0.0).unwrap_or(0);
        (touching, sides.iter().any(|&side| side > 0.0))
    }
}

/// The triangle from this vertex on, the other way round if `flip`.
#[inline]
fn starting_at(triangle: [DVec3; 3], first: usize, flip: bool) -> [DVec3; 3] {
    let step = if flip { 2 } else { 1 };
    array::from_fn(|i| triangle[(first + step * i) % 3])
}

#[inline]
fn on_one_side([p, q, r]: [f64; 3]) -> bool {
    (p > 0.0 && q > 0.0 && r > 0.0) || (p < 0.0 && q < 0.0 && r < 0.0)
}

#[inline]
fn boxes_apart([p, q, r]: &[DVec3; 3], [s, t, u]: &[DVec3; 3]) -> bool {
    let (min_a, max_a) = (p.min(*q).min(*r), p.max(*q).max(*r));
    let (min_b, max_b) = (s.min(*t).min(*u), s.max(*t).max(*u));
    max_a.cmplt(min_b).any() || max_b.cmplt(min_a).any()
}
