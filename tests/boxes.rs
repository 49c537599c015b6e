//! What a game asks of world boxes: what is where, what is near, what is in the way, what touches.

use bevy::{
    camera::visibility::RenderLayers,
    math::{
        Vec3A,
        bounding::{Aabb3d, BoundingSphere, IntersectsVolume},
        primitives::ViewFrustum,
    },
    prelude::*,
};
use bevy_sightline::{
    geometry::{
        convex_hull::ConvexHull,
        obb::Obb,
        ray::Ray,
        sweep::{AabbSweep, SphereSweep, SweepIntersection},
        volume::Volume,
    },
    prelude::*,
    spatial::{Neighbour, Region, SpatialQueries},
};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use crate::common::*;

fn settings<'a>() -> SceneQuerySettings<'a> {
    SceneQuerySettings::default()
}

/// Unit cubes at x = 0, 10, 20, ….
fn row_of_cubes(n: usize) -> (App, Vec<Entity>) {
    let mut app = headless_app();
    let cubes = (0..n)
        .map(|i| spawn_cube(&mut app, Vec3::X * 10.0 * i as f32))
        .collect();
    settle(&mut app);
    (app, cubes)
}

fn random_scene(n: usize, rng: &mut ChaCha8Rng) -> App {
    let mut app = headless_app();
    let cube = add_mesh(&mut app, Cuboid::default());
    for _ in 0..n {
        let transform = Transform {
            translation: random_point(rng, 6.0),
            rotation: random_rotation(rng),
            scale: random_point(rng, 1.0),
        };
        let visibility = [Visibility::Visible, Visibility::Hidden][usize::from(rng.random_bool(0.3))];
        let layers = RenderLayers::from_layers(&[rng.random_range(0..3), 10 * rng.random_range(0..3)]);
        app.world_mut()
            .spawn((Mesh3d(cube.clone()), transform, visibility, layers));
    }
    settle(&mut app);
    app
}

/// All entities of a scene that are visible and share a layer with `layers`, with their world boxes.
fn considered(app: &mut App, layers: &RenderLayers) -> Vec<(Entity, Aabb3d)> {
    let mut entities = app.world_mut().query::<(Entity, &InheritedVisibility, &RenderLayers)>();
    let found = entities.iter(app.world());
    let found = found.filter(|(_, visible, own)| visible.get() && own.intersects(layers));
    let mut found: Vec<_> = found
        .filter_map(|(entity, ..)| Some((entity, index(app).aabb(entity)?)))
        .collect();
    found.sort_by_key(|(entity, _)| *entity);
    found
}

fn distance_squared(point: Vec3, aabb: &Aabb3d) -> f32 {
    (aabb.closest_point(point) - Vec3A::from(point)).length_squared()
}

fn keys(neighbours: &[Neighbour<Entity>]) -> Vec<Entity> {
    neighbours.iter().map(|neighbour| neighbour.key).collect()
}

/// What each kind of query finds around a row of cubes.
fn found_by_all(app: &mut App, settings: SceneQuerySettings) -> Vec<Vec<Entity>> {
    query(app, |scene| {
        let path = Ray3d::new(Vec3::NEG_X * 20.0, Dir3::X);
        let (mut entities, mut near, mut pairs) = (Vec::new(), Vec::new(), Vec::new());
        let mut found = Vec::new();
        scene.overlap(&BoundingSphere::new(Vec3::ZERO, 1e3), &settings, &mut entities);
        found.push(entities.clone());
        scene.overlap(&Aabb3d::new(Vec3::ZERO, Vec3::splat(1e3)), &settings, &mut entities);
        found.push(entities);
        found.push(
            scene
                .nearest(Vec3::ZERO, &settings)
                .iter()
                .map(|near| near.key)
                .collect(),
        );
        scene.k_nearest(Vec3::ZERO, 2, &settings, &mut near);
        found.push(keys(&near));
        scene.neighbours_within(Vec3::ZERO, 1e3, &settings, &mut near);
        found.push(keys(&near));
        found.push(
            scene
                .sweep_sphere(path, 0.1, &settings)
                .iter()
                .map(|hit| hit.entity)
                .collect(),
        );
        let hit = scene.sweep_aabb(path, Vec3::ONE, &settings);
        found.push(hit.iter().map(|hit| hit.entity).collect());
        scene.pairs(&settings, &mut pairs);
        found.push(pairs.into_iter().flatten().collect());
        found.push({
            let mut hits = Vec::new();
            scene.cast_rays(&[path], &settings, &mut hits);
            hits.iter().flatten().map(|hit| hit.entity).collect()
        });
        found
    })
}

#[test]
fn an_empty_scene_answers_nothing() {
    let mut app = headless_app();
    settle(&mut app);
    assert!(found_by_all(&mut app, settings()).iter().all(Vec::is_empty));
}

#[test]
fn no_query_finds_what_the_settings_rule_out() {
    let mut app = headless_app();
    let cubes = [0.0, 0.8].map(|x| spawn_cube(&mut app, Vec3::X * x));
    settle(&mut app);
    let of_second = |found: &Vec<Entity>| found.iter().all(|&entity| entity == cubes[1]);
    let only_second = |app: &mut App, settings: SceneQuerySettings| {
        let found = found_by_all(app, settings);
        assert!(found.iter().all(of_second), "{found:?}");
        let alone = found.iter().filter(|found| found.is_empty()).count();
        assert_eq!(alone, 1, "all but the pairs find the other");
    };
    assert!(
        found_by_all(&mut app, settings())
            .iter()
            .all(|found| found.contains(&cubes[0]))
    );

    only_second(&mut app, settings().excluding(&cubes[..1]));
    only_second(&mut app, settings().filter(&|entity| entity == cubes[1]));
    app.world_mut().entity_mut(cubes[1]).insert(RenderLayers::layer(40));
    app.update();
    only_second(&mut app, settings().with_layers(&RenderLayers::layer(40)));
    app.world_mut().entity_mut(cubes[0]).insert(Visibility::Hidden);
    app.update();
    only_second(&mut app, settings());
    let found = found_by_all(&mut app, settings().with_visibility(QueryVisibility::Any));
    assert!(found.iter().all(|found| found.contains(&cubes[0])), "{found:?}");
}

#[test]
fn what_was_despawned_since_the_last_frame_is_not_found() {
    let (mut app, cubes) = row_of_cubes(1);
    app.world_mut().despawn(cubes[0]);
    assert!(found_by_all(&mut app, settings()).iter().all(Vec::is_empty));
}

#[test]
fn what_was_in_the_buffers_is_overwritten() {
    let (mut app, cubes) = row_of_cubes(1);
    query(&mut app, |scene| {
        let far = Vec3::splat(500.0);
        let mut entities = cubes.clone();
        scene.overlap(&BoundingSphere::new(far, 1.0), &settings(), &mut entities);
        assert_eq!(entities, []);
        let mut near = vec![
            Neighbour {
                key: cubes[0],
                distance_squared: 0.0
            };
            3
        ];
        scene.neighbours_within(far, 1.0, &settings(), &mut near);
        assert_eq!(near, []);
        near.resize(
            3,
            Neighbour {
                key: cubes[0],
                distance_squared: 0.0,
            },
        );
        scene.k_nearest(Vec3::ZERO, 2, &settings(), &mut near);
        assert_eq!(keys(&near), cubes);
        let mut pairs = vec![[cubes[0]; 2]];
        scene.pairs(&settings(), &mut pairs);
        assert!(pairs.is_empty());
        let mut hits = vec![None; 5];
        scene.cast_rays(&[], &settings(), &mut hits);
        assert!(hits.is_empty());
    });
}

// --- What is where ---

#[test]
fn regions_of_every_kind_agree_with_a_plain_loop() {
    let mut rng = rng(41);
    let mut app = random_scene(300, &mut rng);
    let layers = RenderLayers::from_layers(&[1, 20]);
    let all = considered(&mut app, &layers);
    let check = |app: &mut App,
                 region: &dyn Fn(&SceneQuery, &SceneQuerySettings, &mut Vec<Entity>),
                 touches: &dyn Fn(&Aabb3d) -> bool| {
        let expected: Vec<Entity> = all
            .iter()
            .filter(|(_, aabb)| touches(aabb))
            .map(|(entity, _)| *entity)
            .collect();
        let mut found = Vec::new();
        query(app, |scene| {
            region(&scene, &settings().with_layers(&layers), &mut found);
            assert_eq!(found, expected);
        });
        expected.len()
    };
    let mut total = 0;
    for _ in 0..50 {
        let (center, half) = (random_point(&mut rng, 10.0), random_point(&mut rng, 4.0).abs());
        let aabb = Aabb3d::new(center, half);
        let obb = Obb::new(center.into(), half.into(), random_rotation(&mut rng)).expect("a sound box");
        let hull =
            ConvexHull::enclosing((0..12).map(|_| Vec3A::from(center) + Vec3A::from(random_point(&mut rng, 3.0))));
        let hull = hull.expect("finite points");
        let eye = Transform::from_translation(center).looking_to(random_dir(&mut rng), Vec3::Y);
        let clip = Mat4::perspective_infinite_reverse_rh(1.0, 1.5, 0.1) * eye.to_matrix().inverse();
        let frustum = ViewFrustum::from_clip_from_world(&clip);
        total += check(
            &mut app,
            &|scene, settings, found| scene.overlap(&aabb, settings, found),
            &|other| aabb.intersects(other),
        );
        total += check(
            &mut app,
            &|scene, settings, found| scene.overlap(&obb, settings, found),
            &|other| obb.touches(other),
        );
        total += check(
            &mut app,
            &|scene, settings, found| scene.overlap(&hull, settings, found),
            &|other| hull.touches(other),
        );
        total += check(
            &mut app,
            &|scene, settings, found| scene.overlap(&frustum, settings, found),
            &|other| frustum.touches(other),
        );
    }
    assert!(total > 500, "{total}");
}

#[test]
fn the_boxes_of_a_scene_answer_as_a_structure_does() {
    let (mut app, cubes) = row_of_cubes(3);
    query(&mut app, |scene| {
        let settings = settings().excluding(&cubes[..1]);
        let boxes = scene.boxes(&settings);
        assert_eq!(boxes.len(), 2);
        let bounds = boxes.bounds().expect("not empty");
        assert!(bounds.min.x > 9.0 && bounds.max.x > 20.0, "{bounds:?}");
        assert!(boxes.memory() > 0);
        let ray = Ray::new(Vec3::ZERO, Vec3::X, f32::INFINITY).expect("a ray");
        assert_eq!(boxes.closest_box(&ray).map(|(entity, _)| entity), Some(cubes[1]));
    });
}

// --- What is near ---

#[test]
fn the_distance_is_that_to_the_world_box() {
    let (mut app, cubes) = row_of_cubes(2);
    query(&mut app, |scene| {
        let near = |x: f32| scene.nearest(Vec3::X * x, &settings()).expect("there is something");
        assert_eq!((near(0.1).key, near(0.1).distance_squared), (cubes[0], 0.0));
        assert_eq!((near(2.5).key, near(2.5).distance_squared.round()), (cubes[0], 4.0));
        assert_eq!((near(8.5).key, near(8.5).distance_squared.round()), (cubes[1], 1.0));
    });
}

#[test]
fn nothing_is_near_beyond_the_maximum_distance() {
    let (mut app, cubes) = row_of_cubes(1);
    let place = Vec3::Y * 3.0;
    query(&mut app, |scene| {
        let up_to = |distance: f32| {
            scene
                .nearest(place, &settings().with_max_distance(distance))
                .map(|near| near.key)
        };
        assert_eq!(up_to(2.499), None);
        assert_eq!(up_to(2.501), Some(cubes[0]));
        assert_eq!([up_to(0.0), up_to(-1.0), up_to(f32::NAN)], [None; 3]);
    });
}

#[test]
fn of_entities_at_one_distance_the_smallest_is_nearest() {
    let mut app = headless_app();
    let mut cubes: Vec<Entity> = (0..20).map(|_| spawn_cube(&mut app, Vec3::ZERO)).collect();
    settle(&mut app);
    cubes.sort_unstable();
    query(&mut app, |scene| {
        assert_eq!(scene.nearest(Vec3::Y, &settings()).map(|near| near.key), Some(cubes[0]));
        let mut near = Vec::new();
        scene.k_nearest(Vec3::Y, 7, &settings(), &mut near);
        assert_eq!(keys(&near), cubes[..7]);
        scene.neighbours_within(Vec3::Y, 5.0, &settings(), &mut near);
        assert_eq!(keys(&near), cubes);
    });
}

#[test]
fn what_is_near_agrees_with_a_plain_loop() {
    let mut rng = rng(42);
    let mut app = random_scene(300, &mut rng);
    let layers = RenderLayers::from_layers(&[2, 10]);
    let all = considered(&mut app, &layers);
    for _ in 0..100 {
        let (point, radius) = (random_point(&mut rng, 12.0), rng.random_range(0.0..8.0));
        let mut expected: Vec<(f32, Entity)> = all
            .iter()
            .map(|(entity, aabb)| (distance_squared(point, aabb), *entity))
            .collect();
        expected.sort_by(|a, b| a.partial_cmp(b).expect("no NaN"));
        let within = expected
            .iter()
            .filter(|(distance, _)| *distance <= radius * radius)
            .count();
        let expected: Vec<Entity> = expected.into_iter().map(|(_, entity)| entity).collect();
        query(&mut app, |scene| {
            let settings = settings().with_layers(&layers);
            let mut near = Vec::new();
            assert_eq!(
                scene.nearest(point, &settings).map(|near| near.key),
                expected.first().copied()
            );
            scene.k_nearest(point, 5, &settings, &mut near);
            assert_eq!(keys(&near), expected[..5]);
            scene.neighbours_within(point, radius, &settings, &mut near);
            assert_eq!(keys(&near), expected[..within]);
        });
    }
}

#[test]
fn nothing_is_near_a_place_that_is_not_finite() {
    let (mut app, _) = row_of_cubes(2);
    query(&mut app, |scene| {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let mut near = Vec::new();
            assert_eq!(scene.nearest(Vec3::X * bad, &settings()), None);
            scene.k_nearest(Vec3::Y * bad, 3, &settings(), &mut near);
            assert_eq!(near, []);
            scene.neighbours_within(Vec3::Z * bad, f32::INFINITY, &settings(), &mut near);
            assert_eq!(near, []);
        }
        let mut near = Vec::new();
        scene.neighbours_within(Vec3::ZERO, f32::NAN, &settings(), &mut near);
        assert_eq!(near, []);
    });
}

// --- What is in the way ---

/// The path along a row of cubes, beside it by `offset`.
fn along(offset: f32) -> Ray3d {
    Ray3d::new(Vec3::new(-20.0, offset, 0.0), Dir3::X)
}

#[test]
fn a_moving_shape_stops_where_it_touches() {
    let (mut app, cubes) = row_of_cubes(2);
    query(&mut app, |scene| {
        let ball = scene.sweep_sphere(along(0.0), 1.5, &settings()).expect("a hit");
        assert_eq!(ball.entity, cubes[0]);
        assert!(
            (ball.distance - 18.0).abs() < 1e-4 && ball.center.abs_diff_eq(Vec3::NEG_X * 2.0, 1e-4),
            "{ball:?}"
        );
        let crate_ = scene
            .sweep_aabb(along(0.0), Vec3::new(3.0, 1.0, 1.0), &settings())
            .expect("a hit");
        assert_eq!(crate_.entity, cubes[0]);
        assert!((crate_.distance - 16.5).abs() < 1e-4, "{crate_:?}");
    });
}

#[test]
fn a_shape_touches_what_its_centre_passes_by() {
    let (mut app, cubes) = row_of_cubes(1);
    query(&mut app, |scene| {
        let ball = |radius| {
            scene
                .sweep_sphere(along(1.5), radius, &settings())
                .map(|hit| hit.entity)
        };
        assert_eq!((ball(0.9), ball(1.1)), (None, Some(cubes[0])));
        let slab = |half: f32| scene.sweep_aabb(along(1.5), Vec3::new(0.0, half, 0.0), &settings());
        assert!(slab(0.9).is_none() && slab(1.1).is_some());
    });
}

#[test]
fn a_shape_that_touches_at_the_start_has_come_nowhere() {
    let (mut app, cubes) = row_of_cubes(2);
    let inside = Ray3d::new(Vec3::X * 0.2, Dir3::X);
    query(&mut app, |scene| {
        let hits = [
            scene.sweep_sphere(inside, 0.1, &settings()),
            scene.sweep_aabb(inside, Vec3::splat(0.1), &settings()),
        ];
        for hit in hits {
            let hit = hit.expect("it touches");
            assert_eq!((hit.entity, hit.distance), (cubes[0], 0.0));
        }
    });
}

#[test]
fn a_shape_goes_no_farther_than_it_is_told() {
    let (mut app, cubes) = row_of_cubes(1);
    query(&mut app, |scene| {
        let up_to = |distance| {
            let settings = settings().with_max_distance(distance);
            let ball = scene.sweep_sphere(along(0.0), 0.5, &settings).map(|hit| hit.entity);
            let box_ = scene
                .sweep_aabb(along(0.0), Vec3::splat(0.5), &settings)
                .map(|hit| hit.entity);
            assert_eq!(ball, box_);
            ball
        };
        assert_eq!((up_to(18.9), up_to(19.1)), (None, Some(cubes[0])));
        assert_eq!(up_to(f32::NAN), None);
    });
}

#[test]
fn shapes_and_paths_that_are_not_sound_touch_nothing() {
    let (mut app, _) = row_of_cubes(1);
    query(&mut app, |scene| {
        for bad in [f32::NAN, f32::INFINITY, -1.0] {
            assert_eq!(scene.sweep_sphere(along(0.0), bad, &settings()), None);
            assert_eq!(
                scene.sweep_aabb(along(0.0), Vec3::new(1.0, bad, 1.0), &settings()),
                None
            );
        }
        let nowhere = Ray3d::new(Vec3::NAN, Dir3::X);
        assert_eq!(scene.sweep_sphere(nowhere, 1.0, &settings()), None);
        assert_eq!(scene.sweep_aabb(nowhere, Vec3::ONE, &settings()), None);
    });
}

#[test]
fn sweeps_agree_with_a_plain_loop() {
    let mut rng = rng(43);
    let mut app = random_scene(300, &mut rng);
    let layers = RenderLayers::from_layers(&[0]);
    let all = considered(&mut app, &layers);
    let first = |contact: &dyn Fn(&Aabb3d) -> Option<f32>| {
        let contacts = all.iter().filter_map(|(entity, aabb)| Some((contact(aabb)?, *entity)));
        contacts.min_by(|a, b| a.partial_cmp(b).expect("no NaN"))
    };
    let mut hits = 0;
    for _ in 0..200 {
        let path = ray_towards(random_point(&mut rng, 15.0), random_point(&mut rng, 5.0));
        let (radius, half) = (rng.random_range(0.0..1.0), random_point(&mut rng, 1.0).abs());
        let ray = Ray::from_ray3d(path, 20.0).expect("a finite ray");
        let (ball, slab) = (
            SphereSweep::new(ray, radius).expect("sound"),
            AabbSweep::new(ray, half).expect("sound"),
        );
        query(&mut app, |scene| {
            let settings = settings().with_layers(&layers).with_max_distance(20.0);
            let answer = |hit: Option<SweepHit>| hit.map(|hit| (hit.distance, hit.entity));
            let hit = answer(scene.sweep_sphere(path, radius, &settings));
            assert_eq!(hit, first(&|aabb| ball.intersection_at(aabb)));
            assert_eq!(
                answer(scene.sweep_aabb(path, half, &settings)),
                first(&|aabb| slab.intersection_at(aabb))
            );
            hits += usize::from(hit.is_some());
        });
    }
    assert!(hits > 30, "{hits}");
}

// --- What touches ---

#[test]
fn pairs_agree_with_a_plain_loop() {
    let mut rng = rng(44);
    let mut app = random_scene(300, &mut rng);
    let layers = RenderLayers::from_layers(&[0, 1]);
    let all = considered(&mut app, &layers);
    let expected: Vec<[Entity; 2]> = (all.iter().enumerate())
        .flat_map(|(i, a)| all[i + 1..].iter().map(move |b| (a, b)))
        .filter(|(a, b)| a.1.intersects(&b.1))
        .map(|(a, b)| [a.0, b.0])
        .collect();
    assert!(expected.len() > 20);
    query(&mut app, |scene| {
        let mut pairs = Vec::new();
        scene.pairs(&settings().with_layers(&layers), &mut pairs);
        assert_eq!(pairs, expected);
    });
}

// --- Many rays ---

#[test]
fn many_rays_hit_what_they_hit_one_by_one() {
    let mut rng = rng(45);
    let mut app = random_scene(200, &mut rng);
    let rays: Vec<Ray3d> = (0..500)
        .map(|_| ray_towards(random_point(&mut rng, 15.0), random_point(&mut rng, 5.0)))
        .collect();
    query(&mut app, |scene| {
        let is_even = |entity: Entity| entity.index_u32().is_multiple_of(2);
        for settings in [
            settings(),
            settings().with_max_distance(10.0),
            settings().filter(&is_even),
        ] {
            for n in [0, 1, 31, 32, 33, 500] {
                let mut hits = Vec::new();
                scene.cast_rays(&rays[..n], &settings, &mut hits);
                let one_by_one: Vec<_> = rays[..n].iter().map(|&ray| scene.cast_ray(ray, &settings)).collect();
                assert_eq!(hits, one_by_one);
                assert!(n < 100 || hits.iter().flatten().count() > 10);
            }
        }
    });
}

#[test]
fn rays_that_are_not_finite_are_among_many() {
    let (mut app, cubes) = row_of_cubes(1);
    let mut rays = vec![along(0.1); 100];
    rays[40].origin.x = f32::NAN;
    query(&mut app, |scene| {
        let mut hits = Vec::new();
        scene.cast_rays(&rays, &settings(), &mut hits);
        for (at, hit) in hits.iter().enumerate() {
            assert_eq!(hit.map(|hit| hit.entity), (at != 40).then_some(cubes[0]));
        }
    });
}
