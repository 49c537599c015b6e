//! What plugins tell of their own work.

use bevy::{light::LightPlugin, prelude::*};
use bevy_sightline::prelude::*;

use crate::common::*;

fn app() -> App {
    headless_app_with(|app| _ = app.add_plugins((bevy::gizmos::GizmoPlugin, LightPlugin)))
}

fn culling(app: &mut App) -> ViewCullingStats {
    app.update();
    *app.world().resource()
}

/// A camera at the origin that looks along -z.
fn spawn_camera(app: &mut App) -> Entity {
    app.world_mut().spawn(Camera3d::default()).id()
}

#[test]
fn views_count_what_they_see_and_what_comes_and_goes() {
    let mut app = app();
    let camera = spawn_camera(&mut app);
    let cube = spawn_cube(&mut app, Vec3::NEG_Z * 10.0);
    let first = culling(&mut app);
    let set = app.world().get::<VisibleSet>(camera).expect("a camera");
    let (seen, entered) = (set.entities().len(), set.entered().len());
    assert!(set.contains(cube));
    assert_eq!(
        (first.views, first.visible, first.entered, first.left),
        (1, seen, entered, 0)
    );

    let second = culling(&mut app);
    assert_eq!((second.visible, second.entered, second.left), (seen, 0, 0));

    app.world_mut()
        .entity_mut(cube)
        .insert(Transform::from_xyz(0.0, 0.0, 10.0));
    let third = culling(&mut app);
    assert_eq!((third.visible, third.entered, third.left), (seen - 1, 0, 1));

    app.world_mut()
        .entity_mut(cube)
        .insert(Transform::from_xyz(0.0, 0.0, -10.0));
    let fourth = culling(&mut app);
    assert_eq!((fourth.visible, fourth.entered, fourth.left), (seen, 1, 0));

    app.world_mut().despawn(cube);
    let fifth = culling(&mut app);
    assert_eq!((fifth.visible, fifth.entered, fifth.left), (seen - 1, 0, 1));
}

#[test]
fn what_is_known_from_the_frame_before_is_not_tested_again() {
    let mut app = app();
    let camera = spawn_camera(&mut app);
    // Across a plane of the frustum, with its centre outside.
    spawn_cube(&mut app, Vec3::new(5.2, 0.0, -10.0));
    spawn_mesh(
        &mut app,
        Cuboid::new(20.0, 0.2, 0.2),
        Transform::from_xyz(12.0, 0.0, -10.0),
    );
    app.update();
    app.world_mut()
        .entity_mut(camera)
        .insert(Transform::from_xyz(0.0, 0.1, 0.0));
    assert!(culling(&mut app).tested >= 1);
    assert_eq!(culling(&mut app).tested, 0);
}

#[test]
fn a_frame_without_an_active_camera_counts_nothing() {
    let mut app = app();
    let camera = spawn_camera(&mut app);
    spawn_cube(&mut app, Vec3::NEG_Z * 10.0);
    app.update();
    app.world_mut().get_mut::<Camera>(camera).expect("a camera").is_active = false;
    let stats = culling(&mut app);
    assert_eq!((stats.views, stats.visible, stats.entered), (0, 0, 0));
}

#[test]
fn shadow_maps_count_what_casts_into_them() {
    let mut app = app();
    spawn_camera(&mut app);
    spawn_cube(&mut app, Vec3::NEG_Z * 10.0);
    let light = SpotLight {
        shadow_maps_enabled: true,
        ..default()
    };
    app.world_mut().spawn((light, Transform::from_xyz(0.0, 0.0, -5.0)));
    app.update();
    let stats = culling(&mut app);
    assert_eq!((stats.shadow_maps, stats.casters), (1, 1));
}

#[test]
fn while_culling_is_left_to_bevy_stats_stay() {
    let mut app = app();
    spawn_camera(&mut app);
    let stats = culling(&mut app);
    app.world_mut().resource_mut::<ViewCullingSettings>().enabled = false;
    assert_eq!(culling(&mut app), stats);
}
