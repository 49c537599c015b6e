//! Frames in which something does not run.

use bevy::{
    camera::{primitives::Aabb, visibility::NoFrustumCulling},
    mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    prelude::*,
    state::app::StatesPlugin,
};
use bevy_sightline::prelude::*;

use crate::{
    common::*,
    skinned_picking::rig::{spawn_rig, square, with_one_joint},
};

/// Whether the index is paused.
#[derive(Resource, Default)]
struct Paused(bool);

#[derive(States, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
enum Level {
    #[default]
    Outside,
    Cave,
}

fn app() -> App {
    let mut app = headless_app_with(|app| _ = app.add_plugins(StatesPlugin));
    app.init_state::<Level>().init_resource::<Paused>().configure_sets(
        PostUpdate,
        SpatialIndexSystems::Sync.run_if(|paused: Res<Paused>| !paused.0),
    );
    app
}

/// Pauses the index for longer than Bevy remembers what was removed, and does something at the beginning.
fn pause(app: &mut App, meanwhile: impl FnOnce(&mut App)) {
    app.world_mut().resource_mut::<Paused>().0 = true;
    app.update();
    meanwhile(app);
    for _ in 0..5 {
        app.update();
    }
    app.world_mut().resource_mut::<Paused>().0 = false;
    settle(app);
    index(app).validate().expect("a sound index");
}

fn entity_at(app: &mut App, place: Vec3) -> Option<Entity> {
    hit_at(app, place).map(|hit| hit.entity)
}

#[test]
fn what_is_despawned_in_a_pause_is_gone_afterwards() {
    let mut app = app();
    let cube = spawn_cube(&mut app, Vec3::ZERO);
    settle(&mut app);
    pause(&mut app, |app| _ = app.world_mut().despawn(cube));
    assert_eq!(entity_at(&mut app, Vec3::ZERO), None);
    assert!(index(&app).is_empty());
}

#[test]
fn what_loses_its_bounds_in_a_pause_is_gone_afterwards() {
    let mut app = app();
    let cube = spawn_cube(&mut app, Vec3::ZERO);
    settle(&mut app);
    pause(&mut app, |app| {
        app.world_mut().entity_mut(cube).remove::<(Mesh3d, Aabb)>();
    });
    assert!(!index(&app).contains(cube));
}

#[test]
fn what_may_be_found_again_since_a_pause_is_found() {
    let mut app = app();
    let cube = spawn_cube(&mut app, Vec3::ZERO);
    app.world_mut().entity_mut(cube).insert(NoSpatialIndex);
    settle(&mut app);
    pause(&mut app, |app| {
        app.world_mut().entity_mut(cube).remove::<NoSpatialIndex>();
    });
    assert_eq!(entity_at(&mut app, Vec3::ZERO), Some(cube));
}

#[test]
fn what_is_spawned_and_moved_in_a_pause_is_where_it_is_afterwards() {
    let mut app = app();
    let old = spawn_cube(&mut app, Vec3::ZERO);
    settle(&mut app);
    let mut new = None;
    pause(&mut app, |app| {
        app.world_mut()
            .entity_mut(old)
            .insert(Transform::from_xyz(5.0, 0.0, 0.0));
        new = Some(spawn_cube(app, Vec3::ZERO));
    });
    assert_eq!(entity_at(&mut app, Vec3::ZERO), new);
    assert_eq!(entity_at(&mut app, Vec3::X * 5.0), Some(old));
}

#[test]
fn one_that_was_refused_and_is_gone_since_a_pause_is_not_listed_any_more() {
    let mut app = app();
    let cube = spawn_mesh(&mut app, Cuboid::default(), Transform::from_xyz(f32::NAN, 0.0, 0.0));
    settle(&mut app);
    assert_eq!(index(&app).refused().len(), 1);
    pause(&mut app, |app| _ = app.world_mut().despawn(cube));
    assert_eq!(index(&app).refused().len(), 0);
}

#[test]
fn a_mesh_that_is_edited_in_a_pause_is_hit_as_it_is_afterwards() {
    let mut app = app();
    let cube = spawn_cube(&mut app, Vec3::ZERO);
    settle(&mut app);
    let mesh = app.world().get::<Mesh3d>(cube).expect("a mesh").0.clone();
    pause(&mut app, |app| {
        let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
        _ = meshes.insert(&mesh, Cuboid::new(1.0, 1.0, 3.0).into());
    });
    assert_eq!(hit_at(&mut app, Vec3::ZERO).map(|hit| hit.distance), Some(98.5));
}

#[test]
fn paused_time_does_not_stop_the_index() {
    let mut app = app();
    app.world_mut().resource_mut::<Time<Virtual>>().pause();
    let cube = spawn_cube(&mut app, Vec3::ZERO);
    settle(&mut app);
    assert_eq!(entity_at(&mut app, Vec3::ZERO), Some(cube));
    app.world_mut()
        .entity_mut(cube)
        .insert(Transform::from_xyz(5.0, 0.0, 0.0));
    app.update();
    assert_eq!(entity_at(&mut app, Vec3::ZERO), None);
}

#[test]
fn what_goes_with_a_state_is_gone_in_the_same_frame() {
    let mut app = app();
    app.world_mut().resource_mut::<NextState<Level>>().set(Level::Cave);
    app.update();
    let camera = app.world_mut().spawn(Camera3d::default()).id();
    let cube = spawn_cube(&mut app, Vec3::NEG_Z * 5.0);
    let group = ProxyLod::new(LodMetric::Distance, cube).then_nothing(100.0);
    let parts = (Occluder::Box, DespawnOnExit(Level::Cave));
    app.world_mut().entity_mut(cube).insert((group, parts));
    settle(&mut app);
    let is_seen = |app: &App| {
        let set = app.world().get::<VisibleSet>(camera);
        set.is_some_and(|set| set.contains(cube))
    };
    assert!(is_seen(&app));

    app.world_mut().resource_mut::<NextState<Level>>().set(Level::Outside);
    app.update();
    assert!(!app.world().entities().contains(cube));
    assert!(!is_seen(&app) && index(&app).is_empty());
    assert!(app.world().resource::<LodChoices>().is_empty());
    assert!(app.world().resource::<Occluders>().is_empty());
}

#[test]
fn a_mesh_that_is_loaded_in_a_pause_bounds_its_entity_afterwards() {
    let mut app = app();
    let mesh = app.world().resource::<Assets<Mesh>>().reserve_handle();
    let entity = app.world_mut().spawn((Mesh3d(mesh.clone()), NoFrustumCulling)).id();
    settle(&mut app);
    pause(&mut app, |app| {
        let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
        meshes.insert(&mesh, Cuboid::default().into()).expect("a live asset");
    });
    assert_eq!(entity_at(&mut app, Vec3::ZERO), Some(entity));
}

#[test]
fn inverse_bind_poses_that_change_in_a_pause_are_followed_afterwards() {
    let mut app = app();
    let rig = spawn_rig(&mut app, with_one_joint(square()), &[Transform::IDENTITY]);
    settle(&mut app);
    let skin = app.world().get::<SkinnedMesh>(rig.entity).expect("a skin");
    let id = skin.inverse_bindposes.id();
    pause(&mut app, |app| {
        let moved = vec![Mat4::from_translation(Vec3::X * 7.0)];
        let mut assets = app.world_mut().resource_mut::<Assets<SkinnedMeshInverseBindposes>>();
        assets.insert(id, moved.into()).expect("a live asset");
    });
    let aabb = index(&app).aabb(rig.entity).expect("it is indexed");
    assert_eq!(0.5 * (aabb.min.x + aabb.max.x), 7.0);
}
