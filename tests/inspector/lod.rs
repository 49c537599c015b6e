//! The tab of levels of detail.

use bevy::prelude::*;
use bevy_sightline::prelude::*;

use crate::{
    common::{add_mesh, settle},
    panel::Panel,
};

/// A sphere of many triangles with a cube for a coarser level, of which the camera shows the cube.
fn far_group() -> (Panel, Entity) {
    let mut panel = Panel::new(InspectorTab::Lod);
    let fine = add_mesh(&mut panel.app, Sphere::new(0.5));
    let coarse = add_mesh(&mut panel.app, Cuboid::default());
    let lod = ProxyLod::new(LodMetric::Distance, fine.clone()).then(10.0, coarse);
    panel.world().spawn((lod, Mesh3d(fine), Transform::default()));
    let camera = panel.spawn_camera("eye", Vec3::Z * 50.0);
    settle(&mut panel.app);
    panel.update();
    panel.update();
    (panel, camera)
}

#[test]
fn counts_groups_by_level_and_what_that_saves() {
    let (panel, _) = far_group();
    assert_eq!(panel.beside("groups"), Some("1"));
    assert_eq!(panel.beside("groups at level 1"), Some("1"));
    assert_eq!(panel.beside("triangles in view"), Some("12"));
    let full = panel.beside("at full detail they would be").expect("it is told");
    assert!(
        full.replace(',', "").parse::<usize>().is_ok_and(|full| full > 500),
        "{full}"
    );
}

#[test]
fn levels_are_switched_off_by_a_click() {
    let (mut panel, _) = far_group();
    panel.click_beside("choose levels", -10.0);
    assert!(!panel.world().resource::<LodSettings>().enabled);
}

#[test]
fn to_look_changes_no_setting() {
    let (mut panel, camera) = far_group();
    let before = panel.world().resource_ref::<LodSettings>().last_changed();
    panel.update();
    panel.look();
    assert_eq!(panel.world().resource_ref::<LodSettings>().last_changed(), before);
    assert!(!panel.world().entity(camera).contains::<LodBias>());
}
