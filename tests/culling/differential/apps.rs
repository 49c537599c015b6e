//! The two apps that must agree, and how to switch ours.

use bevy::{
    asset::AssetPlugin,
    camera::{CameraPlugin, visibility::VisibilitySystems},
    gizmos::GizmoPlugin,
    image::ImagePlugin,
    light::LightPlugin,
    mesh::{MeshPlugin, mark_3d_meshes_as_changed_if_their_assets_changed, skinning::SkinnedMeshInverseBindposes},
    prelude::*,
    tasks::{ComputeTaskPool, TaskPool},
    window::WindowPlugin,
};
use bevy_sightline::prelude::*;

use super::{
    cast::{Meshes, Skin, run_scripts},
    snapshot,
    third_party::spot,
};
use crate::{
    common::rng,
    skinned_picking::rig::{soup, with_random_joints},
};

/// Entities with smaller indices may be anything in either app; from here on they are the same in both.
const FIRST_INDEX: u32 = 2_000;

/// Bevy's own systems, and nothing of ours.
pub fn bevys() -> App {
    app(|_| ())
}

/// Ours in their place.
pub fn ours() -> App {
    app(|app| _ = app.add_plugins(SightlinePlugins))
}

/// Ours, told to leave it to Bevy's own.
pub fn handed_back() -> App {
    let mut app = ours();
    set_enabled(&mut app, false);
    app
}

/// Whether ours culls, or Bevy's own.
pub fn set_enabled(app: &mut App, enabled: bool) {
    app.world_mut().resource_mut::<ViewCullingSettings>().enabled = enabled;
}

fn app(add_plugins: impl FnOnce(&mut App)) -> App {
    // Left to itself, Bevy takes one thread of two cores, and then runs its queries on none but its own.
    ComputeTaskPool::get_or_init(TaskPool::default);
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        AssetPlugin::default(),
        TransformPlugin,
        ImagePlugin::default(),
        MeshPlugin,
        WindowPlugin::default(),
        CameraPlugin,
        GizmoPlugin,
        LightPlugin,
        snapshot::plugin,
        run_scripts,
        spot,
    ));
    // Bevy leaves open which of the two comes first, and with that in which frame bounds follow an edited mesh.
    app.configure_sets(
        PostUpdate,
        VisibilitySystems::CalculateBounds.after(mark_3d_meshes_as_changed_if_their_assets_changed),
    );
    add_plugins(&mut app);
    app.finish();
    app.cleanup();
    add_meshes(app.world_mut());
    app.update();
    level_indices(app.world_mut());
    app
}

/// The same meshes in each app.
fn add_meshes(world: &mut World) {
    let mut rng = rng(1);
    let skinned = with_random_joints(soup(&mut rng, 12), &mut rng, Skin::JOINTS as u16);
    let skinned = (skinned.with_generated_skinned_mesh_bounds()).expect("it has joints, weights and positions");
    let shapes = [
        Cuboid::default().into(),
        Cuboid::new(0.2, 8.0, 0.2).into(),
        Sphere::new(2.0).mesh().ico(0).expect("few triangles"),
        Tetrahedron::default().into(),
        // Flat, and off its own centre.
        Plane3d::default().mesh().size(6.0, 6.0).build(),
        Mesh::from(Cuboid::default()).translated_by(Vec3::new(5.0, -2.0, 0.0)),
        skinned,
    ];
    let mut meshes = world.resource_mut::<Assets<Mesh>>();
    let handles = shapes.map(|shape: Mesh| meshes.add(shape));
    world.insert_resource(Meshes(handles.into()));
    let bind_poses = vec![Mat4::IDENTITY; Skin::JOINTS];
    let bind_poses = world
        .resource_mut::<Assets<SkinnedMeshInverseBindposes>>()
        .add(bind_poses);
    world.insert_resource(Skin(bind_poses));
}

/// Uses up the indices that the apps have not in common: resources, observers and systems are entities too.
fn level_indices(world: &mut World) {
    while world.spawn_empty().id().index_u32() < FIRST_INDEX {}
}
