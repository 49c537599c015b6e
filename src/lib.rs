#![doc = include_str!("../README.md")]
//!
//! # Architecture
//!
//! The [`guides`] say how all this is used, and what to do when something is wrong; here is how it is made. Arrows point
//! downward only: what is below knows nothing of what is above.
//!
//! ```text
//!       debug                               what all others are about, in lines, figures and a panel
//!         |
//!      sprite                               ECS plugins
//!         |
//!      picking   selection   culling        what is on the screen; what cameras and lights see
//!        |  \        |       /  |  \
//!        |   --------|--- lod   |  occlusion   which level of detail is shown; what hides what is behind it
//!        |           |     |    |   /   |
//!         ----------- index ----     raster    SpatialIndexPlugin, SceneQuery; a depth buffer on the CPU
//!                   |   \               |
//!                   |  mesh             |      a hierarchy over the triangles of each mesh
//!                   |   /               |
//!                  spatial -------------       structures over boxes, generic over a key
//!                     |
//!                 geometry                     bounding volumes, surfaces, rays, tests between shapes
//!                     |
//!               bevy_math, glam
//! ```
//!
//! # One frame
//!
//! ```text
//! PreUpdate    PickingSystems::Backend       pointers' rays → index, as of the last PostUpdate → PointerHits
//! Update       the game                      SceneQuery, as of the last PostUpdate
//! PostUpdate   TransformSystems::Propagate   Bevy writes GlobalTransform
//!              AutoProxySystems::Make        levels that were made meanwhile (feature `simplify`)
//!              LodSystems::Follow            groups, and what belongs to their levels
//!              VisibilitySystems::…          Bevy writes Aabb, InheritedVisibility
//!              SpatialIndexSystems::Sync     what changed → meshes, poses, leaves of tree and grid
//!              SpatialIndexSystems::Optimize upkeep of the tree
//!              LodSystems::Choose            levels for every view, where cameras came near a switch; meshes are swapped
//!              OcclusionSystems::FollowOccluders  what changed → shapes that hide
//!              ViewCullingSystems::Find      frusta of cameras, depth of what hides → tree → what is in sight
//!              ViewCullingSystems::Write     VisibleEntities, VisibleSet, ViewVisibility
//!              ViewCullingSystems::Lights    the same for cascades, cube faces and spot lights
//!              ViewCullingSystems::Hide      what nothing sees any more
//!              SightlineGizmoSystems         what is switched on of all this, as lines, after the levels are chosen
//! Last         SightlineDiagnosticsSystems   what all of this took, if that is asked for
//! ```

pub mod culling;
pub mod debug;
pub mod geometry;
pub mod guides;
pub mod index;
pub mod lod;
pub mod mesh;
pub mod occlusion;
mod phase;
#[cfg(feature = "picking")]
pub mod picking;
pub mod raster;
pub mod selection;
pub mod spatial;
#[cfg(feature = "sprite")]
pub mod sprite;

use bevy::app::{PluginGroup, PluginGroupBuilder};

/// What most programs need: `use bevy_sightline::prelude::*;`.
pub mod prelude {
    pub use crate::{
        SightlinePlugins,
        culling::{
            EnteredView, LeftView, ReportViewChanges, ViewCullingPlugin, ViewCullingSettings, ViewCullingStats,
            ViewCullingSystems, VisibilityReason, VisibilityReasons, VisibleSet,
        },
        debug::diagnostics::{SightlineDiagnosticsPlugin, SightlineDiagnosticsSystems},
        geometry::{
            surface::{BoundedSurface, Surface, SurfaceGroup},
            triangle_triangle::TriangleContact,
            volume::BoundingKind,
        },
        index::{
            Backfaces, BoundedBy, HitSurface, HitTriangle, MeshContact, NoSpatialIndex, PickShape, QueryVisibility,
            RayHit, RayTrace, SceneQuery, SceneQuerySettings, SpatialIndex, SpatialIndexPlugin, SpatialIndexSettings,
            SpatialIndexSystems, SweepHit,
        },
        lod::{
            LevelVariants, LevelVariantsPlugin, LodBias, LodChoices, LodContent, LodHits, LodLevel, LodMetric,
            LodReference, LodSettings, LodStats, LodStreamingSettings, LodStreamingStats, LodSwapped, LodSystems,
            ProxyLod, ProxyLodPlugin,
        },
        occlusion::{
            NoOcclusionCulling, Occluder, OccluderRefusal, OccluderSettings, OccluderShape, OccluderStats, Occluders,
            OcclusionBudget, OcclusionBuffer, OcclusionPlugin, OcclusionStats, OcclusionSystems, SoftwareOcclusion,
        },
        raster::RasterMode,
        selection::{ScreenRegion, SelectionMode, SelectionPrecision, SelectionSettings},
        spatial::Neighbour,
    };

    #[cfg(feature = "gizmos")]
    pub use crate::debug::gizmos::{
        DrawStructures, GizmoCount, ShowGizmos, SightlineGizmoStats, SightlineGizmos, SightlineGizmosPlugin,
        StructureStyle,
    };

    #[cfg(feature = "inspector")]
    pub use crate::debug::inspector::{InspectorTab, SightlineInspector, SightlineInspectorPlugin};

    #[cfg(feature = "simplify")]
    pub use crate::lod::simplify::{
        AutoProxy, AutoProxyPlugin, AutoProxySystems, ClusterMaterials, ClusterProxy, ProxyFailed, ProxyProgress,
        ProxyReady, ProxyStats, SimplifyError, SimplifyTarget,
    };

    #[cfg(feature = "picking")]
    pub use crate::picking::{SpatialPickingPlugin, SpatialPickingSettings, SpatialPickingStats};

    #[cfg(feature = "sprite")]
    pub use crate::sprite::{AlphaTest, SpriteIndexPlugin, SpriteIndexSettings, SpriteIndexStats};
}

/// The plugins of this crate that cost next to nothing while nobody uses what they offer, as far as features have them.
///
/// Not among them: [`SightlineDiagnosticsPlugin`](debug::diagnostics::SightlineDiagnosticsPlugin),
/// [`LevelVariantsPlugin`](lod::LevelVariantsPlugin), and with the feature `inspector` `SightlineInspectorPlugin`.
#[derive(Clone, Copy, Debug, Default)]
pub struct SightlinePlugins;

impl PluginGroup for SightlinePlugins {
    fn build(self) -> PluginGroupBuilder {
        let group = PluginGroupBuilder::start::<Self>()
            .add(index::SpatialIndexPlugin)
            .add(lod::ProxyLodPlugin)
            .add(occlusion::OcclusionPlugin)
            .add(culling::ViewCullingPlugin);
        #[cfg(feature = "simplify")]
        let group = group.add(lod::simplify::AutoProxyPlugin::default());
        #[cfg(feature = "picking")]
        let group = group.add(picking::SpatialPickingPlugin);
        #[cfg(feature = "sprite")]
        let group = group.add(sprite::SpriteIndexPlugin);
        #[cfg(feature = "gizmos")]
        let group = group.add(debug::gizmos::SightlineGizmosPlugin);
        group
    }
}
