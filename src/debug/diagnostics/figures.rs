//! The figures, and where they come from.

use std::time::Duration;

use bevy::{diagnostic::DiagnosticPath, ecs::resource::Resource};

use crate::{
    culling::ViewCullingStats,
    index::{MeshBvhs, SpatialIndex, SyncStats},
    lod::{LodStats, LodStreamingStats},
    occlusion::OccluderStats,
};

/// A figure that is read off a resource.
pub(super) struct Figure<S: 'static> {
    pub path: DiagnosticPath,
    pub read: Read<S>,
}

/// How it is read, at once.
pub(super) enum Read<S: 'static> {
    Count(fn(&S) -> usize),
    Time(fn(&S) -> Duration),
    /// In bytes.
    Memory(fn(&S) -> usize),
}

impl<S> Read<S> {
    /// The unit, as it is printed.
    pub fn suffix(&self) -> &'static str {
        match self {
            Self::Count(_) => "",
            Self::Time(_) => "ms",
            Self::Memory(_) => "MiB",
        }
    }

    /// The value in that unit.
    pub fn value(&self, stats: &S) -> f64 {
        match self {
            Self::Count(read) => read(stats) as f64,
            Self::Time(read) => 1000.0 * read(stats).as_secs_f64(),
            Self::Memory(read) => read(stats) as f64 / f64::from(1 << 20),
        }
    }
}

/// Something that is done with the figures of every resource.
pub(super) trait Visit {
    fn visit<S: Resource>(&mut self, figures: &'static [Figure<S>]);
}

/// Visits all figures that the enabled features have.
pub(super) fn visit_all(visitor: &mut impl Visit) {
    visitor.visit(SYNC);
    visitor.visit(INDEX);
    visitor.visit(MESHES);
    visitor.visit(LOD);
    visitor.visit(STREAMING);
    visitor.visit(OCCLUSION);
    visitor.visit(CULLING);
    #[cfg(feature = "picking")]
    visitor.visit(PICKING);
    #[cfg(feature = "sprite")]
    visitor.visit(SPRITES);
    #[cfg(feature = "simplify")]
    visitor.visit(PROXIES);
    #[cfg(feature = "simplify")]
    visitor.visit(PROGRESS);
    #[cfg(feature = "gizmos")]
    visitor.visit(GIZMOS);
}

const fn count<S>(path: &'static str, read: fn(&S) -> usize) -> Figure<S> {
    Figure {
        path: DiagnosticPath::const_new(path),
        read: Read::Count(read),
    }
}

const fn time<S>(path: &'static str, read: fn(&S) -> Duration) -> Figure<S> {
    Figure {
        path: DiagnosticPath::const_new(path),
        read: Read::Time(read),
    }
}

const fn memory<S>(path: &'static str, read: fn(&S) -> usize) -> Figure<S> {
    Figure {
        path: DiagnosticPath::const_new(path),
        read: Read::Memory(read),
    }
}

static SYNC: &[Figure<SyncStats>] = &[
    time("sightline/index/meshes", |stats| stats.meshes),
    time("sightline/index/sync", |stats| stats.total),
    time("sightline/index/find", |stats| stats.find),
    time("sightline/index/posing", |stats| stats.posing),
    time("sightline/index/structures", |stats| stats.structures),
    time("sightline/index/optimize", |stats| stats.optimize),
    time("sightline/index/posing_for_rays", |stats| stats.posing_for_rays),
    count("sightline/index/moved", |stats| stats.moved),
    count("sightline/index/reconciled", |stats| stats.reconciled),
    count("sightline/index/posed", |stats| stats.posed),
    count("sightline/index/posed_for_rays", |stats| stats.posed_for_rays),
    count("sightline/index/optimized", |stats| stats.optimized.into()),
];

static INDEX: &[Figure<SpatialIndex>] = &[
    count("sightline/index/entities", SpatialIndex::len),
    count("sightline/index/refused", |index| index.refused().len()),
];

static MESHES: &[Figure<MeshBvhs>] = &[
    count("sightline/meshes/known", MeshBvhs::len),
    count("sightline/meshes/building", MeshBvhs::building),
];

static LOD: &[Figure<LodStats>] = &[
    time("sightline/lod/follow", |stats| stats.follow),
    time("sightline/lod/choose", |stats| stats.choose),
    count("sightline/lod/groups", |stats| stats.groups),
    count("sightline/lod/looked_at", |stats| stats.looked_at),
    count("sightline/lod/switched", |stats| stats.switched),
];

static STREAMING: &[Figure<LodStreamingStats>] = &[
    count("sightline/lod/streamed", |stats| stats.loaded),
    count("sightline/lod/streaming", |stats| stats.loading),
    count("sightline/lod/failed", |stats| stats.failed),
    memory("sightline/lod/memory", |stats| stats.memory),
];

static OCCLUSION: &[Figure<OccluderStats>] = &[
    time("sightline/occlusion/follow", |stats| stats.follow),
    count("sightline/occlusion/occluders", |stats| stats.occluders),
    count("sightline/occlusion/refused", |stats| stats.refused),
    count("sightline/occlusion/making", |stats| stats.making),
    count("sightline/occlusion/reconciled", |stats| stats.reconciled),
];

static CULLING: &[Figure<ViewCullingStats>] = &[
    count("sightline/occlusion/drawn", |stats| stats.occlusion.occluders),
    count("sightline/occlusion/triangles", |stats| stats.occlusion.triangles),
    count("sightline/occlusion/over_budget", |stats| stats.occlusion.over_budget),
    count("sightline/occlusion/tested", |stats| stats.occlusion.tested),
    count("sightline/occlusion/hidden", |stats| stats.occlusion.hidden),
    time("sightline/culling/find", |stats| stats.find),
    time("sightline/culling/write", |stats| stats.write),
    time("sightline/culling/lights", |stats| stats.lights),
    time("sightline/culling/hide", |stats| stats.hide),
    count("sightline/culling/views", |stats| stats.views),
    count("sightline/culling/visible", |stats| stats.visible),
    count("sightline/culling/entered", |stats| stats.entered),
    count("sightline/culling/left", |stats| stats.left),
    count("sightline/culling/shadow_maps", |stats| stats.shadow_maps),
    count("sightline/culling/casters", |stats| stats.casters),
    count("sightline/culling/tested", |stats| stats.tested),
];

#[cfg(feature = "picking")]
static PICKING: &[Figure<crate::picking::SpatialPickingStats>] = &[
    time("sightline/picking/backend", |stats| stats.time),
    count("sightline/picking/rays", |stats| stats.rays),
    count("sightline/picking/hits", |stats| stats.hits),
];

#[cfg(feature = "sprite")]
static SPRITES: &[Figure<crate::sprite::SpriteIndexStats>] = &[
    time("sightline/sprite/follow", |stats| stats.follow),
    count("sightline/sprite/sprites", |stats| stats.sprites),
    count("sightline/sprite/reconciled", |stats| stats.reconciled),
];

#[cfg(feature = "simplify")]
static PROXIES: &[Figure<crate::lod::simplify::ProxyStats>] = &[time("sightline/simplify/make", |stats| stats.make)];

#[cfg(feature = "simplify")]
static PROGRESS: &[Figure<crate::lod::simplify::ProxyProgress>] = &[
    count("sightline/simplify/waiting", |progress| progress.waiting),
    count("sightline/simplify/done", |progress| progress.done),
    count("sightline/simplify/failed", |progress| progress.failed),
];

#[cfg(feature = "gizmos")]
static GIZMOS: &[Figure<crate::debug::gizmos::SightlineGizmoStats>] = &[
    time("sightline/gizmos/draw", |stats| stats.draw),
    count("sightline/gizmos/drawn", |stats| stats.total().drawn),
    count("sightline/gizmos/left_out", |stats| stats.total().left_out),
];
