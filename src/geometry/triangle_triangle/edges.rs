//! Triangle against triangle by their edges.

use bevy::math::DVec3;

use super::{
    flat,
    predicates::{Plane, orient3d},
};

/// Whether two triangles have a point in common, by testing each edge of one against the other.
///
/// Two triangles that are not in one plane meet if and only if an edge of one meets the other (Ericson, *Real-Time
/// Collision Detection*, 2005, §5.2.10): six tests of a segment against a triangle, by the signs of scalar triple
/// products (§5.3.4 to §5.3.6). [`intersect_by_intervals`](super::intersect_by_intervals) has the same answers and
/// rejects sooner.
///
/// Exact, in the range that is told [there](super#exactness); false if a coordinate is NaN or infinite. Triangles in
/// one plane, and degenerate ones, are tested as what they are: polygons, segments or points.
pub fn intersect_by_edges(a: [DVec3; 3], b: [DVec3; 3]) -> bool {
    if !a.iter().chain(&b).all(|vertex| vertex.is_finite()) {
        return false;
    }
    let sides_a = Plane::through(b).sides(a);
    let sides_b = Plane::through(a).sides(b);
    if sides_a == [0.0; 3] && sides_b == [0.0; 3] {
        return flat::intersect(a, b);
    }
    any_edge_pierces(a, sides_a, b) || any_edge_pierces(b, sides_b, a)
}

/// Whether an edge meets a triangle in one point. `sides` are those of the vertices on the plane of the triangle.
///
/// An edge within the plane is passed over: what it meets, its neighbours or the edges of the triangle meet too.
fn any_edge_pierces(vertices: [DVec3; 3], sides: [f64; 3], triangle: [DVec3; 3]) -> bool {
    [(0, 1), (1, 2), (2, 0)]
        .into_iter()
        .any(|(i, j)| crosses(sides[i], sides[j]) && line_pierces(vertices[i], vertices[j], triangle))
}

/// Whether a segment whose ends are on these sides of a plane has exactly one point in it.
pub(super) fn crosses(p: f64, q: f64) -> bool {
    (p > 0.0) != (q > 0.0) || (p < 0.0) != (q < 0.0)
}

/// Whether the line through `p` and `q`, which is not parallel to the plane of the triangle, meets the triangle.
pub(super) fn line_pierces(p: DVec3, q: DVec3, [a, b, c]: [DVec3; 3]) -> bool {
    let volumes = [orient3d(p, q, a, b), orient3d(p, q, b, c), orient3d(p, q, c, a)];
    volumes.iter().all(|&volume| volume >= 0.0) || volumes.iter().all(|&volume| volume <= 0.0)
}
