//! The sets that games read.

use bevy::{camera::primitives::Aabb, prelude::*};
use bevy_sightline::prelude::*;

use super::{differential::things::Tree, *};

fn set(app: &App, camera: Entity) -> &VisibleSet {
    app.world().get::<VisibleSet>(camera).expect("every camera has one")
}

/// Two cubes in view and one out of it.
fn three_cubes(app: &mut App) -> [Entity; 3] {
    [0.0, 1.0, 50.0].map(|x| spawn_cube_at(app, x, 0.0, 0.0))
}

#[test]
fn a_set_holds_what_its_camera_sees_in_order() {
    let mut app = ours();
    let camera = spawn_camera(&mut app);
    let [a, b, out] = three_cubes(&mut app);
    app.update();
    let set = set(&app, camera);
    assert!([a, b].iter().all(|&cube| set.contains(cube)));
    assert!(!set.contains(out));
    assert!(set.entities().is_sorted());
    assert!(set.entities().iter().all(|&entity| is_seen(&app, entity)));
}

#[test]
fn a_set_holds_each_entity_once_whatever_its_classes() {
    let mut app = ours();
    let (camera, cube) = (spawn_camera(&mut app), spawn_cube(&mut app));
    insert(&mut app, cube, Tree);
    app.update();
    let times = set(&app, camera)
        .entities()
        .iter()
        .filter(|&&entity| entity == cube)
        .count();
    assert_eq!(times, 1);
}

#[test]
fn what_enters_and_leaves_is_told_for_one_frame() {
    let mut app = ours();
    let camera = spawn_camera(&mut app);
    let [a, b, out] = three_cubes(&mut app);
    app.update();
    assert!([a, b].iter().all(|cube| set(&app, camera).entered().contains(cube)));
    app.update();
    assert!(set(&app, camera).entered().is_empty());
    insert(&mut app, a, Visibility::Hidden);
    insert(&mut app, out, Transform::from_xyz(2.0, 0.0, 0.0));
    app.update();
    assert_eq!(set(&app, camera).entered(), [out]);
    assert_eq!(set(&app, camera).left(), [a]);
    app.update();
    assert!(set(&app, camera).entered().is_empty());
    assert!(set(&app, camera).left().is_empty());
    assert!(set(&app, camera).contains(b));
}

#[test]
fn what_is_despawned_has_left() {
    let mut app = ours();
    let camera = spawn_camera(&mut app);
    let [a, ..] = three_cubes(&mut app);
    app.update();
    app.world_mut().despawn(a);
    app.update();
    assert_eq!(set(&app, camera).left(), [a]);
    assert!(!set(&app, camera).contains(a));
}

#[test]
fn looking_away_is_leaving_everything() {
    let mut app = ours();
    let camera = spawn_camera(&mut app);
    let [a, b, _] = three_cubes(&mut app);
    app.update();
    insert(&mut app, camera, Transform::from_xyz(0.0, 0.0, -10.0));
    app.update();
    let left = set(&app, camera).left();
    assert!(left.contains(&a) && left.contains(&b) && left.is_sorted());
}

#[test]
fn a_set_changes_only_when_something_enters_or_leaves() {
    let mut app = ours();
    let camera = spawn_camera(&mut app);
    let [a, _, out] = three_cubes(&mut app);
    app.update();
    app.update();
    let before = written::<VisibleSet>(&app, camera);
    insert(&mut app, a, Transform::from_xyz(0.1, 0.0, 0.0));
    insert(&mut app, out, Transform::from_xyz(60.0, 0.0, 0.0));
    app.update();
    assert_eq!(written::<VisibleSet>(&app, camera), before);
    insert(&mut app, out, Transform::default());
    app.update();
    assert_ne!(written::<VisibleSet>(&app, camera), before);
}

#[test]
fn the_set_of_an_inactive_camera_stays_as_it_was() {
    let mut app = ours();
    let camera = spawn_camera(&mut app);
    let [a, b, _] = three_cubes(&mut app);
    app.update();
    app.world_mut().get_mut::<Camera>(camera).expect("a camera").is_active = false;
    insert(&mut app, a, Visibility::Hidden);
    app.update();
    assert!([a, b].iter().all(|&cube| set(&app, camera).contains(cube)));
    app.world_mut().get_mut::<Camera>(camera).expect("a camera").is_active = true;
    app.update();
    assert_eq!(set(&app, camera).left(), [a]);
}

#[test]
fn front_to_back_is_by_the_nearest_point_along_the_axis_of_the_camera() {
    let mut app = ours();
    let camera = spawn_camera(&mut app);
    let far = spawn_cube_at(&mut app, 0.0, 0.0, -10.0);
    let near = spawn_cube_at(&mut app, 1.0, 0.0, 0.0);
    let long = spawn(
        &mut app,
        (
            Tree,
            Aabb::from_min_max(Vec3::new(-0.1, -0.1, -40.0), Vec3::new(0.1, 0.1, 5.0)),
        ),
    );
    app.update();
    let eye = app.world().get::<GlobalTransform>(camera).expect("a camera");
    let mut visible = Vec::new();
    set(&app, camera).front_to_back(app.world().resource::<SpatialIndex>(), eye, &mut visible);
    let order: Vec<Entity> = visible.iter().map(|visible| visible.entity).collect();
    assert_eq!(order, [long, near, far]);
    for (visible, depth) in visible.iter().zip([5.0, 9.5, 19.5]) {
        assert!((visible.depth - depth).abs() < 1e-3, "{visible:?} is {depth} m away");
    }
}
