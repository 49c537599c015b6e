//! Lists by visibility class.

use std::any::TypeId;

use bevy::{camera::visibility::VisibilityClass, prelude::*};

use super::{
    differential::things::{Rock, Tree},
    *,
};

#[test]
fn lists_are_in_order() {
    of_both(|app| {
        let camera = spawn_camera(app);
        let cubes: Vec<Entity> = (0..50)
            .map(|i| spawn_cube_at(app, (i * 7 % 5) as f32 - 2.0, 0.0, -i as f32))
            .collect();
        assert_eq!(look(app, camera), sorted(cubes.clone()));
        app.world_mut().despawn(cubes[20]);
        insert(app, cubes[30], Visibility::Hidden);
        let late = spawn_cube(app);
        let left = cubes.iter().enumerate().filter(|(i, _)| ![20, 30].contains(i));
        let expected = sorted(left.map(|(_, &cube)| cube).chain([late]));
        assert_eq!(look(app, camera), expected);
    });
}

#[test]
fn each_class_has_its_list() {
    of_both(|app| {
        let (camera, cube, tree) = (spawn_camera(app), spawn_cube(app), spawn(app, Tree));
        assert_eq!(look(app, camera), [cube]);
        assert_eq!(listed::<Tree>(app, camera), [tree]);
        assert_eq!(listed::<Mesh2d>(app, camera), []);
    });
}

#[test]
fn an_entity_of_two_classes_is_in_both_lists() {
    of_both(|app| {
        let (camera, cube) = (spawn_camera(app), spawn_cube(app));
        app.update();
        insert(app, cube, Tree);
        assert_eq!(look(app, camera), [cube]);
        assert_eq!(listed::<Tree>(app, camera), [cube]);
    });
}

#[test]
fn an_entity_that_has_a_class_twice_is_in_the_list_twice() {
    of_both(|app| {
        let (camera, rock) = (spawn_camera(app), spawn(app, Rock));
        assert_eq!(look_for::<Rock>(app, camera), [rock, rock]);
    });
}

#[test]
fn an_entity_keeps_the_class_of_a_component_that_it_loses() {
    of_both(|app| {
        let (camera, cube) = (spawn_camera(app), spawn_cube(app));
        app.update();
        remove::<Mesh3d>(app, cube);
        assert_eq!(look(app, camera), [cube]);
    });
}

#[test]
fn classes_that_are_edited_in_place_count() {
    of_both(|app| {
        let (camera, cube) = (spawn_camera(app), spawn_cube(app));
        app.update();
        let mut classes = app.world_mut().get_mut::<VisibilityClass>(cube).expect("a mesh has it");
        classes.0 = [TypeId::of::<Tree>()].into_iter().collect();
        assert_eq!(look(app, camera), []);
        assert_eq!(listed::<Tree>(app, camera), [cube]);
    });
}

#[test]
fn an_entity_without_a_class_is_visible_and_in_no_list() {
    of_both(|app| {
        let (camera, cube) = (spawn_camera(app), spawn_cube(app));
        app.update();
        remove::<VisibilityClass>(app, cube);
        assert_eq!(look(app, camera), []);
        assert!(is_seen(app, cube));
    });
}
