//! The loose octree: what it promises beyond the queries, which are compared in `differential`.

use std::{collections::BTreeSet, ops::ControlFlow};

use bevy::math::{
    Vec3A,
    bounding::{Aabb3d, BoundingSphere},
};
use bevy_sightline::{
    geometry::{aabb::Aabb3dExt, ray::Ray},
    spatial::{
        LeafId, Octree, SpatialQueries, SpatialUpdates, UpdateError,
        octree::{Descend, OctreeNode},
    },
};
use proptest::prelude::*;

use crate::{
    common::{random_point, rng},
    properties::{cases, point},
};

fn cube(center: [f32; 3], half_side: f32) -> Aabb3d {
    Aabb3d::new(Vec3A::from_array(center), Vec3A::splat(half_side))
}

/// Inserts boxes one by one, their keys their order.
fn grown(boxes: impl IntoIterator<Item = Aabb3d>) -> (Octree<u32>, Vec<LeafId>) {
    let mut octree = Octree::new();
    let ids = boxes.into_iter().zip(0..);
    let ids = ids
        .map(|(aabb, key)| octree.insert(key, aabb).expect("a sound box"))
        .collect();
    assert_eq!(octree.validate(), Ok(()));
    (octree, ids)
}

fn scattered(count: usize) -> Vec<Aabb3d> {
    let mut rng = rng(3);
    (0..count)
        .map(|_| cube(random_point(&mut rng, 100.0).into(), 0.5))
        .collect()
}

fn nodes(octree: &Octree<u32>) -> Vec<OctreeNode> {
    let mut nodes = Vec::new();
    octree.visit_nodes(|node| {
        nodes.push(*node);
        Descend::Into
    });
    nodes
}

fn keys_below(octree: &Octree<u32>, node: &OctreeNode) -> BTreeSet<u32> {
    let mut keys = BTreeSet::new();
    octree.visit_below(node, |key, _| assert!(keys.insert(key), "{key} twice"));
    keys
}

#[test]
fn an_empty_octree_has_no_nodes() {
    let octree = Octree::<u32>::new();
    assert_eq!((octree.depth(), octree.node_count(), octree.bounds()), (0, 0, None));
    octree.visit_nodes(|node| panic!("{node:?}"));
}

#[test]
fn eight_boxes_share_one_node() {
    let (octree, _) = grown(scattered(8));
    assert_eq!((octree.depth(), octree.node_count()), (1, 1));
}

#[test]
fn the_ninth_box_divides_a_node() {
    let (octree, _) = grown(scattered(9));
    assert_eq!(octree.depth(), 2);
}

#[test]
fn depth_is_logarithmic_in_an_even_scene() {
    let (octree, _) = grown(scattered(10_000));
    assert!(octree.depth() <= 8, "{}", octree.depth());
}

#[test]
fn nodes_are_few_in_an_even_scene() {
    let (octree, _) = grown(scattered(10_000));
    assert!(octree.node_count() < 10_000 / 2, "{}", octree.node_count());
}

#[test]
fn all_nodes_are_gone_with_the_last_box() {
    let (mut octree, ids) = grown(scattered(500));
    for (key, id) in ids.into_iter().enumerate() {
        assert_eq!(octree.remove(id), Ok(key as u32));
        assert_eq!(octree.validate(), Ok(()));
    }
    assert_eq!((octree.len(), octree.node_count(), octree.depth()), (0, 0, 0));
}

#[test]
fn a_box_far_away_makes_the_root_grow_and_its_removal_lets_it_shrink() {
    let (mut octree, _) = grown(scattered(100));
    let level_before = nodes(&octree)[0].level;
    let far = octree
        .insert(1000, cube([3e38, -3e38, 3e38], 1.0))
        .expect("a sound box");
    assert_eq!(octree.validate(), Ok(()));
    assert!(nodes(&octree)[0].level > 100);
    octree.remove(far).expect("a leaf");
    assert_eq!(octree.validate(), Ok(()));
    assert_eq!(nodes(&octree)[0].level, level_before);
}

#[test]
fn a_hundred_thousand_boxes_at_one_place_do_not_pile_up() {
    let mut octree = Octree::new();
    let ids: Vec<LeafId> = (0..100_000)
        .map(|key| octree.insert(key, cube([1.0, 2.0, 3.0], 0.5)).expect("a sound box"))
        .collect();
    assert_eq!(octree.validate(), Ok(()));
    assert!(octree.depth() < 12, "{}", octree.depth());
    // Out and back again, each by itself.
    for &id in &ids {
        octree.update(id, cube([1.0, 2.0, 3.5], 0.5)).expect("a leaf");
    }
    assert_eq!(octree.validate(), Ok(()));
    assert!(octree.depth() < 12, "{}", octree.depth());
}

#[test]
fn a_hundred_thousand_points_at_one_place_build_a_flat_hierarchy() {
    let mut octree = Octree::new();
    octree.insert_many((0..100_000).map(|key| (key, cube([1.0, 2.0, 3.0], 0.0))));
    assert_eq!(octree.validate(), Ok(()));
    assert!(octree.depth() < 12, "{}", octree.depth());
}

#[test]
fn boxes_of_all_sizes_around_one_point_are_told_apart_by_their_sizes() {
    let boxes = (-140..120).map(|exponent| cube([0.0; 3], 2f32.powi(exponent)));
    let (octree, _) = grown(boxes);
    let ray = Ray::new(Vec3A::new(0.0, 0.0, -3e38), Vec3A::Z, f32::INFINITY).expect("a ray");
    assert_eq!(octree.closest_box(&ray).map(|hit| hit.0), Some(259));
}

#[test]
fn the_limits_of_f32_are_no_limits() {
    let (smallest, largest) = (f32::from_bits(1), f32::MAX);
    let corners = [-largest, -smallest, -0.0, 0.0, smallest, f32::MIN_POSITIVE, largest];
    let mut boxes = Vec::new();
    for min in corners {
        for max in corners.into_iter().filter(|&max| max >= min) {
            boxes.push(Aabb3d {
                min: Vec3A::splat(min),
                max: Vec3A::splat(max),
            });
        }
    }
    let (octree, _) = grown(boxes.clone());
    for node in nodes(&octree) {
        assert!(node.cell.is_sound() && node.bounds.is_sound(), "{node:?}");
    }
    let mut found = Vec::new();
    octree.find_in_region(&cube([0.0; 3], 0.0), &mut found);
    let around_zero = boxes.iter().filter(|aabb| aabb.min.x <= 0.0 && aabb.max.x >= 0.0);
    assert_eq!(found.len(), around_zero.count());
}

#[test]
fn a_box_that_stays_in_its_cell_keeps_its_node() {
    let (mut octree, ids) = grown(scattered(1000));
    let before = nodes(&octree).len();
    for _ in 0..100 {
        for &id in &ids[..10] {
            let old = octree.aabb(id).expect("a leaf");
            let moved = Aabb3d {
                min: old.min + 1e-5,
                max: old.max + 1e-5,
            };
            octree.update(id, moved).expect("a leaf");
        }
    }
    assert_eq!(nodes(&octree).len(), before);
    assert_eq!(octree.validate(), Ok(()));
}

#[test]
fn what_comes_and_goes_does_not_divide_and_merge_a_node_every_time() {
    let (mut octree, _) = grown(scattered(9));
    let nodes = octree.node_count();
    for _ in 0..10 {
        let id = octree.insert(9, scattered(10)[9]).expect("a sound box");
        assert!(octree.node_count() >= nodes);
        octree.remove(id).expect("a leaf");
        assert_eq!(octree.node_count(), nodes);
    }
}

#[test]
fn no_memory_is_taken_once_warm() {
    let (mut octree, ids) = grown(scattered(2000));
    let mut rng = rng(8);
    let mut updates = |octree: &mut Octree<u32>, rounds: usize| {
        for _ in 0..rounds {
            let updates: Vec<(LeafId, Aabb3d)> = ids
                .iter()
                .map(|&id| (id, cube(random_point(&mut rng, 100.0).into(), 0.5)))
                .collect();
            assert_eq!(octree.update_many(&updates), []);
        }
    };
    updates(&mut octree, 20);
    let warm = octree.memory();
    updates(&mut octree, 10);
    assert!(octree.memory() <= warm + warm / 8, "{} after {warm}", octree.memory());
}

#[test]
fn of_several_boxes_for_one_leaf_the_last_counts() {
    let (mut octree, ids) = grown(scattered(50));
    let home = octree.aabb(ids[7]).expect("a leaf");
    let (near, far) = (cube([1.0, 2.0, 3.0], 0.5), cube([-1e6, 0.0, 0.0], 9.0));
    let cases = [[far, near], [near, far], [far, home], [far, far]];
    for [first, last] in cases {
        assert_eq!(octree.update_many(&[(ids[7], first), (ids[7], last)]), []);
        assert_eq!(octree.aabb(ids[7]), Some(last));
        assert_eq!(octree.validate(), Ok(()));
    }
}

/// A leaf that was waiting to be taken to another node was gathered with those that belonged to the first.
#[test]
fn boxes_that_all_leave_full_nodes_at_once_get_where_they_belong() {
    let (mut octree, ids) = grown(scattered(400));
    let mirrored: Vec<(LeafId, Aabb3d)> = ids
        .iter()
        .map(|&id| {
            let old = octree.aabb(id).expect("a leaf");
            let mirrored = Aabb3d {
                min: -old.max * 3.0,
                max: -old.min * 3.0,
            };
            (id, mirrored)
        })
        .collect();
    assert_eq!(octree.update_many(&mirrored), []);
    assert_eq!(octree.validate(), Ok(()));
}

#[test]
fn stale_ids_and_unsound_boxes_change_nothing() {
    let (mut octree, ids) = grown(scattered(20));
    octree.remove(ids[3]).expect("a leaf");
    let unsound = Aabb3d {
        min: Vec3A::ONE,
        max: Vec3A::ZERO,
    };
    assert!(octree.insert(9, unsound).is_err());
    assert!(matches!(
        octree.update(ids[4], unsound),
        Err(UpdateError::UnsoundBox(_))
    ));
    assert!(matches!(
        octree.update(ids[3], scattered(1)[0]),
        Err(UpdateError::NoSuchLeaf(_))
    ));
    assert!(octree.remove(ids[3]).is_err());
    assert_eq!((octree.len(), octree.aabb(ids[4])), (19, Some(scattered(20)[4])));
    assert_eq!(octree.validate(), Ok(()));
}

#[test]
fn a_point_or_a_distance_that_is_nan_finds_nothing() {
    let (octree, _) = grown(scattered(20));
    let mut nearest = Vec::new();
    octree.k_nearest(Vec3A::NAN, 3, f32::INFINITY, &mut nearest);
    assert_eq!(nearest, []);
    octree.k_nearest(Vec3A::ZERO, 3, f32::NAN, &mut nearest);
    assert_eq!(nearest, []);
    octree.visit_region(&BoundingSphere::new(Vec3A::new(0.0, f32::NAN, 0.0), 1e9), |key| {
        panic!("{key} touches NaN");
        #[expect(unreachable_code, reason = "the type of the closure")]
        ControlFlow::Continue(())
    });
}

#[test]
fn a_node_is_visited_before_those_within_it() {
    let (octree, _) = grown(scattered(1000));
    let mut above: Vec<OctreeNode> = Vec::new();
    for node in nodes(&octree) {
        let is_within = |a: &OctreeNode| a.cell.min.cmple(node.cell.min).all() && a.cell.max.cmpge(node.cell.max).all();
        assert!(
            above.is_empty() || above.iter().any(|a| a.level > node.level && is_within(a)),
            "{node:?}"
        );
        above.push(node);
    }
}

#[test]
fn passing_a_node_skips_all_within_and_stopping_ends() {
    let (octree, _) = grown(scattered(1000));
    let mut visits = 0;
    octree.visit_nodes(|_| {
        visits += 1;
        Descend::Past
    });
    assert_eq!(visits, 1);
    octree.visit_nodes(|_| {
        visits += 1;
        if visits == 5 { Descend::Stop } else { Descend::Into }
    });
    assert_eq!(visits, 5);
}

#[test]
fn cells_are_powers_of_two_wide_and_whole_multiples_of_that_from_the_origin() {
    let (octree, _) = grown(scattered(1000));
    for node in &nodes(&octree)[1..] {
        let side = 2f32.powi(node.level);
        assert_eq!(node.cell.max - node.cell.min, Vec3A::splat(side), "{node:?}");
        assert_eq!((node.cell.min / side).fract(), Vec3A::ZERO, "{node:?}");
    }
}

#[test]
fn cells_do_not_depend_on_the_order_of_insertion() {
    let boxes = scattered(300);
    let (forward, _) = grown(boxes.iter().copied());
    let (backward, _) = grown(boxes.iter().rev().copied());
    let roots = [&forward, &backward].map(|octree| nodes(octree)[0]);
    assert_eq!((roots[0].level, roots[0].cell), (roots[1].level, roots[1].cell));
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn a_node_knows_its_boxes(centers in prop::collection::vec(point(), 1..60), half in 0.0f32..3.0) {
        let boxes: Vec<Aabb3d> = centers.iter().map(|&center| Aabb3d::new(center, Vec3A::splat(half))).collect();
        let (octree, _) = grown(boxes.iter().copied());
        let all = nodes(&octree);
        let mut own_of_all = BTreeSet::new();
        for node in &all {
            let keys = keys_below(&octree, node);
            prop_assert_eq!(keys.len(), node.count);
            let mut bounds = boxes[*keys.first().expect("a box") as usize];
            for &key in &keys {
                let aabb = &boxes[key as usize];
                bounds.min = bounds.min.min(aabb.min);
                bounds.max = bounds.max.max(aabb.max);
                let center = centers[key as usize];
                // The centre of the box, rounded, is right to its last digit.
                let slack = Vec3A::splat(center.abs().max_element().max(half) * f32::EPSILON);
                prop_assert!(node.cell.min.cmple(center + slack).all() && node.cell.max.cmpge(center - slack).all());
            }
            prop_assert_eq!(node.bounds, bounds);
            octree.visit_own(node, |key, _| assert!(own_of_all.insert(key), "{key} is in two nodes"));
        }
        prop_assert_eq!(own_of_all.len(), boxes.len());
    }

    #[test]
    fn the_nodes_of_a_level_and_the_boxes_above_are_all_there_is(
        centers in prop::collection::vec(point(), 1..60),
        half in 0.0f32..3.0,
        level in -4i32..10,
    ) {
        let (octree, _) = grown(centers.iter().map(|&center| Aabb3d::new(center, Vec3A::splat(half))));
        let mut keys = BTreeSet::new();
        octree.visit_level(level, |node| {
            assert!(node.level <= level, "{node:?}");
            octree.visit_below(node, |key, _| assert!(keys.insert(key), "{key} twice"));
        });
        for node in nodes(&octree).iter().filter(|node| node.level > level) {
            octree.visit_own(node, |key, _| assert!(keys.insert(key), "{key} twice"));
        }
        prop_assert_eq!(keys.len(), centers.len());
    }

    #[test]
    fn building_at_once_obeys_the_invariants(
        centers in prop::collection::vec(point(), 0..200),
        halves in prop::collection::vec(0.0f32..20.0, 200),
        before in 0usize..100,
    ) {
        let boxes = || centers.iter().zip(&halves).map(|(&center, &half)| Aabb3d::new(center, Vec3A::splat(half)));
        let (mut octree, _) = grown(boxes().take(before));
        let inserted = octree.insert_many(boxes().zip(0..).map(|(aabb, key)| (key, aabb)));
        prop_assert_eq!(octree.validate(), Ok(()));
        prop_assert_eq!(octree.len(), before.min(centers.len()) + centers.len());
        for (id, aabb) in inserted.into_iter().zip(boxes()) {
            prop_assert_eq!(octree.aabb(id.expect("a sound box")), Some(aabb));
        }
    }
}
