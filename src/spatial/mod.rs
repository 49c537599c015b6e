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
//! CHOOSING

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
pub use build::BuildStrategy;
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

/// A leaf that is not, or no longer, in the structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no such leaf: it was removed, or belongs to another structure")]
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
