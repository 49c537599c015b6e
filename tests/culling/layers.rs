//! Layers and ranges.

use bevy::{
    camera::visibility::{RenderLayers, VisibilityRange},
    prelude::*,
};

use super::*;

#[test]
fn a_camera_sees_what_is_on_one_of_its_layers() {
    of_both(|app| {
        let camera = spawn_camera(app);
        insert(app, camera, RenderLayers::from_layers(&[1, 2]));
        spawn_cube(app);
        let (one, both) = (spawn_cube(app), spawn_cube(app));
        insert(app, one, RenderLayers::layer(2));
        insert(app, both, RenderLayers::from_layers(&[0, 1]));
        assert_eq!(look(app, camera), sorted([one, both]));
    });
}

#[test]
fn layers_change_and_go_in_the_frame_in_which_they_do() {
    of_both(|app| {
        let (camera, cube) = (spawn_camera(app), spawn_cube(app));
        assert_eq!(look(app, camera), [cube]);
        insert(app, cube, RenderLayers::layer(3));
        assert_eq!(look(app, camera), []);
        *app.world_mut().get_mut::<RenderLayers>(cube).expect("it has layers") = RenderLayers::layer(0);
        assert_eq!(look(app, camera), [cube]);
        insert(app, camera, RenderLayers::layer(3));
        assert_eq!(look(app, camera), []);
        remove::<RenderLayers>(app, camera);
        assert_eq!(look(app, camera), [cube]);
        insert(app, cube, RenderLayers::layer(3));
        app.update();
        remove::<RenderLayers>(app, cube);
        assert_eq!(look(app, camera), [cube]);
    });
}

#[test]
fn who_is_on_no_layer_is_not_seen_and_sees_nothing() {
    of_both(|app| {
        let (camera, blind, cube) = (spawn_camera(app), spawn_camera(app), spawn_cube(app));
        insert(app, cube, RenderLayers::none());
        insert(app, blind, RenderLayers::none());
        assert_eq!(look(app, camera), []);
        assert_eq!(listed::<Mesh3d>(app, blind), []);
    });
}

#[test]
fn layers_beyond_the_sixty_fourth_count() {
    of_both(|app| {
        let (camera, near, far) = (spawn_camera(app), spawn_cube(app), spawn_cube(app));
        insert(app, camera, RenderLayers::none().with(70));
        insert(app, near, RenderLayers::none().with(6));
        insert(app, far, RenderLayers::none().with(70));
        assert_eq!(look(app, camera), [far]);
    });
}

#[test]
fn an_entity_with_a_range_is_seen_from_within_it() {
    of_both(|app| {
        let (camera, cube) = (spawn_camera(app), spawn_cube(app));
        insert(app, cube, VisibilityRange::abrupt(0.0, 15.0));
        assert_eq!(look(app, camera), [cube]);
        insert(app, camera, Transform::from_xyz(0.0, 0.0, 20.0));
        assert_eq!(look(app, camera), []);
        insert(app, cube, VisibilityRange::abrupt(15.0, 25.0));
        assert_eq!(look(app, camera), [cube]);
        remove::<VisibilityRange>(app, cube);
        insert(app, camera, Transform::from_xyz(0.0, 0.0, 50.0));
        assert_eq!(look(app, camera), [cube]);
    });
}

#[test]
fn a_range_is_kept_for_each_camera_alone() {
    of_both(|app| {
        let (near, far, cube) = (spawn_camera(app), spawn_camera(app), spawn_cube(app));
        insert(app, far, Transform::from_xyz(0.0, 0.0, 100.0));
        insert(app, cube, VisibilityRange::abrupt(50.0, 150.0));
        assert_eq!(look(app, near), []);
        assert_eq!(listed::<Mesh3d>(app, far), [cube]);
    });
}
