//! What a game asks of the scene, and what it is told.

use bevy::{
    camera::visibility::RenderLayers,
    math::bounding::{Aabb3d, BoundingSphere, IntersectsVolume},
    picking::mesh_picking::ray_cast::RayCastBackfaces,
    prelude::*,
};
use bevy_sightline::{geometry::ray::triangle::Backfaces, prelude::*};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use crate::common::*;

/// Cubes at z = 0, -10, -20, …, the nearest first to a ray from +z.
fn row_of_cubes(n: usize) -> (App, Vec<Entity>) {
    let mut app = headless_app();
    let cubes = (0..n)
        .map(|i| spawn_cube(&mut app, Vec3::NEG_Z * 10.0 * i as f32))
        .collect();
    settle(&mut app);
    (app, cubes)
}

/// The ray that meets a row of cubes.
const ALONG: Ray3d = Ray3d {
    origin: Vec3::new(0.1, 0.2, 10.0),
    direction: Dir3::NEG_Z,
};

/// An app with one mesh.
fn app_with(mesh: impl Into<Mesh>, transform: Transform) -> (App, Entity) {
    let mut app = headless_app();
    let entity = spawn_mesh(&mut app, mesh, transform);
    settle(&mut app);
    (app, entity)
}

fn cast_with(app: &mut App, ray: Ray3d, settings: SceneQuerySettings) -> Option<RayHit> {
    let hit = query(app, |scene| {
        (scene.cast_ray(ray, &settings), scene.any_hit(ray, &settings))
    });
    assert_eq!(hit.0.is_some(), hit.1, "both agree");
    hit.0
}

/// The entity that a ray hits.
fn hit_with(app: &mut App, ray: Ray3d, settings: SceneQuerySettings) -> Option<Entity> {
    cast_with(app, ray, settings).map(|hit| hit.entity)
}

/// The entities along a ray, until one of `blocking`.
fn along(app: &mut App, ray: Ray3d, settings: SceneQuerySettings, blocking: &[Entity]) -> Vec<Entity> {
    let hits = query(app, |scene| {
        let mut hits = Vec::new();
        scene.cast_ray_until(ray, &settings, |entity| blocking.contains(&entity), &mut hits);
        hits
    });
    assert!(hits.is_sorted_by(|a, b| a.distance <= b.distance));
    hits.iter().map(|hit| hit.entity).collect()
}

fn sees(app: &mut App, from: Vec3, to: Vec3, settings: SceneQuerySettings) -> bool {
    query(app, |scene| scene.line_of_sight(from, to, &settings))
}

fn sphere() -> Mesh {
    Sphere::new(1.0).mesh().ico(20).expect("not too fine")
}

fn settings<'a>() -> SceneQuerySettings<'a> {
    SceneQuerySettings::default()
}

/// Without roll and all positive, rotated, stretched, mirrored once and mirrored twice.
fn transforms() -> [Transform; 5] {
    let turned = Transform::from_xyz(3.0, -2.0, 5.0).with_rotation(Quat::from_euler(EulerRot::XYZ, 0.4, -1.1, 2.0));
    let scales = [
        Vec3::new(0.5, 2.0, 3.0),
        Vec3::new(-1.0, 2.0, 0.7),
        Vec3::new(-1.0, -2.0, 0.7),
    ];
    let [stretched, mirrored, twice] = scales.map(|scale| turned.with_scale(scale));
    [Transform::from_xyz(1.0, 2.0, 3.0), turned, stretched, mirrored, twice]
}

// --- The nearest hit ---

#[test]
fn the_nearest_of_several_is_hit() {
    let (mut app, cubes) = row_of_cubes(5);
    assert_eq!(hit_with(&mut app, ALONG, settings()), Some(cubes[0]));
    let back = Ray3d::new(Vec3::new(0.0, 0.0, -100.0), Dir3::Z);
    assert_eq!(hit_with(&mut app, back, settings()), Some(cubes[4]));
}

#[test]
fn a_ray_past_everything_hits_nothing() {
    let (mut app, _) = row_of_cubes(3);
    assert_eq!(cast(&mut app, Ray3d::new(Vec3::new(0.6, 0.0, 10.0), Dir3::NEG_Z)), None);
    assert_eq!(cast(&mut app, Ray3d::new(Vec3::new(0.0, 0.0, 10.0), Dir3::Z)), None);
}

#[test]
fn an_empty_scene_answers_nothing() {
    let mut app = headless_app();
    app.update();
    assert_eq!(cast_with(&mut app, ALONG, settings()), None);
    assert!(sees(&mut app, Vec3::ZERO, Vec3::ONE, settings()));
}

#[test]
fn distance_place_and_normal_of_a_hit_are_right() {
    let (mut app, cube) = app_with(Cuboid::new(2.0, 2.0, 2.0), Transform::from_xyz(0.0, 0.0, -4.0));
    let hit = cast(&mut app, ALONG).expect("the cube is in the way");
    assert_eq!(hit.entity, cube);
    assert!((hit.distance - 13.0).abs() < 1e-5);
    assert!(hit.position.abs_diff_eq(Vec3::new(0.1, 0.2, -3.0), 1e-5));
    assert!(hit.normal.abs_diff_eq(Vec3::Z, 1e-6));
}

#[test]
fn of_hits_at_one_distance_the_smallest_entity_wins() {
    let mut app = headless_app();
    let twins = [(); 3].map(|()| spawn_cube(&mut app, Vec3::ZERO));
    settle(&mut app);
    assert_eq!(hit_with(&mut app, ALONG, settings()), twins.iter().copied().min());
    let mut sorted = twins.to_vec();
    sorted.sort();
    assert_eq!(along(&mut app, ALONG, settings(), &[]), sorted);
}

#[test]
fn normals_are_right_under_every_transform() {
    for transform in transforms() {
        let (mut app, _) = app_with(sphere(), transform);
        let mut rng = rng(70);
        for _ in 0..100 {
            let ray = ray_towards(
                transform.translation + random_dir(&mut rng) * 20.0,
                transform.translation,
            );
            let hit = cast(&mut app, ray).expect("the sphere is in the way");
            let local = transform.compute_affine().inverse().transform_point3(hit.position);
            let expected = (transform.rotation * (local / transform.scale)).normalize();
            assert!(hit.normal.is_normalized());
            assert!(
                hit.normal.dot(expected) > 0.999,
                "{} {expected} {transform:?}",
                hit.normal
            );
            assert!(hit.normal.dot(*ray.direction) < 0.0, "on the front side");
        }
    }
}

#[test]
fn the_normal_of_a_stretched_slope_is_at_right_angles_to_it() {
    // The plane x + y = 0, with the normal (1, 1, 0), becomes x/4 + y = 0.
    let slope = Plane3d::new(Vec3::new(1.0, 1.0, 0.0).normalize(), Vec2::ONE);
    let (mut app, _) = app_with(slope, Transform::from_scale(Vec3::new(4.0, 1.0, 1.0)));
    let hit = cast(&mut app, Ray3d::new(Vec3::Y * 5.0, Dir3::NEG_Y)).expect("the slope is in the way");
    assert!(
        hit.normal.abs_diff_eq(Vec3::new(0.25, 1.0, 0.0).normalize(), 1e-5),
        "{}",
        hit.normal
    );
}

#[test]
fn the_triangle_of_a_hit_lies_in_the_world_around_it() {
    for transform in transforms() {
        let (mut app, _) = app_with(sphere(), transform);
        let mut rng = rng(71);
        for _ in 0..100 {
            let ray = ray_towards(
                transform.translation + random_dir(&mut rng) * 20.0,
                transform.translation,
            );
            let hit = cast(&mut app, ray).expect("the sphere is in the way");
            let HitTriangle {
                vertices: [a, b, c],
                barycentrics,
                ..
            } = hit.triangle.expect("a mesh was hit");
            let weighted = a * barycentrics.x + b * barycentrics.y + c * barycentrics.z;
            assert!(weighted.abs_diff_eq(hit.position, 1e-4), "{weighted} {}", hit.position);
            assert!((hit.distance - hit.position.distance(ray.origin)).abs() < 1e-4);
        }
    }
}

#[test]
fn texture_coordinates_are_those_of_the_mesh() {
    let (mut app, _) = app_with(Rectangle::new(4.0, 2.0), Transform::default());
    let hit = cast(&mut app, Ray3d::new(Vec3::new(-1.0, 0.5, 3.0), Dir3::NEG_Z)).expect("the rectangle is in the way");
    assert!(
        hit.uv
            .expect("it has texture coordinates")
            .abs_diff_eq(Vec2::new(0.25, 0.25), 1e-5)
    );
    let bare = Mesh::from(Rectangle::new(4.0, 2.0)).with_removed_attribute(Mesh::ATTRIBUTE_UV_0);
    let (mut app, _) = app_with(bare, Transform::default());
    assert_eq!(
        hit_at(&mut app, Vec3::new(-1.0, 0.5, 0.0)).map(|hit| hit.uv),
        Some(None)
    );
}

#[test]
fn a_flattened_mesh_is_hit() {
    let (mut app, disc) = app_with(sphere(), Transform::from_scale(Vec3::new(2.0, 0.0, 2.0)));
    for (from, normal) in [(Vec3::Y, Vec3::Y), (Vec3::NEG_Y, Vec3::NEG_Y)] {
        let ray = Ray3d::new(
            Vec3::new(1.1, 0.0, 0.3) + from * 5.0,
            Dir3::new(-from).expect("a unit vector"),
        );
        let hit = cast(&mut app, ray).expect("the disc is in the way");
        assert_eq!((hit.entity, hit.distance), (disc, 5.0));
        assert!(hit.normal.abs_diff_eq(normal, 1e-5), "{}", hit.normal);
    }
    assert_eq!(cast(&mut app, Ray3d::new(Vec3::new(2.1, 5.0, 0.0), Dir3::NEG_Y)), None);
}

#[test]
fn the_size_of_an_entity_does_not_matter() {
    for size in [1e-6, 1e-3, 1.0, 1e3, 1e6] {
        let (mut app, cube) = app_with(Cuboid::default(), Transform::from_scale(Vec3::splat(size)));
        let through = |x: f32| Ray3d::new(Vec3::new(x, 0.1, 3.0) * size, Dir3::NEG_Z);
        let hit = cast(&mut app, through(0.4)).expect("the cube is in the way");
        assert_eq!((hit.entity, hit.normal), (cube, Vec3::Z));
        assert!((hit.distance / size - 2.5).abs() < 1e-5);
        assert_eq!(cast(&mut app, through(0.6)), None);
    }
}

#[test]
fn far_from_the_origin_of_the_world_entities_are_hit() {
    let far = Vec3::new(1e5, -1e5, 1e5);
    let (mut app, cube) = app_with(Cuboid::default(), Transform::from_translation(far));
    let hit =
        cast(&mut app, Ray3d::new(far + Vec3::new(0.25, 0.25, 10.0), Dir3::NEG_Z)).expect("the cube is in the way");
    assert_eq!(hit.entity, cube);
    assert!((hit.distance - 9.5).abs() < 0.02);
    assert_eq!(
        cast(&mut app, Ray3d::new(far + Vec3::new(0.75, 0.0, 10.0), Dir3::NEG_Z)),
        None
    );
}

#[test]
fn rays_that_are_not_finite_hit_nothing() {
    let (mut app, _) = row_of_cubes(2);
    for origin in [Vec3::NAN, Vec3::INFINITY, Vec3::new(0.0, f32::NAN, 10.0)] {
        let ray = Ray3d { origin, ..ALONG };
        assert_eq!(cast_with(&mut app, ray, settings()), None);
        assert_eq!(along(&mut app, ray, settings(), &[]), []);
    }
}

#[test]
fn what_was_despawned_since_the_last_frame_is_not_hit() {
    let (mut app, cubes) = row_of_cubes(2);
    app.world_mut().despawn(cubes[0]);
    assert_eq!(hit_with(&mut app, ALONG, settings()), Some(cubes[1]));
    assert_eq!(along(&mut app, ALONG, settings(), &[]), [cubes[1]]);
    assert_eq!(
        in_sphere(&mut app, BoundingSphere::new(Vec3::ZERO, 100.0), settings()),
        [cubes[1]]
    );
}

// --- Settings ---

#[test]
fn a_ray_reaches_as_far_as_it_is_told() {
    let (mut app, cubes) = row_of_cubes(3);
    assert_eq!(hit_with(&mut app, ALONG, settings().with_max_distance(9.4)), None);
    assert_eq!(
        hit_with(&mut app, ALONG, settings().with_max_distance(9.6)),
        Some(cubes[0])
    );
    assert_eq!(
        along(&mut app, ALONG, settings().with_max_distance(25.0), &[]),
        cubes[..2]
    );
    for useless in [-1.0, f32::NAN] {
        assert_eq!(hit_with(&mut app, ALONG, settings().with_max_distance(useless)), None);
    }
}

#[test]
fn only_entities_that_share_a_layer_are_hit() {
    let (mut app, cubes) = row_of_cubes(4);
    app.world_mut().entity_mut(cubes[1]).insert(RenderLayers::layer(1));
    app.world_mut()
        .entity_mut(cubes[2])
        .insert(RenderLayers::from_layers(&[1, 2]));
    app.world_mut().entity_mut(cubes[3]).insert(RenderLayers::none());
    app.update();
    let on = |app: &mut App, layers: &RenderLayers| along(app, ALONG, settings().with_layers(layers), &[]);
    assert_eq!(
        along(&mut app, ALONG, settings(), &[]),
        cubes,
        "without layers everything counts"
    );
    assert_eq!(on(&mut app, &RenderLayers::default()), [cubes[0]]);
    assert_eq!(on(&mut app, &RenderLayers::layer(1)), [cubes[1], cubes[2]]);
    assert_eq!(on(&mut app, &RenderLayers::layer(2)), [cubes[2]]);
    assert_eq!(on(&mut app, &RenderLayers::from_layers(&[0, 1])), cubes[..3]);
    assert_eq!(on(&mut app, &RenderLayers::none()), []);
}

#[test]
fn hidden_entities_are_hit_only_when_visibility_is_not_asked() {
    let (mut app, cubes) = row_of_cubes(2);
    app.world_mut().entity_mut(cubes[0]).insert(Visibility::Hidden);
    app.update();
    let hit = |app: &mut App, visibility| hit_with(app, ALONG, settings().with_visibility(visibility));
    assert_eq!(hit(&mut app, QueryVisibility::Any), Some(cubes[0]));
    assert_eq!(hit(&mut app, QueryVisibility::Visible), Some(cubes[1]));
    assert_eq!(
        hit(&mut app, QueryVisibility::VisibleInView),
        None,
        "there is no camera"
    );
}

#[test]
fn only_what_a_camera_sees_is_visible_in_view() {
    let (mut app, cubes) = row_of_cubes(3);
    // Between the first and the second, looking at the second and the third.
    app.world_mut()
        .spawn((Camera3d::default(), Transform::from_xyz(0.0, 0.0, -5.0)));
    app.world_mut().entity_mut(cubes[1]).insert(Visibility::Hidden);
    app.update();
    let seen = |app: &mut App| {
        along(
            app,
            ALONG,
            settings().with_visibility(QueryVisibility::VisibleInView),
            &[],
        )
    };
    assert_eq!(seen(&mut app), [cubes[2]]);
    app.world_mut().entity_mut(cubes[1]).insert(Visibility::Visible);
    app.update();
    assert_eq!(seen(&mut app), [cubes[1], cubes[2]]);
}

#[test]
fn excluded_entities_are_passed_over() {
    let (mut app, cubes) = row_of_cubes(3);
    assert_eq!(
        hit_with(&mut app, ALONG, settings().excluding(&cubes[..2])),
        Some(cubes[2])
    );
    assert_eq!(hit_with(&mut app, ALONG, settings().excluding(&cubes)), None);
}

#[test]
fn entities_that_the_predicate_rejects_are_passed_over() {
    let (mut app, cubes) = row_of_cubes(3);
    let is_last = |entity| entity == cubes[2];
    assert_eq!(hit_with(&mut app, ALONG, settings().filter(&is_last)), Some(cubes[2]));
    assert_eq!(
        in_sphere(
            &mut app,
            BoundingSphere::new(Vec3::ZERO, 100.0),
            settings().filter(&is_last)
        ),
        [cubes[2]]
    );
}

#[test]
fn from_inside_a_closed_mesh_a_ray_hits_only_back_faces() {
    let (mut app, cube) = app_with(Cuboid::new(2.0, 2.0, 2.0), Transform::default());
    let outward = Ray3d::new(Vec3::ZERO, Dir3::X);
    assert_eq!(cast_with(&mut app, outward, settings()), None);
    let hit = cast_with(&mut app, outward, settings().with_backfaces(Backfaces::Include)).expect("the far wall");
    assert_eq!((hit.entity, hit.distance, hit.normal), (cube, 1.0, Vec3::X));
}

#[test]
fn the_settings_overrule_what_an_entity_says_of_back_faces() {
    let (mut app, cube) = app_with(Cuboid::new(2.0, 2.0, 2.0), Transform::default());
    app.world_mut().entity_mut(cube).insert(RayCastBackfaces);
    app.update();
    let outward = Ray3d::new(Vec3::ZERO, Dir3::X);
    assert_eq!(hit_with(&mut app, outward, settings()), Some(cube));
    assert_eq!(
        hit_with(&mut app, outward, settings().with_backfaces(Backfaces::Cull)),
        None
    );
}

#[test]
fn a_mirrored_mesh_keeps_its_front() {
    let (mut app, cube) = app_with(Cuboid::default(), Transform::from_scale(Vec3::new(-1.0, 1.0, 1.0)));
    assert_eq!(hit_with(&mut app, ALONG, settings()), Some(cube));
    assert_eq!(cast(&mut app, Ray3d::new(Vec3::ZERO, Dir3::X)), None);
}

// --- All hits ---

#[test]
fn all_hits_come_nearest_first_and_once_for_each_entity() {
    let (mut app, cubes) = row_of_cubes(20);
    assert_eq!(
        along(&mut app, ALONG, settings().with_backfaces(Backfaces::Include), &[]),
        cubes
    );
}

#[test]
fn a_ray_ends_at_the_nearest_that_blocks_it() {
    let (mut app, cubes) = row_of_cubes(20);
    assert_eq!(along(&mut app, ALONG, settings(), &cubes[7..]), cubes[..=7]);
    assert_eq!(along(&mut app, ALONG, settings(), &[cubes[12], cubes[3]]), cubes[..=3]);
    assert_eq!(along(&mut app, ALONG, settings(), &cubes[..1]), cubes[..1]);
}

#[test]
fn what_was_in_the_buffers_is_overwritten() {
    let (mut app, cubes) = row_of_cubes(1);
    let hit = cast(&mut app, ALONG).expect("the cube is in the way");
    let (hits, entities) = query(&mut app, |scene| {
        let (mut hits, mut entities) = (vec![hit; 5], vec![Entity::PLACEHOLDER; 5]);
        scene.cast_ray_all(ALONG, &settings(), &mut hits);
        scene.overlap(&Aabb3d::new(Vec3::ZERO, Vec3::ONE), &settings(), &mut entities);
        let found = (hits.clone(), entities.clone());
        let nowhere = Ray3d {
            origin: Vec3::NAN,
            ..ALONG
        };
        scene.cast_ray_all(nowhere, &settings(), &mut hits);
        scene.overlap(&BoundingSphere::new(Vec3::ONE * 50.0, 1.0), &settings(), &mut entities);
        assert!(hits.is_empty() && entities.is_empty());
        found
    });
    assert_eq!((hits, entities), (vec![hit], cubes));
}

// --- Line of sight ---

#[test]
fn what_lies_between_blocks_the_view() {
    let (mut app, cubes) = row_of_cubes(1);
    let (here, there, aside) = (Vec3::Z * 5.0, Vec3::NEG_Z * 5.0, Vec3::X * 5.0);
    assert!(!sees(&mut app, here, there, settings()));
    assert!(sees(&mut app, here, aside, settings()));
    assert!(sees(&mut app, here, Vec3::Z, settings()), "what lies behind does not");
    assert!(sees(&mut app, here, there, settings().excluding(&cubes)));
}

#[test]
fn the_view_is_the_same_from_both_sides() {
    // A plane has one side only.
    let (mut app, _) = app_with(Plane3d::default().mesh().size(2.0, 2.0), Transform::default());
    let (above, below) = (Vec3::new(0.3, 3.0, 0.1), Vec3::new(0.2, -3.0, 0.1));
    assert!(!sees(&mut app, above, below, settings()));
    assert!(!sees(&mut app, below, above, settings()));
    let culled = settings().with_backfaces(Backfaces::Cull);
    assert!(!sees(&mut app, above, below, culled));
    assert!(sees(&mut app, below, above, culled), "as the settings say");
}

#[test]
fn a_point_sees_itself() {
    let (mut app, _) = row_of_cubes(1);
    assert!(sees(&mut app, Vec3::ZERO, Vec3::ZERO, settings()));
}

#[test]
fn nothing_is_seen_beyond_the_maximum_distance() {
    let mut app = headless_app();
    app.update();
    assert!(sees(
        &mut app,
        Vec3::ZERO,
        Vec3::X * 10.0,
        settings().with_max_distance(10.0)
    ));
    assert!(!sees(
        &mut app,
        Vec3::ZERO,
        Vec3::X * 10.0,
        settings().with_max_distance(9.9)
    ));
}

#[test]
fn nothing_is_seen_from_or_at_a_place_that_is_not_finite() {
    let mut app = headless_app();
    app.update();
    for nowhere in [Vec3::NAN, Vec3::INFINITY, Vec3::new(0.0, f32::NEG_INFINITY, 0.0)] {
        assert!(!sees(&mut app, nowhere, Vec3::ZERO, settings()));
        assert!(!sees(&mut app, Vec3::ZERO, nowhere, settings()));
    }
}

#[test]
fn points_so_far_apart_that_their_distance_overflows_do_not_see_through_things() {
    let (mut app, _) = row_of_cubes(1);
    assert!(!sees(&mut app, Vec3::Z * 3e38, Vec3::NEG_Z * 3e38, settings()));
}

// --- Overlaps ---

fn in_box(app: &mut App, aabb: Aabb3d, settings: SceneQuerySettings) -> Vec<Entity> {
    query(app, |scene| {
        let mut found = Vec::new();
        scene.overlap(&aabb, &settings, &mut found);
        found
    })
}

fn in_sphere(app: &mut App, sphere: BoundingSphere, settings: SceneQuerySettings) -> Vec<Entity> {
    query(app, |scene| {
        let mut found = Vec::new();
        scene.overlap(&sphere, &settings, &mut found);
        found
    })
}

#[test]
fn touching_is_overlapping() {
    let (mut app, cubes) = row_of_cubes(1);
    assert_eq!(
        in_box(&mut app, Aabb3d::new(Vec3::X, Vec3::splat(0.5)), settings()),
        cubes
    );
    assert_eq!(
        in_box(&mut app, Aabb3d::new(Vec3::X, Vec3::splat(0.49)), settings()),
        []
    );
    assert_eq!(
        in_sphere(&mut app, BoundingSphere::new(Vec3::X, 0.5), settings()),
        cubes
    );
    assert_eq!(in_sphere(&mut app, BoundingSphere::new(Vec3::X, 0.49), settings()), []);
}

fn random_transform(rng: &mut ChaCha8Rng) -> Transform {
    let scale = random_point(rng, 3.0).abs() + 0.1;
    Transform::from_translation(random_point(rng, 20.0))
        .with_rotation(random_rotation(rng))
        .with_scale(scale)
}

#[test]
fn overlaps_agree_with_a_plain_loop_over_a_random_scene() {
    let mut app = headless_app();
    let mut rng = rng(72);
    let mesh = add_mesh(&mut app, Cuboid::default());
    let mut all: Vec<(Entity, bool, bool)> = Vec::new();
    for _ in 0..300 {
        let (is_shown, is_on_layer) = (rng.random_bool(0.8), rng.random_bool(0.7));
        let visibility = if is_shown {
            Visibility::Inherited
        } else {
            Visibility::Hidden
        };
        let layer = RenderLayers::layer(if is_on_layer { 1 } else { 2 });
        let entity = app
            .world_mut()
            .spawn((Mesh3d(mesh.clone()), random_transform(&mut rng), visibility, layer));
        all.push((entity.id(), is_shown, is_on_layer));
    }
    settle(&mut app);
    all.sort();
    let boxes: Vec<Aabb3d> = all
        .iter()
        .map(|(entity, ..)| index(&app).aabb(*entity).expect("indexed"))
        .collect();
    let layer = RenderLayers::layer(1);
    let on_layer = settings().with_layers(&layer);
    let mut found = 0;
    for _ in 0..200 {
        let aabb = Aabb3d::new(random_point(&mut rng, 20.0), random_point(&mut rng, 8.0).abs());
        let sphere = BoundingSphere::new(random_point(&mut rng, 20.0), rng.random_range(0.0..8.0));
        let expect = |touches: &dyn Fn(&Aabb3d) -> bool, needs_layer: bool| -> Vec<Entity> {
            let admitted = all.iter().zip(&boxes).filter(|((_, is_shown, is_on_layer), aabb)| {
                *is_shown && (*is_on_layer || !needs_layer) && touches(aabb)
            });
            admitted.map(|((entity, ..), _)| *entity).collect()
        };
        let (touches_box, touches_sphere) = (|b: &Aabb3d| b.intersects(&aabb), |b: &Aabb3d| b.intersects(&sphere));
        assert_eq!(in_box(&mut app, aabb, settings()), expect(&touches_box, false));
        assert_eq!(in_box(&mut app, aabb, on_layer), expect(&touches_box, true));
        assert_eq!(in_sphere(&mut app, sphere, settings()), expect(&touches_sphere, false));
        assert_eq!(in_sphere(&mut app, sphere, on_layer), expect(&touches_sphere, true));
        found += expect(&touches_box, true).len();
    }
    assert!(found > 100, "only {found} overlaps");
}
