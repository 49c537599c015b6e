//! Proxy LOD: the right stand-in, for each view, without popping back and forth.
//!
//! Proxy geometry stands in for an object where speed matters more than accuracy. It is no bounding volume: culling goes
//! on by the bounds of what is shown, and rays hit the finest level unless [asked otherwise](LodHits).
//!
//! # What a group is
//!
//! [`ProxyLod`] on the root of a group lists its levels, from finest to coarsest. There are two kinds of group:
//!
//! | levels are | shown by | chosen | costs | good for |
//! |---|---|---|---|---|
//! | entities, with all below them | leaving the others out of the lists of each view | for each camera, and for shadows | entities for all levels | split screen, models of many parts, blocks of houses |
//! | meshes | swapping `Mesh3d` on the root | for the [main camera](LodSettings::main_camera) | a handle for each level | single meshes, great numbers |
//!
//! A level may show the roots of other groups: one proxy stands in for a block, and the houses of the block have levels of
//! their own, to any depth. Of everything, every view shows exactly one representation in every frame. A mesh that is
//! swapped keeps its material, unless there are [`LevelVariants`] of that.
//!
//! # Which level is shown
//!
//! [`LodMetric`] decides: the height of the group as a fraction of the viewport, the error of a level in pixels, or the
//! plain distance. The first two know the field of view, zoom, orthographic cameras, the viewport and the scale of the
//! root. All levels of a group are decided by the one place and size of the group, to its nearest point or its
//! [centre](LodReference).
//!
//! A finer level comes at its threshold, which so is a promise; a coarser one only [10% beyond](LodSettings::hysteresis),
//! so that nothing switches back and forth. [`LodSettings::min_dwell`] has levels stay for a time, and
//! [`LodSettings::cross_fade`] has them fade into each other. Biases are multiplied: for all ([`LodSettings::bias`]), for a
//! camera ([`LodBias`]), for a group ([`ProxyLod::bias`]), for shadows ([`LodSettings::shadow_bias`]), which are seen from
//! the place of the camera whose they are, or for point lights and spot lights of Bevy's one shadow origin.
//!
//! [`LodChoices`] tells which level is shown where, and [`LodSwapped`] of each switch.
//!
//! # What it costs
//!
//! Every group knows how far a camera may move before another level can be right. The groups of which that is used up are
//! looked at, and those that have moved or changed: so a camera that stands still costs next to nothing, and one that
//! moves as much as there is near a switch. A lens that changes has all groups looked at, by a few nanoseconds each.
//!
//! # Loading and dropping
//!
//! [`LodContent::Streamed`] names meshes by paths: they are loaded when their level comes near, and dropped when it has been
//! far for long, within [`LodStreamingSettings::memory_budget`]. Of whatever level a mesh is not loaded, or cannot be, the
//! finest that is there stands in for it.

mod await_meshes;
mod choices;
mod choose;
mod eyes;
mod fade;
mod follow;
mod group;
mod groups;
mod lens;
mod mesh_roots;
mod place;
mod settings;
#[cfg(feature = "simplify")]
pub mod simplify;
mod stats;
mod streaming;
mod swap;
mod variants;
mod view_levels;

pub use choices::LodChoices;
pub(crate) use choices::LodView;
pub use group::{LodContent, LodHits, LodLevel, LodMetric, LodReference, ProxyLod};
#[cfg(feature = "inspector")]
pub(crate) use lens::MAX_LEVELS;
pub use settings::{LodBias, LodSettings};
pub use stats::LodStats;
pub use streaming::{LodStreamingSettings, LodStreamingStats};
pub use variants::{LevelVariants, LevelVariantsPlugin};
pub(crate) use view_levels::ViewLevels;

use bevy::{
    app::{App, Plugin, PostUpdate},
    asset::{AssetEvent, AssetEventSystems},
    camera::{CameraUpdateSystems, visibility::VisibilitySystems},
    ecs::{
        change_detection::Res,
        entity::Entity,
        event::EntityEvent,
        message::Messages,
        reflect::ReflectEvent,
        schedule::{IntoScheduleConfigs, SystemSet},
    },
    mesh::Mesh,
    reflect::Reflect,
    transform::TransformSystems,
};

use fade::Fades;
use streaming::StreamedMeshes;

use crate::index::{SpatialIndex, SpatialIndexPlugin, SpatialIndexSystems};

/// When levels are chosen; all in `PostUpdate`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, SystemSet)]
pub enum LodSystems {
    /// Groups are brought up to date: before the index, and before Bevy computes bounds.
    Follow,
    /// Levels are chosen for every view, and meshes swapped: after the index, before views are culled.
    Choose,
}

/// A view shows another level of a group than before. Not triggered for the first that it shows, and triggered wherever
/// the group is: also out of sight, and where another stands in for it.
#[derive(EntityEvent, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Event, Debug, Clone, PartialEq)]
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

/// Chooses between the levels of [`ProxyLod`]s: see [`lod`](self). Adds [`SpatialIndexPlugin`] by itself. Adding it again
/// does nothing, so that whatever makes levels may add it.
///
/// Levels that are entities need the [`ViewCullingPlugin`](crate::culling::ViewCullingPlugin), which leaves those out of
/// views that these do not show.
#[derive(Clone, Copy, Debug, Default)]
pub struct ProxyLodPlugin;

impl Plugin for ProxyLodPlugin {
    fn build(&self, app: &mut App) {
        if app.is_plugin_added::<Self>() {
            return;
        }
        app.add_plugins(SpatialIndexPlugin)
            .init_resource::<LodChoices>()
            .init_resource::<LodSettings>()
            .init_resource::<Fades>()
            .init_resource::<LodStats>()
            .init_resource::<LodStreamingSettings>()
            .init_resource::<LodStreamingStats>()
            .init_resource::<StreamedMeshes>()
            .register_type::<ProxyLod>()
            .register_type::<LodBias>()
            .register_type::<LodSettings>()
            .register_type::<LodStats>()
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
                        .after(CameraUpdateSystems)
                        .before(VisibilitySystems::CheckVisibility),
                ),
            )
            .add_systems(
                PostUpdate,
                (
                    (
                        follow::follow_groups,
                        (mesh_roots::bound_swapped, await_meshes::await_meshes)
                            .chain_ignore_deferred()
                            .run_if(has_news_of_meshes),
                    )
                        .chain_ignore_deferred()
                        .in_set(LodSystems::Follow),
                    (
                        choose::choose_levels,
                        fade::cross_fade.run_if(fade::fades),
                        swap::swap_meshes.run_if(has_pending),
                        streaming::stream_meshes.run_if(streaming::streams),
                    )
                        .chain_ignore_deferred()
                        .in_set(LodSystems::Choose),
                ),
            );
    }

    fn is_unique(&self) -> bool {
        false
    }
}

/// Whether a mesh, or a group, may have changed.
fn has_news_of_meshes(
    events: Option<Res<Messages<AssetEvent<Mesh>>>>,
    choices: Res<LodChoices>,
    index: Res<SpatialIndex>,
) -> bool {
    let is_other = |events: &Messages<_>| {
        !events.is_empty() || choices.has_pending() || choices.has_groups() && !index.reconciled().is_empty()
    };
    events.is_some_and(|events| is_other(&events))
}

fn has_pending(choices: Res<LodChoices>) -> bool {
    choices.has_pending()
}
