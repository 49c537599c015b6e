//! The point of a simplex that is closest to the origin.

use bevy::math::DVec3;

use crate::geometry::tolerance::DOUBLE;

/// The point of a simplex that is closest to the origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Closest {
    pub point: DVec3,
    /// The weights of the vertices in it: each in `0..=1`, their sum 1 up to rounding. All four are positive only where the
    /// origin is inside a tetrahedron.
    pub weights: [f64; 4],
}

/// The closest point of the convex hull of one to four points. Degenerate simplices are those of fewer points that they
/// look like.
pub(crate) fn closest_to_origin(points: &[DVec3]) -> Closest {
    match *points {
        [a, b] => of_segment(a, b),
        [a, b, c] => within_triangle(a, b, c).unwrap_or_else(|| best_face(points)),
        [a, b, c, d] => within_tetrahedron(a, b, c, d).unwrap_or_else(|| best_face(points)),
        _ => Closest {
            point: points[0],
            weights: [1.0, 0.0, 0.0, 0.0],
        },
    }
}

/// The point with these weights.
pub(crate) fn weighted(points: &[DVec3], weights: &[f64; 4]) -> DVec3 {
    points.iter().zip(weights).map(|(&point, &weight)| point * weight).sum()
}

/// From the nearer end, so that a point close to it keeps its digits.
fn of_segment(a: DVec3, b: DVec3) -> Closest {
    let direction = b - a;
    let length_squared = direction.length_squared();
    let (from_a, from_b) = (-a.dot(direction), b.dot(direction));
    let fraction = |along: f64| {
        if length_squared > 0.0 {
            (along / length_squared).clamp(0.0, 1.0)
        } else {
            0.0
        }
    };
    if from_a <= from_b {
        let weight = fraction(from_a);
        Closest {
            point: a + direction * weight,
            weights: [1.0 - weight, weight, 0.0, 0.0],
        }
    } else {
        let weight = fraction(from_b);
        Closest {
            point: b - direction * weight,
            weights: [weight, 1.0 - weight, 0.0, 0.0],
        }
    }
}

/// The origin's projection on the plane, if that is in the triangle. Each weight is the distance from an edge, measured
/// from a vertex of that edge, so that it keeps its digits however far the origin is (compare Ericson, *Real-Time Collision
/// Detection*, 2005, §5.1.5).
fn within_triangle(a: DVec3, b: DVec3, c: DVec3) -> Option<Closest> {
    let (ab, bc, ca) = (b - a, c - b, a - c);
    let longest = [bc, ca].into_iter().fold(ab, |longest, edge| {
        if edge.length_squared() > longest.length_squared() {
            edge
        } else {
            longest
        }
    });
    let product = ab.cross(bc);
    if product.length() <= DOUBLE * longest.length_squared() {
        return None;
    }
    // Of a sliver, the product leans over along it by what rounding left.
    let normal = product - longest * (product.dot(longest) / longest.length_squared());
    let doubled_area_squared = normal.length_squared();
    let beyond = |from: DVec3, edge: DVec3| -from.dot(normal.cross(edge)) / doubled_area_squared;
    let weights = [beyond(b, bc), beyond(c, ca), beyond(a, ab)];
    let sum: f64 = weights.iter().sum();
    weights.iter().all(|&weight| weight >= 0.0).then(|| Closest {
        point: normal * (normal.dot(a) / doubled_area_squared),
        weights: [weights[0] / sum, weights[1] / sum, weights[2] / sum, 0.0],
    })
}

/// The origin itself, if it is in the tetrahedron. The weights are the volumes that it spans with the faces.
fn within_tetrahedron(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> Option<Closest> {
    let (ab, ac, ad) = (b - a, c - a, d - a);
    let volume = ab.dot(ac.cross(ad));
    if volume.abs() <= DOUBLE * ab.length() * ac.length() * ad.length() {
        return None;
    }
    let weights = [
        b.dot((c - b).cross(d - b)) / volume,
        -a.dot(ac.cross(ad)) / volume,
        -a.dot(ad.cross(ab)) / volume,
        -a.dot(ab.cross(ac)) / volume,
    ];
    weights.iter().all(|&weight| weight >= 0.0).then_some(Closest {
        point: DVec3::ZERO,
        weights,
    })
}

/// The best among the simplices with one point less.
fn best_face(points: &[DVec3]) -> Closest {
    let kept = points.len() - 1;
    let of_face = |left_out: usize| {
        // The vertices behind the one left out move up by one place, and their weights back.
        let place = |index: usize| index + usize::from(index >= left_out);
        let mut face = [DVec3::ZERO; 3];
        (0..kept).for_each(|index| face[index] = points[place(index)]);
        let closest = closest_to_origin(&face[..kept]);
        let mut weights = [0.0; 4];
        (0..kept).for_each(|index| weights[place(index)] = closest.weights[index]);
        Closest { weights, ..closest }
    };
    (1..points.len()).map(of_face).fold(of_face(0), |best, other| {
        if other.point.length_squared() < best.point.length_squared() {
            other
        } else {
            best
        }
    })
}
