//! Cameras that come, go, and do not look.

use std::any::TypeId;

use bevy::{
    camera::visibility::{NoCpuCulling, VisibleEntities},
    ecs::entity_disabling::Disabled,
    prelude::*,
};

use super::*;

fn set_active(app: &mut App, camera: Entity, is_active: bool) {
    app.world_mut().get_mut::<Camera>(camera).expect("a camera").is_active = is_active;
}

#[test]
fn an_inactive_camera_keeps_its_last_list() {
    of_both(|app| {
        let (camera, cube) = (spawn_camera(app), spawn_cube(app));
        app.update();
        set_active(app, camera, false);
        insert(app, cube, Visibility::Hidden);
        assert_eq!(look(app, camera), [cube]);
        set_active(app, camera, true);
        assert_eq!(look(app, camera), []);
    });
}

#[test]
fn what_an_inactive_camera_alone_has_seen_is_not_visible() {
    of_both(|app| {
        let (camera, cube) = (spawn_camera(app), spawn_cube(app));
        app.update();
        set_active(app, camera, false);
        app.update();
        assert!(!is_seen(app, cube));
        set_active(app, camera, true);
        app.update();
        assert!(is_seen(app, cube));
    });
}

#[test]
fn what_a_camera_saw_is_not_visible_once_it_is_gone() {
    of_both(|app| {
        let cube = spawn_cube(app);
        for end in [
            |app: &mut App, camera: Entity| _ = app.world_mut().despawn(camera),
            |app: &mut App, camera: Entity| remove::<Camera>(app, camera),
            |app: &mut App, camera: Entity| remove::<VisibleEntities>(app, camera),
            |app: &mut App, camera: Entity| insert(app, camera, Disabled),
        ] {
            let camera = spawn_camera(app);
            app.update();
            assert!(is_seen(app, cube));
            end(app, camera);
            app.update();
            assert!(!is_seen(app, cube));
        }
    });
}

#[test]
fn a_camera_that_comes_later_sees_what_has_been_there() {
    of_both(|app| {
        let cube = spawn_cube(app);
        for _ in 0..3 {
            app.update();
        }
        let camera = spawn_camera(app);
        assert_eq!(look(app, camera), [cube]);
    });
}

#[test]
fn a_hidden_camera_sees() {
    of_both(|app| {
        let (camera, cube) = (spawn_camera(app), spawn_cube(app));
        insert(app, camera, Visibility::Hidden);
        assert_eq!(look(app, camera), [cube]);
    });
}

#[test]
fn a_camera_without_cpu_culling_lists_everything_that_is_not_hidden() {
    of_both(|app| {
        let camera = spawn_camera(app);
        let (cube, away, hidden) = (spawn_cube(app), spawn_cube_at(app, 99.0, 0.0, 0.0), spawn_cube(app));
        insert(app, hidden, Visibility::Hidden);
        insert(app, camera, NoCpuCulling);
        assert_eq!(look(app, camera), sorted([cube, away]));
        remove::<NoCpuCulling>(app, camera);
        assert_eq!(look(app, camera), [cube]);
    });
}

#[test]
fn an_entity_without_cpu_culling_is_visible_and_in_no_list() {
    of_both(|app| {
        let (camera, cube) = (spawn_camera(app), spawn_cube_at(app, 99.0, 0.0, 0.0));
        insert(app, cube, NoCpuCulling);
        assert_eq!(look(app, camera), []);
        assert!(is_seen(app, cube));
        remove::<NoCpuCulling>(app, cube);
        app.update();
        assert!(!is_seen(app, cube));
    });
}

#[test]
fn what_others_have_written_into_a_list_is_gone_in_the_next_frame() {
    of_both(|app| {
        let (camera, cube, away) = (spawn_camera(app), spawn_cube(app), spawn_cube_at(app, 99.0, 0.0, 0.0));
        app.update();
        let mut lists = app.world_mut().get_mut::<VisibleEntities>(camera).expect("a camera");
        lists.push(away, TypeId::of::<Mesh3d>());
        assert_eq!(look(app, camera), [cube]);
        let mut lists = app.world_mut().get_mut::<VisibleEntities>(camera).expect("a camera");
        lists.clear_all();
        assert_eq!(look(app, camera), [cube]);
        insert(app, camera, VisibleEntities::default());
        assert_eq!(look(app, camera), [cube]);
    });
}
