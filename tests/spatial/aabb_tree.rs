//! The tree answers as the oracle does, whatever is done to it.

use std::{collections::HashMap, ops::ControlFlow};

use bevy::math::{
    Vec3, Vec3A,
    bounding::{Aabb3d, BoundingSphere},
};
use bevy_sightline::{
    geometry::ray::Ray,
    spatial::{
        AabbTree, BruteForce, BuildStrategy, Descend, LeafId, NoSuchLeaf, SpatialQueries, SpatialUpdates, UpdateError,
        Visit,
    },
};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use crate::common::{random_dir, random_point, rng};

type Tree = AabbTree<u32>;

/// The oracle, by key.
#[derive(Default)]
struct Oracle {
    boxes: BruteForce<u32>,
    leaves: HashMap<u32, LeafId>,
}

impl Oracle {
    fn new() -> Self {
        Self::default()
    }

    fn set(&mut self, key: u32, aabb: Aabb3d) -> Result<(), UpdateError> {
        match self.leaves.get(&key) {
            Some(&leaf) => self.boxes.update(leaf, aabb),
            None => {
                self.leaves.insert(key, self.boxes.insert(key, aabb)?);
                Ok(())
            }
        }
    }

    fn remove(&mut self, key: u32) -> Option<u32> {
        self.boxes.remove(self.leaves.remove(&key)?).ok()
    }
}

fn cube(center: Vec3, half_size: f32) -> Aabb3d {
    Aabb3d::new(center, Vec3::splat(half_size))
}

/// A box in the cube ±100: most of moderate size, some points, some flat, some huge.
fn random_box(rng: &mut ChaCha8Rng) -> Aabb3d {
    let half_size = match rng.random_range(0..10) {
        0 => Vec3::ZERO,
        1 => Vec3::new(5.0, 0.0, 5.0),
        2 => Vec3::splat(rng.random_range(20.0..60.0)),
        _ => random_point(rng, 4.0).abs(),
    };
    Aabb3d::new(random_point(rng, 100.0), half_size)
}

fn random_ray(rng: &mut ChaCha8Rng) -> Ray {
    let t_max = if rng.random() {
        f32::INFINITY
    } else {
        rng.random_range(0.0..200.0)
    };
    let direction = if rng.random_bool(0.2) {
        Vec3::AXES[rng.random_range(0..3)]
    } else {
        *random_dir(rng)
    };
    Ray::new(random_point(rng, 120.0), direction, t_max).expect("a sound ray")
}

/// All answers of a structure to one set of questions.
#[derive(Debug, PartialEq)]
struct Answers {
    closest: Option<(u32, f32)>,
    any: bool,
    along_ray: Vec<u32>,
    in_box: Vec<u32>,
    in_sphere: Vec<u32>,
}

fn answers(
    structure: &impl SpatialQueries<u32>,
    ray: &Ray,
    aabb: &Aabb3d,
    sphere: &BoundingSphere,
    boxes: &impl Fn(u32) -> Aabb3d,
) -> Answers {
    let enter = |key: u32, ray: &Ray| ray.aabb_intersection_at(&boxes(key)).map(|t| (t, ()));
    let mut along_ray = Vec::new();
    structure.visit_ray(ray, |key, _| {
        along_ray.push(key);
        Visit::Continue
    });
    let mut in_box = Vec::new();
    structure.visit_region(aabb, |key| {
        in_box.push(key);
        ControlFlow::Continue(())
    });
    let mut in_sphere = Vec::new();
    structure.visit_region(sphere, |key| {
        in_sphere.push(key);
        ControlFlow::Continue(())
    });
    for keys in [&mut along_ray, &mut in_box, &mut in_sphere] {
        keys.sort_unstable();
    }
    Answers {
        closest: structure.closest_hit(ray, enter).map(|(key, t, ())| (key, t)),
        any: structure.any_hit(ray, |key, ray| enter(key, ray).is_some()),
        along_ray,
        in_box,
        in_sphere,
    }
}

fn assert_same_answers(tree: &Tree, oracle: &Oracle, leaves: &[(u32, LeafId)], rng: &mut ChaCha8Rng) {
    let (ray, aabb) = (random_ray(rng), random_box(rng));
    let sphere = BoundingSphere::new(random_point(rng, 120.0), rng.random_range(0.0..40.0));
    let boxes = |key: u32| {
        let (_, leaf) = leaves.iter().find(|(k, _)| *k == key).expect("a key that was given");
        tree.aabb(*leaf).expect("a live leaf")
    };
    assert_eq!(
        answers(tree, &ray, &aabb, &sphere, &boxes),
        answers(&oracle.boxes, &ray, &aabb, &sphere, &boxes)
    );
    assert_eq!(tree.len(), oracle.boxes.len());
}

#[test]
fn agrees_with_brute_force_under_100_000_random_operations() {
    let mut rng = rng(10);
    let mut tree = Tree::default();
    let mut oracle = Oracle::new();
    let mut leaves: Vec<(u32, LeafId)> = Vec::new();
    for operation in 0..100_000_u32 {
        let growth = if (operation / 5_000) % 2 == 0 { 45 } else { 20 };
        match rng.random_range(0..100) {
            choice if choice < growth || leaves.is_empty() => {
                let aabb = random_box(&mut rng);
                leaves.push((operation, tree.insert(operation, aabb).expect("a sound box")));
                oracle.set(operation, aabb).expect("a sound box");
            }
            choice if choice < 65 => {
                let (key, leaf) = leaves.swap_remove(rng.random_range(0..leaves.len()));
                assert_eq!(tree.remove(leaf), Ok(key));
                assert!(oracle.remove(key).is_some());
            }
            _ => {
                let (key, leaf) = leaves[rng.random_range(0..leaves.len())];
                let old = tree.aabb(leaf).expect("a live leaf");
                // Some drift, some teleport.
                let offset = Vec3A::from(random_point(&mut rng, 0.3));
                let aabb = if rng.random_bool(0.7) {
                    Aabb3d {
                        min: old.min + offset,
                        max: old.max + offset,
                    }
                } else {
                    random_box(&mut rng)
                };
                tree.update(leaf, aabb).expect("a sound box");
                oracle.set(key, aabb).expect("a sound box");
            }
        }
        // Keep the oracle fast.
        if leaves.len() > 600 {
            for (key, leaf) in leaves.drain(300..) {
                tree.remove(leaf).expect("a live leaf");
                oracle.remove(key).expect("a stored key");
            }
        }
        if operation % 20 == 0 {
            assert_same_answers(&tree, &oracle, &leaves, &mut rng);
        }
        if operation % 100 == 0 {
            tree.validate().expect("a whole tree");
        }
    }
}

#[test]
fn a_tree_built_at_once_agrees_with_brute_force() {
    let mut rng = rng(11);
    for n in [0, 1, 2, 3, 5, 17, 1000] {
        let boxes: Vec<(u32, Aabb3d)> = (0..n).map(|key| (key, random_box(&mut rng))).collect();
        let mut tree = Tree::default();
        let leaves: Vec<(u32, LeafId)> = (0..n)
            .zip(
                tree.insert_many(boxes.iter().copied())
                    .into_iter()
                    .map(|leaf| leaf.expect("sound")),
            )
            .collect();
        let mut oracle = Oracle::new();
        for (key, aabb) in &boxes {
            oracle.set(*key, *aabb).expect("a sound box");
        }
        tree.validate().expect("a whole tree");
        for _ in 0..200 {
            assert_same_answers(&tree, &oracle, &leaves, &mut rng);
        }
    }
}

#[test]
fn a_rebuilt_tree_keeps_its_leaves() {
    let mut rng = rng(12);
    let mut tree = Tree::default();
    let leaves: Vec<LeafId> = (0..500)
        .map(|key| tree.insert(key, random_box(&mut rng)).expect("sound"))
        .collect();
    for leaf in leaves.iter().step_by(3) {
        tree.remove(*leaf).expect("a live leaf");
    }
    let before = tree.sah_cost();
    tree.rebuild();
    tree.validate().expect("a whole tree");
    for (key, leaf) in leaves.iter().enumerate() {
        assert_eq!(tree.key(*leaf), (key % 3 != 0).then_some(key as u32));
    }
    assert!(
        tree.sah_cost() <= before * 1.1,
        "rebuilding made it worse: {before} to {}",
        tree.sah_cost()
    );
}

#[test]
fn many_leaves_join_a_tree_that_is_not_empty() {
    let mut rng = rng(13);
    for (present, added) in [(10, 1000), (1000, 10)] {
        let mut tree = Tree::default();
        for key in 0..present {
            tree.insert(key, random_box(&mut rng)).expect("sound");
        }
        let new: Vec<(u32, Aabb3d)> = (present..present + added)
            .map(|key| (key, random_box(&mut rng)))
            .collect();
        tree.insert_many(new);
        tree.validate().expect("a whole tree");
        assert_eq!(tree.len() as u32, present + added);
    }
}

#[test]
fn an_empty_tree_answers_everything_with_nothing() {
    let tree = Tree::default();
    let everywhere = cube(Vec3::ZERO, 1e6);
    let ray = Ray::segment(Vec3::ZERO, Vec3::X).expect("two points");
    assert!(tree.is_empty());
    assert_eq!(tree.bounds(), None);
    assert_eq!(tree.closest_hit(&ray, |_, _| Some((0.0, ()))), None);
    tree.visit_region(&everywhere, |_| panic!("nothing to visit"));
    tree.visit_region(&BoundingSphere::new(Vec3::ZERO, 1e6), |_| panic!("nothing to visit"));
    assert_eq!(tree.validate(), Ok(()));
}

#[test]
fn unsound_boxes_are_refused_and_nothing_changes() {
    let mut tree = Tree::default();
    let good = cube(Vec3::ZERO, 1.0);
    let leaf = tree.insert(7, good).expect("a sound box");
    let nan = Aabb3d {
        min: Vec3A::NAN,
        max: Vec3A::ONE,
    };
    let infinite = Aabb3d {
        min: Vec3A::splat(f32::NEG_INFINITY),
        max: Vec3A::ONE,
    };
    let inverted = Aabb3d {
        min: Vec3A::ONE,
        max: Vec3A::ZERO,
    };
    for bad in [nan, infinite, inverted] {
        assert!(tree.insert(8, bad).is_err());
        assert!(tree.update(leaf, bad).is_err());
        assert!(tree.insert_many([(9, bad)])[0].is_err());
    }
    assert_eq!(tree.len(), 1);
    assert_eq!(tree.aabb(leaf), Some(good));
    assert_eq!(tree.validate(), Ok(()));
}

#[test]
fn removing_a_leaf_twice_is_an_error() {
    let mut tree = Tree::default();
    let leaf = tree.insert(7, cube(Vec3::ZERO, 1.0)).expect("a sound box");
    assert_eq!(tree.remove(leaf), Ok(7));
    assert_eq!(tree.remove(leaf), Err(NoSuchLeaf));
    assert!(tree.update(leaf, cube(Vec3::ZERO, 1.0)).is_err());
}

#[test]
fn the_id_of_a_removed_leaf_does_not_name_the_next_one() {
    let mut tree = Tree::default();
    let old = tree.insert(7, cube(Vec3::ZERO, 1.0)).expect("a sound box");
    tree.remove(old).expect("a live leaf");
    let new = tree.insert(8, cube(Vec3::ZERO, 1.0)).expect("a sound box");
    assert_ne!(old, new);
    assert_eq!(tree.key(old), None);
    assert_eq!(tree.key(new), Some(8));
}

#[test]
fn clearing_invalidates_all_leaves() {
    let mut tree = Tree::default();
    let leaf = tree.insert(7, cube(Vec3::ZERO, 1.0)).expect("a sound box");
    tree.clear();
    assert!(tree.is_empty());
    assert_eq!(tree.remove(leaf), Err(NoSuchLeaf));
    assert_eq!(tree.validate(), Ok(()));
    assert!(tree.insert(8, cube(Vec3::ZERO, 1.0)).is_ok());
}

#[test]
fn a_leaf_that_moves_within_its_margin_is_still_found_by_its_exact_box() {
    let mut tree = Tree::new();
    let leaf = tree.insert(1, cube(Vec3::ZERO, 1.0)).expect("a sound box");
    for step in 1..100 {
        let center = Vec3::X * (step as f32 * 0.1);
        tree.update(leaf, cube(center, 1.0)).expect("a sound box");
        let mut found = Vec::new();
        let beside = cube(center + Vec3::X * 1.5, 0.49);
        tree.visit_region(&beside, |key| {
            found.push(key);
            ControlFlow::Continue(())
        });
        assert!(found.is_empty(), "the margin shows at step {step}");
        assert_eq!(tree.aabb(leaf), Some(cube(center, 1.0)));
    }
    assert_eq!(tree.validate(), Ok(()));
}

#[test]
fn a_leaf_that_shrinks_is_fitted_again() {
    let mut tree = Tree::default();
    let leaf = tree.insert(1, cube(Vec3::ZERO, 1000.0)).expect("a sound box");
    tree.update(leaf, cube(Vec3::ZERO, 1.0)).expect("a sound box");
    let bounds = tree.bounds().expect("one leaf");
    assert!(bounds.max.max_element() < 2.0, "{bounds:?}");
}

#[test]
fn coincident_boxes_are_all_found() {
    let mut tree = Tree::default();
    for key in 0..1000 {
        tree.insert(key, cube(Vec3::ONE, 1.0)).expect("a sound box");
    }
    tree.validate().expect("a whole tree");
    tree.rebuild();
    tree.validate().expect("a whole tree");
    let mut found = 0;
    tree.visit_region(&cube(Vec3::ONE, 0.1), |_| {
        found += 1;
        ControlFlow::Continue(())
    });
    assert_eq!(found, 1000);
}

#[test]
fn boxes_of_wildly_different_sizes_are_found() {
    let mut rng = rng(14);
    let mut tree = Tree::default();
    let mut oracle = Oracle::new();
    let mut leaves = Vec::new();
    for key in 0..300 {
        let size = 10.0_f32.powi(rng.random_range(-30..30));
        let aabb = cube(random_point(&mut rng, size), size);
        leaves.push((key, tree.insert(key, aabb).expect("a sound box")));
        oracle.set(key, aabb).expect("a sound box");
    }
    tree.validate().expect("a whole tree");
    for _ in 0..200 {
        assert_same_answers(&tree, &oracle, &leaves, &mut rng);
    }
}

#[test]
fn of_two_hits_at_one_distance_the_smaller_key_wins() {
    for order in [[1, 2], [2, 1]] {
        let mut tree = Tree::default();
        for key in order {
            tree.insert(key, cube(Vec3::ZERO, 1.0)).expect("a sound box");
        }
        let ray = Ray::new(Vec3::X * 5.0, -Vec3::X, f32::INFINITY).expect("a sound ray");
        assert_eq!(tree.closest_hit(&ray, |_, _| Some((4.0, ()))), Some((1, 4.0, ())));
    }
}

#[test]
fn a_visitor_that_stops_is_not_called_again() {
    let mut tree = Tree::default();
    for key in 0..100 {
        tree.insert(key, cube(Vec3::ZERO, 1.0)).expect("a sound box");
    }
    let ray = Ray::new(Vec3::X * 5.0, -Vec3::X, f32::INFINITY).expect("a sound ray");
    let mut visits = 0;
    tree.visit_ray(&ray, |_, _| {
        visits += 1;
        Visit::Stop
    });
    tree.visit_region(&cube(Vec3::ZERO, 1.0), |_| {
        visits += 1;
        ControlFlow::Break(())
    });
    assert_eq!(visits, 2);
}

#[test]
fn sorted_insertion_does_not_turn_the_tree_into_a_list() {
    let mut tree = AabbTree::<u32>::default();
    let n = 100_000;
    for key in 0..n {
        tree.insert(key, cube(Vec3::X * key as f32 * 3.0, 1.0))
            .expect("a sound box");
    }
    // A list would cost n / 2; a balanced tree over a line costs about log2(n).
    assert!(tree.sah_cost() < 40.0, "{}", tree.sah_cost());
}

/// A tree of `n` cubes at random places, its leaves, and the boxes that it was given.
fn random_tree(n: u32, rng: &mut ChaCha8Rng) -> (Tree, Vec<LeafId>, Vec<Aabb3d>) {
    let boxes: Vec<Aabb3d> = (0..n).map(|_| cube(random_point(rng, 100.0), 1.0)).collect();
    let mut tree = Tree::default();
    let leaves = tree.insert_many((0..).zip(boxes.iter().copied()));
    (
        tree,
        leaves.into_iter().map(|leaf| leaf.expect("sound")).collect(),
        boxes,
    )
}

fn found(structure: &impl SpatialQueries<u32>, region: &Aabb3d) -> Vec<u32> {
    let mut keys = Vec::new();
    structure.find_in_region(region, &mut keys);
    keys.sort_unstable();
    keys
}

const EVERYWHERE: Aabb3d = Aabb3d {
    min: Vec3A::splat(-1e6),
    max: Vec3A::splat(1e6),
};

#[test]
fn a_mask_hides_the_leaves_that_have_none_of_its_bits_from_every_query() {
    let mut rng = rng(20);
    let mut tree = Tree::default();
    let mut oracle = BruteForce::new();
    let mut leaves = Vec::new();
    for key in 0..500 {
        let (aabb, mask) = (random_box(&mut rng), 1 << (key % 3));
        let leaf = tree.insert_masked(key, aabb, mask).expect("sound");
        leaves.push(leaf);
        // Later, every fifth changes sides.
        let mask = if key % 5 == 0 { 1 } else { mask };
        if mask & 0b101 != 0 {
            oracle.insert(key, aabb).expect("sound");
        }
    }
    for leaf in leaves.iter().step_by(5) {
        tree.set_mask(*leaf, 1).expect("a live leaf");
    }
    tree.validate().expect("a whole tree");
    let view = tree.masked(0b101);
    assert_eq!(view.len(), oracle.len());
    assert_eq!(view.bounds(), oracle.bounds());
    let boxes = |key: u32| tree.aabb(leaves[key as usize]).expect("a live leaf");
    for _ in 0..200 {
        let (ray, aabb) = (random_ray(&mut rng), random_box(&mut rng));
        let sphere = BoundingSphere::new(random_point(&mut rng, 120.0), 30.0);
        assert_eq!(
            answers(&view, &ray, &aabb, &sphere, &boxes),
            answers(&oracle, &ray, &aabb, &sphere, &boxes)
        );
    }
    let pairs = |structure: &dyn Fn(&mut Vec<[u32; 2]>)| {
        let mut pairs = Vec::new();
        structure(&mut pairs);
        pairs.iter_mut().for_each(|pair| pair.sort_unstable());
        pairs.sort_unstable();
        pairs
    };
    let expected = pairs(&|pairs| {
        oracle.visit_pairs(|a, b| {
            pairs.push([a, b]);
            ControlFlow::Continue(())
        });
    });
    let masked = pairs(&|pairs| {
        view.visit_pairs(|a, b| {
            pairs.push([a, b]);
            ControlFlow::Continue(())
        });
    });
    assert_eq!(masked, expected);
}

#[test]
fn a_leaf_without_a_bit_in_its_mask_is_never_found() {
    let mut tree = Tree::default();
    tree.insert_masked(1, cube(Vec3::ZERO, 1.0), 0).expect("sound");
    tree.insert(2, cube(Vec3::ZERO, 1.0)).expect("sound");
    assert_eq!(found(&tree, &EVERYWHERE), [2]);
    assert_eq!(tree.validate(), Ok(()));
}

#[test]
fn a_leaf_that_is_never_found_is_not_found_in_a_part_that_is_taken_whole_either() {
    let mut rng = rng(29);
    let mut tree = Tree::default();
    let leaves = tree.insert_many_masked((0..500).map(|key| {
        let mask = if key % 100 == 7 { 0 } else { 0b11 };
        (key, cube(random_point(&mut rng, 100.0), 1.0), mask)
    }));
    let hidden = leaves[100].expect("sound");
    tree.set_mask(hidden, 0).expect("a live leaf");
    for mask in [u32::MAX, 0b1] {
        let keys = found(&tree.masked(mask), &EVERYWHERE);
        assert!(keys.iter().all(|key| key % 100 != 7 && *key != 100));
        assert_eq!(keys.len(), 494);
    }
    assert_eq!(tree.validate(), Ok(()));
}

#[test]
fn a_tree_that_was_rebuilt_beside_takes_over_all_that_has_changed() {
    let mut rng = rng(21);
    let (mut tree, mut leaves, mut boxes) = random_tree(1000, &mut rng);
    let rebuild = tree.begin_rebuild();
    let mut alive = vec![true; leaves.len()];
    for key in (0..1000).step_by(3) {
        tree.remove(leaves[key]).expect("a live leaf");
        alive[key] = false;
    }
    // The first of these take the numbers of those that are gone.
    for key in 1000..1600 {
        boxes.push(cube(random_point(&mut rng, 100.0), 1.0));
        alive.push(true);
        leaves.push(tree.insert(key, boxes[key as usize]).expect("sound"));
    }
    for key in (1..1600).step_by(7).filter(|&key| alive[key]).collect::<Vec<_>>() {
        boxes[key] = cube(random_point(&mut rng, 100.0), 2.0);
        tree.update(leaves[key], boxes[key]).expect("a live leaf");
        tree.set_mask(leaves[key], 0b100).expect("a live leaf");
    }
    let rebuilt = std::thread::spawn(|| rebuild.run()).join().expect("no panic");
    tree.adopt(rebuilt);
    assert_eq!(tree.validate(), Ok(()));
    for key in 0..1600 {
        let expected = alive[key].then_some(boxes[key]);
        assert_eq!(tree.aabb(leaves[key]), expected);
        assert_eq!(tree.key(leaves[key]), alive[key].then_some(key as u32));
        if alive[key] {
            assert!(found(&tree, &boxes[key]).contains(&(key as u32)));
        }
    }
    assert_eq!(
        found(&tree, &EVERYWHERE).len(),
        alive.iter().filter(|&&alive| alive).count()
    );
}

#[test]
fn a_tree_that_was_cleared_meanwhile_adopts_nothing() {
    let (mut tree, ..) = random_tree(100, &mut rng(22));
    let rebuild = tree.begin_rebuild();
    tree.clear();
    tree.adopt(rebuild.run());
    assert!(tree.is_empty());
    assert_eq!(tree.validate(), Ok(()));
    assert_eq!(found(&tree, &EVERYWHERE), [0_u32; 0]);
}

#[test]
fn leaves_that_teleport_leave_the_tree_as_good_as_new() {
    let mut rng = rng(23);
    let (mut tree, leaves, _) = random_tree(2000, &mut rng);
    for _ in 0..100 {
        let updates: Vec<_> = (0..20)
            .map(|_| {
                let leaf = leaves[rng.random_range(0..leaves.len())];
                (leaf, cube(random_point(&mut rng, 100.0), 1.0))
            })
            .collect();
        assert_eq!(tree.update_many(&updates), []);
        tree.optimize();
    }
    let worn = tree.sah_cost();
    tree.rebuild();
    assert!(worn < 1.1 * tree.sah_cost(), "{worn} instead of {}", tree.sah_cost());
}

#[test]
fn leaves_that_drift_leave_the_tree_as_good_as_new() {
    let mut rng = rng(24);
    let (mut tree, leaves, mut boxes) = random_tree(2000, &mut rng);
    let velocities: Vec<Vec3A> = (0..2000).map(|_| random_point(&mut rng, 1.0).into()).collect();
    for _ in 0..200 {
        for (aabb, velocity) in boxes.iter_mut().zip(&velocities) {
            aabb.min += velocity;
            aabb.max += velocity;
        }
        let updates: Vec<_> = leaves.iter().copied().zip(boxes.iter().copied()).collect();
        assert_eq!(tree.update_many(&updates), []);
        tree.optimize();
    }
    let worn = tree.sah_cost();
    tree.rebuild();
    assert!(worn < 1.1 * tree.sah_cost(), "{worn} instead of {}", tree.sah_cost());
}

#[test]
fn a_still_tree_is_not_built_anew() {
    let mut rng = rng(25);
    let (mut tree, leaves, boxes) = random_tree(1000, &mut rng);
    for _ in 0..10 {
        tree.update_many(&leaves.iter().copied().zip(boxes.iter().copied()).collect::<Vec<_>>());
        assert!(!tree.optimize());
    }
}

#[test]
fn many_updates_are_refused_one_by_one() {
    let mut rng = rng(26);
    let (mut tree, leaves, boxes) = random_tree(10, &mut rng);
    tree.remove(leaves[3]).expect("a live leaf");
    let nan = Aabb3d {
        min: Vec3A::NAN,
        max: Vec3A::ONE,
    };
    let moved = cube(Vec3::ONE, 1.0);
    let refused = tree.update_many(&[(leaves[0], moved), (leaves[3], moved), (leaves[5], nan)]);
    let refused: Vec<LeafId> = refused.into_iter().map(|(leaf, _)| leaf).collect();
    assert_eq!(refused, [leaves[3], leaves[5]]);
    assert_eq!(tree.aabb(leaves[0]), Some(moved));
    assert_eq!(tree.aabb(leaves[5]), Some(boxes[5]));
    assert_eq!(tree.validate(), Ok(()));
}

#[test]
fn every_strategy_builds_a_whole_tree() {
    let mut rng = rng(27);
    let (mut tree, ..) = random_tree(1000, &mut rng);
    for strategy in [
        BuildStrategy::MiddleSplit,
        BuildStrategy::MedianSplit,
        BuildStrategy::BinnedSah,
        BuildStrategy::Ploc,
    ] {
        tree.rebuild_with(strategy);
        assert_eq!(tree.validate(), Ok(()), "{strategy:?}");
        assert_eq!(found(&tree, &EVERYWHERE).len(), 1000, "{strategy:?}");
    }
}

#[test]
fn pairs_of_two_trees_are_found_once_each() {
    let mut rng = rng(28);
    let (a, ..) = random_tree(4000, &mut rng);
    let (b, ..) = random_tree(1000, &mut rng);
    let (mut by_trees, mut by_boxes) = (Vec::new(), Vec::new());
    a.visit_pairs_with_tree(&b, |a, b| {
        by_trees.push((a, b));
        ControlFlow::Continue(())
    });
    a.visit_pairs_with(&b, |a, b| {
        by_boxes.push((a, b));
        ControlFlow::Continue(())
    });
    by_trees.sort_unstable();
    by_boxes.sort_unstable();
    assert!(!by_trees.is_empty());
    assert_eq!(by_trees, by_boxes);
}

#[test]
fn masks_that_change_during_a_rebuild_beside_are_kept() {
    let mut tree = Tree::default();
    let boxes = (0..100).map(|key| (key, cube(Vec3::X * key as f32 * 3.0, 1.0), 1));
    let leaves = tree.insert_many_masked(boxes);
    let rebuild = tree.begin_rebuild();
    tree.set_mask(leaves[40].expect("sound"), 2).expect("a live leaf");
    tree.adopt(rebuild.run());
    assert_eq!(tree.validate(), Ok(()));
    assert_eq!(found(&tree.masked(2), &EVERYWHERE), [40]);
    assert_eq!(found(&tree.masked(1), &EVERYWHERE).len(), 99);
}

#[test]
fn a_rebuild_of_another_tree_does_no_harm() {
    for removed in [[7, 5], [5, 7]] {
        let mut tree = Tree::default();
        let leaves: Vec<LeafId> = (0..20)
            .map(|key| tree.insert(key, cube(Vec3::X * key as f32 * 3.0, 1.0)).expect("sound"))
            .collect();
        let mut other = tree.clone();
        tree.remove(leaves[5]).expect("a live leaf");
        tree.insert(77, cube(Vec3::ZERO, 1.0)).expect("sound");
        for key in removed {
            other.remove(leaves[key]).expect("a live leaf");
        }
        other.adopt(tree.begin_rebuild().run());
        assert_eq!(other.validate(), Ok(()));
        assert_eq!(found(&other, &EVERYWHERE).len(), 18);
    }
}

#[test]
fn nodes_are_visited_only_below_those_that_are_gone_into() {
    let (tree, ..) = random_tree(5000, &mut rng(17));
    let (mut all, mut visited) = (Vec::new(), Vec::new());
    tree.visit_nodes(|depth, aabb| all.push((depth, *aabb)));
    tree.descend_nodes(|depth, aabb| {
        visited.push((depth, *aabb));
        if depth < 2 { Descend::Into } else { Descend::Past }
    });
    assert!(tree.depth() > 3);
    all.retain(|&(depth, _)| depth <= 2);
    assert_eq!(visited.len(), all.len());
    assert!(all.iter().all(|node| visited.contains(node)));
}

#[test]
fn no_node_is_visited_after_a_stop() {
    let (tree, ..) = random_tree(2000, &mut rng(18));
    let mut visits = 0;
    tree.descend_nodes(|_, _| {
        visits += 1;
        if visits == 5 { Descend::Stop } else { Descend::Into }
    });
    assert_eq!(visits, 5);
}
