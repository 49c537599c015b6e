//! Levels whose meshes are loaded when they come near: others stand in for them, and there is never a hole.

use std::time::Duration;

use bevy::{
    asset::{
        AssetLoader, AssetPath, LoadContext,
        io::{
            AssetSourceBuilder, Reader,
            memory::{Dir, MemoryAssetReader},
        },
    },
    camera::{CameraPlugin, primitives::Aabb},
    mesh::MeshPlugin,
    prelude::*,
    reflect::TypePath,
    time::TimeUpdateStrategy,
};
use bevy_sightline::{
    lod::{LodStreamingSettings, LodStreamingStats},
    prelude::*,
};

/// Reads a cube from its size.
#[derive(Default, TypePath)]
struct CubeLoader;

impl AssetLoader for CubeLoader {
    type Asset = Mesh;
    type Settings = ();
    type Error = std::io::Error;

    async fn load(&self, reader: &mut dyn Reader, (): &(), _: &mut LoadContext<'_>) -> Result<Mesh, Self::Error> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        let size = String::from_utf8_lossy(&bytes).trim().parse::<f32>();
        let size = size.map_err(|why| std::io::Error::other(why.to_string()))?;
        Ok(Cuboid::from_length(size).into())
    }

    fn extensions(&self) -> &[&str] {
        &["cube"]
    }
}

/// A size by which a cube is known.
fn size(file: &str) -> f32 {
    match file {
        "fine.cube" => 1.0,
        "mid.cube" => 0.9,
        _ => 0.8,
    }
}

fn app() -> App {
    let files = Dir::default();
    for file in ["fine.cube", "mid.cube", "far.cube"] {
        files.insert_asset_text(std::path::Path::new(file), &size(file).to_string());
    }
    files.insert_asset_text(std::path::Path::new("broken.cube"), "no number");
    let mut app = App::new();
    app.register_asset_source(
        "memory",
        AssetSourceBuilder::new(move || Box::new(MemoryAssetReader { root: files.clone() })),
    );
    app.add_plugins((
        MinimalPlugins,
        AssetPlugin::default(),
        TransformPlugin,
        bevy::image::ImagePlugin::default(),
        MeshPlugin,
        bevy::window::WindowPlugin::default(),
        CameraPlugin,
        SightlinePlugins,
    ));
    app.init_asset_loader::<CubeLoader>();
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(100)));
    app.finish();
    app.cleanup();
    app
}

fn path(file: &str) -> LodContent {
    LodContent::Streamed(AssetPath::from(format!("memory://{file}")))
}

/// A rock at the origin with three levels, from 10 and from 20 metres on.
fn spawn_rock(app: &mut App, files: [&str; 3]) -> Entity {
    let [fine, mid, far] = files.map(path);
    let lod = ProxyLod::new(LodMetric::Distance, fine)
        .then(10.0, mid)
        .then(20.0, far)
        .measured_to(LodReference::Center)
        .with_bounds(Aabb::from_min_max(Vec3::splat(-0.5), Vec3::splat(0.5)));
    app.world_mut()
        .spawn((lod, Transform::default(), Visibility::default()))
        .id()
}

fn spawn_camera_at(app: &mut App, z: f32) -> Entity {
    let place = Transform::from_xyz(0.0, 0.0, z);
    app.world_mut().spawn((Camera3d::default(), place)).id()
}

fn move_to(app: &mut App, camera: Entity, z: f32) {
    app.world_mut()
        .get_mut::<Transform>(camera)
        .expect("a camera")
        .translation
        .z = z;
}

/// The size of the mesh that a rock has.
fn shown(app: &App, rock: Entity) -> Option<f32> {
    let mesh = app.world().get::<Mesh3d>(rock)?;
    let mesh = app.world().resource::<Assets<Mesh>>().get(mesh)?;
    Some(2.0 * bevy::camera::primitives::MeshAabb::compute_aabb(mesh)?.half_extents.x)
}

/// Runs frames until something holds.
fn run_until(app: &mut App, holds: impl Fn(&App) -> bool) {
    for _ in 0..10_000 {
        app.update();
        if holds(app) {
            return;
        }
        std::thread::yield_now();
    }
    panic!("it never holds: {:?}", stats(app));
}

fn stats(app: &App) -> LodStreamingStats {
    *app.world().resource::<LodStreamingStats>()
}

const FILES: [&str; 3] = ["fine.cube", "mid.cube", "far.cube"];

#[test]
fn a_level_that_comes_near_is_loaded_and_shown() {
    let mut app = app();
    let rock = spawn_rock(&mut app, FILES);
    let camera = spawn_camera_at(&mut app, 100.0);
    run_until(&mut app, |app| shown(app, rock) == Some(size("far.cube")));
    assert_eq!(stats(&app).loaded, 1, "nothing else is near");
    move_to(&mut app, camera, 5.0);
    run_until(&mut app, |app| shown(app, rock) == Some(size("fine.cube")));
}

#[test]
fn a_loaded_level_stands_in_while_another_is_loaded() {
    let mut app = app();
    let rock = spawn_rock(&mut app, FILES);
    let camera = spawn_camera_at(&mut app, 100.0);
    run_until(&mut app, |app| shown(app, rock).is_some());
    move_to(&mut app, camera, 5.0);
    for _ in 0..1000 {
        app.update();
        assert!(shown(&app, rock).is_some(), "a hole");
    }
}

#[test]
fn a_level_is_loaded_before_it_is_shown() {
    let mut app = app();
    let rock = spawn_rock(&mut app, FILES);
    spawn_camera_at(&mut app, 24.0);
    run_until(&mut app, |app| {
        stats(app).loaded == 2 && shown(app, rock) == Some(size("far.cube"))
    });
}

#[test]
fn what_has_been_far_for_long_is_dropped() {
    let mut app = app();
    let rock = spawn_rock(&mut app, FILES);
    let camera = spawn_camera_at(&mut app, 5.0);
    run_until(&mut app, |app| shown(app, rock) == Some(size("fine.cube")));
    move_to(&mut app, camera, 100.0);
    run_until(&mut app, |app| {
        shown(app, rock) == Some(size("far.cube")) && stats(app).loaded == 1
    });
    // Nothing holds the others.
    run_until(&mut app, |app| app.world().resource::<Assets<Mesh>>().len() == 1);
}

#[test]
fn what_cannot_be_loaded_is_replaced_by_another_level() {
    for missing in ["broken.cube", "nowhere.cube"] {
        let mut app = app();
        let rock = spawn_rock(&mut app, [missing, "mid.cube", "far.cube"]);
        let camera = spawn_camera_at(&mut app, 100.0);
        run_until(&mut app, |app| shown(app, rock).is_some());
        move_to(&mut app, camera, 9.0);
        run_until(&mut app, |app| {
            stats(app).failed == 1 && shown(app, rock) == Some(size("mid.cube"))
        });
        assert_eq!(stats(&app).loading, 0);
    }
}

#[test]
fn within_a_budget_what_is_shown_stays_and_nothing_else_is_loaded() {
    let mut app = app();
    let rock = spawn_rock(&mut app, FILES);
    spawn_camera_at(&mut app, 24.0);
    app.world_mut().resource_mut::<LodStreamingSettings>().memory_budget = 1;
    run_until(&mut app, |app| shown(app, rock).is_some());
    for _ in 0..1000 {
        app.update();
        assert_eq!(shown(&app, rock), Some(size("far.cube")));
    }
    assert_eq!(stats(&app).loaded, 1);
}

#[test]
fn one_file_is_loaded_once_for_all_that_use_it() {
    let mut app = app();
    let rocks = [(); 10].map(|()| spawn_rock(&mut app, FILES));
    spawn_camera_at(&mut app, 100.0);
    run_until(&mut app, |app| rocks.iter().all(|&rock| shown(app, rock).is_some()));
    assert_eq!(stats(&app).loaded, 1);
}

#[test]
fn meshes_are_dropped_with_the_last_group_that_uses_them() {
    let mut app = app();
    let rock = spawn_rock(&mut app, FILES);
    spawn_camera_at(&mut app, 100.0);
    run_until(&mut app, |app| shown(app, rock).is_some());
    app.world_mut().despawn(rock);
    run_until(&mut app, |app| stats(app) == LodStreamingStats::default());
}

/// A group of two entities, of which the finer has a mesh from a file.
fn spawn_pair(app: &mut App, file: &str) -> [Entity; 2] {
    let server = app.world().resource::<AssetServer>().clone();
    let there = app.world_mut().resource_mut::<Assets<Mesh>>().add(Cuboid::default());
    let levels = [server.load(format!("memory://{file}")), there].map(|mesh| {
        let place = Transform::default();
        app.world_mut().spawn((Mesh3d(mesh), place)).id()
    });
    let lod = ProxyLod::new(LodMetric::Distance, levels[0]).then(10.0, levels[1]);
    let mut root = app
        .world_mut()
        .spawn((lod, Transform::default(), Visibility::default()));
    root.add_children(&levels);
    levels
}

#[test]
fn a_level_of_entities_is_shown_once_all_of_its_meshes_are_loaded() {
    let mut app = app();
    let [fine, coarse] = spawn_pair(&mut app, "fine.cube");
    let camera = spawn_camera_at(&mut app, 5.0);
    run_until(&mut app, |app| {
        let lods = app.world().resource::<LodChoices>();
        assert_ne!(lods.shows(camera, fine), lods.shows(camera, coarse));
        lods.shows(camera, fine)
    });
    let mesh = app.world().get::<Mesh3d>(fine).expect("a mesh");
    assert!(app.world().resource::<Assets<Mesh>>().contains(mesh));
}

#[test]
fn another_level_stands_in_for_entities_whose_meshes_never_load() {
    let mut app = app();
    let [fine, coarse] = spawn_pair(&mut app, "nowhere.cube");
    let camera = spawn_camera_at(&mut app, 5.0);
    for _ in 0..100 {
        app.update();
        let lods = app.world().resource::<LodChoices>();
        assert!(lods.shows(camera, coarse) && !lods.shows(camera, fine));
    }
}

#[test]
fn an_entity_that_is_given_a_mesh_that_is_there_is_shown_again() {
    let mut app = app();
    let [fine, coarse] = spawn_pair(&mut app, "nowhere.cube");
    let camera = spawn_camera_at(&mut app, 5.0);
    for _ in 0..5 {
        app.update();
    }
    let loaded = app.world().get::<Mesh3d>(coarse).expect("a mesh").clone();
    app.world_mut().entity_mut(fine).insert(loaded);
    for _ in 0..3 {
        app.update();
    }
    let lods = app.world().resource::<LodChoices>();
    assert!(lods.shows(camera, fine) && !lods.shows(camera, coarse));
}
