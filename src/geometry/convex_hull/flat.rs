//! Hulls of coplanar points.

use bevy::math::{DVec2, DVec3};

use super::{
    polytope::{Faces, HullRank, Polytope},
    predicates::{PROJECTIONS, orient2d},
};

/// The hull of points that lie in the plane of the triangle of three of them, exactly.
///
/// Source: Andrew, *Another Efficient Algorithm for Convex Hulls in Two Dimensions*, 1979 (the monotone chain), along
/// the axis that leaves the triangle largest: a projection of a plane that does not flatten it keeps its hulls.
pub(super) fn polygon(points: &[DVec3], triangle: [u32; 3]) -> Polytope {
    let area = |project: fn(DVec3) -> DVec2| orient2d(triangle.map(|corner| project(points[corner as usize]))).abs();
    let [x, y, z] = PROJECTIONS.map(area);
    let project = PROJECTIONS[DVec3::new(x, y, z).max_position()];

    let flat: Vec<DVec2> = points.iter().map(|&point| project(point)).collect();
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    order.sort_unstable_by(|&a, &b| {
        let (p, q) = (flat[a as usize], flat[b as usize]);
        p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)).then(a.cmp(&b))
    });
    order.dedup_by_key(|index| flat[*index as usize]);

    let mut corners = chain(&flat, order.iter().copied());
    corners.pop();
    corners.extend(chain(&flat, order.iter().rev().copied()));
    corners.pop();

    let count = corners.len() as u32;
    let mut faces = Faces {
        corners: (0..count).collect(),
        across: vec![1; corners.len()],
        ends: vec![count],
    };
    faces.corners.extend((0..count).rev());
    faces.across.extend((0..count).map(|_| 0));
    faces.close();
    Polytope {
        rank: HullRank::Polygon,
        corners,
        faces,
    }
}

/// The points of a sorted row from the first to the last that the hull has on the right.
fn chain(flat: &[DVec2], row: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut chain: Vec<u32> = Vec::new();
    for next in row {
        while let [.., a, b] = chain[..]
            && orient2d([a, b, next].map(|index| flat[index as usize])) <= 0.0
        {
            chain.pop();
        }
        chain.push(next);
    }
    chain
}
