//! Others that make entities visible.

use bevy::{
    camera::visibility::{SetViewVisibility, VisibilitySystems},
    prelude::*,
};

use super::*;

/// Is made visible by a plugin that is neither Bevy's nor ours.
#[derive(Component)]
struct Spotted;

fn add_spotting(app: &mut App) {
    let spot = |mut things: Query<&mut ViewVisibility, With<Spotted>>| {
        things.iter_mut().for_each(|mut visibility| visibility.set_visible());
    };
    app.add_systems(PostUpdate, spot.in_set(VisibilitySystems::CheckVisibility));
}

#[test]
fn what_others_make_visible_is_visible_for_as_long_as_they_do() {
    of_both(|app| {
        add_spotting(app);
        let (camera, cube) = (spawn_camera(app), spawn_cube_at(app, 99.0, 0.0, 0.0));
        app.update();
        insert(app, cube, Spotted);
        for _ in 0..3 {
            assert_eq!(look(app, camera), []);
            assert!(is_seen(app, cube));
        }
        remove::<Spotted>(app, cube);
        app.update();
        assert!(!is_seen(app, cube));
    });
}

#[test]
fn what_a_camera_and_another_see_in_turns_does_not_change() {
    of_both(|app| {
        add_spotting(app);
        let (camera, cube) = (spawn_camera(app), spawn_cube(app));
        app.update();
        let seen_first = written::<ViewVisibility>(app, cube);
        insert(app, cube, Spotted);
        app.update();
        insert(app, camera, Transform::from_xyz(0.0, 0.0, -10.0));
        app.update();
        insert(app, camera, Transform::from_xyz(0.0, 0.0, 10.0));
        app.update();
        remove::<Spotted>(app, cube);
        app.update();
        assert!(is_seen(app, cube));
        assert_eq!(written::<ViewVisibility>(app, cube), seen_first);
    });
}

#[test]
fn a_view_visibility_that_is_overwritten_is_put_right_in_the_next_frame() {
    of_both(|app| {
        let (_, seen, away) = (spawn_camera(app), spawn_cube(app), spawn_cube_at(app, 99.0, 0.0, 0.0));
        app.update();
        insert(app, seen, ViewVisibility::HIDDEN);
        insert(app, away, ViewVisibility::VISIBLE);
        app.update();
        assert!(is_seen(app, seen));
        assert!(!is_seen(app, away));
    });
}
