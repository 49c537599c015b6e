//! A real model: set `SIGHTLINE_MODELS` to a folder of glTF models, or keep it beside the repository.

use std::path::PathBuf;

use bevy::{
    asset::LoadState,
    camera::CameraPlugin,
    gltf::{Gltf, GltfMesh, GltfPlugin},
    image::ImagePlugin,
    mesh::MeshPlugin,
    prelude::*,
    window::WindowPlugin,
    world_serialization::WorldSerializationPlugin,
};

/// The meshes of a model; none if the model is not there.
pub fn meshes(name: &'static str) -> Option<Vec<Mesh>> {
    let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/models");
    let models = std::env::var_os("SIGHTLINE_MODELS").map_or_else(beside, PathBuf::from);
    if !models.join(name).exists() {
        eprintln!("skipped: there is no {name} in {}", models.display());
        return None;
    }
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        AssetPlugin {
            file_path: models.display().to_string(),
            ..default()
        },
        TransformPlugin,
        ImagePlugin::default(),
        MeshPlugin,
        WindowPlugin::default(),
        CameraPlugin,
        WorldSerializationPlugin,
        GltfPlugin::default(),
    ));
    app.finish();
    app.cleanup();
    let server = app.world().resource::<AssetServer>().clone();
    let gltf: Handle<Gltf> = server.load(name);
    while !server.load_state(&gltf).is_loaded() {
        if let LoadState::Failed(why) = server.load_state(&gltf) {
            panic!("{name}: {why}");
        }
        app.update();
    }
    let world = app.world();
    let gltf = world.resource::<Assets<Gltf>>().get(&gltf).expect("it is loaded");
    let of_gltf = world.resource::<Assets<GltfMesh>>();
    let meshes = world.resource::<Assets<Mesh>>();
    let primitives = gltf
        .meshes
        .iter()
        .flat_map(|mesh| &of_gltf.get(mesh).expect("it is loaded").primitives);
    Some(
        primitives
            .map(|primitive| meshes.get(&primitive.mesh).expect("it is loaded").clone())
            .collect(),
    )
}
