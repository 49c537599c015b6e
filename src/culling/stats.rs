//! What culling has cost, and what has come of it.

use std::time::Duration;

use bevy::{
    ecs::{reflect::ReflectResource, resource::Resource},
    reflect::{Reflect, std_traits::ReflectDefault},
};

use crate::occlusion::OcclusionStats;

/// What the systems of [`ViewCullingSystems`](super::ViewCullingSystems) did in the last frame in which they ran, and how
/// long it took: while [culling is left to Bevy](super::ViewCullingSettings::enabled), it stays as it was.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Resource, Default, Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ViewCullingStats {
    /// The active cameras.
    pub views: usize,
    /// What cameras see, counted once for each.
    pub visible: usize,
    /// What has come into the view of a camera, counted in the same way.
    pub entered: usize,
    /// What has gone out of it.
    pub left: usize,
    /// The shadow maps: cascades, cube faces and those of spot lights.
    pub shadow_maps: usize,
    /// What is in the shadow maps, counted once for each.
    pub casters: usize,
    /// The entities that were tested by themselves, as Bevy tests all: for a plane of a view cuts their box, or they are
    /// [not in the tree](super). What lies wholly inside or outside is not among them, nor what is known from the frame
    /// before.
    pub tested: usize,
    /// What hiding things from cameras took, all together, the last time that it had to be found out for each.
    pub occlusion: OcclusionStats,
    /// The time of [`Find`](super::ViewCullingSystems::Find).
    pub find: Duration,
    /// The time of [`Write`](super::ViewCullingSystems::Write).
    pub write: Duration,
    /// The time of [`Lights`](super::ViewCullingSystems::Lights).
    pub lights: Duration,
    /// The time of [`Hide`](super::ViewCullingSystems::Hide).
    pub hide: Duration,
}
