//! Handing culling back to Bevy, and having none of Bevy's.

use bevy::{camera::visibility::VisibleEntities, prelude::*};
use bevy_sightline::prelude::*;

use super::*;

fn set_enabled(app: &mut App, enabled: bool) {
    app.world_mut().resource_mut::<ViewCullingSettings>().enabled = enabled;
}

#[test]
fn culling_is_ours_by_default() {
    let mut app = ours();
    let (camera, cube) = (spawn_camera(&mut app), spawn_cube(&mut app));
    app.update();
    assert!(app.world().resource::<ViewCullingSettings>().enabled);
    let set = app.world().get::<VisibleSet>(camera).expect("every camera has one");
    assert!(set.contains(cube));
}

#[test]
fn bevy_culls_where_ours_is_switched_off() {
    let mut app = ours();
    let (camera, cube) = (spawn_camera(&mut app), spawn_cube(&mut app));
    app.update();
    set_enabled(&mut app, false);
    insert(&mut app, cube, Transform::from_xyz(99.0, 0.0, 0.0));
    assert_eq!(look(&mut app, camera), []);
    assert!(!is_seen(&app, cube));
}

#[test]
fn the_set_of_a_camera_stays_as_it_was_while_bevy_culls() {
    let mut app = ours();
    let (camera, cube) = (spawn_camera(&mut app), spawn_cube(&mut app));
    app.update();
    set_enabled(&mut app, false);
    let other = spawn_cube(&mut app);
    assert_eq!(look(&mut app, camera), sorted([cube, other]));
    let set = app.world().get::<VisibleSet>(camera).expect("every camera has one");
    assert!(!set.contains(other));
}

#[test]
fn ours_knows_what_has_happened_while_it_was_switched_off() {
    let mut app = ours();
    let camera = spawn_camera(&mut app);
    let [stays, goes, leaves] = [0.0, 1.0, -1.0].map(|x| spawn_cube_at(&mut app, x, 0.0, 0.0));
    app.update();
    set_enabled(&mut app, false);
    app.update();
    app.world_mut().despawn(goes);
    insert(&mut app, leaves, Transform::from_xyz(99.0, 0.0, 0.0));
    let comes = spawn_cube(&mut app);
    for _ in 0..3 {
        app.update();
    }
    set_enabled(&mut app, true);
    assert_eq!(look(&mut app, camera), sorted([stays, comes]));
    assert!(!is_seen(&app, leaves));
    let set = app.world().get::<VisibleSet>(camera).expect("every camera has one");
    assert!(set.contains(comes) && !set.contains(leaves));
}

#[test]
fn nothing_changes_where_culling_is_handed_over() {
    let mut app = ours();
    let (camera, cube) = (spawn_camera(&mut app), spawn_cube(&mut app));
    app.update();
    let seen_first = written::<ViewVisibility>(&app, cube);
    for enabled in [false, true, false, false, true, true] {
        set_enabled(&mut app, enabled);
        assert_eq!(look(&mut app, camera), [cube]);
        assert_eq!(written::<ViewVisibility>(&app, cube), seen_first, "enabled: {enabled}");
    }
}

#[test]
fn an_app_without_cameras_has_nothing_to_cull() {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        AssetPlugin::default(),
        bevy::image::ImagePlugin::default(),
        bevy::mesh::MeshPlugin,
        ViewCullingPlugin,
    ));
    app.finish();
    app.cleanup();
    let lists = app.world_mut().spawn(VisibleEntities::default()).id();
    app.update();
    assert!(app.world().get_entity(lists).is_ok());
}
