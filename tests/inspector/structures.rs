//! The tab of structures.

use bevy::prelude::*;
use bevy_sightline::prelude::*;

use crate::{
    common::{settle, spawn_cube},
    panel::Panel,
};

/// Asks for the comparison and waits for it.
fn compare(panel: &mut Panel) {
    panel.look();
    panel.click("Build and measure");
    while panel.says("structures are being built") {
        panel.look();
    }
}

#[test]
fn compares_all_structures_over_the_same_entities() {
    let mut panel = Panel::new(InspectorTab::Structures);
    for number in 0..50 {
        spawn_cube(&mut panel.app, Vec3::X * number as f32 * 2.0);
    }
    settle(&mut panel.app);
    compare(&mut panel);
    assert!(panel.says("50 boxes"));
    for name in [
        "brute force",
        "tree, PLOC",
        "tree, binned SAH",
        "uniform grid",
        "k-d tree, SAH",
        "octree",
    ] {
        assert!(panel.beside(name).is_some_and(|build| build.ends_with("ms")), "{name}");
    }
    assert!(!panel.says("wrong"));
}

#[test]
fn compares_structures_of_nothing() {
    let mut panel = Panel::new(InspectorTab::Structures);
    panel.update();
    compare(&mut panel);
    assert!(panel.says("0 boxes"));
}

#[test]
fn says_so_when_nothing_can_be_drawn() {
    let mut panel = Panel::new(InspectorTab::Structures);
    panel.update();
    assert!(panel.says("nothing can be drawn: the app has no GizmoPlugin"));
}
