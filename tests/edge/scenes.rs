//! Scene files: what one app writes, another reads.

use std::path::Path;

use bevy::{
    asset::io::{
        AssetSourceBuilder, AssetSourceId,
        memory::{Dir, MemoryAssetReader},
    },
    camera::{CameraPlugin, primitives::Aabb},
    image::ImagePlugin,
    mesh::MeshPlugin,
    prelude::*,
    window::WindowPlugin,
    world_serialization::{DynamicWorldBuilder, DynamicWorldRoot, WorldSerializationPlugin},
};
use bevy_sightline::prelude::*;

use crate::common::*;

const FILE: &str = "level.scn.ron";

/// An app that finds a scene file.
fn app_with_file(contents: &str) -> App {
    let folder = Dir::default();
    folder.insert_asset_text(Path::new(FILE), contents);
    let reader = move || Box::new(MemoryAssetReader { root: folder.clone() }) as Box<_>;
    let mut app = App::new();
    app.register_asset_source(AssetSourceId::Default, AssetSourceBuilder::new(reader))
        .add_plugins((
            MinimalPlugins,
            AssetPlugin::default(),
            TransformPlugin,
            ImagePlugin::default(),
            MeshPlugin,
            WindowPlugin::default(),
            CameraPlugin,
            WorldSerializationPlugin,
            SightlinePlugins,
        ));
    app.finish();
    app.cleanup();
    app
}

/// Spawns a box of so many metres.
fn spawn_box(app: &mut App, half_size: Vec3, place: Vec3, bundle: impl Bundle) -> Entity {
    let aabb = Aabb::from_min_max(-half_size, half_size);
    let visible = (aabb, Transform::from_translation(place), Visibility::default());
    app.world_mut().spawn((visible, bundle)).id()
}

/// Everything of ours in the world, and what it stands on, as a scene file.
fn write(app: &App) -> String {
    let world = app.world();
    let registry = world.resource::<AppTypeRegistry>().read();
    let scene = DynamicWorldBuilder::from_world(world, &registry)
        .deny_all_components()
        .allow_component::<Aabb>()
        .allow_component::<BoundedBy>()
        .allow_component::<HitSurface>()
        .allow_component::<LodBias>()
        .allow_component::<Name>()
        .allow_component::<NoOcclusionCulling>()
        .allow_component::<NoSpatialIndex>()
        .allow_component::<Occluder>()
        .allow_component::<ProxyLod>()
        .allow_component::<ReportViewChanges>()
        .allow_component::<SoftwareOcclusion>()
        .allow_component::<Transform>()
        .allow_component::<Visibility>()
        .deny_all_resources()
        .allow_resource::<LodSettings>()
        .allow_resource::<SpatialIndexSettings>()
        .extract_entities(world.iter_entities().map(|entity| entity.id()))
        .extract_resources()
        .remove_empty_entities()
        .build();
    scene.serialize(&registry).expect("all of it can be written")
}

/// Loads the file, and looks at it with a camera at the origin, along -z.
fn read(file: &str) -> (App, Entity) {
    let mut app = app_with_file(file);
    let scene = app.world().resource::<AssetServer>().load(FILE);
    app.world_mut().spawn(DynamicWorldRoot(scene));
    let camera = app
        .world_mut()
        .spawn((Camera3d::default(), SoftwareOcclusion::default()))
        .id();
    let loaded = |app: &mut App| app.world_mut().query::<&Name>().iter(app.world()).count() > 0;
    for _ in 0..10_000 {
        app.update();
        if loaded(&mut app) {
            app.update();
            return (app, camera);
        }
        std::thread::yield_now();
    }
    panic!("the file was not loaded");
}

fn named(app: &mut App, name: &str) -> Entity {
    let mut names = app.world_mut().query::<(Entity, &Name)>();
    let found = names.iter(app.world()).find(|(_, other)| other.as_str() == name);
    found.expect("an entity of that name").0
}

fn sees(app: &App, camera: Entity, entity: Entity) -> bool {
    app.world()
        .get::<VisibleSet>(camera)
        .expect("a camera")
        .contains(entity)
}

#[test]
fn components_work_in_the_app_that_has_read_them() {
    let mut app = headless_app();
    let wall = (Name::new("wall"), Occluder::Box, BoundedBy::default());
    spawn_box(&mut app, Vec3::new(4.0, 3.0, 0.5), Vec3::NEG_Z * 10.0, wall);
    let cube = Vec3::splat(0.5);
    let hidden = (Name::new("hidden"), HitSurface::default());
    spawn_box(&mut app, cube, Vec3::NEG_Z * 20.0, hidden);
    spawn_box(
        &mut app,
        cube,
        Vec3::NEG_Z * 21.0,
        (Name::new("shown"), NoOcclusionCulling),
    );
    spawn_box(
        &mut app,
        cube,
        Vec3::NEG_Z * 5.0,
        (Name::new("not indexed"), NoSpatialIndex),
    );
    app.update();

    let (mut app, camera) = read(&write(&app));
    let [wall, hidden, shown, not_indexed] =
        ["wall", "hidden", "shown", "not indexed"].map(|name| named(&mut app, name));
    assert!(index(&app).contains(wall) && !index(&app).contains(not_indexed));
    assert!(app.world().resource::<Occluders>().get(wall).is_some());
    assert!(sees(&app, camera, wall) && !sees(&app, camera, hidden) && sees(&app, camera, shown));
}

#[test]
fn levels_are_the_entities_of_the_same_scene() {
    let mut app = headless_app();
    // So that entities have other numbers here and there.
    (0..7).for_each(|_| _ = app.world_mut().spawn_empty());
    let cube = Vec3::splat(0.5);
    let fine = spawn_box(&mut app, cube, Vec3::NEG_Z * 20.0, Name::new("fine"));
    let coarse = spawn_box(&mut app, cube, Vec3::NEG_Z * 20.0, Name::new("coarse"));
    let levels = ProxyLod::new(LodMetric::Distance, fine)
        .then(10.0, coarse)
        .with_bias(1.0);
    let place = Transform::from_xyz(0.0, 0.0, -20.0);
    app.world_mut()
        .spawn((Name::new("group"), place, Visibility::default(), levels));
    app.update();

    let (mut app, camera) = read(&write(&app));
    let [group, fine, coarse] = ["group", "fine", "coarse"].map(|name| named(&mut app, name));
    assert_eq!(app.world().resource::<LodChoices>().level(group, camera), Some(1));
    assert!(sees(&app, camera, coarse) && !sees(&app, camera, fine));
}

#[test]
fn settings_are_those_of_the_file() {
    let mut app = headless_app();
    app.world_mut().resource_mut::<SpatialIndexSettings>().grid = None;
    app.world_mut().resource_mut::<LodSettings>().hysteresis = 0.25;
    app.world_mut().spawn(Name::new("something"));
    app.update();

    let (app, _) = read(&write(&app));
    assert_eq!(app.world().resource::<SpatialIndexSettings>().grid, None);
    assert_eq!(app.world().resource::<LodSettings>().hysteresis, 0.25);
}
