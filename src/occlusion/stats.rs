//! What following occluders has cost.

use std::time::Duration;

use bevy::{
    ecs::{reflect::ReflectResource, resource::Resource},
    reflect::{Reflect, std_traits::ReflectDefault},
};

/// What [`OcclusionSystems::FollowOccluders`](super::OcclusionSystems::FollowOccluders) did in the last frame, and how long
/// it took. What cameras do with the occluders is in their [`OcclusionBuffer`](super::OcclusionBuffer)s, and of all
/// cameras together in the [`ViewCullingStats`](crate::culling::ViewCullingStats).
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Resource, Default, Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct OccluderStats {
    /// The entities that occlude.
    pub occluders: usize,
    /// The entities that do not although they should: see [`Occluders::refused`](super::Occluders::refused).
    pub refused: usize,
    /// The meshes of which the shape is being made.
    pub making: usize,
    /// The entities that were looked at, for something else than their place had changed.
    pub reconciled: usize,
    /// The time that it took.
    pub follow: Duration,
}
