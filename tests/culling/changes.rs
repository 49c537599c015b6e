//! What counts as a change of `ViewVisibility` and of lists.

use bevy::{
    camera::visibility::{NoCpuCulling, VisibleEntities},
    prelude::*,
};

use super::*;

/// Whether something's `ViewVisibility` is written to in the next frame.
fn changes(app: &mut App, entity: Entity) -> bool {
    let before = written::<ViewVisibility>(app, entity);
    app.update();
    written::<ViewVisibility>(app, entity) != before
}

#[test]
fn a_view_visibility_changes_when_its_entity_comes_into_view_and_leaves_it() {
    of_both(|app| {
        let (camera, cube) = (spawn_camera(app), spawn_cube_at(app, 50.0, 0.0, 0.0));
        app.update();
        assert!(!changes(app, cube), "it is not seen");
        insert(app, cube, Transform::default());
        assert!(changes(app, cube), "it comes");
        assert!(!changes(app, cube), "it stays");
        assert!(!changes(app, cube), "it still stays");
        insert(app, camera, Transform::from_xyz(0.0, 0.0, -10.0));
        assert!(changes(app, cube), "it leaves");
        assert!(!changes(app, cube), "it has left");
    });
}

#[test]
fn a_view_visibility_does_not_change_while_its_entity_moves_in_view() {
    of_both(|app| {
        let (_, cube) = (spawn_camera(app), spawn_cube(app));
        app.update();
        for x in [0.5, 1.0, -1.0] {
            insert(app, cube, Transform::from_xyz(x, 0.0, 0.0));
            assert!(!changes(app, cube));
        }
    });
}

#[test]
fn a_view_visibility_does_not_change_when_another_camera_takes_over() {
    of_both(|app| {
        let (first, second, cube) = (spawn_camera(app), spawn_camera(app), spawn_cube(app));
        let away = Transform::from_xyz(0.0, 0.0, -10.0);
        insert(app, second, away);
        app.update();
        insert(app, first, away);
        insert(app, second, Transform::from_xyz(0.0, 0.0, 10.0));
        assert!(!changes(app, cube));
        assert!(is_seen(app, cube));
    });
}

#[test]
fn a_system_sees_in_update_what_has_changed_since_the_last_frame() {
    #[derive(Resource, Default)]
    struct Changed(Vec<Entity>);

    of_both(|app| {
        let note = |things: Query<(Entity, Ref<ViewVisibility>), With<Mesh3d>>, mut changed: ResMut<Changed>| {
            let those = things.iter().filter(|(_, visibility)| visibility.is_changed());
            changed.0 = those.map(|(thing, _)| thing).collect();
        };
        app.init_resource::<Changed>().add_systems(Update, note);
        let changed = |app: &mut App| {
            app.update();
            app.world().resource::<Changed>().0.clone()
        };
        let (camera, cube) = (spawn_camera(app), spawn_cube(app));
        assert_eq!(changed(app), [cube], "it has been spawned");
        assert_eq!(changed(app), [cube], "it has come into view");
        assert_eq!(changed(app), []);
        app.world_mut().despawn(camera);
        assert_eq!(changed(app), []);
        assert_eq!(changed(app), [cube], "it has left the view");
        assert_eq!(changed(app), []);
    });
}

#[test]
fn the_lists_of_a_camera_are_written_in_every_frame_in_which_it_is_active() {
    of_both(|app| {
        let camera = spawn_camera(app);
        spawn_cube(app);
        app.update();
        for is_active in [true, false, true] {
            app.world_mut().get_mut::<Camera>(camera).expect("a camera").is_active = is_active;
            let before = written::<VisibleEntities>(app, camera);
            app.update();
            assert_eq!(written::<VisibleEntities>(app, camera) != before, is_active);
        }
    });
}

#[test]
fn what_is_culled_by_the_gpu_changes_with_its_inherited_visibility_alone() {
    of_both(|app| {
        let (_, cube) = (spawn_camera(app), spawn_cube(app));
        insert(app, cube, NoCpuCulling);
        app.update();
        assert!(is_seen(app, cube));
        insert(app, cube, Transform::from_xyz(500.0, 0.0, 0.0));
        assert!(!changes(app, cube));
        insert(app, cube, Visibility::Hidden);
        assert!(changes(app, cube));
        assert!(!is_seen(app, cube));
    });
}
