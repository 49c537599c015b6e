//! Settings and components, edited through reflection.

use bevy::prelude::*;
use bevy_sightline::prelude::*;

use crate::{
    common::{settle, spawn_cube},
    panel::Panel,
};

/// A panel with the settings of a tab open.
fn settings_of(tab: InspectorTab) -> Panel {
    let mut panel = Panel::new(tab);
    panel.update();
    panel.click("Settings");
    panel
}

#[test]
fn every_setting_of_every_plugin_is_in_one_of_the_tabs() {
    let all = [
        (InspectorTab::Index, vec!["SpatialIndexSettings"]),
        (InspectorTab::Query, vec!["SpatialPickingSettings"]),
        (InspectorTab::Culling, vec!["ViewCullingSettings", "OccluderSettings"]),
        (InspectorTab::Lod, vec!["LodSettings", "LodStreamingSettings"]),
    ];
    for (tab, settings) in all {
        let panel = settings_of(tab);
        for name in settings {
            assert!(panel.says(name), "{tab:?} has no {name}");
        }
    }
}

#[test]
fn a_switch_is_flipped_by_a_click() {
    let mut panel = settings_of(InspectorTab::Culling);
    panel.click("ViewCullingSettings");
    assert!(panel.world().resource::<ViewCullingSettings>().enabled);
    panel.click_beside("enabled", 140.0);
    assert!(!panel.world().resource::<ViewCullingSettings>().enabled);
}

#[test]
fn an_option_is_set_to_its_default() {
    let mut panel = settings_of(InspectorTab::Index);
    panel.click("SpatialIndexSettings");
    panel.click("grid");
    panel.click("Some");
    panel.click("None");
    assert_eq!(panel.world().resource::<SpatialIndexSettings>().grid, None);
}

#[test]
fn to_look_at_settings_changes_none() {
    let mut panel = settings_of(InspectorTab::Culling);
    panel.click("ViewCullingSettings");
    panel.update();
    let before = panel.world().resource_ref::<ViewCullingSettings>().last_changed();
    panel.update();
    panel.look();
    assert_eq!(
        panel.world().resource_ref::<ViewCullingSettings>().last_changed(),
        before
    );
}

#[test]
fn components_of_the_selected_entity_are_edited() {
    let mut panel = Panel::new(InspectorTab::Index);
    let cube = spawn_cube(&mut panel.app, Vec3::ZERO);
    panel.world().entity_mut(cube).insert(Occluder::Box);
    settle(&mut panel.app);
    panel.world().resource_mut::<SightlineInspector>().selected = Some(cube);
    panel.update();
    panel.click("Occluder");
    panel.click("Box");
    panel.click("Mesh");
    assert_eq!(panel.world().get::<Occluder>(cube), Some(&Occluder::Mesh));
}

#[test]
fn the_components_of_other_crates_are_left_out() {
    let mut panel = Panel::new(InspectorTab::Index);
    let cube = spawn_cube(&mut panel.app, Vec3::ZERO);
    settle(&mut panel.app);
    panel.world().resource_mut::<SightlineInspector>().selected = Some(cube);
    panel.update();
    assert!(!panel.says("GlobalTransform"));
}

#[test]
fn what_an_option_holds_is_edited_right_beside_it() {
    let mut panel = Panel::new(InspectorTab::Index);
    let cube = spawn_cube(&mut panel.app, Vec3::ZERO);
    let shown = ShowGizmos {
        volume: Some(BoundingKind::Aabb),
        ..default()
    };
    panel.world().entity_mut(cube).insert(shown);
    settle(&mut panel.app);
    panel.world().resource_mut::<SightlineInspector>().selected = Some(cube);
    panel.update();
    panel.click("ShowGizmos");
    assert_eq!(panel.beside("volume"), Some("Some"));
    assert_eq!(panel.beside("Some"), Some("Aabb"));
    panel.click("Aabb");
    panel.click("Sphere");
    let shown = panel.world().get::<ShowGizmos>(cube).and_then(|shown| shown.volume);
    assert_eq!(shown, Some(BoundingKind::Sphere));
}
