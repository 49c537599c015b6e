//! What Bevy's diagnostics are told.

use std::collections::BTreeSet;

use bevy::{
    diagnostic::{Diagnostic, DiagnosticPath, DiagnosticsPlugin, DiagnosticsStore},
    gizmos::GizmoPlugin,
    light::LightPlugin,
    prelude::*,
};
use bevy_sightline::{index::SyncStats, prelude::*};

use crate::common::*;

/// The documentation, with its table of all paths.
const DOCS: &str = include_str!("../../src/debug/diagnostics/mod.rs");

fn app() -> App {
    headless_app_with(|app| {
        #[cfg(feature = "sprite")]
        app.add_plugins((
            bevy::image::TextureAtlasPlugin,
            bevy::text::TextPlugin,
            bevy::sprite::SpritePlugin,
        ));
        app.add_plugins((GizmoPlugin, LightPlugin, SightlineDiagnosticsPlugin));
    })
}

fn ours(app: &App) -> impl Iterator<Item = &Diagnostic> {
    let store = app.world().resource::<DiagnosticsStore>();
    store
        .iter()
        .filter(|diagnostic| diagnostic.path().as_str().starts_with("sightline/"))
}

fn value(app: &App, path: &str) -> Option<f64> {
    let store = app.world().resource::<DiagnosticsStore>();
    store.get(&DiagnosticPath::new(path.to_owned()))?.value()
}

/// A wall that hides one of two cubes from the only camera, and a group with levels of detail.
fn spawn_scene(app: &mut App) {
    let place = Transform::from_xyz(0.0, 0.0, -10.0);
    let wall = spawn_mesh(app, Cuboid::new(8.0, 6.0, 1.0), place);
    app.world_mut().entity_mut(wall).insert(Occluder::Box);
    spawn_cube(app, Vec3::new(0.0, 0.0, -20.0));
    let near = spawn_cube(app, Vec3::new(0.0, 0.0, -5.0));
    let levels = ProxyLod::new(LodMetric::Distance, near).then_nothing(100.0);
    app.world_mut().spawn((Transform::default(), levels));
    app.world_mut()
        .spawn((Camera3d::default(), SoftwareOcclusion::default()));
}

#[test]
fn every_path_is_measured_in_every_frame() {
    let mut app = app();
    spawn_scene(&mut app);
    let frames = 3;
    for _ in 0..frames {
        app.update();
    }
    assert!(ours(&app).count() > 40);
    for diagnostic in ours(&app) {
        assert_eq!(diagnostic.history_len(), frames, "{}", diagnostic.path());
        assert!(
            diagnostic.values().all(|value| value.is_finite()),
            "{}",
            diagnostic.path()
        );
    }
}

#[test]
fn the_documentation_lists_every_path_with_its_unit() {
    let documented: BTreeSet<(String, String)> = DOCS
        .lines()
        .filter_map(|line| line.strip_prefix("//! | `")?.split_once("` | "))
        .map(|(path, rest)| {
            (
                path.to_owned(),
                rest.split('|').next().unwrap_or_default().trim().to_owned(),
            )
        })
        .collect();
    let app = app();
    let measured: BTreeSet<(String, String)> = ours(&app)
        .map(|diagnostic| (diagnostic.path().to_string(), diagnostic.suffix.to_string()))
        .collect();
    assert!(measured.is_subset(&documented));
    // Of features that are off there is nothing to measure.
    #[cfg(all(feature = "gizmos", feature = "simplify", feature = "sprite"))]
    assert_eq!(measured, documented);
}

#[test]
fn counts_are_those_of_the_scene() {
    let mut app = app();
    spawn_scene(&mut app);
    app.update();
    app.update();
    let expected = [
        ("index/entities", 3.0),
        ("index/reconciled", 0.0),
        ("meshes/known", 3.0),
        ("lod/groups", 1.0),
        ("occlusion/occluders", 1.0),
        ("occlusion/drawn", 1.0),
        ("occlusion/triangles", 12.0),
        ("occlusion/hidden", 1.0),
        ("culling/views", 1.0),
        ("culling/entered", 0.0),
        ("culling/left", 0.0),
    ];
    for (path, expected) in expected {
        assert_eq!(value(&app, &format!("sightline/{path}")), Some(expected), "{path}");
    }
    assert!(value(&app, "sightline/occlusion/tested").is_some_and(|tested| tested >= 2.0));
}

#[test]
fn counts_of_several_cameras_are_added_up() {
    let mut app = app();
    spawn_scene(&mut app);
    app.world_mut()
        .spawn((Camera3d::default(), SoftwareOcclusion::default()));
    app.update();
    app.update();
    assert_eq!(value(&app, "sightline/culling/views"), Some(2.0));
    assert_eq!(value(&app, "sightline/occlusion/drawn"), Some(2.0));
    assert_eq!(value(&app, "sightline/occlusion/triangles"), Some(24.0));
    assert_eq!(value(&app, "sightline/occlusion/hidden"), Some(2.0));
}

#[test]
fn times_are_milliseconds_of_the_frame_that_has_ended() {
    let mut app = app();
    spawn_scene(&mut app);
    app.update();
    let total = app.world().resource::<SyncStats>().total;
    assert_eq!(value(&app, "sightline/index/sync"), Some(1000.0 * total.as_secs_f64()));
}

#[test]
fn one_that_is_disabled_is_not_measured() {
    let mut app = app();
    let path = DiagnosticPath::const_new("sightline/index/sync");
    let mut store = app.world_mut().resource_mut::<DiagnosticsStore>();
    store.get_mut(&path).expect("a diagnostic of ours").is_enabled = false;
    app.update();
    assert_eq!(value(&app, path.as_str()), None);
}

#[test]
fn nothing_is_registered_without_the_plugin() {
    let mut app = headless_app_with(|app| _ = app.add_plugins(DiagnosticsPlugin));
    app.update();
    assert_eq!(ours(&app).count(), 0);
}

#[test]
fn bevys_plugin_may_come_later_and_keeps_them() {
    let mut app = headless_app_with(|app| _ = app.add_plugins((SightlineDiagnosticsPlugin, DiagnosticsPlugin)));
    app.update();
    assert!(value(&app, "sightline/index/sync").is_some());
}

#[test]
fn of_plugins_that_are_not_there_nothing_is_measured() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, SpatialIndexPlugin, SightlineDiagnosticsPlugin));
    app.update();
    assert!(value(&app, "sightline/index/sync").is_some());
    assert_eq!(value(&app, "sightline/culling/find"), None);
}
