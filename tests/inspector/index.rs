//! The tab of the index.

use bevy::prelude::*;
use bevy_sightline::prelude::*;

use crate::{
    common::{settle, spawn_cube},
    panel::Panel,
};

#[test]
fn tells_how_many_entities_there_are() {
    let mut panel = Panel::new(InspectorTab::Index);
    for number in 0..3 {
        spawn_cube(&mut panel.app, Vec3::X * number as f32 * 3.0);
    }
    settle(&mut panel.app);
    panel.look();
    assert_eq!(panel.beside("entities"), Some("3"));
    assert_eq!(panel.beside("refused"), Some("0"));
}

#[test]
fn tells_the_time_of_every_phase() {
    let mut panel = Panel::new(InspectorTab::Index);
    panel.update();
    panel.update();
    for phase in [
        "index/sync",
        "index/optimize",
        "culling/find",
        "lod/choose",
        "occlusion/follow",
        "picking/backend",
    ] {
        let time = panel.beside(phase).unwrap_or_else(|| panic!("nothing of {phase}"));
        assert!(time.ends_with("ms"), "{phase}: {time}");
    }
}

#[test]
fn lists_what_is_refused_with_the_reason_and_selects_it_by_a_click() {
    let mut panel = Panel::new(InspectorTab::Index);
    let lost = spawn_cube(&mut panel.app, Vec3::NAN);
    panel.world().entity_mut(lost).insert(Name::new("lost"));
    settle(&mut panel.app);
    panel.look();
    panel.click("Refused: 1");
    assert!(panel.says("its GlobalTransform has NaN or infinite values"));
    panel.click("lost (");
    assert_eq!(panel.inspector().selected, Some(lost));
    assert!(panel.says("not in the index: its GlobalTransform"));
}

#[test]
fn validates_the_index() {
    let mut panel = Panel::new(InspectorTab::Index);
    spawn_cube(&mut panel.app, Vec3::ZERO);
    settle(&mut panel.app);
    panel.look();
    panel.click("Validate");
    assert!(panel.says("the index is whole"));
}

#[test]
fn rebuilds_the_tree_without_another_answer() {
    let mut panel = Panel::new(InspectorTab::Index);
    for number in 0..100 {
        spawn_cube(&mut panel.app, Vec3::X * number as f32 * 3.0);
    }
    settle(&mut panel.app);
    panel.look();
    let hit = crate::common::hit_at(&mut panel.app, Vec3::X * 30.0);
    panel.click("Rebuild");
    assert_eq!(crate::common::hit_at(&mut panel.app, Vec3::X * 30.0), hit);
    assert_eq!(panel.world().resource::<SpatialIndex>().validate(), Ok(()));
}

#[test]
fn tells_of_what_is_selected() {
    let mut panel = Panel::new(InspectorTab::Index);
    let cube = spawn_cube(&mut panel.app, Vec3::ZERO);
    settle(&mut panel.app);
    panel.world().resource_mut::<SightlineInspector>().selected = Some(cube);
    panel.look();
    assert!(panel.says("box from [-0.50, -0.50, -0.50] to [0.50, 0.50, 0.50]"));
    assert!(panel.says("12 triangles"));
    panel.click("deselect");
    assert_eq!(panel.inspector().selected, None);
}
