//! The tab of the ray under the mouse.

use bevy::{
    picking::{
        PickingSystems,
        backend::ray::{RayId, RayMap},
        pointer::PointerId,
    },
    prelude::*,
};
use bevy_sightline::prelude::*;

use crate::{
    common::{settle, spawn_cube},
    panel::Panel,
};

/// Two cubes behind one another, and the mouse on both.
fn over_two_cubes() -> (Panel, [Entity; 2]) {
    let mut panel = Panel::new(InspectorTab::Query);
    let cubes = ["near", "far"].map(|name| {
        let at = if name == "near" { Vec3::ZERO } else { Vec3::NEG_Z * 4.0 };
        let cube = spawn_cube(&mut panel.app, at);
        panel.world().entity_mut(cube).insert(Name::new(name));
        cube
    });
    settle(&mut panel.app);
    aim(&mut panel, Ray3d::new(Vec3::Z * 5.0, Dir3::NEG_Z));
    (panel, cubes)
}

#[derive(Resource)]
struct Aimed(Ray3d);

fn aim_mouse(aimed: Res<Aimed>, mut rays: ResMut<RayMap>) {
    rays.map
        .insert(RayId::new(Entity::PLACEHOLDER, PointerId::Mouse), aimed.0);
}

/// Puts the mouse where this is its ray.
fn aim(panel: &mut Panel, ray: Ray3d) {
    panel.world().insert_resource(Aimed(ray));
    panel
        .app
        .add_systems(PreUpdate, aim_mouse.in_set(PickingSystems::Backend));
    panel.update();
}

#[test]
fn says_so_while_there_is_no_ray() {
    let mut panel = Panel::new(InspectorTab::Query);
    panel.update();
    assert!(panel.says("there is no ray yet"));
}

#[test]
fn lists_the_hits_by_distance_with_names() {
    let (panel, _) = over_two_cubes();
    assert!(panel.says("It hits 2, the nearest first"));
    let near = panel.beside_containing("near (");
    assert_eq!(near, Some("4.500"));
    assert_eq!(panel.beside_containing("far ("), Some("8.500"));
}

#[test]
fn tells_what_the_search_visited() {
    let (panel, _) = over_two_cubes();
    assert_eq!(panel.beside("nodes visited"), Some("1"));
    assert_eq!(panel.beside("entities tested"), Some("1"));
    assert!(panel.beside("triangles tested").is_some_and(|count| count != "0"));
}

#[test]
fn a_click_on_a_hit_selects_it() {
    let (mut panel, [_, far]) = over_two_cubes();
    panel.click("far (");
    assert_eq!(panel.inspector().selected, Some(far));
}

#[test]
fn says_so_when_nothing_is_hit() {
    let (mut panel, _) = over_two_cubes();
    aim(&mut panel, Ray3d::new(Vec3::Z * 5.0, Dir3::Z));
    assert!(panel.says("It hits nothing"));
}

#[test]
fn a_ray_that_is_held_stays() {
    let (mut panel, _) = over_two_cubes();
    panel.click_beside("hold this ray", -10.0);
    aim(&mut panel, Ray3d::new(Vec3::Z * 5.0, Dir3::Z));
    assert!(panel.says("It hits 2, the nearest first"));
}
