//! What is NaN or infinite is not drawn, and the rest is.

use bevy::{
    gizmos::{config::DefaultGizmoConfigGroup, gizmos::GizmoBuffer},
    math::{Affine3A, primitives::ViewFrustum},
};
use bevy_sightline::{
    geometry::volume::AnyVolume,
    spatial::{AabbTree, SpatialUpdates},
};

use super::*;

fn switch_all_on(gizmos: &mut SightlineGizmos) {
    (gizmos.nodes, gizmos.cells, gizmos.leaves, gizmos.frusta) = (true, true, true, true);
    (gizmos.occluders, gizmos.rays, gizmos.lods) = (true, true, true);
    gizmos.volumes = Some(BoundingKind::Hull);
}

fn assert_finite(app: &App) {
    assert!(lines(app).iter().flatten().all(|point| point.is_finite()));
}

#[test]
fn an_entity_that_is_nowhere_is_not_drawn() {
    for place in [Vec3::NAN, Vec3::INFINITY] {
        let (mut app, cubes) = app_with_cubes([10.0]);
        let bad = spawn_cube(&mut app, place);
        let mesh = add_mesh(&mut app, Cuboid::default());
        let lod = ProxyLod::new(LodMetric::Distance, mesh.clone()).then(20.0, mesh);
        app.world_mut()
            .entity_mut(bad)
            .insert((lod, Occluder::Box, ShowGizmos::default()));
        draw(&mut app, switch_all_on);
        app.update();
        assert_eq!(stats(&app).leaves, count(1, 0));
        assert_eq!(stats(&app).lods, count(0, 0));
        assert_eq!(stats(&app).entities.drawn, 0);
        assert_finite(&app);
        draw(&mut app, |gizmos| {
            *gizmos = SightlineGizmos {
                leaves: true,
                ..default()
            };
        });
        assert_eq!(boxes(&app), world_boxes(&app, &cubes));
    }
}

#[test]
fn a_camera_that_is_nowhere_sees_nothing() {
    let (mut app, _) = app_with_cubes([10.0]);
    let camera = camera(&mut app);
    app.world_mut()
        .entity_mut(camera)
        .insert((Transform::from_translation(Vec3::NAN), ShowGizmos::default()));
    draw(&mut app, switch_all_on);
    assert!(is_blank(&app));
    assert_eq!(stats(&app).frusta, count(0, 1));
}

#[test]
fn a_ray_that_is_nowhere_is_not_drawn() {
    let mut buffer = GizmoBuffer::<DefaultGizmoConfigGroup, ()>::default();
    buffer.ray_hit(Ray3d::new(Vec3::NAN, Dir3::X), None);
    buffer.ray_hit(Ray3d::new(Vec3::splat(f32::MAX), Dir3::X), None);
    assert!(buffer.list_positions.iter().all(|point| point.is_finite()));
    assert!(buffer.list_positions.len() <= 2);
}

#[test]
fn a_volume_that_is_put_nowhere_is_not_drawn() {
    let mut buffer = GizmoBuffer::<DefaultGizmoConfigGroup, ()>::default();
    let aabb = Aabb3d::new(Vec3::ZERO, Vec3::ONE);
    for kind in [
        BoundingKind::Aabb,
        BoundingKind::Sphere,
        BoundingKind::Obb,
        BoundingKind::Hull,
    ] {
        let points = [aabb.min, aabb.max, aabb.min.with_x(1.0), aabb.min.with_y(1.0)];
        let volume: AnyVolume = kind.enclosing(points).expect("finite points");
        buffer.bounding_volume(&volume, &Affine3A::from_translation(Vec3::NAN), Color::WHITE);
    }
    assert!(buffer.list_positions.is_empty());
}

#[test]
fn a_style_that_makes_no_sense_does_no_harm() {
    let mut tree = AabbTree::new();
    tree.insert_many((0..20).map(|key| (key, Aabb3d::new(Vec3::X * key as f32, Vec3::ONE))));
    let nowhere = ViewFrustum::from_clip_from_world(&Mat4::from_cols_array(&[f32::NAN; 16]));
    let style = StructureStyle {
        nearest_to: Some(Vec3::NAN),
        within: Some(nowhere),
        ..default()
    };
    let mut buffer = GizmoBuffer::<DefaultGizmoConfigGroup, ()>::default();
    buffer.aabb_tree(&tree, &style);
    assert!(buffer.list_positions.iter().all(|point| point.is_finite()));
    #[expect(clippy::reversed_empty_ranges, reason = "there are no such depths")]
    let nothing = StructureStyle {
        depths: 3..=1,
        ..default()
    };
    assert_eq!(buffer.aabb_tree(&tree, &nothing), count(0, 0));
}
