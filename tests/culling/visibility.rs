//! Who may be seen at all.

use bevy::{
    camera::visibility::{InheritedVisibility, ViewVisibility},
    ecs::entity_disabling::Disabled,
    prelude::*,
};

use super::*;

#[test]
fn what_is_in_front_of_a_camera_is_in_its_list() {
    of_both(|app| {
        let (camera, cube) = (spawn_camera(app), spawn_cube(app));
        assert_eq!(look(app, camera), [cube]);
        assert!(is_seen(app, cube));
    });
}

#[test]
fn a_hidden_entity_is_in_no_list() {
    of_both(|app| {
        let (camera, cube) = (spawn_camera(app), spawn_cube(app));
        app.update();
        insert(app, cube, Visibility::Hidden);
        assert_eq!(look(app, camera), []);
        assert!(!is_seen(app, cube));
    });
}

#[test]
fn what_is_shown_again_is_seen_in_the_same_frame() {
    of_both(|app| {
        let (camera, cube) = (spawn_camera(app), spawn_cube(app));
        insert(app, cube, Visibility::Hidden);
        app.update();
        insert(app, cube, Visibility::Inherited);
        assert_eq!(look(app, camera), [cube]);
        assert!(is_seen(app, cube));
    });
}

#[test]
fn all_that_is_below_a_hidden_parent_is_hidden() {
    of_both(|app| {
        let (camera, child) = (spawn_camera(app), spawn_cube(app));
        let grandparent = spawn(app, (Transform::default(), Visibility::default()));
        let parent = spawn(app, (Transform::default(), Visibility::default(), ChildOf(grandparent)));
        insert(app, child, ChildOf(parent));
        assert_eq!(look(app, camera), [child]);
        insert(app, grandparent, Visibility::Hidden);
        assert_eq!(look(app, camera), []);
        insert(app, grandparent, Visibility::Inherited);
        assert_eq!(look(app, camera), [child]);
    });
}

#[test]
fn a_child_that_is_visible_of_itself_is_seen_below_a_hidden_parent() {
    of_both(|app| {
        let (camera, child, parent) = (spawn_camera(app), spawn_cube(app), spawn_cube(app));
        insert(app, child, (Visibility::Visible, ChildOf(parent)));
        insert(app, parent, Visibility::Hidden);
        assert_eq!(look(app, camera), [child]);
    });
}

#[test]
fn a_child_is_hidden_and_seen_as_its_parents_change() {
    of_both(|app| {
        let (camera, child, parent) = (spawn_camera(app), spawn_cube(app), spawn_cube(app));
        insert(app, parent, Visibility::Hidden);
        assert_eq!(look(app, camera), [child]);
        insert(app, child, ChildOf(parent));
        assert_eq!(look(app, camera), []);
        remove::<ChildOf>(app, child);
        assert_eq!(look(app, camera), [child]);
    });
}

#[test]
fn what_is_despawned_is_in_no_list() {
    of_both(|app| {
        let (camera, cube, other) = (spawn_camera(app), spawn_cube(app), spawn_cube(app));
        app.update();
        app.world_mut().despawn(cube);
        assert_eq!(look(app, camera), [other]);
    });
}

#[test]
fn a_child_is_despawned_with_its_parent() {
    of_both(|app| {
        let (camera, child, parent) = (spawn_camera(app), spawn_cube(app), spawn_cube(app));
        insert(app, child, ChildOf(parent));
        app.update();
        app.world_mut().despawn(parent);
        assert_eq!(look(app, camera), []);
    });
}

#[test]
fn an_entity_is_not_taken_for_the_one_before_it_with_its_index() {
    of_both(|app| {
        let (camera, cube) = (spawn_camera(app), spawn_cube(app));
        app.update();
        let (mesh, world) = (super::cube(app), app.world_mut());
        let place = world.despawn_no_free(cube).expect("it was there");
        let away = (mesh, Transform::from_xyz(1000.0, 0.0, 0.0));
        let other = world.spawn_at(place, away).expect("nobody is there").id();
        assert_eq!(other.index(), cube.index());
        assert_eq!(look(app, camera), []);
        assert!(!is_seen(app, other));
        insert(app, other, Transform::default());
        assert_eq!(look(app, camera), [other]);
    });
}

#[test]
fn a_disabled_entity_is_in_no_list_until_it_is_enabled() {
    of_both(|app| {
        let (camera, cube) = (spawn_camera(app), spawn_cube(app));
        app.update();
        insert(app, cube, Disabled);
        assert_eq!(look(app, camera), []);
        remove::<Disabled>(app, cube);
        assert_eq!(look(app, camera), [cube]);
    });
}

#[test]
fn a_disabled_entity_keeps_the_view_visibility_that_it_had() {
    of_both(|app| {
        let (_, cube) = (spawn_camera(app), spawn_cube(app));
        app.update();
        insert(app, cube, Disabled);
        app.update();
        assert!(is_seen(app, cube));
    });
}

#[test]
fn an_entity_that_lacks_what_visibility_needs_is_in_no_list_until_it_has_it_again() {
    of_both(|app| {
        let (camera, cube) = (spawn_camera(app), spawn_cube(app));
        assert_eq!(look(app, camera), [cube]);
        remove::<ViewVisibility>(app, cube);
        assert_eq!(look(app, camera), []);
        insert(app, cube, ViewVisibility::default());
        assert_eq!(look(app, camera), [cube]);
        remove::<InheritedVisibility>(app, cube);
        assert_eq!(look(app, camera), []);
        insert(app, cube, InheritedVisibility::VISIBLE);
        assert_eq!(look(app, camera), [cube]);
        remove::<GlobalTransform>(app, cube);
        assert_eq!(look(app, camera), []);
        insert(app, cube, GlobalTransform::default());
        assert_eq!(look(app, camera), [cube]);
    });
}
