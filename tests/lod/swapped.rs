//! Meshes that are swapped on the entity itself, for all views.

use bevy::camera::{primitives::Aabb, visibility::NoAutoAabb};
use bevy_sightline::index::SimplifiedMesh;

use super::*;

/// A group of meshes, with what they are.
struct Swapped {
    root: Entity,
    meshes: Vec<Handle<Mesh>>,
}

/// Three unit cubes, of which the second takes over at 10 m and the third at 20 m.
fn spawn_swapped(app: &mut App) -> Swapped {
    let meshes: Vec<_> = (0..3).map(|_| add_mesh(app, Cuboid::default())).collect();
    let lod = ProxyLod::new(LodMetric::Distance, meshes[0].clone())
        .then(10.0, meshes[1].clone())
        .then(20.0, meshes[2].clone());
    let root = spawn(app, (Mesh3d(meshes[0].clone()), lod));
    Swapped { root, meshes }
}

/// The level whose mesh the entity has.
#[track_caller]
fn level(app: &App, group: &Swapped) -> usize {
    let mesh = app.world().get::<Mesh3d>(group.root).expect("a mesh");
    let level = group.meshes.iter().position(|level| *level == mesh.0);
    level.expect("the mesh of a level")
}

fn level_from(app: &mut App, camera: Entity, distance: f32, group: &Swapped) -> usize {
    insert(app, camera, at_distance(distance));
    app.update();
    assert_eq!(listed(app, camera), [group.root]);
    let level = level(app, group);
    assert_eq!(choices(app).level(group.root, camera), Some(level));
    level
}

#[test]
fn the_entity_gets_the_mesh_that_the_main_camera_shows_in_the_same_frame() {
    let mut app = app();
    let (camera, group) = (spawn_camera(&mut app, 5.0), spawn_swapped(&mut app));
    for (distance, expected) in [(5.0, 0), (15.0, 1), (50.0, 2), (20.5, 2), (19.0, 1), (1.0, 0)] {
        assert_eq!(level_from(&mut app, camera, distance, &group), expected);
    }
}

#[test]
fn other_cameras_show_what_the_main_one_does() {
    let mut app = app();
    let (main, group) = (spawn_camera(&mut app, 15.0), spawn_swapped(&mut app));
    let other = spawn_camera(&mut app, 50.0);
    app.world_mut().get_mut::<Camera>(other).unwrap().order = 1;
    app.update();
    assert_eq!(choices(&app).main_camera(), Some(main));
    assert_eq!(level(&app, &group), 1);
    assert_eq!(choices(&app).level(group.root, other), Some(1));
    assert!(sees(&app, other, group.root));
}

#[test]
fn the_main_camera_is_the_first_active_one_or_the_one_that_is_named() {
    let mut app = app();
    let group = spawn_swapped(&mut app);
    let (near, far) = (spawn_camera(&mut app, 5.0), spawn_camera(&mut app, 50.0));
    app.world_mut().get_mut::<Camera>(far).unwrap().order = 1;
    app.update();
    assert_eq!(level(&app, &group), 0);
    settings(&mut app).main_camera = Some(far);
    app.update();
    assert_eq!(level(&app, &group), 2);
    settings(&mut app).main_camera = None;
    app.world_mut().get_mut::<Camera>(near).unwrap().order = 2;
    app.update();
    assert_eq!(level(&app, &group), 2);
    despawn(&mut app, far);
    app.update();
    assert_eq!(level(&app, &group), 0);
}

#[test]
fn without_a_main_camera_the_finest_mesh_is_there_and_all_views_show_it() {
    let mut app = app();
    let group = spawn_swapped(&mut app);
    app.world_mut().get_mut::<ProxyLod>(group.root).unwrap().levels[2].content = LodContent::Nothing;
    let (main, other) = (spawn_camera(&mut app, 50.0), spawn_camera(&mut app, 5.0));
    settings(&mut app).main_camera = Some(main);
    app.update();
    assert!(!sees(&app, main, group.root) && !sees(&app, other, group.root));
    app.world_mut().get_mut::<Camera>(main).unwrap().is_active = false;
    app.update();
    assert_eq!(level(&app, &group), 0);
    assert!(choices(&app).shows(other, group.root));
    assert!(sees(&app, other, group.root), "what is shown is in the list");
    app.world_mut().get_mut::<Camera>(main).unwrap().is_active = true;
    app.update();
    assert!(!sees(&app, other, group.root));
    despawn(&mut app, main);
    app.update();
    assert!(sees(&app, other, group.root));
}

#[test]
fn a_main_camera_whose_place_is_bad_is_none() {
    let mut app = app();
    let group = spawn_swapped(&mut app);
    app.world_mut().get_mut::<ProxyLod>(group.root).unwrap().levels[2].content = LodContent::Nothing;
    let (main, other) = (spawn_camera(&mut app, 50.0), spawn_camera(&mut app, 15.0));
    app.world_mut().get_mut::<Camera>(other).unwrap().order = 1;
    app.update();
    assert!(!sees(&app, other, group.root));
    insert(&mut app, main, LodBias(f32::NAN));
    app.update();
    assert_eq!(sees(&app, other, group.root), choices(&app).shows(other, group.root));
    assert_ne!(app.world().get::<Mesh3d>(group.root).unwrap().0, group.meshes[2]);
    insert(&mut app, main, LodBias(1.0));
    app.update();
    assert!(!sees(&app, other, group.root));
}

#[test]
fn nothing_is_shown_in_any_view() {
    let mut app = app();
    let (main, group) = (spawn_camera(&mut app, 5.0), spawn_swapped(&mut app));
    let other = spawn_camera(&mut app, 5.0);
    app.world_mut().get_mut::<Camera>(other).unwrap().order = 1;
    app.world_mut().get_mut::<ProxyLod>(group.root).unwrap().levels[2].content = LodContent::Nothing;
    app.update();
    assert!(sees(&app, main, group.root) && sees(&app, other, group.root));
    insert(&mut app, main, at_distance(50.0));
    app.update();
    assert!(!sees(&app, main, group.root) && !sees(&app, other, group.root));
    insert(&mut app, main, at_distance(15.0));
    app.update();
    assert!(sees(&app, main, group.root) && sees(&app, other, group.root));
    assert_eq!(level(&app, &group), 1);
}

#[test]
fn an_entity_without_a_mesh_gets_one() {
    let mut app = app();
    let (camera, mut group) = (spawn_camera(&mut app, 15.0), spawn_swapped(&mut app));
    let lod = app.world().get::<ProxyLod>(group.root).unwrap().clone();
    despawn(&mut app, group.root);
    group.root = spawn(&mut app, (lod, Transform::default()));
    app.update();
    app.update();
    assert_eq!(level(&app, &group), 1);
    assert_eq!(listed(&app, camera), [group.root]);
}

#[test]
fn a_mesh_that_is_not_loaded_yet_is_replaced_by_the_finest_that_is() {
    let mut app = app();
    let (camera, mut group) = (spawn_camera(&mut app, 15.0), spawn_swapped(&mut app));
    let later = app.world().resource::<Assets<Mesh>>().reserve_handle();
    app.world_mut().get_mut::<ProxyLod>(group.root).unwrap().levels[1].content = later.clone().into();
    group.meshes[1] = later.clone();
    app.update();
    assert_eq!(level(&app, &group), 0);
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    meshes
        .insert(later.id(), Cuboid::default().into())
        .expect("it was reserved");
    app.update();
    app.update();
    assert_eq!(level_from(&mut app, camera, 15.0, &group), 1);
}

#[test]
fn its_box_is_around_all_of_its_meshes_and_stays_the_same() {
    let mut app = app();
    let (camera, group) = (spawn_camera(&mut app, 5.0), spawn_swapped(&mut app));
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    _ = meshes.insert(group.meshes[2].id(), Cuboid::new(3.0, 1.0, 1.0).into());
    app.update();
    app.update();
    for distance in [5.0, 15.0, 50.0] {
        level_from(&mut app, camera, distance, &group);
        let aabb = app.world().get::<Aabb>(group.root).expect("bounds");
        assert_eq!(aabb.half_extents, Vec3A::new(1.5, 0.5, 0.5));
    }
}

#[test]
fn what_it_was_given_is_taken_back_with_the_component() {
    for distance in [5.0, 50.0] {
        let mut app = app();
        let (camera, group) = (spawn_camera(&mut app, distance), spawn_swapped(&mut app));
        let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
        _ = meshes.insert(group.meshes[2].id(), Cuboid::new(3.0, 1.0, 1.0).into());
        app.update();
        app.update();
        remove::<ProxyLod>(&mut app, group.root);
        app.update();
        app.update();
        let root = app.world().entity(group.root);
        assert!(!root.contains::<NoAutoAabb>() && !root.contains::<SimplifiedMesh>());
        assert_eq!(level(&app, &group), 0);
        assert_eq!(
            root.get::<Aabb>().unwrap().half_extents,
            Vec3A::splat(0.5),
            "at {distance} m"
        );
        assert_eq!(listed(&app, camera), [group.root]);
    }
}

#[test]
fn what_it_had_before_stays_its_own() {
    let mut app = app();
    let (_, group) = (spawn_camera(&mut app, 50.0), spawn_swapped(&mut app));
    let own = Aabb::from_min_max(Vec3::splat(-2.0), Vec3::splat(2.0));
    let hit = add_mesh(&mut app, Cuboid::default());
    insert(&mut app, group.root, (own, NoAutoAabb, SimplifiedMesh(hit.clone())));
    app.update();
    let has_its_own = |app: &App| {
        let root = app.world().entity(group.root);
        assert_eq!(root.get::<Aabb>(), Some(&own));
        assert_eq!(root.get::<SimplifiedMesh>().unwrap().0, hit);
        assert!(root.contains::<NoAutoAabb>());
    };
    has_its_own(&app);
    remove::<ProxyLod>(&mut app, group.root);
    app.update();
    has_its_own(&app);
}

#[test]
fn a_group_whose_levels_become_entities_gives_back_what_it_was_given() {
    let mut app = app();
    let (camera, group) = (spawn_camera(&mut app, 50.0), spawn_swapped(&mut app));
    app.update();
    assert_eq!(level(&app, &group), 2);
    let levels: Vec<Entity> = (0..2).map(|_| spawn_cube(&mut app, Vec3::ZERO)).collect();
    insert(&mut app, group.root, lod(LodMetric::Distance, &levels, &[10.0]));
    app.update();
    app.update();
    let root = app.world().entity(group.root);
    assert!(!root.contains::<NoAutoAabb>() && !root.contains::<SimplifiedMesh>());
    assert_eq!(level(&app, &group), 0);
    let statue = Statue {
        root: group.root,
        levels,
    };
    assert_eq!(shown(&app, camera, &statue), 1);
}

#[test]
fn a_group_that_is_never_culled_switches_too() {
    let mut app = app();
    let (camera, group) = (spawn_camera(&mut app, 5.0), spawn_swapped(&mut app));
    insert(&mut app, group.root, bevy::camera::visibility::NoFrustumCulling);
    assert_eq!(level_from(&mut app, camera, 5.0, &group), 0);
    assert_eq!(level_from(&mut app, camera, 15.0, &group), 1);
}

#[test]
fn other_levels_may_be_given_at_any_time() {
    let mut app = app();
    let (camera, mut group) = (spawn_camera(&mut app, 15.0), spawn_swapped(&mut app));
    assert_eq!(level_from(&mut app, camera, 15.0, &group), 1);
    let new = add_mesh(&mut app, Cuboid::default());
    app.world_mut().get_mut::<ProxyLod>(group.root).unwrap().levels[1].content = new.clone().into();
    group.meshes[1] = new;
    assert_eq!(level_from(&mut app, camera, 15.0, &group), 1);
    app.world_mut()
        .get_mut::<ProxyLod>(group.root)
        .unwrap()
        .levels
        .truncate(1);
    assert_eq!(level_from(&mut app, camera, 50.0, &group), 0);
}
