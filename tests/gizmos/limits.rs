//! Limits hold, and it is said what was left out.

use super::*;

#[test]
fn no_more_lines_are_drawn_than_the_limit_says() {
    let (mut app, _) = app_with_cubes((1..=40).map(|number| 5.0 * number as f32));
    draw(&mut app, |gizmos| {
        gizmos.leaves = true;
        gizmos.limit = 100;
    });
    assert_eq!(lines(&app).len(), 96);
    assert_eq!(stats(&app).leaves, count(8, 32));
}

#[test]
fn the_nearest_are_drawn() {
    let (mut app, cubes) = app_with_cubes([50.0, 10.0, 40.0, 20.0, 30.0, 15.0]);
    draw(&mut app, |gizmos| {
        gizmos.leaves = true;
        gizmos.limit = 24;
    });
    assert_eq!(boxes(&app), world_boxes(&app, &[cubes[1], cubes[5]]));
}

#[test]
fn each_kind_has_the_whole_limit() {
    let (mut app, _) = app_with_cubes((1..=40).map(|number| 5.0 * number as f32));
    draw(&mut app, |gizmos| {
        (gizmos.leaves, gizmos.volumes, gizmos.nodes) = (true, Some(BoundingKind::Aabb), true);
        gizmos.limit = 12;
    });
    let stats = stats(&app);
    assert_eq!((stats.leaves, stats.volumes), (count(1, 39), count(1, 39)));
    assert_eq!(stats.nodes.drawn, 1);
    assert!(stats.nodes.left_out > 0);
}

#[test]
fn shapes_of_many_lines_take_more_of_the_limit() {
    let (mut app, _) = app_with_cubes([10.0, 20.0, 30.0]);
    draw(&mut app, |gizmos| {
        gizmos.volumes = Some(BoundingKind::Sphere);
        gizmos.limit = 200;
    });
    finish_meshes(&mut app);
    app.update();
    assert_eq!(stats(&app).volumes, count(2, 1));
    assert!(lines(&app).len() <= 200);
}

#[test]
fn with_a_limit_of_zero_all_is_left_out() {
    let (mut app, _) = app_with_cubes([10.0, 20.0]);
    draw(&mut app, |gizmos| {
        (gizmos.leaves, gizmos.nodes, gizmos.frusta, gizmos.volumes) = (true, true, true, Some(BoundingKind::Aabb));
        gizmos.limit = 0;
    });
    assert!(is_blank(&app));
    let stats = stats(&app);
    assert_eq!((stats.leaves, stats.volumes), (count(0, 2), count(0, 2)));
    assert_eq!((stats.nodes, stats.frusta), (count(0, 1), count(0, 1)));
}

#[test]
fn single_entities_are_limited_too() {
    let (mut app, cubes) = app_with_cubes([10.0, 20.0, 30.0]);
    for &cube in &cubes {
        app.world_mut().entity_mut(cube).insert(ShowGizmos::default());
    }
    draw(&mut app, |gizmos| gizmos.limit = 24);
    assert_eq!(boxes(&app), world_boxes(&app, &cubes[..2]));
    assert_eq!(stats(&app).entities, count(2, 1));
}
