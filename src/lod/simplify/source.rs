//! A mesh as it is given to the simplifier: its used vertices, each once, with what tells them apart.

use std::hash::BuildHasher;

use bevy::{
    math::{Vec3, Vec4},
    mesh::{Mesh, MeshVertexAttribute, VertexAttributeValues},
    platform::{
        collections::{HashMap, hash_map::Entry},
        hash::FixedHasher,
    },
};
use meshopt::SimplifyVertex;

use super::{SimplifyError, features::Features};
use crate::mesh::TriangleMesh;

/// The used vertices of a mesh, without duplicates, and its triangles.
#[derive(Debug)]
pub(super) struct Source {
    /// Three for each triangle.
    pub indices: Vec<u32>,
    pub positions: Vec<[f32; 3]>,
    /// The numbers of the vertices in the mesh.
    pub numbers: Vec<u32>,
    /// What besides the positions is to look the same.
    pub features: Features,
    /// Where texture coordinates are torn: the vertices there stay on the seam.
    pub seams: Vec<SimplifyVertex>,
    /// The longest side of the box, in units of the mesh.
    pub extent: f32,
}

impl Source {
    /// Takes the triangles of `mesh`, which are `triangles`, in the order of the mesh.
    pub fn new(mesh: &Mesh, triangles: &TriangleMesh) -> Result<Self, SimplifyError> {
        let vertices = triangles.vertex_count();
        for (attribute, values) in attributes(mesh) {
            if values.len() != vertices {
                return Err(SimplifyError::UnevenAttribute {
                    name: attribute.name,
                    values: values.len(),
                    vertices,
                });
            }
        }
        let aabb = triangles.aabb();
        let extent = (aabb.max - aabb.min).max_element();
        if !(extent * extent).is_finite() {
            return Err(SimplifyError::TooLarge);
        }

        let mut unique = Unique::of(mesh);
        let mut of_vertex = vec![u32::MAX; vertices];
        let mut numbers = Vec::new();
        let mut indices = Vec::with_capacity(3 * triangles.len());
        for vertex in triangles.vertices_of_all().flatten() {
            let known = &mut of_vertex[vertex as usize];
            if *known == u32::MAX {
                *known = unique.number(vertex, numbers.len() as u32);
                if *known as usize == numbers.len() {
                    numbers.push(vertex);
                }
            }
            indices.push(*known);
        }

        let all = mesh.attribute(Mesh::ATTRIBUTE_POSITION);
        let all = all.and_then(VertexAttributeValues::as_float3).unwrap_or_default();
        // One zero, not two: positions are compared by their bits.
        let position = |&vertex: &u32| all[vertex as usize].map(|coordinate| coordinate + 0.0);
        let positions: Vec<[f32; 3]> = numbers.iter().map(position).collect();
        Ok(Self {
            features: Features::of(mesh, &numbers, extent),
            seams: seams(mesh, &numbers, &positions),
            indices,
            positions,
            numbers,
            extent,
        })
    }
}

/// The vertex attributes of a mesh; none if it has been moved to the render world.
pub(super) fn attributes(mesh: &Mesh) -> impl Iterator<Item = (&MeshVertexAttribute, &VertexAttributeValues)> {
    mesh.try_attributes().into_iter().flatten()
}

/// Tells vertices apart by all that they have.
struct Unique<'a> {
    /// Empty where vertices keep their order: nothing is told of them then.
    attributes: Vec<(&'a [u8], usize)>,
    /// By hash, the vertex and its number among the unique ones; the next of the same hash after it.
    known: HashMap<u64, Vec<(u32, u32)>>,
    keeps_all: bool,
}

impl<'a> Unique<'a> {
    fn of(mesh: &'a Mesh) -> Self {
        let of_one = |(attribute, values): (&MeshVertexAttribute, &'a VertexAttributeValues)| {
            (values.get_bytes(), attribute.format.size() as usize)
        };
        Self {
            attributes: attributes(mesh).map(of_one).collect(),
            known: HashMap::default(),
            keeps_all: has_morph_targets(mesh),
        }
    }

    /// The number of the first vertex that is the same, or `next`.
    fn number(&mut self, vertex: u32, next: u32) -> u32 {
        if self.keeps_all {
            return next;
        }
        let Self { attributes, known, .. } = self;
        let bytes = |vertex: u32| {
            let of_one = move |&(bytes, size): &(&'a [u8], usize)| &bytes[vertex as usize * size..][..size];
            attributes.iter().map(of_one)
        };
        let hash = FixedHasher.hash_one(bytes(vertex).collect::<smallvec::SmallVec<[&[u8]; 8]>>());
        match known.entry(hash) {
            Entry::Occupied(mut entry) => {
                let same = entry.get().iter().find(|(other, _)| bytes(*other).eq(bytes(vertex)));
                if let Some(&(_, number)) = same {
                    return number;
                }
                entry.get_mut().push((vertex, next));
            }
            Entry::Vacant(entry) => {
                entry.insert(vec![(vertex, next)]);
            }
        }
        next
    }
}

/// Whether vertices must keep their numbers: displacements are looked up by them.
pub(super) fn has_morph_targets(mesh: &Mesh) -> bool {
    mesh.try_morph_targets().is_ok_and(|targets| !targets.is_empty())
}

/// The vertices at which texture coordinates are torn.
fn seams(mesh: &Mesh, numbers: &[u32], positions: &[[f32; 3]]) -> Vec<SimplifyVertex> {
    let mut seams = vec![SimplifyVertex::None; numbers.len()];
    for attribute in [Mesh::ATTRIBUTE_UV_0, Mesh::ATTRIBUTE_UV_1] {
        let Ok(VertexAttributeValues::Float32x2(uvs)) = mesh.try_attribute(attribute) else {
            continue;
        };
        let mut first = HashMap::<[u32; 3], [f32; 2]>::default();
        for (seam, (position, &number)) in seams.iter_mut().zip(positions.iter().zip(numbers)) {
            let uv = uvs[number as usize];
            if *first.entry(position.map(f32::to_bits)).or_insert(uv) != uv {
                *seam = SimplifyVertex::Protect;
            }
        }
    }
    seams
}

/// A vector of length one, or zero.
pub(super) fn unit(vector: [f32; 3]) -> Vec3 {
    Vec3::from(vector).try_normalize().unwrap_or_default()
}

/// The four numbers, those that are not finite as zero.
pub(super) fn finite(numbers: [f32; 4]) -> Vec4 {
    Vec4::from(numbers.map(|number| if number.is_finite() { number } else { 0.0 }))
}
