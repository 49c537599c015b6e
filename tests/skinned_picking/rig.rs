//! Skinned meshes for the tests.

use bevy::{
    asset::RenderAssetUsages,
    mesh::{
        PrimitiveTopology, VertexAttributeValues,
        morph::MorphAttributes,
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    prelude::*,
};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use crate::common::{add_mesh, random_point, random_rotation};

/// A skinned entity.
pub struct Rig {
    pub entity: Entity,
    pub joints: Vec<Entity>,
}

/// A soup of triangles with normals.
pub fn soup(rng: &mut ChaCha8Rng, triangles: usize) -> Mesh {
    let positions: Vec<[f32; 3]> = (0..triangles)
        .flat_map(|_| {
            let middle = random_point(rng, 1.0);
            [0; 3].map(|_| (middle + random_point(rng, 0.3)).to_array())
        })
        .collect();
    let normals = vec![[0.0, 1.0, 0.0]; positions.len()];
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
}

/// A horizontal unit square that faces up.
pub fn square() -> Mesh {
    Plane3d::new(Vec3::Y, Vec2::splat(0.5)).mesh().build()
}

/// The mesh with joint indices and weights, given for each vertex.
pub fn with_joints(mesh: Mesh, mut influences: impl FnMut(usize) -> ([u16; 4], [f32; 4])) -> Mesh {
    let (joints, weights): (Vec<_>, Vec<_>) = (0..mesh.count_vertices()).map(&mut influences).unzip();
    mesh.with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, VertexAttributeValues::Uint16x4(joints))
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights)
}

/// The mesh with everything on its only joint.
pub fn with_one_joint(mesh: Mesh) -> Mesh {
    with_joints(mesh, |_| ([0; 4], [1.0, 0.0, 0.0, 0.0]))
}

/// The mesh with random joints, and weights whose sum is one.
pub fn with_random_joints(mesh: Mesh, rng: &mut ChaCha8Rng, joints: u16) -> Mesh {
    with_joints(mesh, |_| {
        let weights = [0; 4].map(|_| rng.random_range(0.0f32..1.0));
        let sum: f32 = weights.iter().sum();
        (
            [0; 4].map(|_| rng.random_range(0..joints)),
            weights.map(|weight| weight / sum),
        )
    })
}

/// The mesh with morph targets that displace every vertex by up to one.
pub fn with_random_targets(mesh: Mesh, rng: &mut ChaCha8Rng, targets: usize) -> Mesh {
    let count = targets * mesh.count_vertices();
    let displacements = (0..count).map(|_| MorphAttributes::new(random_point(rng, 1.0), Vec3::ZERO, Vec3::ZERO));
    mesh.with_morph_targets(displacements.collect())
}

/// Random places, some of them scaled unevenly and mirrored.
pub fn random_places(rng: &mut ChaCha8Rng, count: usize) -> Vec<Transform> {
    let place = |rng: &mut ChaCha8Rng| Transform {
        translation: random_point(rng, 2.0),
        rotation: random_rotation(rng),
        scale: Vec3::from_array([0; 3].map(|_| rng.random_range(0.5..1.5)))
            * if rng.random_bool(0.2) { -1.0 } else { 1.0 },
    };
    (0..count).map(|_| place(rng)).collect()
}

/// Spawns a skinned mesh whose joints are at `places`, bound at the origin.
pub fn spawn_rig(app: &mut App, mesh: Mesh, places: &[Transform]) -> Rig {
    let bind_poses = vec![Mat4::IDENTITY; places.len()];
    spawn_bound_rig(app, mesh, places, bind_poses)
}

/// The same with inverse bind poses.
pub fn spawn_bound_rig(app: &mut App, mesh: Mesh, places: &[Transform], bind_poses: Vec<Mat4>) -> Rig {
    let mesh = add_mesh(app, mesh);
    let world = app.world_mut();
    let inverse_bindposes = world
        .resource_mut::<Assets<SkinnedMeshInverseBindposes>>()
        .add(bind_poses);
    let joints: Vec<Entity> = places.iter().map(|&place| world.spawn(place).id()).collect();
    let skin = SkinnedMesh {
        inverse_bindposes,
        joints: joints.clone(),
    };
    let entity = world
        .spawn((Mesh3d(mesh), skin, Transform::from_xyz(30.0, 0.0, 0.0)))
        .id();
    Rig { entity, joints }
}

/// Moves a joint.
pub fn move_joint(app: &mut App, joint: Entity, place: Transform) {
    *app.world_mut().get_mut::<Transform>(joint).expect("a joint") = place;
}
