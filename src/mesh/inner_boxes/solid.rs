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

/// A mesh without open edges, and the closed parts of which it consists.
#[derive(Debug)]
pub(super) struct Solids {
    pub whole: Solid,
    /// At least one. Where several edges lie in one place, triangles are neighbours that come next in the mesh, so that
    /// parts that were made one after the other remain apart.
    pub parts: Vec<Solid>,
}

/// Triangles without open edges.
///
/// Every edge has as many triangles on one side as on the other, so that the winding number of a point off the surface
/// does not depend on the direction in which triangles are counted.
#[derive(Debug)]
pub(super) struct Solid {
    pub triangles: Vec<[DVec3; 3]>,
    pub min: DVec3,
    pub max: DVec3,
    /// The largest coordinate of the mesh.
    pub largest: f64,
    /// How far the vertices of the mesh may be from those of the triangles.
    pub seam: f64,
    /// More than what some steps of double precision are off.
    pub slack: f64,
}

impl Solids {
    pub fn new(mesh: &TriangleMesh) -> Result<Self, NotSolid> {
        let mut welded = Welded::new(mesh);
        let aabb = mesh.aabb();
        let largest = f64::from(aabb.min.abs().max(aabb.max.abs()).max_element());
        let mut seam = 0.0;
        let mut neighbours = welded.neighbours();
        if let Err(open) = &neighbours {
            seam = largest * tolerance::SEAM;
            welded.close_seams(open, seam);
            neighbours = welded.neighbours();
        }
        let neighbours = neighbours.map_err(|open| NotSolid::Open { edges: open.len() })?;
        let solid = |triangles: Vec<[DVec3; 3]>| {
            let corners = || triangles.iter().flatten().copied();
            Solid {
                min: corners().fold(DVec3::INFINITY, DVec3::min),
                max: corners().fold(DVec3::NEG_INFINITY, DVec3::max),
                triangles,
                largest,
                seam,
                slack: largest * tolerance::DOUBLE,
            }
        };
        let mut parts: Vec<Vec<[DVec3; 3]>> = Vec::new();
        let numbers = connected(welded.triangles.len(), &neighbours);
        for (triangle, part) in welded.triangles().zip(numbers) {
            if part == parts.len() {
                parts.push(Vec::new());
            }
            parts[part].push(triangle);
        }
        Ok(Self {
            whole: solid(welded.triangles().collect()),
            parts: parts.into_iter().map(solid).collect(),
        })
    }
}

/// The number of the group in which each of `count` things is, with those that it is connected with: groups are counted
/// as they come.
fn connected(count: usize, pairs: &[[u32; 2]]) -> Vec<usize> {
    let mut parents: Vec<u32> = (0..count as u32).collect();
    for &[a, b] in pairs {
        let (a, b) = (root(&mut parents, a), root(&mut parents, b));
        parents[b as usize] = a;
    }
    let mut numbers = HashMap::new();
    let number = |thing| {
        let next = numbers.len();
        *numbers.entry(root(&mut parents, thing)).or_insert(next)
    };
    (0..count as u32).map(number).collect()
}

/// The thing that stands for a group; shortens the way there.
fn root(parents: &mut [u32], mut thing: u32) -> u32 {
    while parents[thing as usize] != thing {
        let parent = parents[thing as usize];
        parents[thing as usize] = parents[parent as usize];
        thing = parent;
    }
    thing
}

impl Solid {
    /// The surface of the box around it.
    pub fn surface(&self) -> f64 {
        let size = self.max - self.min;
        2.0 * (size * DVec3::new(size.y, size.z, size.x)).element_sum()
    }

    /// Whether it encloses less than nothing: more of it winds clockwise.
    pub fn is_inverted(&self) -> bool {
        let of_cone = |corners: &[DVec3; 3]| {
            let [a, b, c] = corners.map(|corner| corner - self.min);
            a.dot(b.cross(c))
        };
        let volume: f64 = self.triangles.iter().map(of_cone).sum();
        volume < -tolerance::DOUBLE * (self.max - self.min).element_sum().powi(3)
    }

    /// Whether no triangle touches the box.
    pub fn is_clear(&self, aabb: &Aabb3d) -> bool {
        let (min, max) = (aabb.min.as_dvec3(), aabb.max.as_dvec3());
        self.triangles.iter().all(|&[a, b, c]| {
            let is_near = a.min(b).min(c).cmple(max).all() && min.cmple(a.max(b).max(c)).all();
            // The corners were single precision before.
            let [a, b, c] = [a, b, c].map(DVec3::as_vec3);
            !(is_near && aabb.intersects(&Triangle3d::new(a, b, c)))
        })
    }

    /// How often the triangles go around a point that none of them touches, counter-clockwise from outside.
    ///
    /// Counts those in the direction of x, and no edge twice: exactly, for ties are broken as if the point were a
    /// little further along y, and much less along z.
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

/// Triangles between vertices of which no two are in the same place.
struct Welded {
    positions: Vec<Vec3>,
    /// In the order of the mesh.
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
        let mut slots: Vec<u32> = mesh.slots().collect();
        slots.sort_unstable_by_key(|&slot| mesh.number(slot));
        let corners = slots.into_iter().map(|slot| mesh.corners(slot).map(Vec3::from));
        let triangles = corners.map(|corners| corners.map(&mut number)).collect();
        Self { positions, triangles }
    }

    fn triangles(&self) -> impl Iterator<Item = [DVec3; 3]> + '_ {
        let place = |vertex: u32| self.positions[vertex as usize].as_dvec3();
        self.triangles.iter().map(move |vertices| vertices.map(place))
    }

    /// The pairs of triangles that meet at an edge, which one passes in one direction and the other in the other.
    ///
    /// If there are edges that are passed more often in one direction, those, by their vertices.
    fn neighbours(&self) -> Result<Vec<[u32; 2]>, Vec<[u32; 2]>> {
        let mut passes = Vec::with_capacity(3 * self.triangles.len());
        for (triangle, &[a, b, c]) in (0..).zip(&self.triangles) {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                if from != to {
                    passes.push(([from.min(to), from.max(to)], from < to, triangle));
                }
            }
        }
        passes.sort_unstable();
        let (mut neighbours, mut open) = (Vec::with_capacity(passes.len() / 2), Vec::new());
        for of_edge in passes.chunk_by(|a, b| a.0 == b.0) {
            let (back, forth) = of_edge.split_at(of_edge.partition_point(|pass| !pass.1));
            if back.len() != forth.len() {
                open.push(of_edge[0].0);
            }
            neighbours.extend(back.iter().zip(forth).map(|(a, b)| [a.2, b.2]));
        }
        if open.is_empty() { Ok(neighbours) } else { Err(open) }
    }

    /// Makes one of vertices of these edges that are closer to each other than `seam`.
    fn close_seams(&mut self, edges: &[[u32; 2]], seam: f64) {
        // Cells twice as wide as a seam: whatever is within a seam of a point is in the cell of one of the corners of
        // the cube around it.
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
