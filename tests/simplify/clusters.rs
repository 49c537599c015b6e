//! Proxies of blocks.

use bevy::{
    mesh::{VertexAttributeValues, morph::MeshMorphWeights, skinning::SkinnedMesh},
    prelude::*,
};
use bevy_sightline::{lod::simplify::ClusterMaterials, mesh::TriangleMesh, prelude::*};

use crate::{
    auto_proxy::{Told, app, finish_proxies, progress},
    common::{add_mesh, spawn_mesh},
};

/// What parts are made of.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Paint {
    Red,
    Blue,
}

fn fine_box() -> Mesh {
    // Cut up, so that there is something to simplify.
    let mut mesh = Mesh::from(Cuboid::default());
    let side = Mesh::from(Plane3d::default().mesh().size(1.0, 1.0).subdivisions(3));
    let sides = [
        Transform::from_xyz(0.0, 0.5, 0.0),
        Transform::from_xyz(0.0, -0.5, 0.0).with_rotation(Quat::from_rotation_x(std::f32::consts::PI)),
        Transform::from_xyz(0.5, 0.0, 0.0).with_rotation(Quat::from_rotation_z(-std::f32::consts::FRAC_PI_2)),
        Transform::from_xyz(-0.5, 0.0, 0.0).with_rotation(Quat::from_rotation_z(std::f32::consts::FRAC_PI_2)),
        Transform::from_xyz(0.0, 0.0, 0.5).with_rotation(Quat::from_rotation_x(std::f32::consts::FRAC_PI_2)),
        Transform::from_xyz(0.0, 0.0, -0.5).with_rotation(Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2)),
    ];
    for (number, place) in sides.into_iter().enumerate() {
        let side = side.clone().transformed_by(place);
        if number == 0 {
            mesh = side;
        } else {
            mesh.merge(&side).expect("they are alike");
        }
    }
    mesh
}

/// A root that asks for a proxy, at a place that is not the origin.
fn spawn_root(app: &mut App) -> Entity {
    let place = Transform::from_xyz(100.0, -3.0, 7.0).with_scale(Vec3::splat(2.0));
    let proxy = ClusterProxy::new(SimplifyTarget::Error(0.001));
    app.world_mut().spawn((place, Visibility::default(), proxy)).id()
}

fn spawn_part(app: &mut App, parent: Entity, mesh: Mesh, place: Transform) -> Entity {
    let part = spawn_mesh(app, mesh, place);
    app.world_mut().entity_mut(part).insert(ChildOf(parent));
    part
}

fn level(app: &App, root: Entity, number: usize) -> Vec<Entity> {
    let lod = app.world().get::<ProxyLod>(root).expect("it has levels");
    match &lod.levels[number].content {
        LodContent::Entities(entities) => entities.clone(),
        other => panic!("{other:?} are no entities"),
    }
}

fn mesh_of(app: &App, entity: Entity) -> &Mesh {
    let mesh = app.world().get::<Mesh3d>(entity).expect("it has a mesh");
    app.world().resource::<Assets<Mesh>>().get(mesh).expect("it is there")
}

fn volume(mesh: &Mesh) -> f32 {
    let mesh = TriangleMesh::from_mesh(mesh).expect("a usable mesh");
    mesh.corners_of_all().map(|[a, b, c]| a.dot(b.cross(c))).sum::<f32>() / 6.0
}

#[test]
fn a_block_becomes_one_proxy_in_the_space_of_its_root() {
    let mut app = app();
    let root = spawn_root(&mut app);
    let first = spawn_part(&mut app, root, fine_box(), Transform::from_xyz(1.0, 0.0, 0.0));
    let second = spawn_part(&mut app, root, fine_box(), Transform::from_xyz(4.0, 0.0, 0.0));
    let on_top = spawn_part(&mut app, second, fine_box(), Transform::from_xyz(0.0, 1.0, 0.0));
    finish_proxies(&mut app);
    assert_eq!(level(&app, root, 0), [first, second]);
    let proxies = level(&app, root, 1);
    let [proxy] = proxies[..] else { panic!("one mesh") };
    assert_eq!(app.world().get::<ChildOf>(proxy).map(ChildOf::parent), Some(root));
    let mesh = mesh_of(&app, proxy);
    assert!((volume(mesh) - 3.0).abs() < 0.01, "{}", volume(mesh));
    let aabb = TriangleMesh::from_mesh(mesh).expect("a usable mesh").aabb();
    let [min, max] = [aabb.min, aabb.max].map(Vec3::from);
    assert!(min.abs_diff_eq(Vec3::new(0.5, -0.5, -0.5), 1e-5) && max.abs_diff_eq(Vec3::new(4.5, 1.5, 0.5), 1e-5));
    assert!(app.world().get::<Mesh3d>(on_top).is_some());
    let lod = app.world().get::<ProxyLod>(root).expect("it has levels");
    assert_eq!(lod.metric, LodMetric::ONE_PIXEL);
    assert!((0.0..=0.004).contains(&lod.levels[1].threshold) && lod.levels[1].threshold > 0.0);
    let ready = &app.world().resource::<Told>().ready;
    assert_eq!(
        *ready,
        [ProxyReady {
            entity: root,
            levels: 2
        }]
    );
    assert_eq!((progress(&app).total, progress(&app).done), (1, 1));
}

#[test]
fn parts_of_two_materials_become_two_proxies_that_have_them() {
    let mut app = app();
    app.world_mut().resource_mut::<ClusterMaterials>().add::<Paint>();
    let root = spawn_root(&mut app);
    for (number, paint) in [Paint::Red, Paint::Blue, Paint::Red].into_iter().enumerate() {
        let part = spawn_part(
            &mut app,
            root,
            fine_box(),
            Transform::from_xyz(2.0 * number as f32, 0.0, 0.0),
        );
        app.world_mut().entity_mut(part).insert(paint);
    }
    finish_proxies(&mut app);
    let proxies = level(&app, root, 1);
    let mut found: Vec<(Paint, i32)> = proxies
        .iter()
        .map(|&proxy| {
            let paint = *app.world().get::<Paint>(proxy).expect("it is painted");
            (paint, (volume(mesh_of(&app, proxy)) * 10.0).round() as i32)
        })
        .collect();
    found.sort_unstable();
    assert_eq!(found, [(Paint::Red, 20), (Paint::Blue, 10)]);
}

#[test]
fn mirrored_parts_are_not_turned_inside_out() {
    let mut app = app();
    let root = spawn_root(&mut app);
    let mirrored = Transform::from_xyz(3.0, 0.0, 0.0).with_scale(Vec3::new(-1.0, 1.0, 1.0));
    let part = spawn_part(&mut app, root, fine_box(), mirrored);
    spawn_part(
        &mut app,
        part,
        fine_box(),
        Transform::from_xyz(2.0, 0.0, 0.0).with_scale(Vec3::splat(-1.0)),
    );
    finish_proxies(&mut app);
    let proxies = level(&app, root, 1);
    assert!((volume(mesh_of(&app, proxies[0])) - 2.0).abs() < 0.01);
}

#[test]
fn what_moves_by_joints_or_weights_is_left_out_and_stays_shown() {
    let mut app = app();
    let root = spawn_root(&mut app);
    let wall = spawn_part(&mut app, root, fine_box(), Transform::default());
    let skinned = spawn_part(&mut app, root, fine_box(), Transform::from_xyz(5.0, 0.0, 0.0));
    app.world_mut().entity_mut(skinned).insert(SkinnedMesh::default());
    let morphed = spawn_part(&mut app, root, fine_box(), Transform::from_xyz(9.0, 0.0, 0.0));
    app.world_mut()
        .entity_mut(morphed)
        .insert(MeshMorphWeights::Reference(morphed));
    let hidden = spawn_part(&mut app, root, fine_box(), Transform::from_xyz(12.0, 0.0, 0.0));
    app.world_mut().entity_mut(hidden).insert(Visibility::Hidden);
    finish_proxies(&mut app);
    assert_eq!(level(&app, root, 0), [wall]);
    assert!((volume(mesh_of(&app, level(&app, root, 1)[0])) - 1.0).abs() < 0.01);
}

#[test]
fn of_a_part_with_levels_the_finest_is_merged() {
    let mut app = app();
    let root = spawn_root(&mut app);
    let sphere = Mesh::from(Sphere::new(1.0));
    let (fine, coarse) = (add_mesh(&mut app, fine_box()), add_mesh(&mut app, sphere.clone()));
    let group = ProxyLod::new(LodMetric::Height, fine).then(0.1, coarse.clone());
    let part = app
        .world_mut()
        .spawn((Mesh3d(coarse), Transform::default(), ChildOf(root), group))
        .id();
    let near = spawn_part(&mut app, root, fine_box(), Transform::from_xyz(3.0, 0.0, 0.0));
    let far = spawn_part(&mut app, near, sphere, Transform::default());
    let group = ProxyLod::new(LodMetric::Height, Vec::new()).then(0.1, far);
    app.world_mut().entity_mut(near).insert(group);
    finish_proxies(&mut app);
    assert_eq!(level(&app, root, 0), [part, near]);
    assert!((volume(mesh_of(&app, level(&app, root, 1)[0])) - 2.0).abs() < 0.01);
}

#[test]
fn a_block_waits_for_all_of_its_meshes() {
    let mut app = app();
    let root = spawn_root(&mut app);
    spawn_part(&mut app, root, fine_box(), Transform::default());
    let late = app.world().resource::<Assets<Mesh>>().reserve_handle();
    app.world_mut()
        .spawn((Mesh3d(late.clone()), Transform::from_xyz(3.0, 0.0, 0.0), ChildOf(root)));
    for _ in 0..5 {
        app.update();
    }
    assert_eq!(progress(&app).waiting, 1);
    let inserted = app.world_mut().resource_mut::<Assets<Mesh>>().insert(&late, fine_box());
    inserted.expect("the handle is good");
    finish_proxies(&mut app);
    assert!((volume(mesh_of(&app, level(&app, root, 1)[0])) - 2.0).abs() < 0.01);
}

#[test]
fn a_block_that_is_asked_for_once_more_has_only_the_new_proxy() {
    let mut app = app();
    let root = spawn_root(&mut app);
    spawn_part(&mut app, root, fine_box(), Transform::default());
    finish_proxies(&mut app);
    let first = level(&app, root, 1)[0];
    app.world_mut().entity_mut(root).remove::<ClusterProxy>();
    app.update();
    assert_eq!(progress(&app).total, 0);
    let added = spawn_part(&mut app, root, fine_box(), Transform::from_xyz(3.0, 0.0, 0.0));
    app.world_mut()
        .entity_mut(root)
        .insert(ClusterProxy::new(SimplifyTarget::Error(0.001)));
    finish_proxies(&mut app);
    assert!(app.world().get_entity(first).is_err());
    assert!(level(&app, root, 0).contains(&added));
    let proxies = level(&app, root, 1);
    assert_eq!(proxies.len(), 1);
    assert!((volume(mesh_of(&app, proxies[0])) - 2.0).abs() < 0.01);
}

#[test]
fn a_block_that_is_despawned_is_not_waited_for() {
    let mut app = app();
    let root = spawn_root(&mut app);
    spawn_part(&mut app, root, fine_box(), Transform::default());
    app.update();
    app.world_mut().despawn(root);
    app.update();
    assert_eq!(progress(&app).total, 0);
}

#[test]
fn a_block_of_nothing_but_lines_fails_and_stays() {
    let mut app = app();
    let root = spawn_root(&mut app);
    let lines = Mesh::new(bevy::mesh::PrimitiveTopology::LineList, default()).with_inserted_attribute(
        Mesh::ATTRIBUTE_POSITION,
        VertexAttributeValues::Float32x3(vec![[0.0; 3]; 2]),
    );
    spawn_part(&mut app, root, lines, Transform::default());
    finish_proxies(&mut app);
    assert!(app.world().get::<ProxyLod>(root).is_none());
    assert_eq!(app.world().resource::<Told>().failed.len(), 1);
}
