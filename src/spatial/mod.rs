//! Spatial structures over boxes, without an ECS: generic over a small `Copy` key, all answering one trait.
//!
//! | structure | what it is | for |
//! |---|---|---|
//! | [`AabbTree`] | a hierarchy of tight boxes, eight to a node | everything, of any size, moving or not: rays, culling, nearest |
//! | [`UniformGrid`] | cells in a hash table, a coarser level for each size | crowds of like things that move: neighbours, pairs, what is in a cell |
//! | [`KdTree`], [`PointKdTree`] | space split by planes, built once | points and boxes that never move: the nearest points above all |
//! | [`Octree`] | cubes of powers of two | what is to be gone through by level: streaming, level of detail, drawing |
//! | [`BruteForce`] | a list | a handful of boxes; the oracle of the tests |
//!
//! A structure stores boxes and keys, and knows nothing about what is inside a box: the caller's closure decides
//! whether a key whose box was met is a hit, and what a hit is. See [`SpatialQueries`] for what can be asked, and
//! [`SpatialUpdates`] for what can be changed. All give the very same answers.
//!
//! ```
//! use bevy::math::{Vec3, Vec3A, bounding::{Aabb3d, BoundingSphere}};
//! use bevy_sightline::{geometry::ray::Ray, spatial::{AabbTree, SpatialQueries, SpatialUpdates}};
//!
//! let mut tree = AabbTree::new();
//! let cubes = (0..1000).map(|key| (key, Aabb3d::new(Vec3::X * key as f32 * 3.0, Vec3::ONE)));
//! let leaves = tree.insert_many(cubes);
//!
//! let ray = Ray::new(Vec3::new(30.0, 50.0, 0.0), Vec3::NEG_Y, f32::INFINITY).expect("a direction");
//! assert_eq!(tree.closest_box(&ray).map(|(key, _)| key), Some(10));
//!
//! let mut found = Vec::new();
//! tree.find_in_region(&BoundingSphere::new(Vec3::ZERO, 4.0), &mut found);
//! assert_eq!(found.len(), 2);
//!
//! tree.update(leaves[999].expect("a sound box"), Aabb3d::new(Vec3::Y * 9.0, Vec3::ONE)).expect("it is there");
//! tree.k_nearest(Vec3A::Y * 8.5, 1, f32::INFINITY, &mut Vec::new());
//! ```
//!
//! # Which to choose
//!
//! In figures: one thread, medians of one run on a busy two-core virtual machine (AMD EPYC); a frame's worth of moves for the updates,
//! of which a tree that does not change is built anew. The best of each column is bold.
//!
//! Boxes of like size, spread evenly:
//!
//! | structure | boxes | build | 1 % move | 10 % move | 100 % move | closest ray | sphere | box | 8 nearest | frustum | all pairs | bytes a box |
//! |---|---|---|---|---|---|---|---|---|---|---|---|---|
//! | `AabbTree` | 1k | 77.3 µs | 551 ns | 2.2 µs | 7.6 µs | **124 ns** | **257 ns** | **128 ns** | 802 ns | **789 ns** | **18.8 µs** | 68 |
//! | `UniformGrid` | 1k | 77.2 µs | 211 ns | 1.6 µs | 19.3 µs | 470 ns | 275 ns | 148 ns | 867 ns | 1.4 µs | 27.9 µs | 74 |
//! | `Octree` | 1k | 151 µs | 601 ns | 4.3 µs | 29.2 µs | 129 ns | 289 ns | 140 ns | 889 ns | 848 ns | 22.9 µs | 89 |
//! | `KdTree` | 1k | 556 µs | 596 µs | 616 µs | 643 µs | 146 ns | 312 ns | 159 ns | **729 ns** | 936 ns | 25.3 µs | 60 |
//! | `BruteForce` | 1k | **8.5 µs** | **61 ns** | **281 ns** | **2.5 µs** | 3.6 µs | 1.5 µs | 2.8 µs | 3.5 µs | 28.8 µs | 1.2 ms | **41** |
//! | `AabbTree` | 10k | **762 µs** | 24.6 µs | **66.3 µs** | **132 µs** | **217 ns** | 349 ns | **171 ns** | 810 ns | **3.3 µs** | **225 µs** | 75 |
//! | `UniformGrid` | 10k | 823 µs | **15.4 µs** | 80.7 µs | 300 µs | 545 ns | **336 ns** | 175 ns | **766 ns** | 7.8 µs | 324 µs | 71 |
//! | `Octree` | 10k | 1.9 ms | 42.6 µs | 178 µs | 533 µs | 236 ns | 386 ns | 186 ns | 815 ns | 3.8 µs | 264 µs | 143 |
//! | `KdTree` | 10k | 7.9 ms | 15.0 ms | 13.6 ms | 15.1 ms | 247 ns | 410 ns | 184 ns | 783 ns | 4.2 µs | 283 µs | **59** |
//! | `AabbTree` | 100k | 17.5 ms | 262 µs | **791 µs** | **1.9 ms** | 948 ns | 1.1 µs | 621 ns | 1.6 µs | 45.3 µs | **4.0 ms** | 71 |
//! | `UniformGrid` | 100k | **14.4 ms** | **156 µs** | 903 µs | 5.5 ms | 1.4 µs | **749 ns** | **470 ns** | **1.4 µs** | 48.3 µs | 4.0 ms | 60 |
//! | `Octree` | 100k | 37.4 ms | 383 µs | 1.9 ms | 11.0 ms | **916 ns** | 1.1 µs | 578 ns | 1.5 µs | **37.1 µs** | 4.1 ms | 114 |
//! | `KdTree` | 100k | 171 ms | 162 ms | 149 ms | 154 ms | **916 ns** | 1.1 µs | 598 ns | 1.9 µs | 41.6 µs | 5.0 ms | **60** |
//! | `AabbTree` | 1M | 464 ms | 2.5 ms | **15.7 ms** | **38.2 ms** | 2.5 µs | 3.2 µs | 2.3 µs | 4.4 µs | 704 µs | **100 ms** | 68 |
//! | `UniformGrid` | 1M | **274 ms** | **1.8 ms** | 29.7 ms | 274 ms | 3.4 µs | **2.5 µs** | **1.8 µs** | **4.1 µs** | 1.2 ms | 150 ms | **57** |
//! | `Octree` | 1M | 673 ms | 4.5 ms | 58.1 ms | 341 ms | 2.6 µs | 3.1 µs | 2.3 µs | 4.2 µs | 1.2 ms | 117 ms | 91 |
//! | `KdTree` | 1M | 1863 ms | 1293 ms | 1928 ms | 1841 ms | **2.4 µs** | 2.9 µs | 2.1 µs | 4.2 µs | **474 µs** | 133 ms | 62 |
//!
//! In clusters:
//!
//! | structure | boxes | build | 1 % move | 10 % move | 100 % move | closest ray | sphere | box | 8 nearest | frustum | all pairs | bytes a box |
//! |---|---|---|---|---|---|---|---|---|---|---|---|---|
//! | `AabbTree` | 1k | 74.8 µs | 401 ns | 2.3 µs | 8.4 µs | **48 ns** | **147 ns** | **77 ns** | 670 ns | **540 ns** | **13.0 µs** | 68 |
//! | `UniformGrid` | 1k | 89.1 µs | 200 ns | 1.8 µs | 19.4 µs | 310 ns | 167 ns | 110 ns | 761 ns | 1.2 µs | 20.5 µs | 88 |
//! | `Octree` | 1k | 138 µs | 531 ns | 3.8 µs | 22.8 µs | 54 ns | 189 ns | 96 ns | 744 ns | 662 ns | 14.6 µs | 166 |
//! | `KdTree` | 1k | 627 µs | 604 µs | 630 µs | 673 µs | 52 ns | 185 ns | 96 ns | **664 ns** | 649 ns | 16.8 µs | 61 |
//! | `BruteForce` | 1k | **7.9 µs** | **60 ns** | **290 ns** | **3.9 µs** | 3.6 µs | 1.2 µs | 1.8 µs | 2.4 µs | 26.8 µs | 853 µs | **41** |
//! | `AabbTree` | 10k | **856 µs** | 23.5 µs | **70.7 µs** | **142 µs** | **103 ns** | 246 ns | 170 ns | 851 ns | **1.4 µs** | **152 µs** | 76 |
//! | `UniformGrid` | 10k | 1.1 ms | **16.0 µs** | 83.6 µs | 322 µs | 550 ns | **237 ns** | **168 ns** | 872 ns | 4.8 µs | 236 µs | 77 |
//! | `Octree` | 10k | 2.0 ms | 42.1 µs | 180 µs | 517 µs | 129 ns | 288 ns | 207 ns | 923 ns | 1.9 µs | 169 µs | 143 |
//! | `KdTree` | 10k | 9.8 ms | 12.1 ms | 7.4 ms | 7.9 ms | 108 ns | 263 ns | 170 ns | **778 ns** | 1.6 µs | 170 µs | **61** |
//! | `AabbTree` | 100k | 21.5 ms | 250 µs | **870 µs** | **2.1 ms** | **508 ns** | 733 ns | 644 ns | **1.8 µs** | 34.5 µs | **2.6 ms** | 72 |
//! | `UniformGrid` | 100k | **11.5 ms** | **150 µs** | 930 µs | 4.2 ms | 1.8 µs | **587 ns** | **583 ns** | 2.1 µs | 68.6 µs | 4.7 ms | 77 |
//! | `Octree` | 100k | 37.0 ms | 445 µs | 2.6 ms | 11.9 ms | 637 ns | 844 ns | 794 ns | 2.1 µs | 39.6 µs | 2.7 ms | 114 |
//! | `KdTree` | 100k | 170 ms | 150 ms | 155 ms | 108 ms | 527 ns | 746 ns | **583 ns** | 2.0 µs | **26.9 µs** | 3.6 ms | **62** |
//!
//! A flat city, with streets and towers:
//!
//! | structure | boxes | build | 1 % move | 10 % move | 100 % move | closest ray | sphere | box | 8 nearest | frustum | all pairs | bytes a box |
//! |---|---|---|---|---|---|---|---|---|---|---|---|---|
//! | `AabbTree` | 10k | **915 µs** | 17.2 µs | **73.0 µs** | **126 µs** | **133 ns** | **267 ns** | **166 ns** | 797 ns | **4.6 µs** | **214 µs** | 74 |
//! | `UniformGrid` | 10k | 1.4 ms | **11.8 µs** | 84.7 µs | 267 µs | 770 ns | 346 ns | 259 ns | 937 ns | 10.5 µs | 476 µs | 72 |
//! | `Octree` | 10k | 1.8 ms | 40.4 µs | 175 µs | 333 µs | 182 ns | 288 ns | 184 ns | 789 ns | 7.0 µs | 231 µs | 143 |
//! | `KdTree` | 10k | 8.1 ms | 8.0 ms | 8.0 ms | 8.1 ms | 145 ns | 300 ns | 173 ns | **760 ns** | 5.9 µs | 301 µs | **62** |
//!
//! Sizes from tiny to huge:
//!
//! | structure | boxes | build | 1 % move | 10 % move | 100 % move | closest ray | sphere | box | 8 nearest | frustum | all pairs | bytes a box |
//! |---|---|---|---|---|---|---|---|---|---|---|---|---|
//! | `AabbTree` | 10k | **701 µs** | 22.2 µs | **62.6 µs** | **147 µs** | **267 ns** | 328 ns | 154 ns | **804 ns** | 3.2 µs | **70.1 µs** | 76 |
//! | `UniformGrid` | 10k | 1.6 ms | **12.8 µs** | 63.5 µs | 297 µs | 979 ns | 441 ns | 246 ns | 982 ns | 7.7 µs | 357 µs | 71 |
//! | `Octree` | 10k | 1.7 ms | 37.5 µs | 121 µs | 514 µs | 293 ns | 352 ns | 157 ns | 816 ns | 3.3 µs | 71.7 µs | 143 |
//! | `KdTree` | 10k | 7.7 ms | 7.7 ms | 7.7 ms | 7.7 ms | 286 ns | **324 ns** | **150 ns** | 811 ns | **3.1 µs** | 119 µs | **60** |
//!
//! So take the tree unless you know better; the grid for crowds, whose neighbours it finds up to one and a half times as fast
//! and which it follows at half the cost when few of them move; the k-d tree over points ([`PointKdTree`]) for what is built once and asked for the
//! nearest ever after; the octree where its levels are what you are after.

pub mod aabb_tree;
pub mod brute_force;
pub mod build;
pub mod kd_tree;
pub(crate) mod lanes;
pub(crate) mod leaves;
pub mod octree;
pub mod query;
pub mod region;
pub(crate) mod simd;
pub mod sweep;
pub(crate) mod traverse;
pub mod uniform_grid;
pub(crate) mod wide;

pub use aabb_tree::AabbTree;
pub use brute_force::BruteForce;
pub use build::{BuildProgress, BuildStrategy};
pub use kd_tree::{KdTree, PointKdTree};
pub use leaves::LeafId;
pub use octree::Octree;
pub use query::{Neighbour, SpatialQueries, SpatialUpdates, Visit};
pub use region::Region;
pub use sweep::Sweep;
pub use uniform_grid::UniformGrid;

use bevy::math::bounding::Aabb3d;

/// A box that no structure stores: NaN or infinite, or with a minimum above its maximum.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("not a sound box, its bounds must be finite and in order: {0:?}")]
pub struct UnsoundBox(pub Aabb3d);

/// A leaf that is not, or no longer, in the structure. That of another structure may pass for one of this.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no such leaf: it was removed, or is of another structure")]
pub struct NoSuchLeaf;

/// Why a leaf was not moved.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum UpdateError {
    /// The new box is not sound.
    #[error(transparent)]
    UnsoundBox(#[from] UnsoundBox),
    /// There is no such leaf.
    #[error(transparent)]
    NoSuchLeaf(#[from] NoSuchLeaf),
}
