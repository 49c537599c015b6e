//! The combinatorics of a convex hull: which points are its corners, and how its faces meet.

use bevy::math::DVec3;

use crate::geometry::support::unit;

/// What the hull of some points spans.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum HullRank {
    /// All points coincide.
    Point,
    /// All points lie on a line.
    Segment,
    /// All points lie in a plane.
    Polygon,
    /// The points span a volume.
    Solid,
}

/// The faces of a polytope: their loops of corners, one after the other.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Faces {
    /// The corners of all faces, counter-clockwise seen from outside.
    pub corners: Vec<u32>,
    /// For the edge from each corner to the next: the face on its other side.
    pub across: Vec<u32>,
    /// Where in `corners` each face ends.
    pub ends: Vec<u32>,
}

impl Faces {
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Ends the face that was being pushed.
    pub fn close(&mut self) {
        self.ends.push(self.corners.len() as u32);
    }

    fn range(&self, face: usize) -> std::ops::Range<usize> {
        let start = if face == 0 { 0 } else { self.ends[face - 1] as usize };
        start..self.ends[face] as usize
    }

    /// The loop of a face.
    pub fn corners(&self, face: usize) -> &[u32] {
        &self.corners[self.range(face)]
    }

    /// The edges of a face, each from a corner to the next, with the face across.
    pub fn edges(&self, face: usize) -> impl Iterator<Item = ([u32; 2], usize)> {
        let range = self.range(face);
        let corners = &self.corners[range.clone()];
        let next = corners.iter().cycle().skip(1);
        (corners.iter().zip(next).zip(&self.across[range])).map(|((&a, &b), &across)| ([a, b], across as usize))
    }
}

/// The hull of some points, exactly: every corner is one of them and extreme, every face planar and as large as it can
/// be.
pub(super) struct Polytope {
    pub rank: HullRank,
    /// The corners, by the indices of the points. `faces` numbers them as they lie here.
    pub corners: Vec<u32>,
    /// None of a point or a segment; of a polygon both sides.
    pub faces: Faces,
}

impl Polytope {
    /// The hull that is one point, or the segment between two.
    pub fn without_faces(rank: HullRank, corners: Vec<u32>) -> Self {
        Self {
            rank,
            corners,
            faces: Faces::default(),
        }
    }
}

/// The unit normal of a planar convex polygon, on the side that sees it counter-clockwise; zero where even `f64` cannot
/// tell the polygon from a segment.
///
/// Right to a few units in the last place of `f64`, even of a sliver, as long as the differences of its corners are
/// exact: the cross products are formed as in Kahan's difference of products (Jeannerod, Louvet and Muller, *Further
/// Analysis of Kahan's Algorithm for the Accurate Computation of 2x2 Determinants*, 2013), and all triangles of the fan
/// face the same way, so nothing cancels.
pub(super) fn unit_normal(points: &[DVec3], corners: &[u32]) -> DVec3 {
    let point = |corner: u32| points[corner as usize];
    let triangle = |pair: &[u32]| double_area([corners[0], pair[0], pair[1]].map(point));
    unit(corners[1..].windows(2).map(triangle).sum())
}

/// The normal of a triangle, as long as its area twice: from the two shorter sides, as two long ones may round to the
/// same.
fn double_area([a, b, c]: [DVec3; 3]) -> DVec3 {
    let opposite = DVec3::new(b.distance_squared(c), c.distance_squared(a), a.distance_squared(b));
    match opposite.max_position() {
        0 => accurate_cross(b - a, c - a),
        1 => accurate_cross(c - b, a - b),
        _ => accurate_cross(a - c, b - c),
    }
}

fn accurate_cross(a: DVec3, b: DVec3) -> DVec3 {
    let difference_of_products = |a: f64, b: f64, c: f64, d: f64| {
        let product = c * d;
        a.mul_add(b, -product) + (-c).mul_add(d, product)
    };
    DVec3::new(
        difference_of_products(a.y, b.z, a.z, b.y),
        difference_of_products(a.z, b.x, a.x, b.z),
        difference_of_products(a.x, b.y, a.y, b.x),
    )
}
