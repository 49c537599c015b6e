//! Only what is in view is drawn.

use bevy::camera::visibility::RenderLayers;

use super::*;

fn draw_leaves(app: &mut App) -> Vec<[Vec3; 2]> {
    draw(app, |gizmos| gizmos.leaves = true);
    boxes(app)
}

#[test]
fn what_no_camera_sees_is_not_drawn() {
    let (mut app, cubes) = app_with_cubes([10.0, -10.0]);
    assert_eq!(draw_leaves(&mut app), world_boxes(&app, &cubes[..1]));
    assert_eq!(stats(&app).leaves, count(1, 0), "what is out of view is not left out");
}

#[test]
fn without_a_camera_nothing_is_drawn() {
    let mut app = app();
    spawn_cube(&mut app, Vec3::ZERO);
    draw(&mut app, |gizmos| {
        (gizmos.leaves, gizmos.nodes, gizmos.frusta) = (true, true, true);
    });
    assert!(is_blank(&app));
}

#[test]
fn what_is_beyond_the_far_plane_is_drawn_as_it_is_seen() {
    let (mut app, cubes) = app_with_cubes([5000.0]);
    assert_eq!(draw_leaves(&mut app), world_boxes(&app, &cubes));
}

#[test]
fn a_camera_that_is_not_active_sees_nothing() {
    let (mut app, _) = app_with_cubes([10.0]);
    let mut cameras = app.world_mut().query::<&mut Camera>();
    cameras.single_mut(app.world_mut()).expect("one").is_active = false;
    assert!(draw_leaves(&mut app).is_empty());
}

#[test]
fn a_camera_that_does_not_show_gizmos_does_not_count() {
    let (mut app, _) = app_with_cubes([10.0]);
    let camera = camera(&mut app);
    app.world_mut().entity_mut(camera).insert(RenderLayers::layer(1));
    assert!(draw_leaves(&mut app).is_empty());
}

#[test]
fn what_two_cameras_see_is_drawn_once() {
    let (mut app, cubes) = app_with_cubes([10.0, 20.0, -20.0]);
    app.world_mut().spawn((
        Camera3d::default(),
        Transform::from_xyz(0.0, 0.0, -50.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    app.update();
    assert_eq!(draw_leaves(&mut app), world_boxes(&app, &cubes));
    assert_eq!(stats(&app).leaves, count(3, 0));
}
