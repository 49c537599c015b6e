//! From the triangles of a hull to its faces.

use bevy::math::DVec3;

use super::{
    polytope::{Faces, HullRank, Polytope},
    quickhull::Triangle,
};

/// No facet yet, or a corner that is none of the hull.
const NONE: u32 = u32::MAX;

/// Merges triangles that lie in one plane, exactly, into faces, and drops the points inside of faces and edges.
pub(super) fn merged(points: &[DVec3], triangles: &[Triangle]) -> Polytope {
    let (facet_of, facets) = group(points, triangles);
    let is_border = |index: usize, edge: usize| facet_of[triangles[index].neighbors[edge] as usize] != facet_of[index];

    // A point inside of an edge borders on two facets, a corner on three at least.
    let mut bordering = vec![0u32; points.len()];
    let mut starts = vec![(0, 0); facets];
    for (index, triangle) in triangles.iter().enumerate().filter(|(_, triangle)| triangle.alive) {
        for edge in (0..3).filter(|&edge| is_border(index, edge)) {
            bordering[triangle.corners[edge] as usize] += 1;
            starts[facet_of[index] as usize] = (index, edge);
        }
    }
    let mut number_of = vec![NONE; points.len()];
    let mut corners = Vec::new();
    for (point, _) in bordering.iter().enumerate().filter(|&(_, &facets)| facets > 2) {
        number_of[point] = corners.len() as u32;
        corners.push(point as u32);
    }

    let mut faces = Faces::default();
    for start in starts {
        let (mut index, mut edge) = start;
        loop {
            let triangle = &triangles[index];
            let number = number_of[triangle.corners[edge] as usize];
            if number != NONE {
                faces.corners.push(number);
                faces.across.push(facet_of[triangle.neighbors[edge] as usize]);
            }
            // Turn about the end of this edge to the next one on the border.
            edge = (edge + 1) % 3;
            while !is_border(index, edge) {
                let end = triangles[index].corners[edge];
                index = triangles[index].neighbors[edge] as usize;
                edge = (triangles[index].corners.iter().position(|&corner| corner == end)).unwrap_or(0);
            }
            if (index, edge) == start {
                break;
            }
        }
        faces.close();
    }
    Polytope {
        rank: HullRank::Solid,
        corners,
        faces,
    }
}

/// The facet of each triangle, and how many there are: triangles that share an edge and a plane share their facet.
fn group(points: &[DVec3], triangles: &[Triangle]) -> (Vec<u32>, usize) {
    let mut facet_of = vec![NONE; triangles.len()];
    let mut facets = 0;
    let mut stack = Vec::new();
    for (start, triangle) in triangles.iter().enumerate() {
        if !triangle.alive || facet_of[start] != NONE {
            continue;
        }
        facet_of[start] = facets as u32;
        stack.push(start);
        while let Some(index) = stack.pop() {
            for neighbor in triangles[index].neighbors {
                let neighbor = neighbor as usize;
                let known = triangles[index].corners;
                let coplanar =
                    |corner: &u32| known.contains(corner) || triangle.height(points, points[*corner as usize]) == 0.0;
                if facet_of[neighbor] == NONE && triangles[neighbor].corners.iter().all(coplanar) {
                    facet_of[neighbor] = facets as u32;
                    stack.push(neighbor);
                }
            }
        }
        facets += 1;
    }
    (facet_of, facets)
}
