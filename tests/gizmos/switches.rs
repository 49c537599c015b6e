//! Each switch draws what it says, and nothing else does.

use bevy::{
    camera::primitives::Frustum,
    picking::backend::ray::{RayId, RayMap},
    picking::pointer::PointerId,
};

use super::*;

/// Forty cubes that a camera sees, more than one node can hold.
fn many() -> (App, Vec<Entity>) {
    app_with_cubes((0..40).map(|number| 5.0 + 2.0 * number as f32))
}

#[test]
fn nothing_is_drawn_while_everything_is_off() {
    let (mut app, _) = many();
    draw(&mut app, |_| ());
    assert!(is_blank(&app));
    assert_eq!(stats(&app), SightlineGizmoStats::default());
}

#[test]
fn nodes_are_those_of_the_tree() {
    let (mut app, _) = many();
    draw(&mut app, |gizmos| gizmos.nodes = true);
    let mut nodes = Vec::new();
    index(&app).visit_nodes(|_, aabb| nodes.push(corners(aabb)));
    assert!(nodes.len() > 1);
    assert_eq!(boxes(&app), sorted(nodes.clone()));
    assert_eq!(stats(&app).nodes, count(nodes.len(), 0));
}

#[test]
fn nodes_are_drawn_of_the_depths_that_are_asked_for() {
    let (mut app, _) = many();
    let mut nodes = Vec::new();
    index(&app).visit_nodes(|depth, aabb| nodes.extend((depth == 1).then(|| corners(aabb))));
    draw(&mut app, |gizmos| (gizmos.nodes, gizmos.depths) = (true, 1..=1));
    assert_eq!(boxes(&app), sorted(nodes));
    draw(&mut app, |gizmos| gizmos.depths = 100..=200);
    assert!(is_blank(&app));
}

#[test]
fn nodes_have_the_colours_of_their_depths() {
    let (mut app, _) = many();
    draw(&mut app, |gizmos| {
        gizmos.nodes = true;
        gizmos.palette = vec![Color::WHITE, Color::BLACK];
    });
    let root = corners(&index(&app).bounds().expect("entities"));
    for (edges, color) in lines(&app).chunks(12).zip(colors(&app).chunks(12)) {
        let is_root = corners_around(edges) == root;
        assert_eq!(color[0], if is_root { LinearRgba::WHITE } else { LinearRgba::BLACK });
    }
}

#[test]
fn cells_are_those_of_the_grid_that_hold_something() {
    let (mut app, cubes) = many();
    draw(&mut app, |gizmos| gizmos.cells = true);
    // The grid is there since it was asked for.
    draw(&mut app, |_| {});
    let cells = boxes(&app);
    assert!(!cells.is_empty());
    assert_eq!(stats(&app).cells, count(cells.len(), 0));
    let holds = |&[min, max]: &[Vec3; 2], point: Vec3| point.cmpge(min).all() && point.cmple(max).all();
    let centers: Vec<Vec3> = cubes
        .iter()
        .map(|&cube| app.world().get::<GlobalTransform>(cube).expect("a cube").translation())
        .collect();
    assert!(
        cells
            .iter()
            .all(|cell| centers.iter().any(|&center| holds(cell, center)))
    );
    assert!(
        centers
            .iter()
            .all(|&center| cells.iter().any(|cell| holds(cell, center)))
    );
}

#[test]
fn without_a_grid_there_are_no_cells() {
    let (mut app, _) = many();
    app.world_mut().resource_mut::<SpatialIndexSettings>().grid = None;
    draw(&mut app, |gizmos| gizmos.cells = true);
    assert!(is_blank(&app));
}

#[test]
fn leaves_are_the_world_boxes() {
    let (mut app, cubes) = many();
    draw(&mut app, |gizmos| gizmos.leaves = true);
    assert_eq!(boxes(&app), world_boxes(&app, &cubes));
    assert_eq!(stats(&app).leaves, count(40, 0));
}

/// Draws the volumes of one thing, for as many frames as it takes to make them.
fn draw_volumes(app: &mut App, kind: BoundingKind) {
    draw(app, |gizmos| gizmos.volumes = Some(kind));
    while stats(app).volumes.left_out > 0 {
        app.update();
    }
    assert_eq!(stats(app).volumes, count(1, 0));
}

#[test]
fn volumes_are_of_the_kind_that_is_asked_for() {
    let (mut app, _) = app_with_cubes([10.0]);
    for kind in [BoundingKind::Aabb, BoundingKind::Obb, BoundingKind::Hull] {
        draw_volumes(&mut app, kind);
        assert_eq!(lines(&app).len(), 12, "{kind:?}");
        let [min, max] = corners_around(&lines(&app));
        assert!(min.abs_diff_eq(Vec3::new(-0.5, -0.5, -10.5), 1e-4), "{kind:?}: {min}");
        assert!(max.abs_diff_eq(Vec3::new(0.5, 0.5, -9.5), 1e-4), "{kind:?}: {max}");
    }
    draw_volumes(&mut app, BoundingKind::Sphere);
    for point in lines(&app).into_iter().flatten() {
        let distance = point.distance(Vec3::NEG_Z * 10.0);
        assert!((distance - 0.75_f32.sqrt()).abs() < 1e-3, "{distance}");
    }
}

#[test]
fn a_volume_stands_as_its_entity_does() {
    let (mut app, cubes) = app_with_cubes([10.0]);
    let turned = Transform::from_xyz(0.0, 0.0, -10.0).with_rotation(Quat::from_rotation_y(0.5));
    app.world_mut().entity_mut(cubes[0]).insert(turned);
    draw_volumes(&mut app, BoundingKind::Aabb);
    for point in lines(&app).into_iter().flatten() {
        let local = turned.rotation.inverse() * (point - turned.translation);
        assert!(local.abs().abs_diff_eq(Vec3::splat(0.5), 1e-4), "{local}");
    }
}

#[test]
fn frusta_are_what_cameras_see() {
    let mut app = app();
    let camera = spawn_camera(&mut app);
    draw(&mut app, |gizmos| gizmos.frusta = true);
    let frustum = app.world().get::<Frustum>(camera).expect("a camera");
    let expected = frustum.corners().expect("a frustum with corners");
    let drawn = lines(&app);
    assert_eq!(drawn.len(), 12);
    assert!(drawn.iter().flatten().all(|point| expected.contains(point)));
    for corner in expected {
        let edges = drawn.iter().filter(|line| line.contains(&corner)).count();
        assert_eq!(edges, 3, "three edges meet in a corner");
    }
    assert_eq!(stats(&app).frusta, count(1, 0));
}

#[test]
fn occluders_are_drawn_by_their_boxes() {
    let (mut app, cubes) = app_with_cubes([10.0, 20.0, 30.0]);
    app.world_mut().entity_mut(cubes[0]).insert(Occluder::Box);
    app.world_mut().entity_mut(cubes[1]).insert(Occluder::Mesh);
    app.update();
    while app.world().resource::<Occluders>().making() > 0 {
        app.update();
    }
    draw(&mut app, |gizmos| gizmos.occluders = true);
    assert_alike(&boxes(&app), &world_boxes(&app, &cubes[..2]));
    assert_eq!(stats(&app).occluders, count(2, 0));
}

#[test]
fn the_ray_of_a_pointer_is_drawn_with_its_hit() {
    let (mut app, _) = app_with_cubes([10.0]);
    let camera = camera(&mut app);
    let ray = Ray3d::new(Vec3::ZERO, Dir3::NEG_Z);
    app.add_systems(Update, move |mut rays: ResMut<RayMap>| {
        rays.map.insert(RayId::new(camera, PointerId::Mouse), ray);
    });
    draw(&mut app, |gizmos| gizmos.rays = true);
    assert_eq!(stats(&app).rays, count(1, 0));
    assert_eq!(lines(&app)[0], [Vec3::ZERO, Vec3::NEG_Z * 9.5]);
}

#[test]
fn groups_are_spheres_in_the_colour_of_their_level() {
    let mut app = app();
    let mesh = add_mesh(&mut app, Cuboid::default());
    let lod = ProxyLod::new(LodMetric::Distance, mesh.clone()).then(20.0, mesh.clone());
    let place = Transform::from_xyz(0.0, 0.0, -10.0);
    app.world_mut().spawn((Mesh3d(mesh), lod, place));
    let camera = spawn_camera(&mut app);
    settle(&mut app);
    draw(&mut app, |gizmos| {
        gizmos.lods = true;
        gizmos.palette = vec![Color::WHITE, Color::BLACK];
    });
    assert_eq!(stats(&app).lods, count(1, 0));
    for point in lines(&app).into_iter().flatten() {
        assert!((point.distance(place.translation) - 0.75_f32.sqrt()).abs() < 1e-4);
    }
    assert!(colors(&app).iter().all(|&color| color == LinearRgba::WHITE));

    app.world_mut()
        .entity_mut(camera)
        .insert(Transform::from_xyz(0.0, 0.0, 20.0));
    app.update();
    assert!(colors(&app).iter().all(|&color| color == LinearRgba::BLACK));
}

#[test]
fn groups_in_the_place_of_which_something_coarser_is_shown_are_not_drawn() {
    let mut app = app();
    let mesh = add_mesh(&mut app, Cuboid::default());
    let lod = ProxyLod::new(LodMetric::Distance, mesh.clone()).then(20.0, mesh.clone());
    let house = app.world_mut().spawn((Mesh3d(mesh.clone()), lod)).id();
    let proxy = app.world_mut().spawn(Mesh3d(mesh)).id();
    let block = ProxyLod::new(LodMetric::Distance, house).then(50.0, proxy);
    app.world_mut()
        .spawn((block, Transform::from_xyz(0.0, 0.0, -10.0), Visibility::default()))
        .add_children(&[house, proxy]);
    let camera = spawn_camera(&mut app);
    settle(&mut app);
    draw(&mut app, |gizmos| gizmos.lods = true);
    assert_eq!(stats(&app).lods, count(2, 0));
    app.world_mut()
        .entity_mut(camera)
        .insert(Transform::from_xyz(0.0, 0.0, 100.0));
    app.update();
    assert_eq!(stats(&app).lods, count(1, 0));
}

#[test]
fn what_is_switched_off_again_is_gone_in_that_frame() {
    let (mut app, _) = many();
    draw(&mut app, |gizmos| (gizmos.leaves, gizmos.nodes) = (true, true));
    assert!(!is_blank(&app));
    draw(&mut app, |gizmos| (gizmos.leaves, gizmos.nodes) = (false, false));
    assert!(is_blank(&app));
    assert_eq!(stats(&app), SightlineGizmoStats::default());
}

#[test]
fn a_configuration_that_is_not_enabled_draws_nothing() {
    let (mut app, cubes) = many();
    app.world_mut().entity_mut(cubes[0]).insert(ShowGizmos::default());
    draw(&mut app, |gizmos| gizmos.leaves = true);
    let mut store = app.world_mut().resource_mut::<GizmoConfigStore>();
    store.config_mut::<SightlineGizmos>().0.enabled = false;
    app.update();
    assert!(is_blank(&app));
    assert_eq!(stats(&app), SightlineGizmoStats::default());
}
