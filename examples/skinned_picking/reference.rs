//! Where the vertices of a model are now, in double precision, and what a ray meets there: worked out from the asset
//! and the components alone, triangle by triangle.

use bevy::{
    ecs::system::SystemParam,
    math::{DMat4, DVec3},
    mesh::{
        VertexAttributeValues,
        morph::{MeshMorphWeights, MorphWeights},
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    prelude::*,
};

/// The posed meshes of the world as of the last `PostUpdate`.
#[derive(SystemParam)]
pub struct Reference<'w, 's> {
    meshes: Res<'w, Assets<Mesh>>,
    inverse_bindposes: Res<'w, Assets<SkinnedMeshInverseBindposes>>,
    things: Query<
        'w,
        's,
        (
            &'static Mesh3d,
            &'static GlobalTransform,
            Option<&'static SkinnedMesh>,
            Option<&'static MeshMorphWeights>,
        ),
    >,
    places: Query<'w, 's, &'static GlobalTransform>,
    weights: Query<'w, 's, &'static MorphWeights>,
}

/// The corners of all triangles of a mesh, in world space.
pub type Triangles = Vec<[DVec3; 3]>;

impl Reference<'_, '_> {
    /// The triangles of an entity as posed now, if it has a mesh that is loaded.
    pub fn triangles(&self, entity: Entity) -> Option<Triangles> {
        let vertices = self.vertices(entity)?;
        let mesh = self.meshes.get(self.things.get(entity).ok()?.0)?;
        let numbers: Vec<usize> = match mesh.indices() {
            Some(indices) => indices.iter().collect(),
            None => (0..vertices.len()).collect(),
        };
        let corners = numbers
            .chunks_exact(3)
            .map(|three| [0, 1, 2].map(|i| vertices[three[i]]));
        Some(corners.collect())
    }

    fn vertices(&self, entity: Entity) -> Option<Vec<DVec3>> {
        let (mesh, place, skin, morph) = self.things.get(entity).ok()?;
        let mesh = self.meshes.get(mesh)?;
        let mut vertices: Vec<DVec3> = mesh
            .attribute(Mesh::ATTRIBUTE_POSITION)?
            .as_float3()?
            .iter()
            .map(|&position| Vec3::from(position).as_dvec3())
            .collect();

        let weights = match morph {
            Some(MeshMorphWeights::Value { weights }) => weights.as_slice(),
            Some(MeshMorphWeights::Reference(holder)) => {
                self.weights.get(*holder).map_or(&[][..], MorphWeights::weights)
            }
            None => &[],
        };
        let targets = mesh.get_morph_targets().unwrap_or_default();
        for (target, &weight) in targets.chunks_exact(vertices.len()).zip(weights) {
            for (vertex, moved) in vertices.iter_mut().zip(target) {
                *vertex += f64::from(weight) * moved.position.as_dvec3();
            }
        }

        let Some((joints, shares, skin)) = skin.and_then(|skin| Some((joints(mesh)?, shares(mesh)?, skin))) else {
            let place = matrix(place);
            return Some(
                vertices
                    .into_iter()
                    .map(|vertex| place.transform_point3(vertex))
                    .collect(),
            );
        };
        let inverse = self.inverse_bindposes.get(&skin.inverse_bindposes)?;
        let joint_matrices: Vec<DMat4> = skin
            .joints
            .iter()
            .zip(inverse.iter())
            .map(|(&joint, inverse)| self.places.get(joint).map(|place| matrix(place) * inverse.as_dmat4()))
            .collect::<Result<_, _>>()
            .ok()?;
        for ((vertex, joints), shares) in vertices.iter_mut().zip(joints).zip(shares) {
            let followed = joints.iter().zip(shares).filter(|(_, share)| **share != 0.0);
            *vertex = followed
                .map(|(&joint, &share)| f64::from(share) * joint_matrices[usize::from(joint)].transform_point3(*vertex))
                .sum();
        }
        Some(vertices)
    }
}

fn matrix(place: &GlobalTransform) -> DMat4 {
    place.to_matrix().as_dmat4()
}

fn joints(mesh: &Mesh) -> Option<&[[u16; 4]]> {
    match mesh.attribute(Mesh::ATTRIBUTE_JOINT_INDEX)? {
        VertexAttributeValues::Uint16x4(joints) => Some(joints),
        _ => None,
    }
}

fn shares(mesh: &Mesh) -> Option<&[[f32; 4]]> {
    match mesh.attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT)? {
        VertexAttributeValues::Float32x4(shares) => Some(shares),
        _ => None,
    }
}

/// How far along a ray its first hit on the front of a triangle is.
pub fn cast(ray: Ray3d, triangles: &[[DVec3; 3]]) -> Option<f64> {
    let (origin, way) = (ray.origin.as_dvec3(), ray.direction.as_vec3().as_dvec3());
    let along = |&[a, b, c]: &[DVec3; 3]| {
        // Möller and Trumbore (1997).
        let (ab, ac, from_a) = (b - a, c - a, origin - a);
        let across = way.cross(ac);
        let volume = ab.dot(across);
        let (v, w) = (from_a.dot(across), way.dot(from_a.cross(ab)));
        let inside = volume > 0.0 && v >= 0.0 && w >= 0.0 && v + w <= volume;
        inside.then(|| ac.dot(from_a.cross(ab)) / volume).filter(|t| *t >= 0.0)
    };
    triangles.iter().filter_map(along).min_by(f64::total_cmp)
}
