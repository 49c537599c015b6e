//! The index agrees with the world after every `PostUpdate`.

use bevy::{
    asset::RenderAssetUsages,
    camera::{
        primitives::Aabb,
        visibility::{InheritedVisibility, NoAutoAabb, NoFrustumCulling, RenderLayers},
    },
    ecs::{entity_disabling::Disabled, query::Allow},
    math::{BVec3, DVec3, Vec3A, bounding::Aabb3d},
    mesh::PrimitiveTopology,
    picking::mesh_picking::ray_cast::{RayCastBackfaces, SimplifiedMesh},
    prelude::*,
};
use bevy_sightline::{
    geometry::ray::{Ray, triangle::Backfaces},
    index::{MeshBvhs, MeshStatus, NoSpatialIndex, Refusal, SyncStats},
    mesh::TriangleMesh,
    prelude::*,
    spatial::uniform_grid::{CellSize, GridSettings},
};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use crate::common::*;

/// Runs a frame, and compares the index with the world.
fn step(app: &mut App) {
    app.update();
    assert_agrees(app);
}

/// Compares the index with what a plain loop over the world computes.
fn assert_agrees(app: &mut App) {
    index(app).validate().expect("a whole index");
    let world = app.world_mut();
    let mut entities = world.query_filtered::<EntityRef, Allow<Disabled>>();
    let world = app.world();
    let index = index(app);
    let assets = world.get_resource::<Assets<Mesh>>();
    let (mut indexed, mut refused) = (0, 0);
    for entity in entities.iter(world) {
        let id = entity.id();
        match expected_bounds(entity, assets) {
            None => assert!(!index.contains(id), "{id} should not be in the index"),
            Some(Err(why)) => {
                assert!(!index.contains(id), "{id} should be refused");
                assert!(
                    index.refused().any(|refusal| refusal == (id, why)),
                    "{id} should be refused: {why}"
                );
                refused += 1;
            }
            Some(Ok(corners)) => {
                let aabb = index.aabb(id).unwrap_or_else(|| panic!("{id} should be in the index"));
                assert_contains_tightly(&aabb, &corners);
                indexed += 1;
            }
        }
    }
    assert_eq!(index.len(), indexed, "the index holds what is not in the world");
    assert_eq!(index.refused().len(), refused, "what is not in the world is refused");
}

/// The corners of the bounds of an entity in the world, if it should be in the index, or why it is refused.
fn expected_bounds(entity: EntityRef, assets: Option<&Assets<Mesh>>) -> Option<Result<Vec<DVec3>, Refusal>> {
    if entity.contains::<Disabled>() || entity.contains::<NoSpatialIndex>() {
        return None;
    }
    let transform = entity.get::<GlobalTransform>()?.affine();
    let of_mesh = mesh_of(entity)
        .and_then(|mesh| surface(assets?.get(mesh)?))
        .map(|mesh| mesh.aabb());
    let own = entity.get::<Aabb>();
    let has_mesh = mesh_of(entity).is_some();
    if own.is_none() && !has_mesh {
        return None;
    }
    if !transform.is_finite() {
        return Some(Err(Refusal::Transform));
    }
    let is_good = |aabb: &Aabb| {
        aabb.center.is_finite() && aabb.half_extents.is_finite() && aabb.half_extents.cmpge(Vec3A::ZERO).all()
    };
    if own.is_some_and(|own| !is_good(own)) {
        return Some(Err(Refusal::Bounds));
    }
    let asks_mesh = own.is_none() || entity.contains::<SimplifiedMesh>();
    let own = own.map(|own| {
        let (center, half) = (own.center.as_dvec3(), own.half_extents.as_dvec3());
        (center - half, center + half)
    });
    let of_mesh = of_mesh
        .filter(|_| asks_mesh)
        .map(|aabb| (aabb.min.as_dvec3(), aabb.max.as_dvec3()));
    let (min, max) = (own.into_iter().chain(of_mesh)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))?;
    let transform = transform.as_daffine3();
    let corner = |bits: u32| DVec3::select(BVec3::new(bits & 1 > 0, bits & 2 > 0, bits & 4 > 0), max, min);
    let world: Vec<DVec3> = (0..8).map(|bits| transform.transform_point3(corner(bits))).collect();
    let overflows = world
        .iter()
        .any(|corner| corner.abs().max_element() > f64::from(f32::MAX));
    Some(if overflows {
        Err(Refusal::WorldBounds)
    } else {
        Ok(world)
    })
}

/// The mesh that rays hit.
fn mesh_of(entity: EntityRef) -> Option<AssetId<Mesh>> {
    (entity.get::<SimplifiedMesh>().map(|mesh| mesh.0.id()))
        .or(entity.get::<Mesh3d>().map(|mesh| mesh.0.id()))
        .or(entity.get::<Mesh2d>().map(|mesh| mesh.0.id()))
}

fn surface(mesh: &Mesh) -> Option<TriangleMesh> {
    TriangleMesh::from_mesh(mesh).ok()
}

fn assert_contains_tightly(aabb: &Aabb3d, corners: &[DVec3]) {
    let min = corners.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let max = corners.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let (got_min, got_max) = (aabb.min.as_dvec3(), aabb.max.as_dvec3());
    assert!(
        got_min.cmple(min).all() && got_max.cmpge(max).all(),
        "{aabb:?} does not contain {min} {max}"
    );
    let slack = 2e-5 * (min.abs().max_element().max(max.abs().max_element()) + (max - min).max_element());
    assert!(
        (min - got_min).max_element() <= slack && (got_max - max).max_element() <= slack,
        "{aabb:?} is loose"
    );
}

/// An app with one cube at the origin.
fn app_with_cube() -> (App, Entity) {
    let mut app = headless_app();
    let cube = spawn_cube(&mut app, Vec3::ZERO);
    step(&mut app);
    assert!(is_hit(&mut app, cube, Vec3::ZERO));
    (app, cube)
}

/// Whether the nearest hit of a ray along -z through `position` is on `entity`.
fn is_hit(app: &mut App, entity: Entity, position: Vec3) -> bool {
    hit_at(app, position).is_some_and(|hit| hit.entity == entity)
}

fn is_indexed(app: &App, entity: Entity) -> bool {
    index(app).contains(entity)
}

fn refusal(app: &App, entity: Entity) -> Option<Refusal> {
    index(app)
        .refused()
        .find(|(refused, _)| *refused == entity)
        .map(|(_, why)| why)
}

fn bounds_of(app: &App, entity: Entity) -> [Vec3; 2] {
    let aabb = index(app).aabb(entity).expect("the entity is in the index");
    [aabb.min.into(), aabb.max.into()]
}

fn assert_bounds(app: &App, entity: Entity, min: Vec3, max: Vec3) {
    let [got_min, got_max] = bounds_of(app, entity);
    assert!(
        got_min.abs_diff_eq(min, 1e-4) && got_max.abs_diff_eq(max, 1e-4),
        "{got_min} {got_max}"
    );
}

fn insert(app: &mut App, entity: Entity, bundle: impl Bundle) {
    app.world_mut().entity_mut(entity).insert(bundle);
    step(app);
}

fn remove<B: Bundle>(app: &mut App, entity: Entity) {
    app.world_mut().entity_mut(entity).remove::<B>();
    step(app);
}

fn despawn(app: &mut App, entity: Entity) {
    app.world_mut().despawn(entity);
    step(app);
}

/// Puts another mesh in the place of an asset.
fn replace_mesh(app: &mut App, entity: Entity, mesh: impl Into<Mesh>) {
    let id = app.world().get::<Mesh3d>(entity).expect("a mesh entity").0.id();
    let world = app.world_mut();
    *world.resource_mut::<Assets<Mesh>>().get_mut(id).expect("a loaded mesh") = mesh.into();
    step(app);
}

fn status(app: &App, mesh: AssetId<Mesh>) -> Option<MeshStatus> {
    app.world().resource::<MeshBvhs>().status(mesh)
}

// --- Entities come, go and move ---

#[test]
fn a_spawned_entity_is_found_and_a_despawned_one_is_not() {
    let (mut app, cube) = app_with_cube();
    assert_eq!(index(&app).len(), 1);
    despawn(&mut app, cube);
    assert!(index(&app).is_empty());
    assert_eq!(hit_at(&mut app, Vec3::ZERO), None);
}

#[test]
fn an_entity_that_is_spawned_and_despawned_within_a_frame_is_not_found() {
    let mut app = headless_app();
    let cube = spawn_cube(&mut app, Vec3::ZERO);
    despawn(&mut app, cube);
    assert!(index(&app).is_empty());
}

#[test]
fn children_are_despawned_with_their_parent() {
    let (mut app, parent) = app_with_cube();
    let child = spawn_cube(&mut app, Vec3::X * 5.0);
    let grandchild = spawn_cube(&mut app, Vec3::X * 5.0);
    app.world_mut().entity_mut(parent).add_child(child);
    app.world_mut().entity_mut(child).add_child(grandchild);
    step(&mut app);
    assert_eq!(index(&app).len(), 3);
    despawn(&mut app, parent);
    assert!(index(&app).is_empty());
}

#[test]
fn a_moved_entity_is_found_where_it_is_and_not_where_it_was() {
    let (mut app, cube) = app_with_cube();
    insert(&mut app, cube, Transform::from_xyz(10.0, 0.0, 0.0));
    assert!(is_hit(&mut app, cube, Vec3::X * 10.0));
    assert_eq!(hit_at(&mut app, Vec3::ZERO), None);
}

#[test]
fn the_box_follows_rotation_and_scale() {
    let (mut app, cube) = app_with_cube();
    insert(&mut app, cube, Transform::from_scale(Vec3::new(4.0, 1.0, 2.0)));
    assert_bounds(&app, cube, Vec3::new(-2.0, -0.5, -1.0), Vec3::new(2.0, 0.5, 1.0));
    insert(
        &mut app,
        cube,
        Transform::from_rotation(Quat::from_rotation_z(std::f32::consts::FRAC_PI_4)),
    );
    let half = 0.5_f32.sqrt();
    assert_bounds(&app, cube, Vec3::new(-half, -half, -0.5), Vec3::new(half, half, 0.5));
}

#[test]
fn children_follow_their_parent() {
    let (mut app, parent) = app_with_cube();
    let child = spawn_cube(&mut app, Vec3::X * 3.0);
    insert(&mut app, child, ChildOf(parent));
    insert(&mut app, parent, Transform::from_xyz(0.0, 7.0, 0.0));
    assert!(is_hit(&mut app, child, Vec3::new(3.0, 7.0, 0.0)));
    assert_eq!(hit_at(&mut app, Vec3::X * 3.0), None);
}

#[test]
fn a_new_parent_moves_an_entity_and_its_removal_moves_it_back() {
    let (mut app, cube) = app_with_cube();
    let parent = app
        .world_mut()
        .spawn((Transform::from_xyz(0.0, 7.0, 0.0), Visibility::default()))
        .id();
    insert(&mut app, cube, ChildOf(parent));
    assert!(is_hit(&mut app, cube, Vec3::Y * 7.0));
    remove::<ChildOf>(&mut app, cube);
    assert!(is_hit(&mut app, cube, Vec3::ZERO));
}

#[test]
fn without_a_place_in_the_world_an_entity_is_not_found() {
    let (mut app, cube) = app_with_cube();
    remove::<GlobalTransform>(&mut app, cube);
    assert!(!is_indexed(&app, cube));
    insert(&mut app, cube, GlobalTransform::default());
    assert!(is_hit(&mut app, cube, Vec3::ZERO));
}

#[test]
fn without_a_transform_an_entity_stays_where_it_was() {
    let (mut app, cube) = app_with_cube();
    remove::<Transform>(&mut app, cube);
    assert!(is_hit(&mut app, cube, Vec3::ZERO));
}

#[test]
fn an_entity_without_bounds_is_not_in_the_index() {
    let mut app = headless_app();
    app.world_mut().spawn(Transform::default());
    step(&mut app);
    assert!(index(&app).is_empty());
}

#[test]
fn nothing_changes_where_nothing_has_changed() {
    let mut app = headless_app();
    let mut rng = rng(60);
    let cubes: Vec<Entity> = (0..50)
        .map(|_| spawn_cube(&mut app, random_point(&mut rng, 20.0)))
        .collect();
    settle(&mut app);
    let boxes = |app: &App| -> Vec<_> {
        cubes
            .iter()
            .map(|cube| bounds_of(app, *cube))
            .chain(index(app).bounds().map(|b| [b.min.into(), b.max.into()]))
            .collect()
    };
    let before = boxes(&app);
    for _ in 0..5 {
        step(&mut app);
    }
    assert_eq!(boxes(&app), before);
}

// --- Bounds ---

#[test]
fn without_its_mesh_an_entity_keeps_its_box_and_is_hit_by_no_ray() {
    let (mut app, cube) = app_with_cube();
    let mesh = app.world().get::<Mesh3d>(cube).expect("a mesh entity").clone();
    remove::<Mesh3d>(&mut app, cube);
    assert!(is_indexed(&app, cube), "Bevy leaves the Aabb");
    assert_eq!(hit_at(&mut app, Vec3::ZERO), None);
    insert(&mut app, cube, mesh);
    assert!(is_hit(&mut app, cube, Vec3::ZERO));
}

#[test]
fn without_mesh_and_box_an_entity_is_not_found() {
    let (mut app, cube) = app_with_cube();
    remove::<(Mesh3d, Aabb)>(&mut app, cube);
    assert!(!is_indexed(&app, cube));
}

#[test]
fn a_removed_box_is_computed_anew() {
    let (mut app, cube) = app_with_cube();
    app.world_mut()
        .entity_mut(cube)
        .insert(Aabb::from_min_max(Vec3::splat(-9.0), Vec3::splat(9.0)));
    step(&mut app);
    assert_bounds(&app, cube, Vec3::splat(-9.0), Vec3::splat(9.0));
    remove::<Aabb>(&mut app, cube);
    assert_bounds(&app, cube, Vec3::splat(-0.5), Vec3::splat(0.5));
}

#[test]
fn a_box_made_by_hand_counts() {
    let (mut app, cube) = app_with_cube();
    insert(
        &mut app,
        cube,
        (NoAutoAabb, Aabb::from_min_max(Vec3::splat(-2.0), Vec3::splat(3.0))),
    );
    assert_bounds(&app, cube, Vec3::splat(-2.0), Vec3::splat(3.0));
    insert(&mut app, cube, Aabb::from_min_max(Vec3::splat(-1.0), Vec3::splat(1.0)));
    assert_bounds(&app, cube, Vec3::splat(-1.0), Vec3::splat(1.0));
    remove::<Aabb>(&mut app, cube);
    assert_bounds(&app, cube, Vec3::splat(-0.5), Vec3::splat(0.5));
}

#[test]
fn an_entity_with_a_box_and_no_mesh_is_found_by_its_box_and_hit_by_no_ray() {
    let mut app = headless_app();
    let aabb = Aabb::from_min_max(Vec3::splat(-1.0), Vec3::splat(1.0));
    let zone = app.world_mut().spawn((aabb, Transform::from_xyz(5.0, 0.0, 0.0))).id();
    step(&mut app);
    assert_eq!(hit_at(&mut app, Vec3::X * 5.0), None);
    assert_eq!(overlapping(&mut app, Vec3::X * 5.0), [zone]);
    despawn(&mut app, zone);
    assert_eq!(overlapping(&mut app, Vec3::X * 5.0), []);
}

/// The entities whose box touches a small box around a point.
fn overlapping(app: &mut App, point: Vec3) -> Vec<Entity> {
    let mut found = Vec::new();
    query(app, |scene| {
        scene.overlap(
            &Aabb3d::new(point, Vec3::splat(0.1)),
            &SceneQuerySettings::default(),
            &mut found,
        );
        found
    })
}

#[test]
fn a_mesh_that_is_never_culled_is_bounded_by_its_mesh() {
    let mut app = headless_app();
    let mesh = add_mesh(&mut app, Cuboid::new(2.0, 4.0, 6.0));
    let entity = app.world_mut().spawn((Mesh3d(mesh), NoFrustumCulling)).id();
    step(&mut app);
    assert!(!app.world().entity(entity).contains::<Aabb>());
    assert_bounds(&app, entity, Vec3::new(-1.0, -2.0, -3.0), Vec3::new(1.0, 2.0, 3.0));
    replace_mesh(&mut app, entity, Cuboid::new(8.0, 8.0, 8.0));
    assert_bounds(&app, entity, Vec3::splat(-4.0), Vec3::splat(4.0));
    despawn(&mut app, entity);
    assert!(index(&app).is_empty());
}

#[test]
fn a_mesh_in_two_dimensions_is_found_and_hit_from_both_sides() {
    let mut app = headless_app();
    let mesh = add_mesh(&mut app, Rectangle::new(2.0, 2.0));
    let entity = app
        .world_mut()
        .spawn((Mesh2d(mesh), Transform::from_xyz(3.0, 0.0, 0.0)))
        .id();
    step(&mut app);
    assert!(is_hit(&mut app, entity, Vec3::X * 3.0));
    let from_behind = cast(&mut app, Ray3d::new(Vec3::new(3.0, 0.5, -5.0), Dir3::Z));
    assert_eq!(from_behind.map(|hit| hit.entity), Some(entity));
    remove::<Mesh2d>(&mut app, entity);
    assert!(!is_indexed(&app, entity));
}

// --- Meshes and their assets ---

#[test]
fn another_mesh_takes_the_place_of_the_first() {
    let (mut app, cube) = app_with_cube();
    let large = add_mesh(&mut app, Cuboid::new(6.0, 6.0, 6.0));
    insert(&mut app, cube, Mesh3d(large));
    assert_bounds(&app, cube, Vec3::splat(-3.0), Vec3::splat(3.0));
    assert!(is_hit(&mut app, cube, Vec3::X * 2.9));
}

#[test]
fn a_modified_mesh_is_hit_as_it_is_now() {
    let (mut app, cube) = app_with_cube();
    replace_mesh(&mut app, cube, Cuboid::new(6.0, 6.0, 6.0));
    assert_bounds(&app, cube, Vec3::splat(-3.0), Vec3::splat(3.0));
    assert!(is_hit(&mut app, cube, Vec3::X * 2.9));
    replace_mesh(&mut app, cube, Cuboid::new(0.2, 0.2, 0.2));
    assert_bounds(&app, cube, Vec3::splat(-0.1), Vec3::splat(0.1));
    assert_eq!(hit_at(&mut app, Vec3::X * 0.2), None);
    finish_meshes(&mut app);
    assert!(is_hit(&mut app, cube, Vec3::X * 0.05));
    assert_eq!(hit_at(&mut app, Vec3::X * 0.2), None);
}

#[test]
fn a_removed_mesh_is_hit_by_no_ray_until_it_is_there_again() {
    let (mut app, cube) = app_with_cube();
    let id = app.world().get::<Mesh3d>(cube).expect("a mesh entity").0.id();
    let mesh = app
        .world_mut()
        .resource_mut::<Assets<Mesh>>()
        .remove(id)
        .expect("a loaded mesh");
    step(&mut app);
    assert_eq!(status(&app, id), Some(MeshStatus::Missing));
    assert_eq!(hit_at(&mut app, Vec3::ZERO), None);
    app.world_mut()
        .resource_mut::<Assets<Mesh>>()
        .insert(id, mesh)
        .expect("a live id");
    step(&mut app);
    assert!(is_hit(&mut app, cube, Vec3::ZERO));
}

#[test]
fn without_an_aabb_the_box_comes_and_goes_with_the_mesh() {
    let mut app = headless_app();
    let mesh = add_mesh(&mut app, Cuboid::default());
    let entity = app.world_mut().spawn((Mesh3d(mesh.clone()), NoFrustumCulling)).id();
    step(&mut app);
    let cube = app
        .world_mut()
        .resource_mut::<Assets<Mesh>>()
        .remove(&mesh)
        .expect("a loaded mesh");
    step(&mut app);
    assert!(!is_indexed(&app, entity));
    app.world_mut()
        .resource_mut::<Assets<Mesh>>()
        .insert(&mesh, cube)
        .expect("a live id");
    step(&mut app);
    assert!(is_hit(&mut app, entity, Vec3::ZERO));
}

#[test]
fn a_mesh_that_is_loaded_later_is_found_when_it_is_there() {
    let mut app = headless_app();
    let mesh = app.world().resource::<Assets<Mesh>>().reserve_handle();
    let bounded_by_bevy = app.world_mut().spawn(Mesh3d(mesh.clone())).id();
    let bounded_by_mesh = app.world_mut().spawn((Mesh3d(mesh.clone()), NoFrustumCulling)).id();
    step(&mut app);
    assert!(index(&app).is_empty());
    app.world_mut()
        .resource_mut::<Assets<Mesh>>()
        .insert(&mesh, Cuboid::default().into())
        .expect("a live id");
    step(&mut app);
    assert!(is_indexed(&app, bounded_by_bevy) && is_indexed(&app, bounded_by_mesh));
    assert!(hit_at(&mut app, Vec3::ZERO).is_some());
}

#[test]
fn a_mesh_is_missing_then_building_then_ready() {
    let mut app = headless_app();
    let late = app.world().resource::<Assets<Mesh>>().reserve_handle();
    let there = add_mesh(&mut app, Sphere::default());
    let aabb = Aabb::from_min_max(Vec3::NEG_ONE, Vec3::ONE);
    app.world_mut().spawn((Mesh3d(late.clone()), aabb));
    app.world_mut().spawn(Mesh3d(there.clone()));
    assert_eq!(status(&app, there.id()), None, "before anything uses it");
    step(&mut app);
    assert_eq!(status(&app, late.id()), Some(MeshStatus::Missing));
    assert_eq!(status(&app, there.id()), Some(MeshStatus::Building));
    app.world_mut()
        .resource_mut::<Assets<Mesh>>()
        .insert(&late, Cuboid::default().into())
        .expect("a live id");
    settle(&mut app);
    assert_eq!(app.world().resource::<MeshBvhs>().building(), 0);
    assert_eq!(
        [&late, &there].map(|mesh| status(&app, mesh.id())),
        [Some(MeshStatus::Ready); 2]
    );
}

#[test]
fn answers_are_the_same_while_a_mesh_is_being_built() {
    let mut app = headless_app();
    let torus = spawn_mesh(
        &mut app,
        Torus::new(0.5, 2.0),
        Transform::from_xyz(1.0, 2.0, 3.0).with_scale(Vec3::new(1.0, 2.0, 3.0)),
    );
    step(&mut app);
    let mesh = app.world().get::<Mesh3d>(torus).expect("a mesh entity").0.id();
    assert_eq!(status(&app, mesh), Some(MeshStatus::Building));
    let answers = |app: &mut App| -> Vec<(Option<RayHit>, bool)> {
        let mut rng = rng(61);
        let settings = SceneQuerySettings::default();
        query(app, |scene| {
            let rays = (0..500).map(|_| ray_towards(random_point(&mut rng, 20.0), random_point(&mut rng, 5.0)));
            rays.map(|ray| (scene.cast_ray(ray, &settings), scene.any_hit(ray, &settings)))
                .collect()
        })
    };
    let before = answers(&mut app);
    finish_meshes(&mut app);
    assert_eq!(status(&app, mesh), Some(MeshStatus::Ready));
    assert!(before.iter().filter(|(hit, _)| hit.is_some()).count() > 50);
    assert_eq!(answers(&mut app), before);
}

#[test]
fn a_mesh_is_built_once_for_all_who_use_it_and_dropped_with_the_asset() {
    let mut app = headless_app();
    let mesh = add_mesh(&mut app, Sphere::default());
    let users = [0.0, 10.0].map(|x| {
        app.world_mut()
            .spawn((Mesh3d(mesh.clone()), Transform::from_xyz(x, 0.0, 0.0)))
            .id()
    });
    step(&mut app);
    assert_eq!(app.world().resource::<MeshBvhs>().building(), 1);
    assert!(is_hit(&mut app, users[0], Vec3::ZERO) && is_hit(&mut app, users[1], Vec3::X * 10.0));
    finish_meshes(&mut app);
    despawn(&mut app, users[0]);
    assert!(is_hit(&mut app, users[1], Vec3::X * 10.0));
    let id = mesh.id();
    drop(mesh);
    app.world_mut().despawn(users[1]);
    for _ in 0..3 {
        step(&mut app);
    }
    assert_eq!(status(&app, id), None);
}

#[test]
fn lines_and_points_keep_their_box_and_are_hit_by_no_ray() {
    for topology in [PrimitiveTopology::LineStrip, PrimitiveTopology::PointList] {
        let mut app = headless_app();
        let positions = vec![Vec3::NEG_ONE, Vec3::ZERO, Vec3::ONE];
        let mesh = Mesh::new(topology, RenderAssetUsages::default());
        let entity = spawn_mesh(
            &mut app,
            mesh.with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions),
            Transform::default(),
        );
        step(&mut app);
        let mesh = app.world().get::<Mesh3d>(entity).expect("a mesh entity").0.id();
        assert_eq!(status(&app, mesh), Some(MeshStatus::Unusable));
        assert_bounds(&app, entity, Vec3::NEG_ONE, Vec3::ONE);
        assert_eq!(hit_at(&mut app, Vec3::ZERO), None);
        replace_mesh(&mut app, entity, Cuboid::default());
        assert!(is_hit(&mut app, entity, Vec3::ZERO), "a surface since");
    }
}

#[test]
fn a_mesh_for_the_renderer_is_usable_while_no_renderer_takes_it() {
    let mut app = headless_app();
    let mut mesh = Mesh::from(Cuboid::default());
    mesh.asset_usage = RenderAssetUsages::RENDER_WORLD;
    let entity = spawn_mesh(&mut app, mesh, Transform::default());
    step(&mut app);
    assert!(is_hit(&mut app, entity, Vec3::ZERO));
}

// --- Components that say how an entity takes part ---

#[test]
fn a_hidden_entity_is_not_hit_until_it_is_shown() {
    let (mut app, cube) = app_with_cube();
    insert(&mut app, cube, Visibility::Hidden);
    assert!(is_indexed(&app, cube));
    assert_eq!(hit_at(&mut app, Vec3::ZERO), None);
    insert(&mut app, cube, Visibility::Inherited);
    assert!(is_hit(&mut app, cube, Vec3::ZERO));
}

#[test]
fn children_are_hidden_and_shown_with_their_parent() {
    let (mut app, child) = app_with_cube();
    let parent = app.world_mut().spawn((Transform::default(), Visibility::Hidden)).id();
    insert(&mut app, child, ChildOf(parent));
    assert_eq!(hit_at(&mut app, Vec3::ZERO), None);
    insert(&mut app, parent, Visibility::Visible);
    assert!(is_hit(&mut app, child, Vec3::ZERO));
    insert(&mut app, parent, Visibility::Hidden);
    insert(&mut app, child, Visibility::Visible);
    assert!(is_hit(&mut app, child, Vec3::ZERO));
}

#[test]
fn an_entity_that_knows_no_visibility_is_visible() {
    let (mut app, cube) = app_with_cube();
    insert(&mut app, cube, Visibility::Hidden);
    remove::<InheritedVisibility>(&mut app, cube);
    assert!(is_hit(&mut app, cube, Vec3::ZERO));
}

#[test]
fn layers_are_followed_when_they_are_added_changed_and_removed() {
    let (mut app, cube) = app_with_cube();
    let layers = |app: &mut App| {
        let is_on = |app: &mut App, layer| {
            let layers = RenderLayers::layer(layer);
            let ray = Ray3d::new(Vec3::Z * 9.0, Dir3::NEG_Z);
            query(app, |scene| {
                scene.any_hit(ray, &SceneQuerySettings::default().with_layers(&layers))
            })
        };
        [0, 1, 2].map(|layer| is_on(app, layer))
    };
    assert_eq!(layers(&mut app), [true, false, false]);
    insert(&mut app, cube, RenderLayers::layer(1));
    assert_eq!(layers(&mut app), [false, true, false]);
    insert(&mut app, cube, RenderLayers::from_layers(&[0, 2]));
    assert_eq!(layers(&mut app), [true, false, true]);
    remove::<RenderLayers>(&mut app, cube);
    assert_eq!(layers(&mut app), [true, false, false]);
}

#[test]
fn back_faces_are_hit_while_the_entity_says_so() {
    let (mut app, cube) = app_with_cube();
    let from_inside = Ray3d::new(Vec3::ZERO, Dir3::X);
    assert_eq!(cast(&mut app, from_inside), None);
    insert(&mut app, cube, RayCastBackfaces);
    assert_eq!(cast(&mut app, from_inside).map(|hit| hit.entity), Some(cube));
    remove::<RayCastBackfaces>(&mut app, cube);
    assert_eq!(cast(&mut app, from_inside), None);
}

#[test]
fn the_simplified_mesh_is_hit_in_place_of_the_other() {
    let (mut app, cube) = app_with_cube();
    let simple = add_mesh(&mut app, Cuboid::new(4.0, 0.2, 4.0));
    insert(&mut app, cube, SimplifiedMesh(simple));
    assert!(is_hit(&mut app, cube, Vec3::X * 1.9), "sticks out");
    assert_eq!(hit_at(&mut app, Vec3::Y * 0.3), None);
    remove::<SimplifiedMesh>(&mut app, cube);
    assert_bounds(&app, cube, Vec3::splat(-0.5), Vec3::splat(0.5));
    assert!(is_hit(&mut app, cube, Vec3::Y * 0.3));
    assert_eq!(hit_at(&mut app, Vec3::X * 1.9), None);
}

#[test]
fn an_entity_is_kept_out_while_it_says_so_and_its_children_are_not() {
    let (mut app, cube) = app_with_cube();
    let child = spawn_cube(&mut app, Vec3::X * 3.0);
    insert(&mut app, child, ChildOf(cube));
    insert(&mut app, cube, NoSpatialIndex);
    assert!(!is_indexed(&app, cube) && is_indexed(&app, child));
    remove::<NoSpatialIndex>(&mut app, cube);
    assert!(is_hit(&mut app, cube, Vec3::ZERO));
}

#[test]
fn a_disabled_entity_is_not_found_until_it_is_enabled() {
    let (mut app, cube) = app_with_cube();
    insert(&mut app, cube, Disabled);
    assert!(!is_indexed(&app, cube));
    remove::<Disabled>(&mut app, cube);
    assert!(is_hit(&mut app, cube, Vec3::ZERO));
    insert(&mut app, cube, Disabled);
    despawn(&mut app, cube);
    assert!(index(&app).is_empty());
}

// --- Bad data ---

#[test]
fn a_place_that_is_not_finite_is_refused_until_it_is() {
    for bad in [Vec3::new(0.0, f32::NAN, 0.0), Vec3::X * f32::INFINITY] {
        let (mut app, cube) = app_with_cube();
        insert(&mut app, cube, Transform::from_translation(bad));
        assert_eq!(refusal(&app, cube), Some(Refusal::Transform));
        insert(&mut app, cube, Transform::default());
        assert_eq!(refusal(&app, cube), None);
        assert!(is_hit(&mut app, cube, Vec3::ZERO));
    }
}

#[test]
fn bounds_that_are_not_sound_are_refused_until_they_are() {
    let good = Aabb::from_min_max(Vec3::NEG_ONE, Vec3::ONE);
    for bad in [
        Aabb {
            center: Vec3A::NAN,
            ..good
        },
        Aabb {
            half_extents: Vec3A::NAN,
            ..good
        },
        Aabb {
            half_extents: Vec3A::INFINITY,
            ..good
        },
        Aabb {
            half_extents: Vec3A::new(1.0, -1.0, 1.0),
            ..good
        },
    ] {
        let (mut app, cube) = app_with_cube();
        insert(&mut app, cube, (NoAutoAabb, bad));
        assert_eq!(refusal(&app, cube), Some(Refusal::Bounds), "{bad:?}");
        insert(&mut app, cube, good);
        assert_eq!(refusal(&app, cube), None);
        assert!(is_hit(&mut app, cube, Vec3::ZERO));
    }
}

#[test]
fn bounds_that_overflow_in_the_world_are_refused_until_they_do_not() {
    let mut app = headless_app();
    let aabb = Aabb::from_min_max(Vec3::splat(-1e30), Vec3::splat(1e30));
    let huge = app
        .world_mut()
        .spawn((aabb, Transform::from_scale(Vec3::splat(1e30))))
        .id();
    step(&mut app);
    assert_eq!(refusal(&app, huge), Some(Refusal::WorldBounds));
    insert(&mut app, huge, Transform::default());
    assert_eq!(refusal(&app, huge), None);
    assert!(is_indexed(&app, huge));
}

#[test]
fn one_reason_of_refusal_gives_way_to_another() {
    let (mut app, cube) = app_with_cube();
    insert(
        &mut app,
        cube,
        (
            NoAutoAabb,
            Aabb {
                center: Vec3A::NAN,
                half_extents: Vec3A::ONE,
            },
        ),
    );
    assert_eq!(refusal(&app, cube), Some(Refusal::Bounds));
    insert(&mut app, cube, Transform::from_translation(Vec3::NAN));
    assert_eq!(refusal(&app, cube), Some(Refusal::Transform));
}

#[test]
fn what_is_gone_or_kept_out_is_no_longer_refused() {
    let (mut app, cube) = app_with_cube();
    insert(&mut app, cube, Transform::from_translation(Vec3::NAN));
    insert(&mut app, cube, NoSpatialIndex);
    assert_eq!(refusal(&app, cube), None);
    remove::<NoSpatialIndex>(&mut app, cube);
    assert_eq!(refusal(&app, cube), Some(Refusal::Transform));
    despawn(&mut app, cube);
    assert_eq!(index(&app).refused().len(), 0);
}

#[test]
fn without_bounds_an_entity_is_no_longer_refused() {
    let (mut app, cube) = app_with_cube();
    insert(&mut app, cube, Transform::from_translation(Vec3::NAN));
    assert_eq!(refusal(&app, cube), Some(Refusal::Transform));
    remove::<(Mesh3d, Aabb)>(&mut app, cube);
    assert_eq!(refusal(&app, cube), None);
}

#[test]
fn every_finite_scale_is_indexed() {
    let scales = [
        Vec3::new(1.0, 0.0, 1.0),
        Vec3::new(0.0, 0.0, 1.0),
        Vec3::ZERO,
        Vec3::new(-1.0, 2.0, 1.0),
        Vec3::NEG_ONE,
        Vec3::splat(1e-20),
        Vec3::new(1e-20, 1.0, 1e20),
    ];
    for scale in scales {
        let (mut app, cube) = app_with_cube();
        insert(&mut app, cube, Transform::from_scale(scale));
        assert!(is_indexed(&app, cube), "{scale}");
        // No ray makes it panic.
        for ray in [Vec3::X, Vec3::Y, Vec3::ONE].map(|from| ray_towards(from * 3.0, Vec3::ZERO)) {
            assert!(
                cast(&mut app, ray).is_none_or(|hit| hit.normal.is_normalized()),
                "{scale}"
            );
        }
        insert(&mut app, cube, Transform::default());
        assert!(is_hit(&mut app, cube, Vec3::ZERO));
    }
}

// --- All at once ---

/// The meshes and entities of a random scene.
struct Game {
    meshes: Vec<Handle<Mesh>>,
    entities: Vec<Entity>,
}

impl Game {
    fn new(app: &mut App) -> Self {
        let meshes = vec![
            add_mesh(app, Cuboid::default()),
            add_mesh(app, Sphere::new(1.0)),
            add_mesh(app, Plane3d::default()),
            app.world().resource::<Assets<Mesh>>().reserve_handle(),
        ];
        Self {
            meshes,
            entities: Vec::new(),
        }
    }

    fn any_mesh(&self, rng: &mut ChaCha8Rng) -> Handle<Mesh> {
        self.meshes[rng.random_range(0..self.meshes.len())].clone()
    }

    fn any_entity(&self, rng: &mut ChaCha8Rng) -> Entity {
        self.entities[rng.random_range(0..self.entities.len())]
    }

    /// Does something to something.
    fn play(&mut self, world: &mut World, rng: &mut ChaCha8Rng) {
        self.entities.retain(|entity| world.get_entity(*entity).is_ok());
        if self.entities.len() < 20 || (self.entities.len() < 80 && rng.random_bool(0.1)) {
            self.entities.push(self.spawn(world, rng));
            return;
        }
        let (mesh, other, chosen) = (self.any_mesh(rng), self.any_entity(rng), self.any_entity(rng));
        let would_be_a_circle =
            std::iter::successors(Some(other), |e| world.get::<ChildOf>(*e).map(ChildOf::parent)).any(|e| e == chosen);
        let any_visibility = [Visibility::Hidden, Visibility::Inherited, Visibility::Visible][rng.random_range(0..3)];
        let mut entity = world.entity_mut(chosen);
        match rng.random_range(0..20) {
            0 => entity.despawn(),
            1 if !would_be_a_circle => _ = entity.insert(ChildOf(other)),
            2 => _ = entity.remove::<ChildOf>(),
            3 => _ = entity.insert(any_visibility),
            4 => _ = entity.insert(Mesh3d(mesh)),
            5 => _ = entity.remove::<Mesh3d>(),
            6 => _ = entity.remove::<Aabb>(),
            7 => _ = entity.insert(random_aabb(rng)),
            8 => toggle(entity, NoSpatialIndex),
            9 => toggle(entity, Disabled),
            10 => toggle(entity, RayCastBackfaces),
            11 => toggle(entity, RenderLayers::layer(1)),
            12 => toggle(entity, SimplifiedMesh(mesh)),
            13 => toggle(entity, NoFrustumCulling),
            14 => toggle(entity, Mesh2d(mesh)),
            15 if rng.random_bool(0.3) => _ = entity.insert(Transform::from_translation(Vec3::NAN)),
            16 if rng.random_bool(0.2) => _ = entity.remove::<GlobalTransform>(),
            17 => change_asset(world, &mesh, rng),
            _ => _ = entity.insert((random_transform(rng), GlobalTransform::default())),
        }
    }

    fn spawn(&self, world: &mut World, rng: &mut ChaCha8Rng) -> Entity {
        let mut entity = world.spawn((random_transform(rng), Visibility::default()));
        if rng.random_bool(0.8) {
            entity.insert(Mesh3d(self.any_mesh(rng)));
        }
        if !self.entities.is_empty() && rng.random_bool(0.3) {
            entity.insert(ChildOf(self.any_entity(rng)));
        }
        entity.id()
    }
}

fn random_transform(rng: &mut ChaCha8Rng) -> Transform {
    let scale = if rng.random_bool(0.1) {
        Vec3::new(1.0, 0.0, -1.0)
    } else {
        random_point(rng, 2.0)
    };
    Transform::from_translation(random_point(rng, 10.0))
        .with_rotation(random_rotation(rng))
        .with_scale(scale)
}

fn random_aabb(rng: &mut ChaCha8Rng) -> Aabb {
    Aabb::from_min_max(random_point(rng, 2.0) - 2.0, random_point(rng, 2.0) + 2.0)
}

fn toggle<C: Component>(mut entity: EntityWorldMut, component: C) {
    if entity.contains::<C>() {
        entity.remove::<C>();
    } else {
        entity.insert(component);
    }
}

/// Modifies, removes or adds a mesh asset.
fn change_asset(world: &mut World, mesh: &Handle<Mesh>, rng: &mut ChaCha8Rng) {
    let mut assets = world.resource_mut::<Assets<Mesh>>();
    if assets.contains(mesh) && rng.random_bool(0.3) {
        assets.remove(mesh);
    } else {
        let cuboid = Cuboid::from_size(random_point(rng, 2.0).abs() + 0.1);
        assets.insert(mesh, cuboid.into()).expect("a live id");
    }
}

/// Compares what a ray hits with what a plain loop over the world and over all triangles finds; returns how many hits.
fn assert_ray_agrees(app: &mut App, ray: Ray3d) -> usize {
    let world = app.world_mut();
    let mut entities = world.query_filtered::<EntityRef, (With<GlobalTransform>, Without<NoSpatialIndex>)>();
    let world = app.world();
    let assets = world.resource::<Assets<Mesh>>();
    let straight = Ray::from_ray3d(ray, f32::INFINITY).expect("a sound ray");
    let is_hit = |entity: EntityRef| {
        let mesh = mesh_of(entity).and_then(|mesh| surface(assets.get(mesh)?))?;
        let transform = entity.get::<GlobalTransform>()?.affine();
        let backfaces = entity.contains::<RayCastBackfaces>() || entity.contains::<Mesh2d>();
        let backfaces = if backfaces { Backfaces::Include } else { Backfaces::Cull };
        let is_visible = entity
            .get::<InheritedVisibility>()
            .is_none_or(|visibility| visibility.get());
        // The mesh may stick out of a box that is made by hand: the box is what counts then.
        let enters = index(app)
            .aabb(entity.id())
            .is_some_and(|aabb| straight.aabb_intersection_at(&aabb).is_some());
        let inverse = transform.as_daffine3().inverse();
        let hit = if inverse.is_finite() {
            mesh.closest_hit(&straight.transformed_by(&inverse)?, backfaces)
        } else {
            mesh.closest_hit_of(&straight, backfaces, |corner| transform.transform_point3a(corner))
        };
        (is_visible && enters).then_some(())?;
        hit.map(|hit| (entity.id(), hit.t))
    };
    let mut expected: Vec<(Entity, f32)> = entities.iter(world).filter_map(is_hit).collect();
    expected.sort_by_key(|(entity, _)| *entity);
    let mut hits = query(app, |scene| {
        let mut hits = Vec::new();
        scene.cast_ray_all(ray, &SceneQuerySettings::default(), &mut hits);
        hits
    });
    hits.sort_by_key(|hit| hit.entity);
    assert_eq!(
        hits.iter().map(|hit| hit.entity).collect::<Vec<_>>(),
        expected.iter().map(|(e, _)| *e).collect::<Vec<_>>()
    );
    for (hit, (_, distance)) in hits.iter().zip(expected) {
        assert!((hit.distance - distance).abs() <= 1e-5 * distance, "{hit:?} {distance}");
    }
    hits.len()
}

#[test]
fn agrees_with_the_world_for_a_thousand_random_frames() {
    let mut app = headless_app();
    let mut rng = rng(62);
    let mut game = Game::new(&mut app);
    let mut hits = 0;
    for _ in 0..1_000 {
        for _ in 0..rng.random_range(0..5) {
            game.play(app.world_mut(), &mut rng);
        }
        step(&mut app);
        for _ in 0..5 {
            let ray = ray_towards(random_point(&mut rng, 15.0), random_point(&mut rng, 5.0));
            hits += assert_ray_agrees(&mut app, ray);
        }
    }
    assert!(hits > 300, "only {hits} hits");
    for entity in game.entities {
        // Some are gone with a parent.
        _ = app.world_mut().try_despawn(entity);
    }
    step(&mut app);
    assert!(index(&app).is_empty());
}

// --- The short cut for what only moves ---

#[test]
fn what_moves_and_changes_otherwise_in_one_frame_is_followed_whole() {
    let (mut app, cube) = app_with_cube();
    insert(&mut app, cube, (Transform::from_xyz(5.0, 0.0, 0.0), Visibility::Hidden));
    assert!(!is_hit(&mut app, cube, Vec3::X * 5.0), "it is hidden");
    insert(
        &mut app,
        cube,
        (Transform::from_xyz(9.0, 0.0, 0.0), Visibility::Visible),
    );
    assert!(is_hit(&mut app, cube, Vec3::X * 9.0));
    insert(&mut app, cube, (Transform::from_xyz(3.0, 0.0, 0.0), NoSpatialIndex));
    assert!(!is_indexed(&app, cube));
}

#[test]
fn what_moves_while_something_is_taken_away_is_followed_whole() {
    let (mut app, cube) = app_with_cube();
    insert(&mut app, cube, RenderLayers::layer(7));
    let mut cube_mut = app.world_mut().entity_mut(cube);
    cube_mut
        .insert(Transform::from_xyz(5.0, 0.0, 0.0))
        .remove::<RenderLayers>();
    step(&mut app);
    let ground = RenderLayers::layer(0);
    let found = query(&mut app, |scene| {
        let ray = Ray3d::new(Vec3::new(5.0, 0.0, 9.0), Dir3::NEG_Z);
        scene.cast_ray(ray, &SceneQuerySettings::default().with_layers(&ground))
    });
    assert_eq!(found.map(|hit| hit.entity), Some(cube));

    let mut cube_mut = app.world_mut().entity_mut(cube);
    cube_mut
        .insert(Transform::from_xyz(8.0, 0.0, 0.0))
        .remove::<(Mesh3d, Aabb)>();
    step(&mut app);
    assert!(!is_indexed(&app, cube));
}

#[test]
fn what_only_moves_is_placed_without_being_looked_at_whole() {
    let mut app = headless_app();
    let cubes: Vec<Entity> = (0..10)
        .map(|i| spawn_cube(&mut app, Vec3::X * 3.0 * i as f32))
        .collect();
    settle(&mut app);
    step(&mut app);
    let stats = |app: &App| *app.world().resource::<SyncStats>();
    assert_eq!((stats(&app).moved, stats(&app).reconciled), (0, 0));
    for cube in &cubes[..4] {
        app.world_mut()
            .get_mut::<Transform>(*cube)
            .expect("a cube")
            .translation
            .y = 4.0;
    }
    insert(&mut app, cubes[9], Visibility::Hidden);
    assert_eq!((stats(&app).moved, stats(&app).reconciled), (4, 1));
    assert!(stats(&app).total >= stats(&app).find + stats(&app).structures);
    for (i, cube) in cubes[..4].iter().enumerate() {
        assert!(is_hit(&mut app, *cube, Vec3::new(3.0 * i as f32, 4.0, 0.0)));
    }
}

#[test]
fn an_entity_that_moves_to_a_bad_place_is_refused_and_comes_back() {
    let (mut app, cube) = app_with_cube();
    for bad in [f32::NAN, f32::INFINITY, 3e38] {
        insert(
            &mut app,
            cube,
            Transform::from_xyz(bad, 0.0, 0.0).with_scale(Vec3::splat(1e38)),
        );
        assert!(!is_indexed(&app, cube), "{bad}");
        insert(&mut app, cube, Transform::from_xyz(0.0, 5.0, 0.0));
        assert!(is_hit(&mut app, cube, Vec3::Y * 5.0));
    }
}

/// What is asleep is disabled. Not stored in tables.
#[derive(Component)]
#[component(storage = "SparseSet")]
struct Asleep;

#[test]
fn entities_are_followed_where_disabling_components_are_not_in_tables() {
    let mut app = headless_app();
    app.world_mut().register_disabling_component::<Asleep>();
    let cube = spawn_cube(&mut app, Vec3::ZERO);
    step(&mut app);
    assert!(is_hit(&mut app, cube, Vec3::ZERO));
    insert(&mut app, cube, Transform::from_xyz(7.0, 0.0, 0.0));
    assert!(is_hit(&mut app, cube, Vec3::X * 7.0));
    app.world_mut().entity_mut(cube).insert(Asleep);
    app.update();
    assert!(!is_hit(&mut app, cube, Vec3::X * 7.0));
}

#[test]
fn an_entity_takes_the_place_of_one_whose_end_was_missed() {
    let mut app = headless_app();
    let is_on = |on: Res<IsOn>| on.0;
    app.insert_resource(IsOn(true))
        .configure_sets(PostUpdate, SpatialIndexSystems::Sync.run_if(is_on));
    let old = spawn_cube(&mut app, Vec3::ZERO);
    step(&mut app);
    app.insert_resource(IsOn(false));
    app.world_mut().despawn(old);
    // Bevy gives indices back to be used again by the hundred.
    let others: Vec<Entity> = (0..300).map(|_| app.world_mut().spawn_empty().id()).collect();
    others.into_iter().for_each(|other| _ = app.world_mut().despawn(other));
    let mut spawned = (0..300).map(|_| spawn_cube(&mut app, Vec3::Y));
    let new = spawned.find(|new| new.index() == old.index());
    drop(spawned);
    let new = new.expect("indices are used again");
    for _ in 0..5 {
        app.update();
    }
    app.insert_resource(IsOn(true));
    app.update();
    index(&app).validate().expect("a whole index");
    assert!(is_indexed(&app, new) && !is_indexed(&app, old));
}

#[derive(Resource)]
struct IsOn(bool);

// --- The grid ---

#[test]
fn a_grid_is_kept_as_the_settings_say() {
    let mut app = headless_app();
    let mut rng = rng(63);
    let cubes: Vec<Entity> = (0..200)
        .map(|_| spawn_cube(&mut app, random_point(&mut rng, 10.0)))
        .collect();
    step(&mut app);
    let near = |app: &mut App| {
        query(app, |scene| {
            let mut near = Vec::new();
            scene.neighbours_within(Vec3::ONE, 5.0, &SceneQuerySettings::default(), &mut near);
            near
        })
    };
    near(&mut app);
    let fixed = |cell| {
        Some(GridSettings {
            cell_size: CellSize::Fixed(cell),
        })
    };
    for (round, grid) in [
        None,
        fixed(2.0),
        None,
        Some(GridSettings::default()),
        fixed(0.5),
        fixed(30.0),
    ]
    .into_iter()
    .enumerate()
    {
        app.world_mut().resource_mut::<SpatialIndexSettings>().grid = grid;
        app.world_mut().despawn(cubes[round]);
        insert(&mut app, cubes[100 + round], Transform::from_xyz(1.0, 2.0, 3.0));
        assert_eq!(index(&app).stats().cell_size.is_some(), grid.is_some());
        assert_eq!(index(&app).stats().grid_memory > 0, grid.is_some());
        let with = near(&mut app);
        app.world_mut().resource_mut::<SpatialIndexSettings>().grid = None;
        step(&mut app);
        assert_eq!(near(&mut app), with);
        assert!(with.len() > 5);
        app.world_mut().resource_mut::<SpatialIndexSettings>().grid = grid;
        step(&mut app);
        assert_eq!(near(&mut app), with);
    }
}

#[test]
fn a_grid_is_there_only_while_it_is_asked_for() {
    let (mut app, cube) = app_with_cube();
    app.world_mut().resource_mut::<SpatialIndexSettings>().grid_kept = 3;
    let near = |app: &mut App| {
        query(app, |scene| {
            let mut near = Vec::new();
            scene.neighbours_within(Vec3::ZERO, 1.0, &SceneQuerySettings::default(), &mut near);
            near.into_iter().map(|neighbour| neighbour.key).collect::<Vec<_>>()
        })
    };
    let is_there = |app: &App| index(app).stats().cell_size.is_some();
    step(&mut app);
    assert!(!is_there(&app), "nobody has asked");
    for _ in 0..2 {
        assert_eq!(near(&mut app), [cube]);
        for _ in 0..4 {
            step(&mut app);
            assert!(is_there(&app), "somebody has asked");
            assert_eq!(index(&app).validate(), Ok(()));
        }
        step(&mut app);
        assert!(!is_there(&app), "not for long");
        assert_eq!(index(&app).stats().grid_memory, 0);
    }
}

#[test]
fn that_a_grid_comes_and_goes_is_no_change_of_the_index() {
    let (mut app, _) = app_with_cube();
    app.world_mut().resource_mut::<SpatialIndexSettings>().grid_kept = 1;
    step(&mut app);
    let last_changed = |app: &App| app.world().resource_ref::<SpatialIndex>().last_changed();
    let before = last_changed(&app);
    query(&mut app, |scene| {
        scene.neighbours_within(Vec3::ZERO, 1.0, &SceneQuerySettings::default(), &mut Vec::new());
    });
    for _ in 0..4 {
        step(&mut app);
    }
    assert_eq!(last_changed(&app), before);
}

// --- Figures ---

#[test]
fn the_index_is_known_in_figures() {
    let mut app = headless_app();
    step(&mut app);
    let empty = index(&app).stats();
    assert_eq!((empty.entities, empty.nodes, empty.depth), (0, 0, 0));
    for i in 0..100 {
        spawn_cube(&mut app, Vec3::X * 3.0 * i as f32);
    }
    let bad = spawn_cube(&mut app, Vec3::NAN);
    step(&mut app);
    let stats = index(&app).stats();
    assert_eq!((stats.entities, stats.refused), (100, 1));
    assert!(refusal(&app, bad).is_some());
    assert!(
        stats.nodes >= 13 && stats.depth >= 2 && stats.sah_cost >= 1.0,
        "{stats:?}"
    );
    assert!(
        stats.tree_memory > 100 * 32 && stats.table_memory > 100 * 64,
        "{stats:?}"
    );
}

// --- Apps ---

#[test]
fn the_plugins_may_be_added_more_than_once_and_in_any_order() {
    let orders: [fn(&mut App); 4] = [
        |app| _ = app.add_plugins(SpatialIndexPlugin).add_plugins(SpatialIndexPlugin),
        |app| _ = app.add_plugins((SpatialPickingPlugin, SpatialIndexPlugin)),
        |app| _ = app.add_plugins((SpatialIndexPlugin, SpatialPickingPlugin)),
        |app| _ = app.add_plugins(SpatialIndexPlugin).add_plugins(SightlinePlugins),
    ];
    for add_plugins in orders {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, TransformPlugin));
        add_plugins(&mut app);
        app.finish();
        let zone = spawn_zone(&mut app);
        step(&mut app);
        assert!(is_indexed(&app, zone));
    }
}

fn spawn_zone(app: &mut App) -> Entity {
    app.world_mut()
        .spawn((Aabb::from_min_max(Vec3::NEG_ONE, Vec3::ONE), Transform::default()))
        .id()
}

#[test]
fn neither_assets_nor_meshes_nor_windows_are_needed() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, SightlinePlugins));
    app.finish();
    let zone = spawn_zone(&mut app);
    step(&mut app);
    assert_eq!(overlapping(&mut app, Vec3::ONE), [zone]);
    insert(&mut app, zone, Transform::from_xyz(9.0, 0.0, 0.0));
    assert_eq!(overlapping(&mut app, Vec3::ONE), []);
    assert_eq!(overlapping(&mut app, Vec3::X * 9.0), [zone]);
}

#[test]
fn two_worlds_share_nothing() {
    let (mut here, cube) = app_with_cube();
    let mut there = headless_app();
    step(&mut there);
    assert!(index(&there).is_empty());
    assert_eq!(hit_at(&mut there, Vec3::ZERO), None);
    spawn_cube(&mut there, Vec3::X * 9.0);
    step(&mut there);
    despawn(&mut here, cube);
    assert_eq!((index(&here).len(), index(&there).len()), (0, 1));
}

#[test]
fn a_grid_that_cannot_be_leaves_the_one_that_is() {
    let (mut app, cube) = app_with_cube();
    for cell in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        app.world_mut().resource_mut::<SpatialIndexSettings>().grid = Some(GridSettings {
            cell_size: CellSize::Fixed(cell),
        });
        step(&mut app);
        let mut near = Vec::new();
        query(&mut app, |scene| {
            let mut found = Vec::new();
            scene.neighbours_within(Vec3::ZERO, 1.0, &SceneQuerySettings::default(), &mut found);
            near.extend(found.iter().map(|neighbour| neighbour.key));
            assert_eq!(near, [cube]);
        });
    }
}
