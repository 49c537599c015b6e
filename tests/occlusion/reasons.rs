//! Why something is seen, or not.

use bevy::{
    camera::visibility::{NoCpuCulling, RenderLayers, VisibilityRange},
    ecs::system::RunSystemOnce,
    prelude::*,
};
use bevy_sightline::culling::{VisibilityReason, VisibilityReasons};

use super::*;

fn reason(app: &mut App, entity: Entity, camera: Entity) -> Option<VisibilityReason> {
    app.update();
    let ask = move |reasons: VisibilityReasons| reasons.of(entity, camera);
    app.world_mut().run_system_once(ask).expect("a system that runs")
}

#[test]
fn every_reason_is_told() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    let wall = spawn_wall(&mut app);
    let cube = spawn_ahead(&mut app, 20.0);
    assert_eq!(reason(&mut app, wall, camera), Some(VisibilityReason::Visible));
    assert_eq!(reason(&mut app, cube, camera), Some(VisibilityReason::Occluded));
    insert(&mut app, cube, Transform::from_xyz(200.0, 0.0, -20.0));
    assert_eq!(reason(&mut app, cube, camera), Some(VisibilityReason::OutsideFrustum));
    insert(&mut app, cube, VisibilityRange::abrupt(1.0, 2.0));
    assert_eq!(reason(&mut app, cube, camera), Some(VisibilityReason::OutOfRange));
    insert(&mut app, cube, RenderLayers::layer(3));
    assert_eq!(reason(&mut app, cube, camera), Some(VisibilityReason::OnOtherLayers));
    insert(&mut app, cube, Visibility::Hidden);
    assert_eq!(reason(&mut app, cube, camera), Some(VisibilityReason::Hidden));
    insert(&mut app, cube, NoCpuCulling);
    assert_eq!(reason(&mut app, cube, camera), Some(VisibilityReason::LeftToGpu));
    let nothing = spawn(&mut app, Transform::IDENTITY);
    assert_eq!(reason(&mut app, nothing, camera), Some(VisibilityReason::NotVisual));
    app.world_mut().get_mut::<Camera>(camera).unwrap().is_active = false;
    assert_eq!(reason(&mut app, wall, camera), Some(VisibilityReason::InactiveCamera));
}

#[test]
fn what_does_not_exist_has_no_reason() {
    let mut app = headless_app();
    let (camera, wall) = (spawn_camera(&mut app), spawn_wall(&mut app));
    assert_eq!(reason(&mut app, wall, wall), None);
    app.world_mut().despawn(wall);
    assert_eq!(reason(&mut app, wall, camera), None);
}

#[test]
fn what_has_come_since_is_not_seen_yet() {
    let mut app = headless_app();
    let camera = spawn(&mut app, Camera3d::default());
    let cube = spawn_ahead(&mut app, 5.0);
    insert(&mut app, cube, Visibility::Hidden);
    app.update();
    insert(&mut app, cube, InheritedVisibility::VISIBLE);
    let ask = move |reasons: VisibilityReasons| reasons.of(cube, camera);
    let reason = app.world_mut().run_system_once(ask).expect("a system that runs");
    assert_eq!(reason, Some(VisibilityReason::NotYet));
}
