//! What the tests share: seeded randomness, and the headless app.

use bevy::{
    camera::CameraPlugin, input::InputPlugin, mesh::MeshPlugin, picking::DefaultPickingPlugins, prelude::*,
    window::WindowPlugin,
};
use bevy_sightline::index::MeshBvhs;
use bevy_sightline::prelude::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A generator that gives the same numbers everywhere.
pub fn rng(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// A point in the cube `-size..size`.
pub fn random_point(rng: &mut ChaCha8Rng, size: f32) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| rng.random_range(-size..size)))
}

/// A unit vector, uniform over the sphere.
pub fn random_dir(rng: &mut ChaCha8Rng) -> Dir3 {
    loop {
        let point = random_point(rng, 1.0);
        if (0.01..1.0).contains(&point.length_squared()) {
            return Dir3::new(point).expect("not zero");
        }
    }
}

/// A rotation, uniform.
pub fn random_rotation(rng: &mut ChaCha8Rng) -> Quat {
    Quat::from_rotation_arc(Vec3::Z, *random_dir(rng))
        * Quat::from_rotation_z(rng.random_range(0.0..std::f32::consts::TAU))
}

/// An app with what a server would have: no window, no renderer, no GPU.
pub fn headless_app() -> App {
    headless_app_with(|_| {})
}

/// The same, with more plugins.
pub fn headless_app_with(add_plugins: impl FnOnce(&mut App)) -> App {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        AssetPlugin::default(),
        TransformPlugin,
        bevy::image::ImagePlugin::default(),
        MeshPlugin,
        WindowPlugin::default(),
        CameraPlugin,
        InputPlugin,
        DefaultPickingPlugins,
        SightlinePlugins,
    ));
    add_plugins(&mut app);
    app.finish();
    app.cleanup();
    app
}

/// Runs frames until all mesh hierarchies are built.
pub fn finish_meshes(app: &mut App) {
    while app.world().resource::<MeshBvhs>().building() > 0 {
        app.update();
    }
}

/// Adds a mesh asset.
pub fn add_mesh(app: &mut App, mesh: impl Into<Mesh>) -> Handle<Mesh> {
    app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh)
}

/// Spawns an entity with a mesh of its own.
pub fn spawn_mesh(app: &mut App, mesh: impl Into<Mesh>, transform: Transform) -> Entity {
    let mesh = add_mesh(app, mesh);
    app.world_mut().spawn((Mesh3d(mesh), transform)).id()
}

/// Spawns a unit cube at `position`, visible as far as no camera is asked.
pub fn spawn_cube(app: &mut App, position: Vec3) -> Entity {
    spawn_mesh(app, Cuboid::default(), Transform::from_translation(position))
}

/// Brings the index up to date with what was spawned, and builds all mesh hierarchies.
pub fn settle(app: &mut App) {
    app.update();
    finish_meshes(app);
}

/// The index of an app.
pub fn index(app: &App) -> &SpatialIndex {
    app.world().resource()
}

/// A ray from `origin` towards `target`.
pub fn ray_towards(origin: Vec3, target: Vec3) -> Ray3d {
    Ray3d::new(origin, Dir3::new(target - origin).expect("two different points"))
}

/// Runs `ask` with a [`SceneQuery`].
pub fn query<R: 'static>(app: &mut App, ask: impl FnOnce(SceneQuery) -> R) -> R {
    let mut state = bevy::ecs::system::SystemState::<SceneQuery>::new(app.world_mut());
    ask(state.get(app.world()).expect("the plugin is there"))
}

/// What a ray hits with the default settings.
pub fn cast(app: &mut App, ray: Ray3d) -> Option<RayHit> {
    query(app, |scene| scene.cast_ray(ray, &SceneQuerySettings::default()))
}

/// What a ray along -z from far in front of `position` hits, with the default settings.
pub fn hit_at(app: &mut App, position: Vec3) -> Option<RayHit> {
    cast(app, Ray3d::new(position + Vec3::Z * 100.0, Dir3::NEG_Z))
}
