//! The tab of views.

use bevy::prelude::*;
use bevy_sightline::prelude::*;

use crate::{
    common::{settle, spawn_cube},
    panel::Panel,
};

const EYE: Vec3 = Vec3::new(0.0, 0.0, 10.0);

#[test]
fn says_so_when_there_is_no_camera() {
    let mut panel = Panel::new(InspectorTab::Culling);
    panel.update();
    assert!(panel.says("no camera has a VisibleSet"));
}

#[test]
fn counts_what_is_seen_and_the_rest_by_reasons() {
    let mut panel = Panel::new(InspectorTab::Culling);
    panel.spawn_camera("eye", EYE);
    spawn_cube(&mut panel.app, Vec3::ZERO);
    spawn_cube(&mut panel.app, Vec3::X);
    spawn_cube(&mut panel.app, Vec3::Z * 100.0);
    let hidden = spawn_cube(&mut panel.app, Vec3::Y);
    panel.world().entity_mut(hidden).insert(Visibility::Hidden);
    settle(&mut panel.app);
    panel.look();
    assert_eq!(panel.beside("visible"), Some("2"));
    assert_eq!(panel.beside("outside of the view"), Some("1"));
    assert_eq!(panel.beside("hidden"), Some("1"));
}

#[test]
fn a_reason_that_was_told_stays_so_that_nothing_below_it_jumps() {
    let mut panel = Panel::new(InspectorTab::Culling);
    panel.spawn_camera("eye", EYE);
    let cube = spawn_cube(&mut panel.app, Vec3::ZERO);
    panel.world().entity_mut(cube).insert(Visibility::Hidden);
    settle(&mut panel.app);
    panel.look();
    assert_eq!(panel.beside("hidden"), Some("1"));

    panel.world().entity_mut(cube).insert(Visibility::Visible);
    settle(&mut panel.app);
    panel.look();
    assert_eq!(panel.beside("visible"), Some("1"));
    assert_eq!(panel.beside("hidden"), Some("0"));
}

#[test]
fn tells_why_the_selected_entity_is_not_seen_and_what_can_be_done() {
    let mut panel = Panel::new(InspectorTab::Culling);
    panel.spawn_camera("eye", EYE);
    let behind = spawn_cube(&mut panel.app, Vec3::Z * 100.0);
    settle(&mut panel.app);
    panel.world().resource_mut::<SightlineInspector>().selected = Some(behind);
    panel.look();
    assert!(panel.says("OutsideFrustum"));
    assert!(panel.says("Its Aabb is outside of the frustum"));
}

#[test]
fn another_view_can_be_chosen() {
    let mut panel = Panel::new(InspectorTab::Culling);
    panel.spawn_camera("first", EYE);
    let second = panel.spawn_camera("second", EYE);
    settle(&mut panel.app);
    panel.look();
    panel.click("first (");
    panel.click("second (");
    assert_eq!(panel.inspector().view, Some(second));
}

#[test]
fn a_view_that_is_gone_gives_way_to_another() {
    let mut panel = Panel::new(InspectorTab::Culling);
    panel.spawn_camera("stays", EYE);
    let gone = panel.spawn_camera("goes", EYE);
    settle(&mut panel.app);
    panel.world().resource_mut::<SightlineInspector>().view = Some(gone);
    panel.world().entity_mut(gone).despawn();
    panel.update();
    assert!(panel.says("stays ("));
}

#[test]
fn shows_the_occlusion_buffer_with_its_figures() {
    let mut panel = Panel::new(InspectorTab::Culling);
    let camera = panel.spawn_camera("eye", EYE);
    panel.world().entity_mut(camera).insert(SoftwareOcclusion::default());
    let wall = spawn_cube(&mut panel.app, Vec3::ZERO);
    panel
        .world()
        .entity_mut(wall)
        .insert((Transform::from_scale(Vec3::splat(4.0)), Occluder::Box));
    spawn_cube(&mut panel.app, Vec3::NEG_Z * 20.0);
    settle(&mut panel.app);
    panel.update();
    assert_eq!(panel.beside("occluders drawn"), Some("1"));
    assert_eq!(panel.beside("behind something"), Some("1"));
}
