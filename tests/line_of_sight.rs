//! What lies between two points, and how much of an entity a camera sees.

use bevy::{
    camera::{
        ScalingMode,
        primitives::{self, Frustum},
        visibility::RenderLayers,
    },
    math::bounding::{Aabb3d, BoundingVolume},
    prelude::*,
};
use bevy_sightline::{geometry::ray::triangle::Backfaces, geometry::tolerance::LINE_OF_SIGHT, prelude::*};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use crate::{common::*, skinned_picking::rig::*};

fn settings<'a>() -> SceneQuerySettings<'a> {
    SceneQuerySettings::default()
}

fn sees(app: &mut App, from: Vec3, to: Vec3, settings: SceneQuerySettings) -> bool {
    query(app, |scene| {
        let sees = scene.line_of_sight(from, to, &settings);
        let blocker = scene.line_of_sight_blocker(from, to, &settings);
        assert!(!sees || blocker.is_none(), "what blocks, blocks: {blocker:?}");
        sees
    })
}

fn blocker(app: &mut App, from: Vec3, to: Vec3, settings: SceneQuerySettings) -> Option<RayHit> {
    query(app, |scene| scene.line_of_sight_blocker(from, to, &settings))
}

/// A slab across z.
fn spawn_wall(app: &mut App, center: Vec3, size: Vec2) -> Entity {
    spawn_mesh(
        app,
        Cuboid::new(size.x, size.y, 0.1),
        Transform::from_translation(center),
    )
}

/// A camera that looks along -z, with the projection.
fn spawn_camera(app: &mut App, place: Transform, projection: impl Into<Projection>) -> Entity {
    app.world_mut()
        .spawn((Camera3d::default(), place, projection.into()))
        .id()
}

/// A square view of 90 degrees.
fn perspective() -> Projection {
    PerspectiveProjection {
        fov: std::f32::consts::FRAC_PI_2,
        ..default()
    }
    .into()
}

/// A square view of 10 by 10.
fn orthographic() -> Projection {
    OrthographicProjection {
        scaling_mode: ScalingMode::Fixed {
            width: 10.0,
            height: 10.0,
        },
        area: Rect::from_center_half_size(Vec2::ZERO, Vec2::splat(5.0)),
        ..OrthographicProjection::default_3d()
    }
    .into()
}

/// What a camera sees of an entity.
fn seen(app: &mut App, camera: Entity, entity: Entity, settings: SceneQuerySettings) -> Option<f32> {
    query(app, |scene| scene.visible_fraction(camera, entity, 256, &settings))
}

/// A camera at the origin and a square of 2 by 2 that faces it, ten units off.
fn with_target(projection: Projection) -> (App, Entity, Entity) {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app, Transform::IDENTITY, projection);
    let target = spawn_mesh(&mut app, Rectangle::new(2.0, 2.0), Transform::from_xyz(0.0, 0.0, -10.0));
    (app, camera, target)
}

/// Checks a share up to the sampling error.
#[track_caller]
fn assert_about(seen: Option<f32>, expected: f32) {
    assert!(
        seen.is_some_and(|seen| (seen - expected).abs() <= 0.02),
        "{seen:?}, expected {expected}"
    );
}

// --- Between two points ---

#[test]
fn points_on_the_sides_that_two_walls_turn_to_each_other_see_each_other() {
    let mut app = headless_app();
    spawn_wall(&mut app, Vec3::ZERO, Vec2::splat(4.0));
    spawn_wall(&mut app, Vec3::NEG_Z * 5.0, Vec2::splat(4.0));
    settle(&mut app);
    let (front, back) = (Vec3::new(0.3, 0.2, -0.05), Vec3::new(-1.0, 0.4, -4.95));
    assert!(sees(&mut app, front, back, settings()));
    assert!(sees(&mut app, back, front, settings()));
    let behind = Vec3::new(-1.0, 0.4, -5.05);
    assert!(
        !sees(&mut app, front, behind, settings()),
        "through the whole of a wall"
    );
    assert!(!sees(&mut app, behind, front, settings()));
}

#[test]
fn where_rays_hit_is_seen_from_where_they_came() {
    let mut rng = rng(50);
    let mut app = headless_app();
    for _ in 0..200 {
        spawn_random(&mut app, &mut rng, 10.0);
    }
    settle(&mut app);
    query(&mut app, |scene| {
        let mut hits = 0;
        for _ in 0..3000 {
            let eye = random_point(&mut rng, 15.0);
            let ray = Ray3d::new(eye, random_dir(&mut rng));
            let both = settings().with_backfaces(Backfaces::Include);
            let Some(hit) = scene.cast_ray(ray, &both) else {
                continue;
            };
            // Where a line of sight grazes a surface, it is not told apart from its end for longer.
            if hit.normal.dot(*ray.direction).abs() < 0.1 {
                continue;
            }
            hits += 1;
            assert!(scene.line_of_sight(eye, hit.position, &settings()), "{hit:?}");
            assert!(scene.line_of_sight(hit.position, eye, &settings()), "{hit:?}");
            let beyond = ray.get_point(hit.distance + 0.01);
            let blocker = scene.line_of_sight_blocker(eye, beyond, &settings());
            assert_eq!(blocker.map(|blocker| blocker.entity), Some(hit.entity));
        }
        assert!(hits > 500, "{hits}");
    });
}

#[test]
fn what_blocks_is_the_nearest_to_where_one_looks_from() {
    let mut app = headless_app();
    let near = spawn_wall(&mut app, Vec3::NEG_Z * 2.0, Vec2::ONE);
    let far = spawn_wall(&mut app, Vec3::NEG_Z * 6.0, Vec2::ONE);
    settle(&mut app);
    let (here, there) = (Vec3::ZERO, Vec3::NEG_Z * 10.0);
    let hit = blocker(&mut app, here, there, settings()).expect("a wall");
    assert_eq!(hit.entity, near);
    assert!((hit.distance - 1.95).abs() < 1e-6);
    assert!(hit.position.distance(Vec3::NEG_Z * 1.95) < 1e-6);
    let hit = blocker(&mut app, there, here, settings()).expect("a wall");
    assert_eq!(hit.entity, far);
    assert!((hit.distance - 3.95).abs() < 1e-5);
    let but_near = [near];
    let hit = blocker(&mut app, here, there, settings().excluding(&but_near)).expect("a wall");
    assert_eq!(hit.entity, far);
    assert_eq!(blocker(&mut app, here, Vec3::NEG_Z, settings()), None);
    assert_eq!(blocker(&mut app, here, there, settings().with_max_distance(9.0)), None);
    assert_eq!(blocker(&mut app, here, here, settings()), None);
}

#[test]
fn one_looks_out_of_a_body_only_where_it_is_left_out() {
    let mut app = headless_app();
    let watcher = spawn_cube(&mut app, Vec3::ZERO);
    let watched = spawn_cube(&mut app, Vec3::X * 5.0);
    settle(&mut app);
    assert!(!sees(&mut app, Vec3::ZERO, Vec3::X * 5.0, settings()));
    assert!(!sees(
        &mut app,
        Vec3::ZERO,
        Vec3::X * 5.0,
        settings().excluding(&[watcher])
    ));
    assert!(sees(
        &mut app,
        Vec3::ZERO,
        Vec3::X * 5.0,
        settings().excluding(&[watcher, watched])
    ));
}

#[test]
fn a_hidden_wall_blocks_only_those_who_ask_for_hidden_things() {
    let mut app = headless_app();
    let wall = spawn_wall(&mut app, Vec3::ZERO, Vec2::ONE);
    app.world_mut().entity_mut(wall).insert(Visibility::Hidden);
    settle(&mut app);
    assert!(sees(&mut app, Vec3::Z, Vec3::NEG_Z, settings()));
    assert!(!sees(
        &mut app,
        Vec3::Z,
        Vec3::NEG_Z,
        settings().with_visibility(QueryVisibility::Any)
    ));
}

#[test]
fn points_closer_than_can_be_told_apart_see_each_other() {
    let mut app = headless_app();
    spawn_wall(&mut app, Vec3::X * 1000.0, Vec2::ONE);
    settle(&mut app);
    let (front, back) = (Vec3::new(1000.0, 0.0, 0.0501), Vec3::new(1000.0, 0.0, 0.0499));
    assert!(front.distance(back) < 1000.0 * LINE_OF_SIGHT);
    assert!(sees(&mut app, front, back, settings()));
    for tiny in [f32::MIN_POSITIVE, f32::from_bits(1)] {
        assert!(sees(&mut app, Vec3::ZERO, Vec3::X * tiny, settings()));
    }
}

#[test]
fn lines_of_sight_at_random_are_blocked_by_what_a_scan_of_all_finds() {
    let mut rng = rng(51);
    let mut app = headless_app();
    let entities: Vec<Entity> = (0..150).map(|_| spawn_random(&mut app, &mut rng, 12.0)).collect();
    settle(&mut app);
    query(&mut app, |scene| {
        let mut blocked = 0;
        for _ in 0..2000 {
            let (from, to) = (random_point(&mut rng, 15.0), random_point(&mut rng, 15.0));
            let length = from.distance(to);
            let nearest = entities
                .iter()
                .filter_map(|&entity| {
                    let is_it = |other| other == entity;
                    let alone = settings()
                        .with_max_distance(length)
                        .with_backfaces(Backfaces::Include)
                        .filter(&is_it);
                    scene.cast_ray(ray_towards(from, to), &alone)
                })
                .min_by(|a, b| a.distance.total_cmp(&b.distance));
            let blocker = scene.line_of_sight_blocker(from, to, &settings());
            assert_eq!(scene.line_of_sight(from, to, &settings()), blocker.is_none());
            assert_eq!(scene.line_of_sight(to, from, &settings()), blocker.is_none());
            match (blocker, nearest) {
                (Some(blocker), Some(nearest)) => {
                    assert!(
                        (blocker.distance - nearest.distance).abs() <= 1e-4,
                        "{blocker:?}, {nearest:?}"
                    );
                    blocked += 1;
                }
                (blocker, nearest) => assert_eq!(blocker, nearest),
            }
        }
        assert!((500..1900).contains(&blocked), "{blocked}");
    });
}

// --- The share that a camera sees ---

#[test]
fn what_stands_free_in_view_is_seen_wholly() {
    for projection in [perspective(), orthographic()] {
        let (mut app, camera, target) = with_target(projection);
        settle(&mut app);
        assert_eq!(seen(&mut app, camera, target, settings()), Some(1.0));
    }
}

#[test]
fn what_is_behind_a_wall_is_not_seen() {
    for projection in [perspective(), orthographic()] {
        let (mut app, camera, target) = with_target(projection);
        let wall = spawn_wall(&mut app, Vec3::NEG_Z * 5.0, Vec2::splat(2.0));
        settle(&mut app);
        assert_eq!(seen(&mut app, camera, target, settings()), Some(0.0));
        assert_eq!(seen(&mut app, camera, wall, settings()), Some(1.0));
        assert_eq!(seen(&mut app, camera, target, settings().excluding(&[wall])), Some(1.0));
    }
}

#[test]
fn a_wall_before_half_of_it_hides_half() {
    for projection in [perspective(), orthographic()] {
        let (mut app, camera, target) = with_target(projection);
        spawn_wall(&mut app, Vec3::new(2.0, 0.0, -9.5), Vec2::splat(4.0));
        settle(&mut app);
        assert_about(seen(&mut app, camera, target, settings()), 0.5);
    }
}

#[test]
fn what_reaches_out_of_the_view_by_half_is_seen_by_half() {
    // The edge of the view is at 10 in one case, and at 5 in the other.
    for (projection, edge) in [(perspective(), 10.0), (orthographic(), 5.0)] {
        let (mut app, camera, target) = with_target(projection);
        app.world_mut()
            .entity_mut(target)
            .insert(Transform::from_xyz(edge, 0.0, -10.0));
        settle(&mut app);
        // What is farther out is smaller by solid angle.
        let seen = seen(&mut app, camera, target, settings()).expect("it is there");
        assert!((seen - 0.5).abs() < 0.06, "{seen}");
    }
}

#[test]
fn what_is_out_of_the_view_is_not_seen() {
    for projection in [perspective(), orthographic()] {
        let (mut app, camera, target) = with_target(projection);
        for place in [
            Vec3::Z * 10.0,
            Vec3::new(14.0, 0.0, -10.0),
            Vec3::new(0.0, -14.0, -10.0),
            Vec3::Z * 0.1,
        ] {
            app.world_mut()
                .entity_mut(target)
                .insert(Transform::from_translation(place));
            settle(&mut app);
            assert_eq!(seen(&mut app, camera, target, settings()), Some(0.0), "{place}");
        }
    }
}

#[test]
fn what_is_beyond_the_far_plane_or_the_maximum_distance_is_not_seen() {
    let (mut app, camera, target) = with_target(orthographic());
    settle(&mut app);
    assert_eq!(
        seen(&mut app, camera, target, settings().with_max_distance(9.0)),
        Some(0.0)
    );
    let near = Projection::from(OrthographicProjection {
        far: 9.0,
        area: Rect::from_center_half_size(Vec2::ZERO, Vec2::splat(5.0)),
        ..OrthographicProjection::default_3d()
    });
    app.world_mut().entity_mut(camera).insert(near);
    app.update();
    assert_eq!(seen(&mut app, camera, target, settings()), Some(0.0));
}

#[test]
fn what_is_before_the_near_plane_hides_nothing() {
    let (mut app, camera, target) = with_target(perspective());
    spawn_wall(&mut app, Vec3::ZERO, Vec2::ONE);
    settle(&mut app);
    assert_eq!(seen(&mut app, camera, target, settings()), Some(1.0));
}

#[test]
fn both_projections_see_the_same_share_of_what_is_far_away() {
    let mut shares = Vec::new();
    for (projection, distance) in [
        (orthographic(), 500.0),
        (PerspectiveProjection { fov: 0.02, ..default() }.into(), 500.0),
    ] {
        let mut app = headless_app();
        let camera = spawn_camera(&mut app, Transform::from_xyz(0.0, 0.0, distance), projection);
        let target = spawn_mesh(&mut app, Sphere::new(1.0), Transform::IDENTITY);
        spawn_wall(&mut app, Vec3::new(1.0, 0.8, 2.0), Vec2::splat(2.0));
        settle(&mut app);
        shares.extend(seen(&mut app, camera, target, settings()));
    }
    assert!((shares[0] - shares[1]).abs() < 0.02, "{shares:?}");
    assert!((0.3..0.95).contains(&shares[0]), "{shares:?}");
}

#[test]
fn back_faces_hide_nothing_unless_they_are_hit() {
    let (mut app, camera, target) = with_target(perspective());
    let turned = Transform::from_xyz(0.0, 0.0, -5.0).with_rotation(Quat::from_rotation_y(std::f32::consts::PI));
    spawn_mesh(&mut app, Rectangle::new(4.0, 4.0), turned);
    settle(&mut app);
    assert_eq!(seen(&mut app, camera, target, settings()), Some(1.0));
    let both = settings().with_backfaces(Backfaces::Include);
    assert_eq!(seen(&mut app, camera, target, both), Some(0.0));
}

#[test]
fn an_entity_seen_only_from_behind_is_not_seen() {
    let (mut app, camera, target) = with_target(perspective());
    let turned = Transform::from_xyz(0.0, 0.0, -10.0).with_rotation(Quat::from_rotation_y(std::f32::consts::PI));
    app.world_mut().entity_mut(target).insert(turned);
    settle(&mut app);
    assert_eq!(seen(&mut app, camera, target, settings()), Some(0.0));
}

#[test]
fn what_lies_on_a_wall_is_not_hidden_by_it() {
    let (mut app, camera, target) = with_target(perspective());
    let wall = spawn_mesh(
        &mut app,
        Rectangle::new(20.0, 20.0),
        Transform::from_xyz(0.0, 0.0, -10.0),
    );
    settle(&mut app);
    assert_eq!(seen(&mut app, camera, target, settings()), Some(1.0));
    assert_eq!(seen(&mut app, camera, wall, settings()), Some(1.0));
}

#[test]
fn a_camera_sees_and_is_blocked_by_what_is_on_its_layers() {
    let (mut app, camera, target) = with_target(perspective());
    let wall = spawn_wall(&mut app, Vec3::NEG_Z * 5.0, Vec2::splat(2.0));
    let second = RenderLayers::layer(1);
    app.world_mut().entity_mut(wall).insert(second.clone());
    settle(&mut app);
    assert_eq!(seen(&mut app, camera, target, settings()), Some(1.0));
    assert_eq!(
        seen(&mut app, camera, wall, settings()),
        Some(0.0),
        "it does not draw it"
    );
    let both = RenderLayers::from_layers(&[0, 1]);
    assert_eq!(seen(&mut app, camera, target, settings().with_layers(&both)), Some(0.0));
    app.world_mut().entity_mut(camera).insert(both);
    app.update();
    assert_eq!(seen(&mut app, camera, target, settings()), Some(0.0));
}

#[test]
fn hidden_entities_neither_hide_nor_are_seen() {
    let (mut app, camera, target) = with_target(perspective());
    let wall = spawn_wall(&mut app, Vec3::NEG_Z * 5.0, Vec2::splat(2.0));
    app.world_mut().entity_mut(wall).insert(Visibility::Hidden);
    settle(&mut app);
    assert_eq!(seen(&mut app, camera, target, settings()), Some(1.0));
    assert_eq!(seen(&mut app, camera, wall, settings()), Some(0.0));
    let any = settings().with_visibility(QueryVisibility::Any);
    assert_eq!(seen(&mut app, camera, target, any), Some(0.0));
    assert_eq!(seen(&mut app, camera, wall, any), Some(1.0));
}

#[test]
fn there_is_no_share_without_a_camera_or_an_entity() {
    let (mut app, camera, target) = with_target(perspective());
    let bare = app.world_mut().spawn(Transform::default()).id();
    settle(&mut app);
    assert_eq!(seen(&mut app, target, target, settings()), None, "not a camera");
    assert_eq!(seen(&mut app, camera, bare, settings()), None, "without bounds");
    let world = app.world_mut();
    world.despawn(target);
    assert_eq!(seen(&mut app, camera, target, settings()), None, "despawned since");
    app.world_mut().despawn(camera);
    app.update();
    assert_eq!(seen(&mut app, camera, target, settings()), None);
}

#[test]
fn a_camera_without_an_inverse_sees_no_share() {
    let (mut app, camera, target) = with_target(perspective());
    // Bevy, which would compute it, does not take such transforms.
    app.world_mut().entity_mut(camera).remove::<Frustum>();
    for place in [
        Transform::from_scale(Vec3::ZERO),
        Transform::from_xyz(f32::NAN, 0.0, 0.0),
        Transform::from_xyz(0.0, f32::INFINITY, 0.0),
    ] {
        app.world_mut().entity_mut(camera).insert(place);
        settle(&mut app);
        assert_eq!(seen(&mut app, camera, target, settings()), None, "{place:?}");
    }
    let flat = OrthographicProjection {
        area: Rect::from_center_half_size(Vec2::ZERO, Vec2::ZERO),
        ..OrthographicProjection::default_3d()
    };
    app.world_mut()
        .entity_mut(camera)
        .insert((Transform::IDENTITY, Projection::from(flat)));
    app.update();
    assert_eq!(seen(&mut app, camera, target, settings()), None);
}

#[test]
fn an_entity_with_bounds_and_no_surface_is_not_seen() {
    let (mut app, camera, _) = with_target(perspective());
    let bounds = primitives::Aabb::from_min_max(Vec3::splat(-1.0), Vec3::splat(1.0));
    let empty = app
        .world_mut()
        .spawn((bounds, Transform::from_xyz(0.0, 0.0, -5.0)))
        .id();
    settle(&mut app);
    assert_eq!(seen(&mut app, camera, empty, settings()), Some(0.0));
}

#[test]
fn a_thin_pole_is_met_by_as_many_rays_as_a_ball() {
    let (mut app, camera, _) = with_target(perspective());
    let tilt = Quat::from_rotation_z(0.7);
    let pole = spawn_mesh(
        &mut app,
        Cuboid::new(0.1, 6.0, 0.1),
        Transform::from_xyz(0.0, 0.0, -9.0).with_rotation(tilt),
    );
    spawn_wall(&mut app, Vec3::new(0.0, -5.0, -5.0), Vec2::splat(10.0));
    settle(&mut app);
    // Along the pole, the edge of the wall is where the line from the eye passes it.
    assert_about(seen(&mut app, camera, pole, settings()), 0.5);
}

#[test]
fn the_eye_may_be_within_the_box_of_what_it_looks_at() {
    let (mut app, camera, _) = with_target(perspective());
    let floor = spawn_mesh(
        &mut app,
        Plane3d::default().mesh().size(200.0, 200.0),
        Transform::from_xyz(0.0, -1.0, 0.0),
    );
    let room = spawn_mesh(&mut app, Cuboid::from_length(100.0), Transform::IDENTITY);
    settle(&mut app);
    // A sixth of all directions is in a view of 90 degrees, half of it above the horizon.
    let both = settings().with_backfaces(Backfaces::Include);
    let but_the_rest = [room];
    assert_about(seen(&mut app, camera, floor, both.excluding(&but_the_rest)), 1.0 / 6.0);
    let is_room = |entity| entity == room;
    assert_about(seen(&mut app, camera, room, both.filter(&is_room)), 1.0 / 6.0);
}

#[test]
fn a_point_looks_in_all_directions() {
    let mut app = headless_app();
    let target = spawn_cube(&mut app, Vec3::Z * 10.0);
    spawn_wall(&mut app, Vec3::new(-5.0, 0.0, 5.0), Vec2::splat(10.0));
    settle(&mut app);
    let seen = |app: &mut App, eye| query(app, |scene| scene.visible_fraction_from(eye, target, 256, &settings()));
    assert_about(seen(&mut app, Vec3::ZERO), 0.5);
    assert_eq!(seen(&mut app, Vec3::Z * 20.0), Some(1.0));
    assert_eq!(
        seen(&mut app, Vec3::Z * 10.0),
        Some(0.0),
        "from inside, only back faces"
    );
    for nowhere in [Vec3::NAN, Vec3::INFINITY] {
        assert_eq!(seen(&mut app, nowhere), None);
    }
}

#[test]
fn a_system_that_asks_may_change_cameras() {
    fn ask(
        scene: SceneQuery,
        mut cameras: Query<(Entity, &mut Camera, &mut Transform)>,
        target: Single<Entity, With<Mesh3d>>,
    ) {
        for (entity, mut camera, mut place) in &mut cameras {
            camera.order += 1;
            place.translation.x += 0.001;
            assert_eq!(scene.visible_fraction(entity, *target, 16, &settings()), Some(1.0));
        }
    }
    let (mut app, _, _) = with_target(perspective());
    settle(&mut app);
    app.add_systems(Update, ask);
    app.update();
}

#[test]
fn a_skinned_mesh_is_seen_and_blocks_where_it_is_posed() {
    let mut app = headless_app();
    // Spawned far off, and faces up.
    let at = |x| Transform::from_xyz(x, 0.0, 0.0);
    let rig = spawn_rig(&mut app, with_one_joint(square()), &[at(5.0)]);
    settle(&mut app);
    let blocks = |app: &mut App, x: f32| !sees(app, Vec3::new(x, 1.0, 0.1), Vec3::new(x, -1.0, 0.1), settings());
    let seen = |app: &mut App, eye| {
        query(app, |scene| {
            scene.visible_fraction_from(eye, rig.entity, 64, &settings())
        })
    };
    assert!(blocks(&mut app, 5.0) && !blocks(&mut app, 8.0));
    let over_both = Vec3::new(6.5, 4.0, 0.0);
    assert_eq!(seen(&mut app, over_both), Some(1.0));
    spawn_mesh(&mut app, Cuboid::new(2.0, 0.1, 2.0), Transform::from_xyz(5.3, 1.0, 0.0));
    app.update();
    assert_eq!(seen(&mut app, over_both), Some(0.0));
    move_joint(&mut app, rig.joints[0], at(8.0));
    app.update();
    assert!(blocks(&mut app, 8.0));
    assert_eq!(seen(&mut app, over_both), Some(1.0));
}

// --- Against an oracle ---

/// Something somewhere, of some size and turned somehow.
fn spawn_random(app: &mut App, rng: &mut ChaCha8Rng, extent: f32) -> Entity {
    let place = Transform {
        translation: random_point(rng, extent),
        rotation: random_rotation(rng),
        scale: Vec3::from_array(std::array::from_fn(|_| rng.random_range(0.3..3.0))),
    };
    match rng.random_range(0..3) {
        0 => spawn_mesh(app, Cuboid::default(), place),
        1 => spawn_mesh(app, Sphere::new(0.6).mesh().uv(12, 8), place),
        _ => app
            .world_mut()
            .spawn((PickShape::new(Cylinder::new(0.5, 1.5)), place))
            .id(),
    }
}

/// The share of an entity that a camera sees, by rays in a fine lattice over all that may be met: by solid angle from a
/// point, by area in parallel.
fn share_by_lattice(
    scene: &SceneQuery,
    view: (&Camera, &GlobalTransform),
    parallel: bool,
    entity: Entity,
) -> Option<f32> {
    const SIDE: i32 = 160;
    let (camera, place) = view;
    let aabb: Aabb3d = scene.index().aabb(entity)?;
    let (center, radius): (Vec3, f32) = (aabb.center().into(), aabb.half_size().length());
    let forward: Dir3 = if parallel {
        place.forward()
    } else {
        Dir3::new(center - place.translation()).ok()?
    };
    let (right, up) = forward.any_orthonormal_pair();
    // The outline of the ball around the box, which is wider than the ball from near by.
    let reach = if parallel {
        radius
    } else {
        radius / (1.0 - (radius / center.distance(place.translation())).powi(2)).sqrt()
    };
    let is_it = |other| other == entity;
    let alone = settings().filter(&is_it);
    let (mut met, mut seen) = (0.0_f32, 0.0_f32);
    for (x, y) in (0..SIDE * SIDE).map(|n| (n % SIDE, n / SIDE)) {
        let at = |n| (n as f32 + 0.5) / SIDE as f32 * 2.0 - 1.0;
        let aside = center + (right * at(x) + up * at(y)) * reach;
        let (ray, weight) = if parallel {
            // From the near plane, which is where the camera is.
            let depth = (aside - place.translation()).dot(*forward);
            (Ray3d::new(aside - forward * depth, forward), 1.0)
        } else {
            // The solid angle of a patch of a plane.
            let ray = ray_towards(place.translation(), aside);
            (ray, ray.direction.dot(*forward).powi(3))
        };
        let Some(hit) = scene.cast_ray(ray, &alone) else {
            continue;
        };
        met += weight;
        let is_first = scene
            .cast_ray(ray, &settings())
            .is_some_and(|first| first.entity == entity);
        let in_view = |ndc: Vec3| ndc.truncate().abs().max_element() <= 1.0 && (0.0..=1.0).contains(&ndc.z);
        let in_view = camera.world_to_ndc(place, hit.position).is_some_and(in_view);
        let is_ahead = (hit.position - place.translation()).dot(*place.forward()) > 0.0;
        if is_first && in_view && is_ahead {
            seen += weight;
        }
    }
    (met > 0.0).then_some(seen / met)
}

fn shares_agree_with_a_lattice(projection: Projection, parallel: bool, seed: u64) {
    let mut rng = rng(seed);
    let (mut worst, mut squares, mut partly) = (0.0_f32, 0.0_f32, 0);
    let mut compared = 0;
    for _ in 0..6 {
        let mut app = headless_app();
        let mut place = Transform::from_translation(random_point(&mut rng, 4.0) + Vec3::Z * 14.0);
        place.look_at(random_point(&mut rng, 4.0), Vec3::Y);
        let camera_entity = spawn_camera(&mut app, place, projection.clone());
        let entities: Vec<Entity> = (0..60).map(|_| spawn_random(&mut app, &mut rng, 7.0)).collect();
        settle(&mut app);
        // The oracle asks Bevy's camera, whose matrix nobody computes without a renderer.
        let mut camera = Camera::default();
        camera.computed.clip_from_view = projection.get_clip_from_view();
        let place = GlobalTransform::from(place);
        query(&mut app, |scene| {
            for &entity in entities.iter().step_by(3) {
                let aabb = scene.index().aabb(entity).expect("it is there");
                let distance = Vec3::from(aabb.center()).distance(place.translation());
                if distance < 1.5 * aabb.half_size().length() {
                    continue;
                }
                let expected = share_by_lattice(&scene, (&camera, &place), parallel, entity);
                let seen = scene
                    .visible_fraction(camera_entity, entity, 256, &settings())
                    .expect("it is there");
                let error = (seen - expected.unwrap_or(0.0)).abs();
                worst = worst.max(error);
                squares += error * error;
                partly += u32::from((0.05..0.95).contains(&seen));
                compared += 1;
            }
        });
    }
    let rms = (squares / compared as f32).sqrt();
    assert!(worst < 0.05 && rms < 0.015, "{worst} at worst, {rms} on average");
    assert!(partly > compared / 5, "{partly} of {compared} are hidden in part");
}

#[test]
fn shares_in_perspective_are_those_of_a_fine_lattice() {
    shares_agree_with_a_lattice(perspective(), false, 52);
}

#[test]
fn orthographic_shares_are_those_of_a_fine_lattice() {
    shares_agree_with_a_lattice(orthographic(), true, 53);
}
