//! What Bevy's diagnostics tell.

use bevy::diagnostic::{DiagnosticPath, DiagnosticsPlugin, DiagnosticsStore};
use bevy_sightline::occlusion::OcclusionDiagnosticsPlugin;

use super::*;

#[test]
fn the_figures_of_all_cameras_are_added_up() {
    let mut app = headless_app_with(|app| _ = app.add_plugins((DiagnosticsPlugin, OcclusionDiagnosticsPlugin)));
    spawn_camera(&mut app);
    spawn_camera(&mut app);
    spawn_wall(&mut app);
    spawn_ahead(&mut app, 20.0);
    app.update();
    app.update();
    let store = app.world().resource::<DiagnosticsStore>();
    let value = |path: &DiagnosticPath| store.get(path).and_then(bevy::diagnostic::Diagnostic::value);
    assert_eq!(value(&OcclusionDiagnosticsPlugin::OCCLUDERS), Some(2.0));
    assert_eq!(value(&OcclusionDiagnosticsPlugin::TRIANGLES), Some(24.0));
    assert_eq!(value(&OcclusionDiagnosticsPlugin::HIDDEN), Some(2.0));
    assert!(value(&OcclusionDiagnosticsPlugin::TESTED).is_some_and(|tested| tested >= 4.0));
}
