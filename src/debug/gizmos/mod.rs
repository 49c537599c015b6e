//! Gizmos: what the index, the views and the levels of detail are made of, drawn as lines.
//!
//! # What is drawn
//!
//! Everything is off until it is switched on in [`SightlineGizmos`], which is a
//! [`GizmoConfigGroup`](bevy::gizmos::config::GizmoConfigGroup), for the whole scene:
//!
//! | switch | draws | in the colour of |
//! |---|---|---|
//! | `nodes` | the nodes of the tree, between the depths that are asked for | their depth |
//! | `cells` | the cells of the grid that hold something; a grid is kept while this is on, unless the [settings](crate::index::SpatialIndexSettings::grid) have none | their level |
//! | `leaves` | the world box of every entity | |
//! | `volumes` | a bounding volume of this kind around every mesh, where it stands | |
//! | `frusta` | what every active camera sees | |
//! | `occluders` | the boxes by which things occlude; of triangles, the box around them | |
//! | `rays` | for every pointer: the ray, what it hits, the normal and the triangle (feature `picking`) | |
//! | `lods` | the sphere around every [group](crate::lod::ProxyLod) | the level that the main camera shows |
//!
//! or for one entity, with the component [`ShowGizmos`]:
//!
//! ```
//! # use bevy::prelude::*;
//! # use bevy_sightline::prelude::*;
//! fn show_tree(mut store: ResMut<GizmoConfigStore>) {
//!     let (config, gizmos) = store.config_mut::<SightlineGizmos>();
//!     gizmos.nodes = true;
//!     gizmos.depths = 2..=4;
//!     config.line.width = 1.0;
//! }
//!
//! fn show_selected(mut commands: Commands, selected: Res<Selected>) {
//!     commands.entity(selected.0).insert(ShowGizmos::default());
//! }
//! # #[derive(Resource)]
//! # struct Selected(Entity);
//! ```
//!
//! Structures that one builds oneself, and rays that one casts, are drawn by the methods of [`DrawStructures`], which every
//! [`Gizmos`](bevy::gizmos::gizmos::Gizmos) has:
//!
//! ```
//! # use bevy::prelude::*;
//! # use bevy_sightline::{prelude::*, spatial::Octree};
//! # #[derive(Resource)]
//! # struct Regions(Octree<u32>);
//! fn draw(regions: Res<Regions>, eye: Single<&GlobalTransform, With<Camera>>, scene: SceneQuery, mut gizmos: Gizmos) {
//!     gizmos.octree(&regions.0, &StructureStyle::default());
//!
//!     let ray = Ray3d::new(eye.translation(), eye.forward());
//!     gizmos.ray_hit(ray, scene.cast_ray(ray, &SceneQuerySettings::default()).as_ref());
//! }
//! ```
//!
//! # What it costs
//!
//! While everything is off, and nothing has [`ShowGizmos`], one run condition a frame. Otherwise what is in view of some
//! camera is found by the index, in about the time that culling takes, and the nearest are drawn, up to
//! [`SightlineGizmos::limit`] lines of each kind: [`SightlineGizmoStats`] says how many were drawn and how many were left
//! out. Volumes are made in the background, as those that rays hit, and kept with their meshes.

mod config;
mod draw;
mod entities;
mod lods;
mod nearest;
#[cfg(feature = "picking")]
mod rays;
mod scene;
mod shapes;
mod stats;
mod structures;
mod views;
mod volumes;

pub use config::{ShowGizmos, SightlineGizmos, default_palette};
pub use stats::{GizmoCount, SightlineGizmoStats};
pub use structures::{DrawStructures, StructureStyle};

use bevy::{
    app::{App, Plugin, PostUpdate},
    asset::Assets,
    camera::visibility::VisibilitySystems,
    ecs::{
        change_detection::Res,
        query::With,
        schedule::{IntoScheduleConfigs, SystemSet},
        system::Query,
    },
    gizmos::{AppGizmoBuilder, GizmoAsset, config::GizmoConfigStore, gizmos::GizmoStorage},
    transform::TransformSystems,
};

use crate::{
    index::{SpatialIndexPlugin, SpatialIndexSystems},
    lod::LodSystems,
    occlusion::OcclusionSystems,
};

/// When gizmos are drawn; in `PostUpdate`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, SystemSet)]
pub struct SightlineGizmoSystems;

/// Draws what is switched on: see [`gizmos`](self). Adds [`SpatialIndexPlugin`] by itself.
///
/// Needs Bevy's `GizmoPlugin`, which is among its `DefaultPlugins`; does nothing without it.
#[derive(Clone, Copy, Debug, Default)]
pub struct SightlineGizmosPlugin;

impl Plugin for SightlineGizmosPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(SpatialIndexPlugin)
            .init_resource::<SightlineGizmoStats>()
            .init_resource::<volumes::Wanted>()
            .register_type::<SightlineGizmos>()
            .register_type::<SightlineGizmoStats>()
            .register_type::<ShowGizmos>();
        start_drawing(app);
    }

    fn finish(&self, app: &mut App) {
        start_drawing(app);
    }
}

/// Adds what draws, once there is something to draw with.
fn start_drawing(app: &mut App) {
    let can_draw = app.world().contains_resource::<Assets<GizmoAsset>>();
    // There too if the configuration was given before.
    let has_begun = app.world().contains_resource::<draw::Begun>();
    if !can_draw || has_begun {
        return;
    }
    app.init_resource::<draw::Begun>()
        .init_gizmo_group::<SightlineGizmos>()
        .configure_sets(
            PostUpdate,
            SightlineGizmoSystems
                .after(TransformSystems::Propagate)
                .after(VisibilitySystems::UpdateFrusta)
                .after(SpatialIndexSystems::Optimize)
                .after(LodSystems::Choose)
                .after(OcclusionSystems::FollowOccluders)
                .run_if(is_anything_shown),
        )
        .add_systems(
            PostUpdate,
            (draw::draw_all, volumes::request_wanted)
                .chain()
                .in_set(SightlineGizmoSystems),
        );
    #[cfg(feature = "picking")]
    app.add_systems(
        PostUpdate,
        rays::draw_pointer_rays
            .after(draw::draw_all)
            .in_set(SightlineGizmoSystems),
    );
    debug_assert!(app.world().contains_resource::<GizmoStorage<SightlineGizmos, ()>>());
}

/// Whether anything is switched on, or was when stats were last written.
fn is_anything_shown(
    store: Res<GizmoConfigStore>,
    shown: Query<(), With<ShowGizmos>>,
    stats: Res<SightlineGizmoStats>,
) -> bool {
    let (config, gizmos) = store.config::<SightlineGizmos>();
    config.enabled && (gizmos.is_any_on() || !shown.is_empty()) || *stats != SightlineGizmoStats::default()
}
