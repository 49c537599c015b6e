//! Triangles, made ready to be drawn.

use bevy::{
    math::{Vec3, Vec3A, bounding::Aabb3d},
    platform::collections::{HashMap, hash_map::Entry},
};

use crate::spatial::simd::LANES;

/// A mesh that hides what is behind it: vertices at the same place are one, and triangles know their neighbours.
#[derive(Clone, Debug, Default)]
pub struct OccluderMesh {
    /// Eight vertices at a time, axis by axis; the last ones repeat the last vertex.
    pub(super) vertices: Vec<[[f32; LANES]; 3]>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Beyond the edge from each corner to the next: the triangle that has the same edge the other way round, or
    /// [`NOBODY`](Self::NOBODY).
    pub(super) neighbours: Vec<[u32; 3]>,
    /// Where the triangles of each connected part end.
    pub(super) parts: Vec<u32>,
    aabb: Option<Aabb3d>,
}

impl OccluderMesh {
    pub(super) const NOBODY: u32 = u32::MAX;

    /// Takes triangles of which each names three positions, counter-clockwise as seen from outside. Left out are those
    /// without an extent, those with a position that is NaN or infinite, and those that name one that is not there.
    pub fn new(positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let mut places: Vec<Vec3> = Vec::new();
        let mut numbers: HashMap<[u32; 3], u32> = HashMap::default();
        let mut number_of = |position: Vec3| {
            // Adding zero makes one of the two zeros.
            let key = (position + Vec3::ZERO).to_array().map(f32::to_bits);
            *numbers.entry(key).or_insert_with(|| {
                places.push(position);
                places.len() as u32 - 1
            })
        };
        let usable = triangles.iter().filter_map(|corners| {
            let at = |corner: u32| positions.get(corner as usize).copied().filter(|at| at.is_finite());
            let [a, b, c] = [at(corners[0])?, at(corners[1])?, at(corners[2])?];
            let numbers = [number_of(a), number_of(b), number_of(c)];
            let is_flat = numbers[0] == numbers[1] || numbers[1] == numbers[2] || numbers[2] == numbers[0];
            (!is_flat).then_some(numbers)
        });
        let triangles: Vec<[u32; 3]> = usable.collect();
        let (triangles, parts) = by_parts(triangles);
        let neighbours = neighbours(&triangles);
        let aabb = (!places.is_empty()).then(|| {
            let places = places.iter().map(|&place| Vec3A::from(place));
            let (min, max) = places.fold((Vec3A::INFINITY, Vec3A::NEG_INFINITY), |(min, max), place| {
                (min.min(place), max.max(place))
            });
            Aabb3d { min, max }
        });
        let vertices = places.chunks(LANES).map(|places| {
            std::array::from_fn(|axis| {
                std::array::from_fn(|lane| places.get(lane).unwrap_or(&places[places.len() - 1])[axis])
            })
        });
        Self {
            vertices: vertices.collect(),
            triangles,
            neighbours,
            parts,
            aabb,
        }
    }

    /// The number of triangles.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Whether there are no triangles.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// The box around all of it, if there is something.
    pub fn aabb(&self) -> Option<Aabb3d> {
        self.aabb
    }

    /// The bytes that are kept.
    pub fn memory(&self) -> usize {
        size_of_val(self)
            + self.vertices.capacity() * size_of::<[[f32; LANES]; 3]>()
            + (self.triangles.capacity() + self.neighbours.capacity()) * size_of::<[u32; 3]>()
            + self.parts.capacity() * size_of::<u32>()
    }
}

/// Brings triangles that share vertices together, part by part in the order of their first ones, with where each part
/// ends.
fn by_parts(triangles: Vec<[u32; 3]>) -> (Vec<[u32; 3]>, Vec<u32>) {
    fn root(parents: &mut [u32], mut vertex: u32) -> u32 {
        while parents[vertex as usize] != vertex {
            let above = parents[parents[vertex as usize] as usize];
            parents[vertex as usize] = above;
            vertex = above;
        }
        vertex
    }

    let vertices = triangles.iter().flatten().map(|&vertex| vertex + 1).max().unwrap_or(0);
    let mut parents: Vec<u32> = (0..vertices).collect();
    for &[a, b, c] in &triangles {
        let a = root(&mut parents, a);
        let b = root(&mut parents, b);
        parents[b as usize] = a;
        let c = root(&mut parents, c);
        parents[c as usize] = a;
    }
    let mut numbers: HashMap<u32, usize> = HashMap::default();
    let mut parts: Vec<Vec<[u32; 3]>> = Vec::new();
    for corners in triangles {
        let next = parts.len();
        let part = *numbers.entry(root(&mut parents, corners[0])).or_insert(next);
        if part == next {
            parts.push(Vec::new());
        }
        parts[part].push(corners);
    }
    let mut end = 0;
    let ends = parts.iter().map(|part| {
        end += part.len() as u32;
        end
    });
    let ends = ends.collect();
    (parts.concat(), ends)
}

/// Finds for each edge the one triangle beyond it. An edge of more than two triangles, or of two that are wound against
/// each other, has nobody beyond it: it is taken as a part of every outline.
fn neighbours(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    /// Who has an edge in one direction.
    #[derive(Clone, Copy)]
    enum Owner {
        One { triangle: u32, side: usize },
        Several,
    }

    let mut owners: HashMap<[u32; 2], Owner> = HashMap::default();
    let edge = |corners: &[u32; 3], side: usize| [corners[side], corners[(side + 1) % 3]];
    for (triangle, corners) in triangles.iter().enumerate() {
        for side in 0..3 {
            match owners.entry(edge(corners, side)) {
                Entry::Occupied(mut owner) => {
                    owner.insert(Owner::Several);
                }
                Entry::Vacant(owner) => {
                    owner.insert(Owner::One {
                        triangle: triangle as u32,
                        side,
                    });
                }
            }
        }
    }
    let mut neighbours = vec![[OccluderMesh::NOBODY; 3]; triangles.len()];
    for (&[from, to], &owner) in &owners {
        if let (Owner::One { triangle, side }, Some(&Owner::One { triangle: beyond, .. })) =
            (owner, owners.get(&[to, from]))
        {
            neighbours[triangle as usize][side] = beyond;
        }
    }
    neighbours
}
