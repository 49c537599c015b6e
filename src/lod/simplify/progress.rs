//! How far the making of proxies has come.

use std::time::Duration;

use bevy::{
    ecs::{
        change_detection::{DetectChangesMut, Res, ResMut},
        entity::Entity,
        event::EntityEvent,
        reflect::{ReflectEvent, ReflectResource},
        resource::Resource,
    },
    reflect::{Reflect, std_traits::ReflectDefault},
};

use super::{SimplifyError, clusters::ClusterProxies, proxies::AutoProxies};
use crate::phase::phase;

/// How many proxies are done of how many, for a loading bar.
///
/// What is made once counts once: the levels of a mesh for all entities that use it with the same settings, and the
/// proxy of each block. What is not used any more does not count.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Resource, Default, Debug, Clone, PartialEq)]
pub struct ProxyProgress {
    /// How many there are to be.
    pub total: usize,
    /// How many are done, with those that have failed.
    pub done: usize,
    /// How many of those have failed.
    pub failed: usize,
    /// How many wait for their meshes to be loaded, or for their turn.
    pub waiting: usize,
    /// What part of the work is done, about, with what is half done: from 0 to 1.
    pub fraction: f32,
}

impl ProxyProgress {
    /// Whether nothing is left to be done.
    pub fn is_done(&self) -> bool {
        self.done == self.total
    }
}

/// What [`AutoProxySystems::Make`](super::AutoProxySystems::Make) took in the last frame, beside what is made in the
/// background.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Resource, Default, Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ProxyStats {
    /// The time that it took.
    pub make: Duration,
}

/// The proxies of an entity with [`AutoProxy`](super::AutoProxy) or [`ClusterProxy`](super::ClusterProxy) are there.
///
/// Triggered again when the component is changed, or what was made is made anew.
#[derive(EntityEvent, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Event, Debug, Clone, PartialEq)]
pub struct ProxyReady {
    /// The root of the group.
    pub entity: Entity,
    /// How many levels the group has, with the original. If it is one, nothing simpler was worth its memory, and there
    /// is no group.
    pub levels: usize,
}

/// There are no proxies for an entity with [`AutoProxy`](super::AutoProxy) or [`ClusterProxy`](super::ClusterProxy),
/// which stays as it is.
///
/// Not reflected, for its error tells of formats of vertices, which are not.
#[derive(EntityEvent, Clone, Copy, Debug, PartialEq)]
pub struct ProxyFailed {
    /// The entity.
    pub entity: Entity,
    /// Why.
    pub error: SimplifyError,
}

/// Where one of the things is that are counted.
pub(super) enum Stage {
    Waiting,
    /// So much of it is done.
    Making(f32),
    Ready,
    Failed,
}

/// Counts what is done.
pub(super) fn count_progress(
    proxies: Res<AutoProxies>,
    clusters: Res<ClusterProxies>,
    mut progress: ResMut<ProxyProgress>,
    mut stats: ResMut<ProxyStats>,
) {
    let _phase = phase!("sightline/simplify/make").adds_to(&mut stats.make);
    let mut now = ProxyProgress::default();
    let mut work = 0.0;
    for stage in proxies.stages().chain(clusters.stages()) {
        now.total += 1;
        match stage {
            Stage::Waiting => now.waiting += 1,
            Stage::Making(fraction) => work += fraction,
            Stage::Ready => now.done += 1,
            Stage::Failed => {
                now.done += 1;
                now.failed += 1;
            }
        }
    }
    now.fraction = if now.total > 0 {
        (work + now.done as f32) / now.total as f32
    } else {
        1.0
    };
    progress.set_if_neq(now);
}
