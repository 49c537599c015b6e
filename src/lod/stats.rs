//! What following groups and choosing levels has cost, and what has come of it.

use std::time::Duration;

use bevy::{
    ecs::{reflect::ReflectResource, resource::Resource},
    reflect::{Reflect, std_traits::ReflectDefault},
};

/// What the systems of [`LodSystems`](super::LodSystems) did in the last frame, and how long it took.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Resource, Default, Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct LodStats {
    /// The groups that there are.
    pub groups: usize,
    /// The groups that were looked at in some view, as often as they were: near a switch, moved, or changed.
    pub looked_at: usize,
    /// The groups that switched in some view, as often as they did.
    pub switched: usize,
    /// The time of [`Follow`](super::LodSystems::Follow).
    pub follow: Duration,
    /// The time of [`Choose`](super::LodSystems::Choose), with fading, swapping and streaming.
    pub choose: Duration,
}
