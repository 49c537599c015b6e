//! Whether a mesh encloses anything, and what.

use bevy::{
    math::{DVec3, Vec3, bounding::Aabb3d, primitives::Triangle3d},
    platform::collections::{HashMap, HashSet},
};
use robust::{Coord, Coord3D};

use super::NotSolid;
use crate::{
    geometry::{intersection::Intersects, tolerance},
    mesh::TriangleMesh,
};

/// The triangles of a mesh without open edges.
///
/// Every edge has as many triangles on one side as on the other, so that the winding number of a point off the surface
/// does not depend on the direction in which triangles are counted.
#[derive(Debug)]
pub(super) struct Solid {
    pub triangles: Vec<[DVec3; 3]>,
    pub min: DVec3,
    pub max: DVec3,
    /// The largest coordinate.
    pub largest: f64,
    /// How far the vertices of the mesh may be from those of the triangles.
    pub seam: f64,
    /// More than what some steps of double precision are off.
    pub slack: f64,
}

impl Solid {
    pub fn new(mesh: &TriangleMesh) -> Result<Self, NotSolid> {
        let mut welded = Welded::new(mesh);
        let aabb = mesh.aabb();
        let largest = f64::from(aabb.min.abs().max(aabb.max.abs()).max_element());
        let mut seam = 0.0;
        let mut open = welded.open_edges();
        if !open.is_empty() {
            seam = largest * tolerance::SEAM;
            welded.close_seams(&open, seam);
            open = welded.open_edges();
        }
        if !open.is_empty() {
            return Err(NotSolid::Open { edges: open.len() });
        }
        Ok(Self {
            triangles: welded.triangles().collect(),
            min: aabb.min.as_dvec3(),
            max: aabb.max.as_dvec3(),
            largest,
            seam,
            slack: largest * tolerance::DOUBLE,
        })
    }

    /// How often the triangles go around a point that none of them touches, counter-clockwise from outside.
    ///
    /// Counts those in the direction of x, and no edge twice: exactly, for ties are broken as if the point were a little
    /// further along y, and much less along z.
    pub fn winding_number(&self, point: DVec3) -> i32 {
        self.triangles.iter().map(|corners| crossing(corners, point)).sum()
    }
}

/// 1 if the ray from `point` along x leaves through the triangle, -1 if it enters.
fn crossing(corners: &[DVec3; 3], point: DVec3) -> i32 {
    let [a, b, c] = *corners;
    let (min, max) = (a.min(b).min(c), a.max(b).max(c));
    let may_cross = max.x >= point.x && min.z <= point.z && point.z < max.z && min.y <= point.y && point.y <= max.y;
    if !may_cross {
        return 0;
    }
    let turn = turn(a, b, point) + turn(b, c, point) + turn(c, a, point);
    let coord = |p: DVec3| Coord3D { x: p.x, y: p.y, z: p.z };
    let behind = || robust::orient3d(coord(a), coord(b), coord(c), coord(point));
    let is_ahead = turn != 0 && f64::from(turn) * behind() > 0.0;
    if is_ahead { turn } else { 0 }
}

/// What an edge adds to the number of times that a triangle, as seen against x, goes around a point: the opposite of
/// what the opposite edge adds.
fn turn(from: DVec3, to: DVec3, point: DVec3) -> i32 {
    let coord = |p: DVec3| Coord { x: p.y, y: p.z };
    let left = || robust::orient2d(coord(from), coord(to), coord(point));
    match (from.z <= point.z, to.z <= point.z) {
        (true, false) => i32::from(left() > 0.0),
        (false, true) => -i32::from(left() < 0.0),
        _ => 0,
    }
}

/// Whether no triangle of the mesh touches the box.
pub(super) fn is_clear(mesh: &TriangleMesh, aabb: &Aabb3d) -> bool {
    let (min, max) = (Vec3::from(aabb.min), Vec3::from(aabb.max));
    mesh.corners_of_all().all(|[a, b, c]| {
        let is_near = a.min(b).min(c).cmple(max).all() && min.cmple(a.max(b).max(c)).all();
        !(is_near && aabb.intersects(&Triangle3d::new(a, b, c)))
    })
}

/// Triangles between vertices of which no two are in the same place.
struct Welded {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

impl Welded {
    fn new(mesh: &TriangleMesh) -> Self {
        let mut numbers = HashMap::new();
        let mut positions = Vec::new();
        let mut number = |corner: Vec3| {
            // The two zeros are one place.
            let corner = corner + 0.0;
            *numbers.entry(corner.to_array().map(f32::to_bits)).or_insert_with(|| {
                positions.push(corner);
                positions.len() as u32 - 1
            })
        };
        let triangles = mesh.corners_of_all().map(|corners| corners.map(&mut number)).collect();
        Self { positions, triangles }
    }

    fn triangles(&self) -> impl Iterator<Item = [DVec3; 3]> + '_ {
        let place = |vertex: u32| self.positions[vertex as usize].as_dvec3();
        self.triangles.iter().map(move |vertices| vertices.map(place))
    }

    /// The edges, by their vertices, that are passed more often in one direction than in the other.
    fn open_edges(&self) -> Vec<[u32; 2]> {
        let mut edges = Vec::with_capacity(3 * self.triangles.len());
        for &[a, b, c] in &self.triangles {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                if from != to {
                    edges.push(([from.min(to), from.max(to)], if from < to { 1 } else { -1 }));
                }
            }
        }
        edges.sort_unstable();
        let same_edge = edges.chunk_by(|(a, _), (b, _)| a == b);
        let open = same_edge.filter(|passes| passes.iter().map(|(_, way)| way).sum::<i32>() != 0);
        open.map(|passes| passes[0].0).collect()
    }

    /// Makes one of vertices of these edges that are closer to each other than `seam`.
    fn close_seams(&mut self, edges: &[[u32; 2]], seam: f64) {
        // Cells twice as wide as a seam: whatever is within a seam of a point is in the cell of one of the corners of the
        // cube around it.
        let cell = |point: DVec3| (point / (2.0 * seam)).floor().to_array();
        let key = |cell: [f64; 3]| cell.map(|coordinate| coordinate as i64);
        let vertices: HashSet<u32> = edges.iter().flatten().copied().collect();
        let mut vertices: Vec<u32> = vertices.into_iter().collect();
        vertices.sort_unstable();
        let mut kept: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
        let mut merged = HashMap::new();
        for vertex in vertices {
            let point = self.positions[vertex as usize].as_dvec3();
            let corners = (0..8).map(|corner| DVec3::from_array([0, 1, 2].map(|axis| f64::from(corner >> axis & 1))));
            let near = corners
                .filter_map(|corner| kept.get(&key(cell(point + (2.0 * corner - 1.0) * seam))))
                .flatten()
                .find(|&&other| self.positions[other as usize].as_dvec3().distance(point) <= seam);
            match near {
                Some(&other) => {
                    merged.insert(vertex, other);
                }
                None => kept.entry(key(cell(point))).or_default().push(vertex),
            }
        }
        for vertex in self.triangles.iter_mut().flatten() {
            *vertex = merged.get(vertex).copied().unwrap_or(*vertex);
        }
    }
}
