//! Proxy LOD: the right stand-in, for each view, without popping back and forth.

mod await_meshes;
mod choices;
mod choose;
mod fade;
mod follow;
mod group;
mod groups;
mod lens;
mod place;
mod settings;
mod streaming;
mod view_levels;

pub use choices::LodChoices;
pub(crate) use choices::LodView;
pub use group::{LodContent, LodHits, LodLevel, LodMetric, LodReference, ProxyLod};
pub use settings::{LodBias, LodSettings};
pub use streaming::{LodStreamingSettings, LodStreamingStats};
pub(crate) use view_levels::ViewLevels;

use bevy::{
    app::{App, Plugin, PostUpdate},
    asset::AssetEventSystems,
    camera::visibility::VisibilitySystems,
    ecs::{
        entity::Entity,
        event::EntityEvent,
        schedule::{IntoScheduleConfigs, SystemSet},
    },
    reflect::Reflect,
    transform::TransformSystems,
};

use fade::Fades;
use streaming::StreamedMeshes;

use crate::index::{SpatialIndexPlugin, SpatialIndexSystems};

/// When levels are chosen; all in `PostUpdate`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, SystemSet)]
pub enum LodSystems {
    /// Groups are brought up to date: before the index, and before Bevy computes bounds.
    Follow,
    /// Levels are chosen for every view, and meshes swapped: after the index, before views are culled.
    Choose,
}

/// A view shows another level of a group than before. Not triggered for the first that it shows.
#[derive(EntityEvent, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Debug, Clone, PartialEq)]
pub struct LodSwapped {
    /// The root of the group.
    pub entity: Entity,
    /// The camera; where meshes are swapped, the main one.
    pub view: Entity,
    /// The level that was shown, from zero for the finest.
    pub from: usize,
    /// The level that is shown.
    pub to: usize,
}

/// Chooses between the levels of [`ProxyLod`]s: see [`lod`](self). Adds [`SpatialIndexPlugin`] by itself.
///
/// Levels that are entities need the [`ViewCullingPlugin`](crate::culling::ViewCullingPlugin), which leaves those out of
/// views that these do not show.
#[derive(Clone, Copy, Debug, Default)]
pub struct ProxyLodPlugin;

impl Plugin for ProxyLodPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(SpatialIndexPlugin)
            .init_resource::<LodChoices>()
            .init_resource::<LodSettings>()
            .init_resource::<Fades>()
            .init_resource::<LodStreamingSettings>()
            .init_resource::<LodStreamingStats>()
            .init_resource::<StreamedMeshes>()
            .register_type::<ProxyLod>()
            .register_type::<LodBias>()
            .register_type::<LodSettings>()
            .register_type::<LodStreamingSettings>()
            .register_type::<LodStreamingStats>()
            .register_type::<LodSwapped>()
            .configure_sets(
                PostUpdate,
                (
                    LodSystems::Follow
                        .after(AssetEventSystems)
                        .before(VisibilitySystems::CalculateBounds)
                        .before(SpatialIndexSystems::Sync),
                    LodSystems::Choose
                        .after(SpatialIndexSystems::Sync)
                        .after(TransformSystems::Propagate)
                        .before(VisibilitySystems::CheckVisibility),
                ),
            )
            .add_systems(
                PostUpdate,
                (
                    (follow::follow_groups, follow::bound_swapped, await_meshes::await_meshes)
                        .chain_ignore_deferred()
                        .in_set(LodSystems::Follow),
                    (
                        choose::choose_levels,
                        fade::cross_fade,
                        choose::swap_meshes,
                        streaming::stream_meshes,
                    )
                        .chain_ignore_deferred()
                        .in_set(LodSystems::Choose),
                ),
            );
    }
}
