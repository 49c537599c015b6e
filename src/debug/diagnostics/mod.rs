//! Diagnostics: what every phase of a frame takes and how much it has to do, for Bevy's [`DiagnosticsStore`].
//!
//! ```no_run
//! # use bevy::{diagnostic::{DiagnosticPath, DiagnosticsStore, LogDiagnosticsPlugin}, prelude::*};
//! # use bevy_sightline::prelude::*;
//! App::new()
//!     .add_plugins((DefaultPlugins, SightlinePlugins))
//!     // Not one of the SightlinePlugins; nothing is measured without it.
//!     .add_plugins((SightlineDiagnosticsPlugin, LogDiagnosticsPlugin::default()))
//!     .add_systems(Update, show);
//!
//! fn show(store: Res<DiagnosticsStore>, mut text: Single<&mut Text>) {
//!     let find = store.get(&DiagnosticPath::const_new("sightline/culling/find"));
//!     if let Some(milliseconds) = find.and_then(|find| find.smoothed()) {
//!         text.0 = format!("culling {milliseconds:.2} ms");
//!     }
//! }
//! ```
//!
//! # What is measured
//!
//! In [`Last`], of the frame that ends. Of a plugin that is not there nothing is. What a phase does is told by the resource
//! from which its figures come.
//!
//! | path | unit | meaning |
//! |---|---|---|
//! | from [`SyncStats`] and [`SpatialIndex`] | | |
//! | `sightline/index/meshes` | ms | following the assets of meshes, and their hierarchies |
//! | `sightline/index/sync` | ms | [`SpatialIndexSystems::Sync`](crate::index::SpatialIndexSystems), without that |
//! | `sightline/index/find` | ms | of that: finding what has changed |
//! | `sightline/index/posing` | ms | of that: following poses |
//! | `sightline/index/structures` | ms | of `sync`: bringing tree and grid up to date |
//! | `sightline/index/optimize` | ms | [`SpatialIndexSystems::Optimize`](crate::index::SpatialIndexSystems) |
//! | `sightline/index/posing_for_rays` | ms | posing meshes that rays came near, in all threads together |
//! | `sightline/index/entities` | | entities in the index |
//! | `sightline/index/refused` | | entities that are left out, for their data are bad |
//! | `sightline/index/moved` | | entities that had moved and not changed otherwise |
//! | `sightline/index/reconciled` | | entities that had changed otherwise, come or gone |
//! | `sightline/index/posed` | | entities whose pose had changed |
//! | `sightline/index/posed_for_rays` | | meshes that were posed, for a ray came near |
//! | `sightline/index/optimized` | | 1 if a tree that was built anew was taken over, otherwise 0 |
//! | from [`MeshBvhs`] | | |
//! | `sightline/meshes/known` | | meshes that indexed entities use, or have used of late |
//! | `sightline/meshes/building` | | meshes of which something is being built in the background |
//! | from [`LodStats`] and [`LodStreamingStats`] | | |
//! | `sightline/lod/follow` | ms | [`LodSystems::Follow`](crate::lod::LodSystems) |
//! | `sightline/lod/choose` | ms | [`LodSystems::Choose`](crate::lod::LodSystems) |
//! | `sightline/lod/groups` | | groups with levels of detail |
//! | `sightline/lod/looked_at` | | groups that were looked at, once for each view |
//! | `sightline/lod/switched` | | groups that switched, once for each view |
//! | `sightline/lod/streamed` | | meshes of levels that are loaded |
//! | `sightline/lod/streaming` | | meshes of levels that are being loaded |
//! | `sightline/lod/failed` | | meshes of levels that could not be loaded |
//! | `sightline/lod/memory` | MiB | vertices and indices of those that are loaded |
//! | from [`OccluderStats`] | | |
//! | `sightline/occlusion/follow` | ms | [`OcclusionSystems::FollowOccluders`](crate::occlusion::OcclusionSystems) |
//! | `sightline/occlusion/occluders` | | entities that occlude |
//! | `sightline/occlusion/refused` | | entities that should and do not |
//! | `sightline/occlusion/making` | | meshes of which the shape is being made in the background |
//! | `sightline/occlusion/reconciled` | | entities of which something else than their place had changed |
//! | from [`ViewCullingStats`] | | |
//! | `sightline/occlusion/drawn` | | occluders that were drawn, for all cameras together |
//! | `sightline/occlusion/triangles` | | their triangles |
//! | `sightline/occlusion/over_budget` | | occluders that were not drawn |
//! | `sightline/occlusion/tested` | | boxes of entities and nodes that were tested |
//! | `sightline/occlusion/hidden` | | entities that were passed over |
//! | `sightline/culling/find` | ms | [`ViewCullingSystems::Find`](crate::culling::ViewCullingSystems), with all that is drawn to hide things |
//! | `sightline/culling/write` | ms | [`ViewCullingSystems::Write`](crate::culling::ViewCullingSystems) |
//! | `sightline/culling/lights` | ms | [`ViewCullingSystems::Lights`](crate::culling::ViewCullingSystems) |
//! | `sightline/culling/hide` | ms | [`ViewCullingSystems::Hide`](crate::culling::ViewCullingSystems) |
//! | `sightline/culling/views` | | active cameras |
//! | `sightline/culling/visible` | | what they see, once for each |
//! | `sightline/culling/entered` | | what has come into view |
//! | `sightline/culling/left` | | what has gone out of it |
//! | `sightline/culling/shadow_maps` | | shadow maps |
//! | `sightline/culling/casters` | | what is in them, once for each |
//! | `sightline/culling/tested` | | entities that were tested by themselves, for cameras and shadow maps |
//! | from `SpatialPickingStats` (feature `picking`) | | |
//! | `sightline/picking/backend` | ms | [`PickingSystems::Backend`](https://docs.rs/bevy_picking), as far as it is ours |
//! | `sightline/picking/rays` | | rays that were cast for pointers |
//! | `sightline/picking/hits` | | hits that were reported |
//! | from `SpriteIndexStats` (feature `sprite`) | | |
//! | `sightline/sprite/follow` | ms | following sprites |
//! | `sightline/sprite/sprites` | | sprites that are known |
//! | `sightline/sprite/reconciled` | | sprites that had come, changed or gone |
//! | from `ProxyStats` and `ProxyProgress` (feature `simplify`) | | |
//! | `sightline/simplify/make` | ms | `AutoProxySystems::Make`, without what is made in the background |
//! | `sightline/simplify/waiting` | | proxies that wait for their meshes or their turn |
//! | `sightline/simplify/done` | | proxies that are done, with those that have failed |
//! | `sightline/simplify/failed` | | proxies that have failed |
//! | from `SightlineGizmoStats` (feature `gizmos`) | | |
//! | `sightline/gizmos/draw` | ms | `SightlineGizmoSystems` |
//! | `sightline/gizmos/drawn` | | shapes that were drawn |
//! | `sightline/gizmos/left_out` | | shapes in view that were not |
//!
//! All of this is counted anyway, and copied by this plugin in about a microsecond. What takes longer to find out is not
//! here: ask [`SpatialIndex::stats`] and [`MeshBvhs::memory`] when you want to know.
//!
//! # Spans
//!
//! Every path in milliseconds but `posing_for_rays` is the name of a `tracing` span around that work too, of level `DEBUG`,
//! whether the plugin is there or not. Bevy's `LogPlugin` leaves them out by default; to see them in Tracy or in a trace
//! for Chrome, let it have `bevy_sightline=debug` in its filter, or in `RUST_LOG`.

mod figures;

use bevy::{
    app::{App, Last, Plugin},
    diagnostic::{Diagnostic, DiagnosticMeasurement, DiagnosticsStore, RegisterDiagnostic},
    ecs::{
        resource::Resource,
        schedule::{IntoScheduleConfigs, SystemSet},
        world::World,
    },
    platform::time::Instant,
};
use smallvec::SmallVec;

#[cfg(doc)]
use crate::{
    culling::ViewCullingStats,
    index::{MeshBvhs, SpatialIndex, SyncStats},
    lod::{LodStats, LodStreamingStats},
    occlusion::OccluderStats,
};
use figures::{Figure, Read, Visit, visit_all};

/// When diagnostics are measured; in [`Last`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, SystemSet)]
pub struct SightlineDiagnosticsSystems;

/// Measures what all plugins of this crate do, in every frame: see [`diagnostics`](self).
///
/// Needs no other plugin. [`SightlinePlugins`](crate::SightlinePlugins) do not add it. Adding it again does nothing, so that
/// every tool that shows the figures may add it.
#[derive(Clone, Copy, Debug, Default)]
pub struct SightlineDiagnosticsPlugin;

impl Plugin for SightlineDiagnosticsPlugin {
    fn build(&self, app: &mut App) {
        if app.is_plugin_added::<Self>() {
            return;
        }
        visit_all(&mut Register(app));
        app.add_systems(Last, measure.in_set(SightlineDiagnosticsSystems));
    }

    fn is_unique(&self) -> bool {
        false
    }
}

struct Register<'a>(&'a mut App);

impl Visit for Register<'_> {
    fn visit<S: Resource>(&mut self, figures: &'static [Figure<S>]) {
        for figure in figures {
            let diagnostic = Diagnostic::new(figure.path.clone()).with_suffix(figure.read.suffix());
            self.0.register_diagnostic(match figure.read {
                Read::Time(_) => diagnostic,
                // Of a count the last is wanted.
                Read::Count(_) | Read::Memory(_) => diagnostic.with_smoothing_factor(0.0),
            });
        }
    }
}

/// Takes over all figures.
fn measure(world: &mut World) {
    let now = Instant::now();
    visit_all(&mut Measure { world, now });
}

struct Measure<'a> {
    world: &'a mut World,
    now: Instant,
}

impl Visit for Measure<'_> {
    fn visit<S: Resource>(&mut self, figures: &'static [Figure<S>]) {
        let Some(stats) = self.world.get_resource::<S>() else {
            return;
        };
        let values: SmallVec<[f64; 16]> = figures.iter().map(|figure| figure.read.value(stats)).collect();
        let Some(mut store) = self.world.get_resource_mut::<DiagnosticsStore>() else {
            return;
        };
        for (figure, value) in figures.iter().zip(values) {
            if let Some(diagnostic) = store.get_mut(&figure.path).filter(|diagnostic| diagnostic.is_enabled) {
                diagnostic.add_measurement(DiagnosticMeasurement { time: self.now, value });
            }
        }
    }
}
