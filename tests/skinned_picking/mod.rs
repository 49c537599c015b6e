//! Skinned and morphed meshes are found and hit where they are drawn.

mod models;
mod reference;
pub mod rig;

use bevy::{
    math::{
        Vec3A,
        bounding::{Aabb3d, BoundingVolume},
    },
    mesh::{
        morph::{MeshMorphWeights, MorphAttributes, MorphWeights},
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    picking::mesh_picking::ray_cast::SimplifiedMesh,
    prelude::*,
};
use bevy_sightline::{
    geometry::tolerance,
    index::{PosedMeshes, PosingStats, Refusal, SyncStats},
    prelude::*,
};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use crate::common::{
    add_mesh, cast, headless_app, index, query, random_dir, random_point, ray_towards, rng, settle, spawn_mesh,
};
use reference::{Reference, bounds};
use rig::*;

fn both_sides() -> SceneQuerySettings<'static> {
    SceneQuerySettings::default().with_backfaces(Backfaces::Include)
}

fn stats(app: &App) -> PosingStats {
    app.world().resource::<PosedMeshes>().stats()
}

fn refusal(app: &App, entity: Entity) -> Option<Refusal> {
    let mut refused = index(app).refused();
    refused.find(|(refused, _)| *refused == entity).map(|(_, why)| why)
}

/// What a ray straight down from high above `x`, `z` hits.
fn look_down(app: &mut App, x: f32, z: f32) -> Option<RayHit> {
    cast(app, Ray3d::new(Vec3::new(x, 100.0, z), Dir3::NEG_Y))
}

/// Checks every vertex, the world box, and random rays.
fn assert_is_hit_where_it_is_drawn(app: &mut App, entity: Entity, rng: &mut ChaCha8Rng, rays: usize) {
    let reference = Reference::of(app, entity);
    let aabb = index(app).aabb(entity).expect("it is in the index");
    query(app, |scene| {
        for (number, expected) in reference.triangles.iter().enumerate() {
            let corners = scene.triangle(entity, number as u32).expect("such a triangle");
            for (corner, expected) in corners.into_iter().zip(expected) {
                let off = corner.as_dvec3().distance(*expected);
                assert!(off <= reference.slack, "{off:e} off, {:e} allowed", reference.slack);
                assert!(corner.cmpge(aabb.min.into()).all() && corner.cmple(aabb.max.into()).all());
            }
        }
        let past_the_end = reference.triangles.len() as u32;
        assert_eq!(scene.triangle(entity, past_the_end), None);
    });

    let (min, max) = bounds(&reference.triangles);
    let (middle, size) = (((min + max) / 2.0).as_vec3(), (max - min).length() as f32);
    for _ in 0..rays {
        let origin = middle + *random_dir(rng) * size;
        let ray = ray_towards(origin, middle + random_point(rng, 0.3 * size));
        let hit = query(app, |scene| {
            let hit = scene.cast_ray(ray, &both_sides());
            assert_eq!(scene.any_hit(ray, &both_sides()), hit.is_some());
            hit
        });
        assert!(hit.is_none_or(|hit| hit.entity == entity));
        reference.check(ray, hit.map(|hit| on_triangle(&hit)));
    }
}

/// The triangle that was hit, and its distance.
fn on_triangle(hit: &RayHit) -> (usize, f64) {
    let triangle = hit.triangle.expect("a mesh").index;
    (triangle as usize, hit.distance.into())
}

#[test]
fn vertices_and_hits_are_those_of_skinning_in_double_precision() {
    for seed in 0..6 {
        let rng = &mut rng(seed);
        let mut app = headless_app();
        let mesh = soup(rng, 60);
        let mesh = with_random_joints(mesh, rng, 5);
        let places = random_places(rng, 5);
        let bind_poses = random_places(rng, 5)
            .iter()
            .map(|place| place.to_matrix().inverse())
            .collect();
        let rig = spawn_bound_rig(&mut app, mesh, &places, bind_poses);
        settle(&mut app);
        assert_is_hit_where_it_is_drawn(&mut app, rig.entity, rng, 40);
    }
}

#[test]
fn more_than_256_joints_are_followed() {
    let rng = &mut rng(7);
    let mut app = headless_app();
    let mesh = soup(rng, 200);
    let mesh = with_random_joints(mesh, rng, 600);
    let places = random_places(rng, 600);
    let rig = spawn_rig(&mut app, mesh, &places);
    settle(&mut app);
    assert_is_hit_where_it_is_drawn(&mut app, rig.entity, rng, 40);
}

#[test]
fn weights_are_taken_as_they_are_whatever_their_sum() {
    let rng = &mut rng(8);
    let ranges = [(0.0, 0.2), (0.5, 1.5), (-1.0, 1.0), (-1.0, -0.1), (0.0, 1e-30)];
    for (least, greatest) in ranges {
        let mut app = headless_app();
        let mesh = with_joints(soup(rng, 40), |_| {
            let weights = [0; 4].map(|_| rng.random_range(least..greatest));
            ([0; 4].map(|_| rng.random_range(0..4)), weights)
        });
        let places = random_places(rng, 4);
        let rig = spawn_rig(&mut app, mesh, &places);
        settle(&mut app);
        assert_is_hit_where_it_is_drawn(&mut app, rig.entity, rng, if greatest < 1e-20 { 0 } else { 30 });
    }
}

#[test]
fn far_from_the_origin_the_box_still_holds_every_vertex() {
    let rng = &mut rng(9);
    for distance in [1e3, 1e5, 1e7] {
        let mut app = headless_app();
        let mesh = with_random_joints(soup(rng, 100), rng, 6);
        let bind_poses = random_places(rng, 6)
            .iter()
            .map(|place| place.to_matrix().inverse())
            .collect();
        let places: Vec<Transform> = random_places(rng, 6)
            .into_iter()
            .map(|place| place.with_translation(place.translation + Vec3::splat(distance)))
            .collect();
        let rig = spawn_bound_rig(&mut app, mesh, &places, bind_poses);
        settle(&mut app);
        assert_is_hit_where_it_is_drawn(&mut app, rig.entity, rng, 0);
    }
}

#[test]
fn morph_targets_displace_what_is_hit() {
    let rng = &mut rng(10);
    for targets in [1, 3, 80] {
        let mut app = headless_app();
        let mesh = with_random_targets(soup(rng, 60), rng, targets);
        let place = random_places(rng, 1)[0];
        let entity = spawn_mesh(&mut app, mesh, place);
        let weights = (0..targets).map(|_| rng.random_range(-1.0..1.0)).collect();
        app.world_mut()
            .entity_mut(entity)
            .insert(MeshMorphWeights::Value { weights });
        settle(&mut app);
        assert_is_hit_where_it_is_drawn(&mut app, entity, rng, 40);
    }
}

#[test]
fn morph_targets_and_joints_work_together() {
    let rng = &mut rng(11);
    let mut app = headless_app();
    let mesh = with_random_joints(soup(rng, 60), rng, 4);
    let mesh = with_random_targets(mesh, rng, 3);
    let places = random_places(rng, 4);
    let rig = spawn_rig(&mut app, mesh, &places);
    let weights = vec![0.5, 0.0, -0.7];
    app.world_mut()
        .entity_mut(rig.entity)
        .insert(MeshMorphWeights::Value { weights });
    settle(&mut app);
    assert_is_hit_where_it_is_drawn(&mut app, rig.entity, rng, 40);
}

#[test]
fn a_pose_is_followed_from_frame_to_frame() {
    let rng = &mut rng(12);
    let mut app = headless_app();
    let mesh = with_random_joints(soup(rng, 60), rng, 4);
    let mesh = with_random_targets(mesh, rng, 2);
    let places = random_places(rng, 4);
    let rig = spawn_rig(&mut app, mesh, &places);
    let holder = app
        .world_mut()
        .spawn(MorphWeights::new(vec![0.0; 2], None).expect("few"))
        .id();
    app.world_mut()
        .entity_mut(rig.entity)
        .insert(MeshMorphWeights::Reference(holder));
    settle(&mut app);
    for frame in 0..8 {
        if frame % 2 == 0 {
            let place = random_places(rng, 1)[0];
            move_joint(&mut app, rig.joints[frame / 2], place);
        } else {
            let mut weights = app.world_mut().get_mut::<MorphWeights>(holder).expect("weights");
            weights.weights_mut()[frame % 4 / 2] = rng.random_range(-1.0..1.0);
        }
        app.update();
        assert_eq!(app.world().resource::<SyncStats>().posed, 1);
        assert_is_hit_where_it_is_drawn(&mut app, rig.entity, rng, 20);
    }
}

#[test]
fn while_the_hierarchy_is_built_the_pose_is_hit_too() {
    let rng = &mut rng(13);
    let mut app = headless_app();
    let mesh = with_random_joints(soup(rng, 60), rng, 4);
    let places = random_places(rng, 4);
    let rig = spawn_rig(&mut app, mesh, &places);
    app.update();
    for joint in rig.joints.clone() {
        assert_is_hit_where_it_is_drawn(&mut app, rig.entity, rng, 10);
        let place = random_places(rng, 1)[0];
        move_joint(&mut app, joint, place);
        app.update();
    }
    settle(&mut app);
    assert_is_hit_where_it_is_drawn(&mut app, rig.entity, rng, 10);
}

#[test]
fn the_place_of_a_skinned_entity_itself_does_not_matter() {
    let mut app = headless_app();
    let rig = spawn_rig(
        &mut app,
        with_one_joint(square()),
        &[Transform::from_xyz(5.0, 0.0, 0.0)],
    );
    settle(&mut app);
    assert_eq!(look_down(&mut app, 5.0, 0.0).expect("a hit").entity, rig.entity);
    move_joint(
        &mut app,
        rig.entity,
        Transform::from_xyz(-5.0, 0.0, 0.0).with_scale(Vec3::ZERO),
    );
    app.update();
    assert!(look_down(&mut app, 5.0, 0.0).is_some());
    assert!(look_down(&mut app, -5.0, 0.0).is_none());
}

#[test]
fn a_skin_comes_and_goes() {
    let mut app = headless_app();
    let rig = spawn_rig(
        &mut app,
        with_one_joint(square()),
        &[Transform::from_xyz(5.0, 0.0, 0.0)],
    );
    settle(&mut app);
    let skin = app
        .world_mut()
        .entity_mut(rig.entity)
        .take::<SkinnedMesh>()
        .expect("a skin");
    app.update();
    assert!(app.world().resource::<PosedMeshes>().is_empty());
    assert!(look_down(&mut app, 5.0, 0.0).is_none());
    assert!(
        look_down(&mut app, 30.0, 0.0).is_some(),
        "without a skin it is where its entity is"
    );
    app.world_mut().entity_mut(rig.entity).insert(skin);
    app.update();
    assert!(look_down(&mut app, 5.0, 0.0).is_some());
    assert!(look_down(&mut app, 30.0, 0.0).is_none());
    app.world_mut().despawn(rig.entity);
    app.update();
    assert!(look_down(&mut app, 5.0, 0.0).is_none());
    assert!(app.world().resource::<PosedMeshes>().is_empty());
}

#[test]
fn a_joint_that_is_despawned_stays_where_it_was() {
    let mut app = headless_app();
    let rig = spawn_rig(
        &mut app,
        with_one_joint(square()),
        &[Transform::from_xyz(5.0, 0.0, 0.0)],
    );
    settle(&mut app);
    app.world_mut().despawn(rig.joints[0]);
    app.update();
    assert!(look_down(&mut app, 5.0, 0.0).is_some());
    let mut skin = app.world_mut().get_mut::<SkinnedMesh>(rig.entity).expect("a skin");
    skin.set_changed();
    app.update();
    assert!(
        look_down(&mut app, 0.0, 0.0).is_some(),
        "a new skin starts from the identity"
    );
}

#[test]
fn joints_that_the_skin_does_not_name_are_at_the_origin() {
    let mut app = headless_app();
    let mesh = with_joints(square(), |_| ([9; 4], [0.25; 4]));
    let rig = spawn_rig(&mut app, mesh, &[Transform::from_xyz(5.0, 0.0, 0.0)]);
    settle(&mut app);
    assert_eq!(look_down(&mut app, 0.0, 0.0).expect("a hit").entity, rig.entity);
}

#[test]
fn a_skin_on_a_mesh_without_joints_is_of_no_effect() {
    let mut app = headless_app();
    spawn_rig(&mut app, square(), &[Transform::from_xyz(5.0, 0.0, 0.0)]);
    settle(&mut app);
    assert!(look_down(&mut app, 30.0, 0.0).is_some());
    assert!(look_down(&mut app, 5.0, 0.0).is_none());
}

#[test]
fn inverse_bind_poses_are_followed() {
    let mut app = headless_app();
    let rig = spawn_rig(&mut app, with_one_joint(square()), &[Transform::IDENTITY]);
    settle(&mut app);
    assert!(look_down(&mut app, 0.0, 0.0).is_some());
    let id = app
        .world()
        .get::<SkinnedMesh>(rig.entity)
        .expect("a skin")
        .inverse_bindposes
        .id();
    let moved = vec![Mat4::from_translation(Vec3::X * 7.0)];
    let mut assets = app.world_mut().resource_mut::<Assets<SkinnedMeshInverseBindposes>>();
    assets.insert(id, moved.into()).expect("a live asset");
    app.update();
    app.update();
    assert!(look_down(&mut app, 7.0, 0.0).is_some());
    assert!(look_down(&mut app, 0.0, 0.0).is_none());
}

#[test]
fn a_mesh_that_is_exchanged_is_posed_like_the_first() {
    let rng = &mut rng(14);
    let mut app = headless_app();
    let mesh = with_random_joints(soup(rng, 30), rng, 4);
    let places = random_places(rng, 4);
    let rig = spawn_rig(&mut app, mesh, &places);
    settle(&mut app);
    assert_is_hit_where_it_is_drawn(&mut app, rig.entity, rng, 10);

    let other = with_random_joints(soup(rng, 50), rng, 4);
    let id = app.world().get::<Mesh3d>(rig.entity).expect("a mesh").0.id();
    app.world_mut()
        .resource_mut::<Assets<Mesh>>()
        .insert(id, other)
        .expect("a live asset");
    app.update();
    settle(&mut app);
    assert_is_hit_where_it_is_drawn(&mut app, rig.entity, rng, 10);

    let other = with_random_joints(soup(rng, 20), rng, 4);
    let other = add_mesh(&mut app, other);
    app.world_mut().get_mut::<Mesh3d>(rig.entity).expect("a mesh").0 = other;
    settle(&mut app);
    assert_is_hit_where_it_is_drawn(&mut app, rig.entity, rng, 10);
}

#[test]
fn bad_poses_leave_the_entity_out_until_they_are_good() {
    let mut app = headless_app();
    let good = Transform::from_xyz(5.0, 0.0, 0.0);
    let rig = spawn_rig(&mut app, with_one_joint(square()), &[good]);
    settle(&mut app);
    for (bad, why) in [
        (Transform::from_xyz(f32::NAN, 0.0, 0.0), Refusal::Pose),
        (Transform::from_xyz(0.0, f32::INFINITY, 0.0), Refusal::Pose),
        (
            Transform::from_scale(Vec3::splat(f32::MAX)).with_translation(Vec3::splat(f32::MAX)),
            Refusal::WorldBounds,
        ),
    ] {
        move_joint(&mut app, rig.joints[0], bad);
        app.update();
        assert_eq!(refusal(&app, rig.entity), Some(why));
        assert!(look_down(&mut app, 5.0, 0.0).is_none());
        app.update();
        assert_eq!(refusal(&app, rig.entity), Some(why));
        move_joint(&mut app, rig.joints[0], good);
        app.update();
        assert_eq!(refusal(&app, rig.entity), None);
        assert!(look_down(&mut app, 5.0, 0.0).is_some());
    }
}

#[test]
fn bad_morph_weights_leave_the_entity_out_until_they_are_good() {
    let mut app = headless_app();
    let up = MorphAttributes::new(Vec3::Y, Vec3::ZERO, Vec3::ZERO);
    let mesh = square();
    let targets = vec![up; mesh.count_vertices()];
    let entity = spawn_mesh(&mut app, mesh.with_morph_targets(targets), Transform::default());
    let set = |app: &mut App, weight: f32| {
        let weights = MeshMorphWeights::Value { weights: vec![weight] };
        app.world_mut().entity_mut(entity).insert(weights);
        app.update();
    };
    set(&mut app, f32::NAN);
    assert_eq!(refusal(&app, entity), Some(Refusal::Pose));
    set(&mut app, 2.0);
    assert_eq!(refusal(&app, entity), None);
    assert_eq!(look_down(&mut app, 0.1, 0.2).expect("a hit").position.y, 2.0);
}

#[test]
fn bad_joint_weights_and_targets_of_a_mesh_leave_its_entities_out() {
    let mut app = headless_app();
    let nan = with_joints(square(), |vertex| {
        ([0; 4], [if vertex == 2 { f32::NAN } else { 1.0 }, 0.0, 0.0, 0.0])
    });
    let nan = spawn_rig(&mut app, nan, &[Transform::IDENTITY]);
    let flat = MorphAttributes::new(Vec3::INFINITY, Vec3::ZERO, Vec3::ZERO);
    let mesh = square();
    let targets = vec![flat; mesh.count_vertices()];
    let infinite = spawn_mesh(&mut app, mesh.with_morph_targets(targets), Transform::default());
    let weights = MeshMorphWeights::Value { weights: vec![0.0] };
    app.world_mut().entity_mut(infinite).insert(weights);
    settle(&mut app);
    assert_eq!(refusal(&app, nan.entity), Some(Refusal::Pose));
    assert_eq!(refusal(&app, infinite), Some(Refusal::Pose));
}

#[test]
fn hidden_skinned_meshes_are_passed_over_like_others() {
    let mut app = headless_app();
    let rig = spawn_rig(&mut app, with_one_joint(square()), &[Transform::IDENTITY]);
    app.world_mut().entity_mut(rig.entity).insert(Visibility::Hidden);
    settle(&mut app);
    assert!(look_down(&mut app, 0.0, 0.0).is_none());
    let any = SceneQuerySettings::default().with_visibility(QueryVisibility::Any);
    let ray = Ray3d::new(Vec3::Y, Dir3::NEG_Y);
    assert!(query(&mut app, |scene| scene.cast_ray(ray, &any)).is_some());
}

#[test]
fn normals_turn_with_the_joints_by_the_inverse_transpose() {
    let mut app = headless_app();
    let squeezed = Transform::from_rotation(Quat::from_rotation_z(0.5)).with_scale(Vec3::new(3.0, 0.5, 1.0));
    let tilted = square().rotated_by(Quat::from_rotation_z(0.4));
    let expected = (squeezed.to_matrix().inverse().transpose() * (Quat::from_rotation_z(0.4) * Vec3::Y).extend(0.0))
        .truncate()
        .normalize();
    spawn_rig(&mut app, with_one_joint(tilted), &[squeezed]);
    settle(&mut app);
    let hit = look_down(&mut app, 0.1, 0.1).expect("a hit");
    assert!(
        hit.normal.abs_diff_eq(expected, 1e-5),
        "{} is not {expected}",
        hit.normal
    );
}

#[test]
fn morph_targets_turn_normals_too() {
    let mut app = headless_app();
    let mesh = square();
    let lean = MorphAttributes::new(Vec3::ZERO, Vec3::X, Vec3::ZERO);
    let targets = vec![lean; mesh.count_vertices()];
    let entity = spawn_mesh(&mut app, mesh.with_morph_targets(targets), Transform::default());
    let weights = MeshMorphWeights::Value { weights: vec![1.0] };
    app.world_mut().entity_mut(entity).insert(weights);
    settle(&mut app);
    let hit = look_down(&mut app, 0.1, 0.1).expect("a hit");
    assert!(hit.normal.abs_diff_eq(Vec3::new(1.0, 1.0, 0.0).normalize(), 1e-6));
}

#[test]
fn a_mirrored_joint_turns_front_faces_into_back_faces() {
    let mut app = headless_app();
    let mirrored = Transform::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    let rig = spawn_rig(&mut app, with_one_joint(square()), &[mirrored]);
    settle(&mut app);
    assert!(look_down(&mut app, 0.1, 0.1).is_none());
    let from_below = Ray3d::new(Vec3::new(0.1, -9.0, 0.1), Dir3::Y);
    assert_eq!(cast(&mut app, from_below).expect("a hit").entity, rig.entity);
}

#[test]
fn the_simplified_mesh_is_posed_if_it_has_joints() {
    let mut app = headless_app();
    let rig = spawn_rig(
        &mut app,
        with_one_joint(square()),
        &[Transform::from_xyz(5.0, 0.0, 0.0)],
    );
    let simple = add_mesh(&mut app, with_one_joint(square().scaled_by(Vec3::splat(3.0))));
    app.world_mut().entity_mut(rig.entity).insert(SimplifiedMesh(simple));
    settle(&mut app);
    assert!(look_down(&mut app, 6.2, 0.0).is_some());
    let rigid = add_mesh(&mut app, square());
    app.world_mut().entity_mut(rig.entity).insert(SimplifiedMesh(rigid));
    settle(&mut app);
    assert!(look_down(&mut app, 5.0, 0.0).is_none());
    assert!(look_down(&mut app, 30.0, 0.0).is_some());
}

/// A row of skinned cubes, three apart.
fn row(app: &mut App, count: usize) -> Vec<Rig> {
    (0..count)
        .map(|i| {
            let place = Transform::from_xyz(3.0 * i as f32, 0.0, 0.0);
            spawn_rig(app, with_one_joint(Cuboid::default().into()), &[place])
        })
        .collect()
}

#[test]
fn only_what_a_ray_comes_near_is_posed_and_once_per_pose() {
    let mut app = headless_app();
    let rigs = row(&mut app, 50);
    settle(&mut app);
    assert_eq!(stats(&app).meshes, 0);

    assert!(look_down(&mut app, 30.0, 0.0).is_some());
    assert!(look_down(&mut app, 30.2, 0.1).is_some());
    assert!(look_down(&mut app, 31.5, 0.0).is_none());
    app.update();
    assert!(look_down(&mut app, 30.0, 0.0).is_some());
    assert_eq!((stats(&app).meshes, stats(&app).vertices), (1, 24));

    for (i, rig) in rigs.iter().enumerate() {
        move_joint(&mut app, rig.joints[0], Transform::from_xyz(3.0 * i as f32, 0.5, 0.0));
    }
    app.update();
    assert_eq!(app.world().resource::<SyncStats>().posed, 50);
    assert_eq!(stats(&app).meshes, 1);
    assert_eq!(look_down(&mut app, 30.0, 0.0).expect("a hit").position.y, 1.0);
    assert_eq!(stats(&app).meshes, 2);
}

#[test]
fn a_mesh_is_posed_once_however_many_threads_ask() {
    let mut app = headless_app();
    row(&mut app, 3);
    settle(&mut app);
    let rays: Vec<Ray3d> = (0..4000)
        .map(|i| Ray3d::new(Vec3::new((i % 3) as f32 * 3.0, 9.0, i as f32 / 9000.0), Dir3::NEG_Y))
        .collect();
    query(&mut app, |scene| {
        let mut hits = Vec::new();
        scene.cast_rays(&rays, &SceneQuerySettings::default(), &mut hits);
        assert_eq!(hits.iter().flatten().count(), rays.len());
    });
    assert_eq!(stats(&app).meshes, 3);
}

#[test]
fn a_pose_that_does_not_change_is_left_alone() {
    let mut app = headless_app();
    let rigs = row(&mut app, 5);
    settle(&mut app);
    app.update();
    let stats = *app.world().resource::<SyncStats>();
    assert_eq!((stats.moved, stats.reconciled, stats.posed), (0, 0, 0));
    // To the same place.
    move_joint(&mut app, rigs[0].joints[0], Transform::IDENTITY);
    app.update();
    assert_eq!(app.world().resource::<SyncStats>().posed, 0);
}

#[test]
fn posed_copies_are_freed_when_nobody_asks() {
    let mut app = headless_app();
    app.world_mut().resource_mut::<SpatialIndexSettings>().posed_meshes_kept = 3;
    let rigs = row(&mut app, 5);
    settle(&mut app);
    let copies = |app: &App| app.world().resource::<PosedMeshes>().copies();
    assert_eq!(copies(&app), 0);
    look_down(&mut app, 3.0, 0.0).expect("a hit");
    look_down(&mut app, 6.0, 0.0).expect("a hit");
    for frame in 0..8 {
        move_joint(
            &mut app,
            rigs[2].joints[0],
            Transform::from_xyz(6.0, 0.1 * frame as f32, 0.0),
        );
        app.update();
        look_down(&mut app, 6.0, 0.0).expect("a hit");
    }
    assert_eq!(copies(&app), 1, "the one that is asked for");
    look_down(&mut app, 3.0, 0.0).expect("a hit");
    assert_eq!(copies(&app), 2);
}

#[test]
fn meshes_touch_where_they_are_posed() {
    let mut app = headless_app();
    let rigs = row(&mut app, 2);
    settle(&mut app);
    let touching = |app: &mut App| {
        query(app, |scene| {
            let mut touching = Vec::new();
            scene.touching_meshes(rigs[0].entity, &SceneQuerySettings::default(), &mut touching);
            assert_eq!(scene.meshes_touch(rigs[0].entity, rigs[1].entity), !touching.is_empty());
            touching
        })
    };
    assert_eq!(touching(&mut app), []);
    move_joint(&mut app, rigs[1].joints[0], Transform::from_xyz(0.3, 0.4, 0.5));
    app.update();
    assert_eq!(touching(&mut app), [rigs[1].entity]);
}

#[test]
fn boxes_are_found_where_the_pose_is() {
    let mut app = headless_app();
    let rig = spawn_rig(
        &mut app,
        with_one_joint(Cuboid::default().into()),
        &[Transform::from_xyz(5.0, 0.0, 0.0)],
    );
    settle(&mut app);
    let aabb = index(&app).aabb(rig.entity).expect("in the index");
    // As much looser as coordinates of up to 5.5 may round.
    let slack = 6.0 * (tolerance::POSED_BOX + tolerance::TRIANGLE_BOX);
    assert!(aabb.center().abs_diff_eq(Vec3A::X * 5.0, slack) && aabb.half_size().abs_diff_eq(Vec3A::splat(0.5), slack));
    query(&mut app, |scene| {
        let mut found = Vec::new();
        scene.overlap(
            &Aabb3d::new(Vec3::X * 5.0, Vec3::splat(0.1)),
            &SceneQuerySettings::default(),
            &mut found,
        );
        assert_eq!(found, [rig.entity]);
        scene.overlap(
            &Aabb3d::new(Vec3::X * 30.0, Vec3::splat(5.0)),
            &SceneQuerySettings::default(),
            &mut found,
        );
        assert_eq!(found, []);
    });
}

#[test]
fn triangles_of_unposed_meshes_can_be_looked_up_too() {
    let mut app = headless_app();
    let place = Transform::from_xyz(1.0, 2.0, 3.0);
    let entity = spawn_mesh(&mut app, Cuboid::default(), place);
    settle(&mut app);
    let hit = look_down(&mut app, 1.1, 3.2).expect("a hit");
    let triangle = hit.triangle.expect("a mesh");
    query(&mut app, |scene| {
        assert_eq!(scene.triangle(entity, triangle.index), Some(triangle.vertices));
        assert_eq!(scene.triangle(entity, 12), None);
        assert_eq!(scene.triangle(Entity::PLACEHOLDER, 0), None);
    });
}
