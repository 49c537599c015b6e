//! What is drawn for one entity, while everything is off for the others.

use super::*;

fn show(app: &mut App, entity: Entity, show: ShowGizmos) {
    app.world_mut().entity_mut(entity).insert(show);
    app.update();
}

#[test]
fn its_leaf_is_drawn() {
    let (mut app, cubes) = app_with_cubes([10.0, 20.0]);
    show(&mut app, cubes[1], ShowGizmos::default());
    assert_eq!(boxes(&app), world_boxes(&app, &cubes[1..]));
    assert_eq!(stats(&app).entities, count(1, 0));
}

#[test]
fn it_is_gone_with_the_component() {
    let (mut app, cubes) = app_with_cubes([10.0]);
    show(&mut app, cubes[0], ShowGizmos::default());
    app.world_mut().entity_mut(cubes[0]).remove::<ShowGizmos>();
    app.update();
    assert!(is_blank(&app));
    assert_eq!(stats(&app), SightlineGizmoStats::default());
}

#[test]
fn nothing_is_drawn_that_is_not_asked_for() {
    let (mut app, cubes) = app_with_cubes([10.0]);
    show(&mut app, cubes[0], ShowGizmos::NOTHING);
    assert!(is_blank(&app));
}

#[test]
fn its_bounding_volume_is_of_the_kind_that_is_asked_for() {
    let (mut app, cubes) = app_with_cubes([10.0]);
    let volume = Some(BoundingKind::Sphere);
    show(
        &mut app,
        cubes[0],
        ShowGizmos {
            volume,
            ..ShowGizmos::NOTHING
        },
    );
    assert_eq!(stats(&app).entities, count(0, 1), "it is not made yet");
    while stats(&app).entities.drawn == 0 {
        app.update();
    }
    let [min, max] = corners_around(&lines(&app));
    assert!((max - min).abs_diff_eq(Vec3::splat(3.0_f32.sqrt()), 1e-3));
}

#[test]
fn its_occluding_boxes_are_drawn() {
    let (mut app, cubes) = app_with_cubes([10.0]);
    app.world_mut().entity_mut(cubes[0]).insert(Occluder::Box);
    let occluder = ShowGizmos {
        occluder: true,
        ..ShowGizmos::NOTHING
    };
    show(&mut app, cubes[0], occluder);
    assert_alike(&boxes(&app), &world_boxes(&app, &cubes));
}

#[test]
fn the_frustum_of_a_camera_is_drawn() {
    let mut app = app();
    let camera = spawn_camera(&mut app);
    show(&mut app, camera, ShowGizmos::default());
    assert_eq!(lines(&app).len(), 12);
    assert_eq!(stats(&app).entities, count(1, 0));
}

#[test]
fn a_group_is_drawn_with_the_distances_of_its_levels() {
    let mut app = app();
    let mesh = add_mesh(&mut app, Cuboid::default());
    let lod = ProxyLod::new(LodMetric::Distance, mesh.clone())
        .then(20.0, mesh.clone())
        .then(40.0, mesh.clone());
    let root = app.world_mut().spawn((Mesh3d(mesh), lod)).id();
    spawn_camera(&mut app);
    settle(&mut app);
    let only_lod = ShowGizmos {
        lod: true,
        ..ShowGizmos::NOTHING
    };
    show(&mut app, root, only_lod);
    assert_eq!(stats(&app).entities, count(1, 0));
    let curves = asset(&app).expect("something drawn").buffer().strip_positions.clone();
    let to_box = |point: Vec3| (point.abs() - 0.5).max(Vec3::ZERO).with_y(0.0).length();
    let at = |distance: f32| {
        let on_it = |point: &&Vec3| (to_box(**point) - distance).abs() < 0.01;
        curves.iter().filter(|point| point.is_finite()).filter(on_it).count()
    };
    let points = curves.iter().filter(|point| point.is_finite()).count();
    assert!(at(20.0) >= 8 && at(40.0) >= 8);
    assert_eq!(at(20.0) + at(40.0), points);
}
