//! The components that ask for proxies.

use bevy::{
    ecs::{component::Component, reflect::ReflectComponent},
    reflect::{Reflect, std_traits::ReflectDefault},
};

use super::SimplifyTarget;
use crate::lod::ProxyLod;

/// Has levels of detail made of the mesh of an entity, in the background, and fills its [`ProxyLod`] with them.
///
/// On an entity with `Mesh3d`. Once the mesh is loaded, it is simplified to each of the targets and measured; then the
/// entity has a [`ProxyLod`] of metric [`PixelError`](crate::lod::LodMetric::PixelError), in which every level stands
/// with its measured error: the original first. What was there of a [`ProxyLod`] but levels and metric stays. Levels
/// are made once for all entities with the same mesh and settings, and made anew when the mesh asset is modified, or
/// the entity given another one; meanwhile the original is shown. [`ProxyReady`](super::ProxyReady) and
/// [`ProxyFailed`](super::ProxyFailed) tell the outcome.
///
/// Skinned and morphed meshes are measured at rest: a pose that stretches them stretches the error.
///
/// Without this component the entity keeps the [`ProxyLod`] that it has got, which nothing follows any more; what is
/// still being made is called off.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sightline::prelude::*;
/// # fn spawn(mut commands: Commands, assets: Res<AssetServer>) {
/// commands.spawn((
///     Mesh3d(assets.load("statue.glb#Mesh0/Primitive0")),
///     AutoProxy::new([SimplifyTarget::Ratio(0.3), SimplifyTarget::Error(0.02)]),
/// ));
/// # }
/// ```
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub struct AutoProxy {
    /// A level for each, in any order; at most seven, for a [`ProxyLod`](crate::lod::ProxyLod) has eight with the original. One that is not worth its memory is left out: see
    /// [`MeshChain::build`](super::MeshChain::build).
    pub levels: Vec<SimplifyTarget>,
    /// Whether vertices at open edges stay, so that neighbours that share them still fit.
    pub lock_borders: bool,
    /// How many pixels of error may be seen.
    pub pixels: f32,
}

impl Default for AutoProxy {
    /// Five levels, each of half the triangles of the one before, at most a pixel off.
    fn default() -> Self {
        Self::new([0.5, 0.25, 0.125, 0.0625, 0.03125].map(SimplifyTarget::Ratio))
    }
}

impl AutoProxy {
    /// Levels for these targets, at most a pixel off.
    pub fn new(levels: impl IntoIterator<Item = SimplifyTarget>) -> Self {
        Self {
            levels: levels.into_iter().collect(),
            lock_borders: false,
            pixels: 1.0,
        }
    }

    /// Allows so many pixels of error to be seen.
    pub fn with_pixels(self, pixels: f32) -> Self {
        Self { pixels, ..self }
    }

    /// Keeps vertices at open edges.
    pub fn with_locked_borders(self) -> Self {
        Self {
            lock_borders: true,
            ..self
        }
    }
}

/// Has one simple proxy made of a whole block of static meshes, in the background, and fills a [`ProxyLod`] with it.
///
/// On the root of the block. Once the meshes of all that is below are loaded, they are merged in the space of the root,
/// simplified and measured; then the root has a [`ProxyLod`] of metric
/// [`PixelError`](crate::lod::LodMetric::PixelError) with two levels: its children with all that is below, and the
/// proxy, which is a child of the root too. There is one proxy mesh for all parts with the same materials: see
/// [`AutoProxyPlugin::with_material`](super::AutoProxyPlugin::with_material).
///
/// Of descendants with levels of their own the finest level is merged, whichever is shown. Left out, and shown at any
/// distance as long as nothing beside them below the same child is merged, are skinned meshes and those with morph
/// weights; left out are hidden entities, and the mesh of the root itself, which is always shown.
///
/// Nothing of the block is followed afterwards: insert the component anew when it has changed. Without it the root
/// keeps the [`ProxyLod`] and the proxy; what is still being made is called off.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub struct ClusterProxy {
    /// How far the merged meshes are simplified: those of each material by themselves.
    pub target: SimplifyTarget,
    /// Whether vertices at open edges stay.
    pub lock_borders: bool,
    /// How many pixels of error may be seen.
    pub pixels: f32,
}

impl Default for ClusterProxy {
    /// A tenth of the triangles, at most a pixel off.
    fn default() -> Self {
        Self::new(SimplifyTarget::Ratio(0.1))
    }
}

impl ClusterProxy {
    /// A proxy for this target, at most a pixel off.
    pub fn new(target: SimplifyTarget) -> Self {
        Self {
            target,
            lock_borders: false,
            pixels: 1.0,
        }
    }

    /// Allows so many pixels of error to be seen.
    pub fn with_pixels(self, pixels: f32) -> Self {
        Self { pixels, ..self }
    }
}

/// A group with new levels and metric, otherwise as it was.
pub(super) fn filled(before: Option<&ProxyLod>, levels: ProxyLod) -> ProxyLod {
    match before {
        Some(before) => ProxyLod {
            levels: levels.levels,
            metric: levels.metric,
            ..before.clone()
        },
        None => levels,
    }
}
