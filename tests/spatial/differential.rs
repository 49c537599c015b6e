//! Structures against [`BruteForce`], which is too simple to be wrong: every query must have the very same answer.
//!
//! Two entries. [`agrees_while_changing`] takes a structure that changes through random operations, one line for each
//! kind; [`agrees_when_built`] builds one that does not from scenes of every kind and size.
//!
//! # How much
//!
//! `SPATIAL_OPERATIONS` in the environment is the number of operations for each structure, with a new seed every time
//! unless `SPATIAL_SEED` has one; without it, 6000 from a fixed seed. After each operation its own outcome is compared.
//! All queries are compared, and the structure validated, 120 times at least, and then once in every 2000 operations. All
//! scenes have the same share. The long run, 10⁸ operations in total over the four structures that change:
//!
//! ```sh
//! SPATIAL_OPERATIONS=25000000 cargo test --release --test all spatial::differential
//! ```

mod operations;
mod queries;
pub mod scenes;

use bevy::math::{Quat, Vec3, Vec3A, bounding::Aabb3d};
use bevy_sightline::{
    geometry::{obb::Obb, ray::Ray, sweep::SphereSweep},
    spatial::{
        AabbTree, BruteForce, KdTree, Octree, Region, SpatialQueries, SpatialUpdates, UniformGrid, Visit,
        kd_tree::SplitMethod,
    },
};
use rand::Rng;

use crate::common::rng;
use operations::Pair;
use scenes::Scene;

/// Structures that know what must hold of them.
pub trait Validate {
    /// What does not hold, in words.
    fn broken_invariant(&self) -> Option<String>;
}

impl<K: Copy> Validate for Octree<K> {
    fn broken_invariant(&self) -> Option<String> {
        self.validate().err().map(|broken| broken.to_string())
    }
}

impl<K: Copy> Validate for AabbTree<K> {
    fn broken_invariant(&self) -> Option<String> {
        self.validate().err().map(|broken| broken.to_string())
    }
}

impl<K: Copy> Validate for UniformGrid<K> {
    fn broken_invariant(&self) -> Option<String> {
        self.validate().err().map(|broken| broken.to_string())
    }
}

impl<K> Validate for BruteForce<K> {
    fn broken_invariant(&self) -> Option<String> {
        None
    }
}

/// The operations that were asked for, and a seed.
fn asked() -> (usize, u64) {
    let number = |name| std::env::var(name).ok().map(|number| number.parse().expect("a number"));
    match number("SPATIAL_OPERATIONS") {
        Some(operations) => (operations as usize, number("SPATIAL_SEED").unwrap_or_else(rand::random)),
        None => (6000, 0),
    }
}

/// Takes a structure and the oracle through the same random operations, and compares what they say.
///
/// # Panics
///
/// If they disagree, or if an invariant is broken; the message names scene and seed.
pub fn agrees_while_changing<T: SpatialUpdates<u32> + Validate>(new: impl Fn() -> T) {
    let (operations, seed) = asked();
    let for_scene = operations.div_ceil(Scene::ALL.len());
    let period = (for_scene / 15).clamp(1, 2000);
    for scene in Scene::ALL {
        let context = format!("{scene:?}, seed {seed}");
        let mut rng = rng(seed);
        let mut pair = Pair::new(new(), scene, context);
        let mut done = 0;
        while done < for_scene {
            let until = for_scene.min(done + period);
            while done < until {
                done += pair.change(&mut rng);
                if period < 100 {
                    pair.validate();
                }
            }
            pair.compare(&mut rng);
        }
        pair.empty(&mut rng);
    }
}

/// Builds a structure from scenes of every kind, with from none to some hundred boxes, and compares all queries.
///
/// # Panics
///
/// If it and the oracle disagree; the message names scene and seed.
pub fn agrees_when_built<T: SpatialQueries<u32>>(build: impl Fn(&[(u32, Aabb3d)]) -> T) {
    let (operations, seed) = asked();
    let rounds = (operations / 2000).max(3);
    for round in 0..rounds {
        for scene in Scene::ALL {
            for size in [0, 1, 2, 9, 300] {
                let seed = seed.wrapping_add(round as u64);
                let mut rng = rng(seed);
                let count = rng.random_range(size / 2..=size);
                let leaves: Vec<(u32, Aabb3d)> = (0..count).map(|key| (key, scene.aabb(&mut rng))).collect();
                let mut oracle = BruteForce::new();
                oracle.insert_many(leaves.iter().copied());
                let context = format!("{scene:?}, {count} boxes, seed {seed}");
                queries::compare_all(&build(&leaves), &oracle, scene, &mut rng, &context);
            }
        }
    }
}

#[test]
fn brute_force_agrees_with_itself() {
    agrees_while_changing(BruteForce::<u32>::new);
    agrees_when_built(|leaves| {
        let mut built = BruteForce::new();
        built.insert_many(leaves.iter().copied());
        built
    });
}

#[test]
fn octree_agrees_while_changing() {
    agrees_while_changing(Octree::<u32>::new);
}

#[test]
fn octree_agrees_when_built_at_once() {
    agrees_when_built(|leaves| {
        let mut built = Octree::new();
        built.insert_many(leaves.iter().copied());
        built
    });
}

#[test]
fn aabb_tree_agrees_while_changing() {
    agrees_while_changing(AabbTree::<u32>::default);
}

/// The same box a dozen times: enough for a node above.
fn dozen(aabb: Aabb3d) -> [(u32, Aabb3d); 12] {
    std::array::from_fn(|key| (key as u32, aabb))
}

/// What counts as contact grows with the distance along the path, and boxes around must be met so much earlier.
#[test]
fn a_sweep_finds_what_it_barely_touches_far_away() {
    let path = Ray::new(Vec3A::ZERO, Vec3A::X, f32::INFINITY).expect("a ray");
    let sweep = SphereSweep::new(path, 1.0).expect("a sweep");
    let mut touched = 0;
    for gap in (0..200).map(|i| i as f32 * 3e-7) {
        let aabb = Aabb3d {
            min: Vec3A::new(1e7, 1.0 + gap, -1.0),
            max: Vec3A::new(1e7 + 1.0, 5.0, 1.0),
        };
        let (mut octree, mut oracle) = (Octree::new(), BruteForce::new());
        octree.insert_many(dozen(aabb));
        oracle.insert_many(dozen(aabb));
        assert_eq!(octree.first_touched(&sweep), oracle.first_touched(&sweep), "{gap}");
        touched += u32::from(oracle.first_touched(&sweep).is_some());
    }
    assert!((1..200).contains(&touched), "the gaps are all too small or too large");
}

/// The axes of an oriented box are not quite at right angles: the planes around a flat one are a little apart, and what
/// is between them need not touch it.
#[test]
fn a_flat_oriented_box_does_not_contain_what_is_beside_it() {
    let half_size = Vec3A::new(1000.0, 0.0, 1000.0);
    let mut apart = 0;
    for turn in 0..100 {
        let rotation = Quat::from_scaled_axis(Vec3::new(0.3, 0.7, 0.2) * (turn as f32 * 0.04 + 0.1));
        let obb = Obb::new(Vec3A::ZERO, half_size, rotation).expect("a box");
        for step in -5i8..5 {
            let center = obb.axes().y_axis * f32::from(step) * 1e-5;
            let aabb = Aabb3d::new(center, Vec3A::splat(1e-7));
            let (mut octree, mut found) = (Octree::new(), Vec::new());
            octree.insert_many(dozen(aabb));
            octree.find_in_region(&obb, &mut found);
            assert_eq!(found.is_empty(), !obb.touches(&aabb), "{obb:?} and {aabb:?}");
            apart += u32::from(found.is_empty());
        }
    }
    assert!(apart > 0, "none was beside it");
}

#[test]
fn aabb_tree_agrees_when_built_at_once() {
    agrees_when_built(|leaves| {
        let mut built = AabbTree::new();
        built.insert_many(leaves.iter().copied());
        built
    });
}

#[test]
fn uniform_grid_agrees_while_changing() {
    agrees_while_changing(UniformGrid::<u32>::default);
}

#[test]
fn uniform_grid_agrees_when_built_at_once() {
    agrees_when_built(|leaves| {
        let mut built = UniformGrid::default();
        built.insert_many(leaves.iter().copied());
        built
    });
}

#[test]
fn kd_tree_agrees() {
    for method in [SplitMethod::Sah, SplitMethod::Median] {
        agrees_when_built(|leaves| KdTree::new(leaves.iter().copied(), method).expect("sound boxes"));
    }
}

/// How many boxes are near a point.
fn near(structure: &impl SpatialQueries<u32>, point: Vec3A, max_distance: f32) -> usize {
    let mut count = 0;
    structure.visit_near(point, max_distance, |_, _| {
        count += 1;
        Visit::Continue
    });
    count
}

#[test]
fn nothing_is_within_a_negative_distance_or_near_a_point_at_infinity() {
    let leaves = [
        (0, Aabb3d::new(Vec3::ZERO, Vec3::ONE)),
        (1, Aabb3d::new(Vec3::X * 9.0, Vec3::ONE)),
    ];
    let mut tree = AabbTree::new();
    let mut grid = UniformGrid::default();
    let mut octree = Octree::new();
    let mut oracle = BruteForce::new();
    tree.insert_many(leaves);
    grid.insert_many(leaves);
    octree.insert_many(leaves);
    oracle.insert_many(leaves);
    let kd_tree = KdTree::new(leaves, SplitMethod::Sah).expect("sound boxes");
    for (point, distance) in [
        (Vec3A::X * 2.0, -3.0),
        (Vec3A::ZERO, -0.5),
        (Vec3A::ZERO, f32::NEG_INFINITY),
        (Vec3A::INFINITY, f32::INFINITY),
        (Vec3A::NAN, f32::INFINITY),
    ] {
        assert_eq!(near(&tree, point, distance), 0);
        assert_eq!(near(&grid, point, distance), 0);
        assert_eq!(near(&octree, point, distance), 0);
        assert_eq!(near(&kd_tree, point, distance), 0);
        assert_eq!(near(&oracle, point, distance), 0);
        grid.neighbours_within(point, distance, |key, _| {
            panic!("{key} is within {distance} of {point}")
        });
    }
}
