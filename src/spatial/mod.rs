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
//! | `AabbTree` | 1k | 102 µs | 460 ns | 2.4 µs | 8.1 µs | **141 ns** | **261 ns** | **130 ns** | **632 ns** | **815 ns** | **16.6 µs** | 68 |
//! | `UniformGrid` | 1k | 76.7 µs | 180 ns | 1.7 µs | 19.6 µs | 461 ns | 263 ns | 136 ns | 697 ns | 1.4 µs | 25.4 µs | 74 |
//! | `Octree` | 1k | 157 µs | 431 ns | 4.9 µs | 31.4 µs | 149 ns | 295 ns | 144 ns | 714 ns | 834 ns | 19.5 µs | 89 |
//! | `KdTree` | 1k | 545 µs | 481 µs | 541 µs | 567 µs | 160 ns | 294 ns | 136 ns | 640 ns | 905 ns | 23.4 µs | 60 |
//! | `BruteForce` | 1k | **8.5 µs** | **60 ns** | **290 ns** | **2.9 µs** | 3.3 µs | 1.3 µs | 2.5 µs | 2.4 µs | 67.4 µs | 1.1 ms | **41** |
//! | `AabbTree` | 10k | **804 µs** | 24.5 µs | **67.7 µs** | **132 µs** | 329 ns | 406 ns | 191 ns | 833 ns | **3.9 µs** | **211 µs** | 75 |
//! | `UniformGrid` | 10k | 825 µs | **15.2 µs** | 80.0 µs | 289 µs | 620 ns | **358 ns** | **179 ns** | **814 ns** | 8.7 µs | 320 µs | 71 |
//! | `Octree` | 10k | 5.8 ms | 42.1 µs | 169 µs | 516 µs | 364 ns | 466 ns | 195 ns | 854 ns | 4.0 µs | 247 µs | 143 |
//! | `KdTree` | 10k | 15.1 ms | 15.0 ms | 15.8 ms | 15.8 ms | **325 ns** | 432 ns | 195 ns | 838 ns | 4.5 µs | 288 µs | **59** |
//! | `AabbTree` | 100k | 25.3 ms | 264 µs | **729 µs** | **1.6 ms** | **950 ns** | 1.2 µs | 446 ns | 1.7 µs | **30.2 µs** | **3.6 ms** | 71 |
//! | `UniformGrid` | 100k | **14.1 ms** | **134 µs** | 823 µs | 3.3 ms | 1.3 µs | **755 ns** | **307 ns** | **1.6 µs** | 48.8 µs | 6.3 ms | 60 |
//! | `Octree` | 100k | 54.0 ms | 362 µs | 1.8 ms | 6.7 ms | 974 ns | 1.3 µs | 419 ns | 1.7 µs | 31.6 µs | 3.6 ms | 114 |
//! | `KdTree` | 100k | 213 ms | 193 ms | 91.4 ms | 104 ms | 956 ns | 1.1 µs | 406 ns | 1.9 µs | 31.3 µs | 6.2 ms | **60** |
//!
//! In clusters:
//!
//! | structure | boxes | build | 1 % move | 10 % move | 100 % move | closest ray | sphere | box | 8 nearest | frustum | all pairs | bytes a box |
//! |---|---|---|---|---|---|---|---|---|---|---|---|---|
//! | `AabbTree` | 10k | **880 µs** | 23.3 µs | **66.3 µs** | **147 µs** | **117 ns** | 257 ns | 165 ns | 828 ns | **1.7 µs** | **132 µs** | 76 |
//! | `UniformGrid` | 10k | 1.1 ms | **13.9 µs** | 75.6 µs | 325 µs | 584 ns | **242 ns** | 168 ns | 874 ns | 4.8 µs | 244 µs | 77 |
//! | `Octree` | 10k | 2.0 ms | 42.9 µs | 154 µs | 520 µs | 142 ns | 311 ns | 166 ns | 910 ns | 2.3 µs | 157 µs | 143 |
//! | `KdTree` | 10k | 15.1 ms | 8.3 ms | 8.2 ms | 8.3 ms | 121 ns | 269 ns | **142 ns** | **794 ns** | 1.9 µs | 172 µs | **61** |
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
