//! Spatial structures over boxes, without an ECS: generic over a small `Copy` key, all answering one trait.
//!
//! | structure | build | update | queries | for |
//! |---|---|---|---|---|
//! | [`AabbTree`] | binned SAH, O(n log n) | O(log n) each: refitted inside the margin, re-inserted beyond | O(log n + hits) | everything that moves, of any size |
//! | [`BruteForce`] | none | O(1) | O(n) | the oracle of the tests, and a handful of boxes |
//!
//! A structure stores boxes and keys, and knows nothing about what is inside a box: the caller's closure decides
//! whether a key whose box was met is a hit, and what a hit is. See [`SpatialQueries`].

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
