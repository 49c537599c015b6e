//! What is needed.

use super::*;

#[test]
fn without_bevys_gizmos_nothing_happens() {
    let mut app = headless_app();
    spawn_camera_without_lights(&mut app);
    let cube = spawn_cube(&mut app, Vec3::NEG_Z * 10.0);
    app.world_mut().entity_mut(cube).insert(ShowGizmos::default());
    app.update();
    assert_eq!(stats(&app), SightlineGizmoStats::default());
}

fn spawn_camera_without_lights(app: &mut App) {
    app.world_mut().spawn((Camera::default(), Projection::default()));
}

#[test]
fn what_is_configured_before_the_app_runs_is_drawn() {
    let mut app = headless_app_with(|app| {
        app.add_plugins((GizmoPlugin, LightPlugin)).insert_gizmo_config(
            SightlineGizmos {
                leaves: true,
                ..default()
            },
            default(),
        );
    });
    spawn_camera(&mut app);
    spawn_cube(&mut app, Vec3::NEG_Z * 10.0);
    settle(&mut app);
    assert_eq!(stats(&app).leaves, count(1, 0));
}
