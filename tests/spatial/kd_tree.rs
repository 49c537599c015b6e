//! The static k-d trees, over boxes and over points.

use std::ops::ControlFlow;

use bevy::math::{
    Affine3A, Mat4, Vec3A,
    bounding::{Aabb3d, BoundingSphere},
    primitives::ViewFrustum,
};
use bevy_sightline::{
    geometry::{
        convex_hull::ConvexHull,
        intersection::Frustum,
        obb::Obb,
        ray::Ray,
        sweep::{AabbSweep, SphereSweep},
        volume::Volume,
    },
    spatial::{
        BruteForce, Descend, KdTree, Neighbour, PointKdTree, Region, SpatialQueries, SpatialUpdates, Visit,
        kd_tree::SplitMethod,
    },
};
use proptest::prelude::*;
use rand::Rng;

use crate::{common, properties};

const METHODS: [SplitMethod; 2] = [SplitMethod::Sah, SplitMethod::Median];

fn point_box(point: Vec3A) -> Aabb3d {
    Aabb3d { min: point, max: point }
}

fn keyed<T>(items: impl IntoIterator<Item = T>) -> impl Iterator<Item = (u32, T)> {
    (0..).zip(items)
}

fn oracle(boxes: &[Aabb3d]) -> BruteForce<u32> {
    let mut oracle = BruteForce::new();
    for (key, aabb) in keyed(boxes) {
        oracle.insert(key, *aabb).expect("a sound box");
    }
    oracle
}

fn tree(boxes: &[Aabb3d], method: SplitMethod) -> KdTree<u32> {
    let tree = KdTree::new(keyed(boxes.iter().copied()), method).expect("sound boxes");
    tree.validate().expect("all invariants");
    tree
}

fn point_tree(points: &[Vec3A], method: SplitMethod) -> PointKdTree<u32> {
    let tree = PointKdTree::from_points(keyed(points.iter().copied()), method).expect("finite points");
    tree.validate().expect("all invariants");
    tree
}

/// What everything is asked for.
#[derive(Clone, Debug)]
struct Questions {
    ray: Ray,
    half_size: Vec3A,
    region: Aabb3d,
    obb: Obb,
    hull: ConvexHull,
    frustum: ViewFrustum,
    point: Vec3A,
    distance: f32,
    k: usize,
}

type Found = Vec<(u32, u32)>;

/// The answers that a visitor with parameters gets: keys, and the parameters bit by bit.
fn collected(visit_all: impl FnOnce(&mut dyn FnMut(u32, f32) -> Visit)) -> Found {
    let mut found = Vec::new();
    visit_all(&mut |key, at| {
        found.push((key, at.to_bits()));
        Visit::Continue
    });
    found.sort_unstable();
    found
}

fn in_region(queries: &impl SpatialQueries<u32>, region: &impl Region) -> Vec<u32> {
    let mut found = vec![u32::MAX];
    queries.find_in_region(region, &mut found);
    found.sort_unstable();
    found
}

fn pairs(queries: &impl SpatialQueries<u32>) -> Vec<(u32, u32)> {
    let mut pairs = Vec::new();
    queries.visit_pairs(|a, b| {
        pairs.push((a.min(b), a.max(b)));
        ControlFlow::Continue(())
    });
    pairs.sort_unstable();
    pairs
}

fn nearest(queries: &impl SpatialQueries<u32>, point: Vec3A, k: usize, distance: f32) -> Vec<Neighbour<u32>> {
    let mut nearest = Vec::new();
    queries.k_nearest(point, k, distance, &mut nearest);
    nearest
}

fn assert_same_answers(tree: &impl SpatialQueries<u32>, oracle: &BruteForce<u32>, ask: &Questions) {
    assert_eq!(tree.len(), oracle.len());
    assert_eq!(tree.bounds(), oracle.bounds());
    let mut all = Vec::new();
    tree.visit_all(|key, aabb| all.push((key, *aabb)));
    all.sort_unstable_by_key(|&(key, _)| key);
    let mut expected = Vec::new();
    oracle.visit_all(|key, aabb| expected.push((key, *aabb)));
    assert_eq!(all, expected);

    let ray = &ask.ray;
    assert_eq!(
        collected(|visit| tree.visit_ray(ray, visit)),
        collected(|visit| oracle.visit_ray(ray, visit))
    );
    assert_eq!(tree.closest_box(ray), oracle.closest_box(ray));
    assert_eq!(
        tree.any_hit(ray, |key, _| key % 3 == 0),
        oracle.any_hit(ray, |key, _| key % 3 == 0)
    );

    let sphere_sweep = SphereSweep::new(*ray, ask.half_size.x).expect("a radius");
    let box_sweep = AabbSweep::new(*ray, ask.half_size).expect("a half size");
    assert_eq!(
        collected(|visit| tree.visit_sweep(&sphere_sweep, visit)),
        collected(|visit| oracle.visit_sweep(&sphere_sweep, visit))
    );
    assert_eq!(tree.first_touched(&sphere_sweep), oracle.first_touched(&sphere_sweep));
    assert_eq!(
        collected(|visit| tree.visit_sweep(&box_sweep, visit)),
        collected(|visit| oracle.visit_sweep(&box_sweep, visit))
    );
    assert_eq!(tree.first_touched(&box_sweep), oracle.first_touched(&box_sweep));

    let sphere = BoundingSphere::new(ask.point, ask.half_size.y);
    assert_eq!(in_region(tree, &ask.region), in_region(oracle, &ask.region));
    assert_eq!(in_region(tree, &sphere), in_region(oracle, &sphere));
    assert_eq!(in_region(tree, &ask.obb), in_region(oracle, &ask.obb));
    assert_eq!(in_region(tree, &ask.hull), in_region(oracle, &ask.hull));
    assert_eq!(in_region(tree, &ask.frustum), in_region(oracle, &ask.frustum));
    let frustum = Frustum::from(&ask.frustum);
    assert_eq!(in_region(tree, &frustum), in_region(oracle, &frustum));

    for distance in [ask.distance, f32::INFINITY, 0.0, f32::NAN] {
        assert_eq!(
            collected(|visit| tree.visit_near(ask.point, distance, visit)),
            collected(|visit| oracle.visit_near(ask.point, distance, visit))
        );
        for k in [0, 1, ask.k, usize::MAX] {
            assert_eq!(
                nearest(tree, ask.point, k, distance),
                nearest(oracle, ask.point, k, distance)
            );
        }
    }
    assert_eq!(pairs(tree), pairs(oracle));
}

/// Boxes of every kind of scene that there is: scattered, in clusters, a flat city, of wildly mixed sizes, all at one
/// place, in a line, in a grid so that they touch, without size, and at sizes from 1e-20 to 1e7.
fn boxes() -> impl Strategy<Value = Vec<Aabb3d>> {
    let scale = prop_oneof![4 => Just(1.0f32), 1 => Just(1e-20f32), 1 => Just(1e5f32)];
    let len = prop_oneof![4 => 0usize..40, 1 => 40usize..200];
    (0..8, len, any::<u64>(), scale).prop_map(|(kind, len, seed, scale)| {
        let mut rng = common::rng(seed);
        let mut number = |size: f32| rng.random_range(-size..size);
        let mut boxes: Vec<Aabb3d> = (0..len)
            .map(|_| {
                let place = Vec3A::new(number(100.0), number(100.0), number(100.0));
                let size = Vec3A::new(number(3.0), number(3.0), number(3.0)).abs();
                let (center, half_size) = match kind {
                    0 => (place, size),
                    1 => ((place * 0.03).round() * 30.0 + size, size),
                    2 => (place * Vec3A::new(1.0, 0.0, 1.0), size),
                    3 => (place, size * 10f32.powf(number(4.0))),
                    4 => (Vec3A::ONE, Vec3A::ONE),
                    5 => (Vec3A::splat(place.x), size),
                    6 => ((place * 0.03).round(), Vec3A::splat(0.5)),
                    _ => ((place * 0.1).round(), Vec3A::ZERO),
                };
                Aabb3d {
                    min: (center - half_size) * scale,
                    max: (center + half_size) * scale,
                }
            })
            .collect();
        if kind == 3 && !boxes.is_empty() {
            boxes[0] = Aabb3d {
                min: Vec3A::splat(-1e7),
                max: Vec3A::splat(1e7),
            };
        }
        boxes
    })
}

/// Half of the time, what is asked for has corners and places of the scene itself.
fn questions() -> impl Strategy<Value = Questions> {
    let place = || prop_oneof![3 => properties::point(), 1 => properties::point().prop_map(|point| point * 1e-20)];
    let size = || {
        prop_oneof![
            4 => [0.1f32..20.0, 0.1f32..20.0, 0.1f32..20.0].prop_map(Vec3A::from_array),
            1 => Just(Vec3A::ONE),
            1 => Just(Vec3A::splat(150.0)),
        ]
    };
    let t_max = prop_oneof![2 => Just(f32::INFINITY), 1 => 0.0f32..100.0];
    let camera = (0.3f32..2.0, 0.5f32..2.0, 0.1f32..2.0, 1.0f32..200.0);
    let corners = prop::collection::vec(properties::point(), 1..8);
    (
        (place(), properties::direction(), t_max, size()),
        (place(), size(), properties::rotation(), corners),
        (camera, place(), properties::rotation()),
        (place(), 0.0f32..100.0, 1usize..20),
    )
        .prop_map(
            |((origin, direction, t_max, half_size), (center, size, turn, corners), camera, near)| {
                let ((fov, aspect, near_plane, depth), eye, rotation) = camera;
                let world_from_view = Affine3A::from_rotation_translation(rotation, eye.into());
                let clip_from_view = Mat4::perspective_rh(fov, aspect, near_plane, near_plane + depth);
                let (point, distance, k) = near;
                Questions {
                    ray: Ray::new(origin, direction, t_max).expect("a ray"),
                    half_size,
                    region: Aabb3d {
                        min: center - size,
                        max: center + size,
                    },
                    obb: Obb::new(center, size, turn).expect("an oriented box"),
                    hull: ConvexHull::enclosing(corners).expect("a hull"),
                    frustum: ViewFrustum::from_clip_from_world(
                        &(clip_from_view * Mat4::from(world_from_view.inverse())),
                    ),
                    point,
                    distance,
                    k,
                }
            },
        )
}

proptest! {
    #![proptest_config(properties::cases())]

    #[test]
    fn trees_of_boxes_answer_as_a_list_does(boxes in boxes(), ask in questions()) {
        let oracle = oracle(&boxes);
        for method in METHODS {
            assert_same_answers(&tree(&boxes, method), &oracle, &ask);
        }
    }

    #[test]
    fn trees_of_points_answer_as_a_list_does(
        points in prop_oneof![
            1 => boxes().prop_map(|boxes| boxes.iter().map(|aabb| aabb.min).collect::<Vec<_>>()),
            1 => properties::points(),
        ],
        ask in questions(),
    ) {
        let oracle = oracle(&points.iter().copied().map(point_box).collect::<Vec<_>>());
        for method in METHODS {
            assert_same_answers(&point_tree(&points, method), &oracle, &ask);
        }
    }

    #[test]
    fn questions_from_the_boxes_themselves_are_answered_as_a_list_does(
        boxes in boxes().prop_filter("some boxes", |boxes| !boxes.is_empty()),
        ask in questions(),
        index in any::<prop::sample::Index>(),
    ) {
        let oracle = oracle(&boxes);
        let one = *index.get(&boxes);
        let ask = Questions {
            ray: Ray::new(one.min, ask.ray.direction(), f32::INFINITY).expect("a ray"),
            region: one,
            point: one.max,
            distance: (one.max - one.min).length(),
            ..ask
        };
        for method in METHODS {
            assert_same_answers(&tree(&boxes, method), &oracle, &ask);
        }
    }

    #[test]
    fn shortened_searches_visit_all_up_to_the_limit(boxes in boxes(), ask in questions(), limit in 0.0f32..50.0) {
        let oracle = oracle(&boxes);
        let within = |found: Found| -> Found {
            found.into_iter().filter(|&(_, at)| f32::from_bits(at) <= limit).collect()
        };
        let shortened = |search: &dyn Fn(&mut dyn FnMut(u32, f32) -> Visit)| {
            let mut found = Vec::new();
            search(&mut |key, at| {
                found.push((key, at.to_bits()));
                Visit::Shorten(limit)
            });
            found.sort_unstable();
            within(found)
        };
        for method in METHODS {
            let tree = tree(&boxes, method);
            prop_assert_eq!(
                shortened(&|visit| tree.visit_ray(&ask.ray, visit)),
                within(collected(|visit| oracle.visit_ray(&ask.ray, visit)))
            );
            prop_assert_eq!(
                shortened(&|visit| tree.visit_near(ask.point, f32::INFINITY, visit)),
                within(collected(|visit| oracle.visit_near(ask.point, f32::INFINITY, visit)))
            );
        }
    }
}

fn scattered(count: usize) -> Vec<Aabb3d> {
    let mut rng = common::rng(1);
    let mut boxes = || {
        let center = Vec3A::from(common::random_point(&mut rng, 100.0));
        let half_size = Vec3A::from(common::random_point(&mut rng, 1.0)).abs();
        Aabb3d {
            min: center - half_size,
            max: center + half_size,
        }
    };
    (0..count).map(|_| boxes()).collect()
}

#[test]
fn an_empty_tree_finds_nothing() {
    let (boxes, points) = (tree(&[], SplitMethod::Sah), point_tree(&[], SplitMethod::Median));
    assert!(boxes.is_empty() && points.is_empty());
    assert_eq!((boxes.bounds(), points.bounds()), (None, None));
    assert_eq!((boxes.depth(), points.depth()), (0, 0));
    assert_eq!(boxes.sah_cost(), 0.0);
    let ray = Ray::new(Vec3A::ZERO, Vec3A::X, f32::INFINITY).expect("a ray");
    assert_eq!(boxes.closest_box(&ray), None);
    assert_eq!(points.closest_box(&ray), None);
    assert_eq!(nearest(&boxes, Vec3A::ZERO, 3, f32::INFINITY), []);
    assert_eq!(nearest(&points, Vec3A::ZERO, 3, f32::INFINITY), []);
}

#[test]
fn unsound_boxes_are_refused_by_their_index() {
    let unit = point_box(Vec3A::ONE);
    for unsound in [
        Aabb3d {
            min: Vec3A::ONE,
            max: Vec3A::ZERO,
        },
        Aabb3d {
            min: Vec3A::NAN,
            max: Vec3A::ONE,
        },
        Aabb3d {
            min: Vec3A::ZERO,
            max: Vec3A::new(1.0, f32::INFINITY, 1.0),
        },
    ] {
        for method in METHODS {
            let refused = KdTree::new(keyed([unit, unit, unsound, unit]), method).expect_err("an unsound box");
            assert_eq!(refused.index, 2);
            assert_eq!(refused.unsound.0.max.x, unsound.max.x);
        }
    }
}

#[test]
fn points_that_are_not_finite_are_refused_by_their_index() {
    for unsound in [Vec3A::NAN, Vec3A::new(0.0, f32::NEG_INFINITY, 0.0)] {
        let refused = PointKdTree::from_points(keyed([Vec3A::ONE, unsound]), SplitMethod::Median);
        assert_eq!(refused.expect_err("an unsound point").index, 1);
    }
}

#[test]
fn what_is_nan_finds_nothing() {
    let boxes = scattered(100);
    let points: Vec<Vec3A> = boxes.iter().map(|aabb| aabb.min).collect();
    let (tree, point_tree) = (tree(&boxes, SplitMethod::Sah), point_tree(&points, SplitMethod::Sah));
    for point in [
        Vec3A::NAN,
        Vec3A::new(f32::NAN, 0.0, 0.0),
        Vec3A::new(0.0, 0.0, f32::NAN),
    ] {
        assert_eq!(nearest(&tree, point, 5, f32::INFINITY), []);
        assert_eq!(nearest(&point_tree, point, 5, f32::INFINITY), []);
        let region = Aabb3d {
            min: point,
            max: Vec3A::splat(1e6),
        };
        assert_eq!(in_region(&tree, &region), [0; 0]);
        assert_eq!(in_region(&point_tree, &region), [0; 0]);
        let sphere = BoundingSphere::new(point, 1e6);
        assert_eq!(in_region(&tree, &sphere), [0; 0]);
        assert_eq!(in_region(&point_tree, &sphere), [0; 0]);
    }
}

#[test]
fn nothing_is_nearest_to_a_point_at_infinity() {
    let boxes = scattered(20);
    let (tree, oracle) = (tree(&boxes, SplitMethod::Sah), oracle(&boxes));
    for point in [
        Vec3A::INFINITY,
        Vec3A::NEG_INFINITY,
        Vec3A::new(0.0, f32::NEG_INFINITY, 0.0),
    ] {
        assert_eq!(nearest(&tree, point, 3, f32::INFINITY), []);
        assert_eq!(nearest(&oracle, point, 3, f32::INFINITY), []);
    }
}

#[test]
fn a_point_that_is_off_a_turned_box_at_the_origin_by_less_than_its_rounding_is_found() {
    let obb = Obb::new(Vec3A::Z, Vec3A::ONE, bevy::math::Quat::IDENTITY).expect("an oriented box");
    let points = [Vec3A::new(5.3e-19, -4.5e-19, -3.1e-21)];
    let oracle = oracle(&points.map(point_box));
    let found = in_region(&point_tree(&points, SplitMethod::Median), &obb);
    assert_eq!(found, in_region(&oracle, &obb));
    assert_eq!(found, [0]);
}

#[test]
fn of_neighbours_at_one_distance_the_smaller_keys_come_first() {
    let at_one_place = vec![Vec3A::ONE; 1000];
    let keys = (0..1000).rev();
    for method in METHODS {
        let points = PointKdTree::from_points(keys.clone().zip(at_one_place.clone()), method).expect("finite points");
        let boxes = KdTree::new(keys.clone().zip(at_one_place.iter().copied().map(point_box)), method);
        let boxes = boxes.expect("sound boxes");
        let expected: Vec<_> = (0..20)
            .map(|key| Neighbour {
                key,
                distance_squared: 3.0,
            })
            .collect();
        assert_eq!(nearest(&points, Vec3A::ZERO, 20, f32::INFINITY), expected);
        assert_eq!(nearest(&boxes, Vec3A::ZERO, 20, f32::INFINITY), expected);
    }
}

#[test]
fn a_hundred_thousand_at_one_place_make_a_balanced_tree() {
    let points = vec![Vec3A::splat(1e7); 100_000];
    for method in METHODS {
        let points = point_tree(&points, method);
        assert!(points.depth() <= 7, "{} levels", points.depth());
        assert_eq!(nearest(&points, Vec3A::ZERO, 8, f32::INFINITY).len(), 8);
    }
    let boxes = vec![point_box(Vec3A::ONE); 100_000];
    for method in METHODS {
        let boxes = tree(&boxes, method);
        assert!(boxes.depth() <= 7, "{} levels", boxes.depth());
        assert_eq!(in_region(&boxes, &point_box(Vec3A::ONE)).len(), 100_000);
    }
}

#[test]
fn boxes_that_halve_in_size_and_distance_make_no_deep_tree() {
    let boxes: Vec<Aabb3d> = (0..120)
        .flat_map(|power| {
            let size = 2f32.powi(-power);
            [Vec3A::X, Vec3A::Y, Vec3A::Z].map(|axis| Aabb3d {
                min: axis * size,
                max: axis * size + Vec3A::splat(size * 0.1),
            })
        })
        .collect();
    let tree = tree(&boxes, SplitMethod::Sah);
    assert!(tree.depth() <= 20, "{} levels", tree.depth());
}

#[test]
fn cells_contain_what_is_in_them() {
    let boxes = scattered(500);
    for method in METHODS {
        let tree = tree(&boxes, method);
        let mut at_level = vec![0; tree.depth() + 1];
        let mut levels = Vec::new();
        tree.visit_cells(|level, aabb, count| {
            levels.truncate(level);
            if let Some(&outer) = levels.last() {
                let outer: Aabb3d = outer;
                assert!(outer.min.cmple(aabb.min).all() && outer.max.cmpge(aabb.max).all());
            }
            levels.push(*aabb);
            at_level[level] += count;
            if level == 0 {
                assert_eq!((Some(*aabb), count), (tree.bounds(), 500));
            }
        });
        assert_eq!(at_level[0], 500);
        assert!(at_level.is_sorted_by(|a, b| a >= b));
    }
}

#[test]
fn cells_are_visited_only_in_those_that_are_gone_into() {
    let boxes = scattered(500);
    for method in METHODS {
        let tree = tree(&boxes, method);
        let (mut all, mut visited) = (Vec::new(), Vec::new());
        tree.visit_cells(|level, aabb, _| all.push((level, *aabb)));
        tree.descend_cells(|level, aabb| {
            visited.push((level, *aabb));
            if level < 2 { Descend::Into } else { Descend::Past }
        });
        all.retain(|&(level, _)| level <= 2);
        assert_eq!(visited, all);
        let mut visits = 0;
        tree.descend_cells(|_, _| {
            visits += 1;
            Descend::Stop
        });
        assert_eq!(visits, 1);
    }
}

#[test]
fn splits_by_area_cost_less_than_medians_where_sizes_are_mixed() {
    let mut rng = common::rng(5);
    let boxes: Vec<Aabb3d> = scattered(3000)
        .into_iter()
        .map(|aabb| {
            let grown = 10f32.powf(rng.random_range(-3.0..1.5));
            Aabb3d {
                min: aabb.min - grown,
                max: aabb.max + grown,
            }
        })
        .collect();
    let [by_area, by_median] = METHODS.map(|method| tree(&boxes, method).sah_cost());
    assert!(by_area < by_median, "{by_area} against {by_median}");
}

#[test]
fn a_visitor_can_stop() {
    let tree = tree(&vec![point_box(Vec3A::ONE); 300], SplitMethod::Sah);
    let everything = Aabb3d {
        min: Vec3A::splat(-1e3),
        max: Vec3A::splat(1e3),
    };
    let mut visits = 0;
    tree.visit_region(&everything, |_| {
        visits += 1;
        if visits == 7 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    });
    assert_eq!(visits, 7);
    tree.visit_near(Vec3A::ZERO, f32::INFINITY, |_, _| {
        visits += 1;
        if visits == 10 { Visit::Stop } else { Visit::Continue }
    });
    assert_eq!(visits, 10);
    tree.visit_pairs(|_, _| {
        visits += 1;
        ControlFlow::Break(())
    });
    assert_eq!(visits, 11);
}

#[test]
fn memory_counts_the_boxes() {
    let tree = tree(&scattered(1000), SplitMethod::Sah);
    let least = 1000 * (24 + size_of::<u32>());
    assert!((least..4 * least).contains(&tree.memory()), "{} bytes", tree.memory());
}
