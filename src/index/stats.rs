//! What keeping the index in step has cost.

use std::time::Duration;

use bevy::{
    ecs::{reflect::ReflectResource, resource::Resource},
    reflect::{Reflect, std_traits::ReflectDefault},
};

/// What the systems of [`SpatialIndexSystems`](super::SpatialIndexSystems) did in the last frame, and how long it took.
///
/// What the index is, as opposed to what became of it, is in [`SpatialIndex::stats`](super::SpatialIndex::stats).
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Resource, Default, Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SyncStats {
    /// The entities that had moved and not changed otherwise.
    pub moved: usize,
    /// The entities that had changed otherwise, were new or gone: they are looked at one by one.
    pub reconciled: usize,
    /// The skinned and morphed entities whose pose had changed; those are among what had moved.
    pub posed: usize,
    /// The time that it took to follow the poses, which is part of [`find`](Self::find).
    pub posing: Duration,
    /// The meshes that were posed for rays since the frame before.
    pub posed_for_rays: usize,
    /// The time that this took, in all threads together. Not part of any other.
    pub posing_for_rays: Duration,
    /// The time that it took to follow the assets of meshes, which is part of no other.
    pub meshes: Duration,
    /// The time that it took to find them and to compute the world boxes of what had moved.
    pub find: Duration,
    /// The time that it took to bring the structures up to date.
    pub structures: Duration,
    /// The time of [`Sync`](super::SpatialIndexSystems::Sync) from end to end, without the meshes.
    pub total: Duration,
    /// The time of [`Optimize`](super::SpatialIndexSystems::Optimize).
    pub optimize: Duration,
    /// Whether a tree that was built anew was taken over: see [`AabbTree::adopt`](crate::spatial::AabbTree::adopt). Large
    /// ones are built beside their use.
    pub optimized: bool,
}
