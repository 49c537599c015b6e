//! The figures, and where they come from.

use std::time::Duration;

use bevy::{diagnostic::DiagnosticPath, ecs::world::World};

use crate::{
    culling::ViewCullingStats,
    index::{MeshBvhs, SpatialIndex, SyncStats},
    lod::{LodStats, LodStreamingStats},
    occlusion::OccluderStats,
};

/// A figure that is measured in every frame.
pub(super) struct Figure {
    pub path: DiagnosticPath,
    pub read: Read,
}

/// How it is read off the world, at once: `None` if the plugin that it is of is not there.
pub(super) enum Read {
    Count(fn(&World) -> Option<usize>),
    Time(fn(&World) -> Option<Duration>),
    /// In bytes.
    Memory(fn(&World) -> Option<usize>),
}

impl Read {
    /// The unit, as it is printed.
    pub fn suffix(&self) -> &'static str {
        match self {
            Self::Count(_) => "",
            Self::Time(_) => "ms",
            Self::Memory(_) => "MiB",
        }
    }

    /// The value in that unit.
    pub fn value(&self, world: &World) -> Option<f64> {
        match self {
            Self::Count(read) => read(world).map(|count| count as f64),
            Self::Time(read) => read(world).map(|time| 1000.0 * time.as_secs_f64()),
            Self::Memory(read) => read(world).map(|bytes| bytes as f64 / f64::from(1 << 20)),
        }
    }
}

const fn count(path: &'static str, read: fn(&World) -> Option<usize>) -> Figure {
    Figure {
        path: DiagnosticPath::const_new(path),
        read: Read::Count(read),
    }
}

const fn time(path: &'static str, read: fn(&World) -> Option<Duration>) -> Figure {
    Figure {
        path: DiagnosticPath::const_new(path),
        read: Read::Time(read),
    }
}

const fn memory(path: &'static str, read: fn(&World) -> Option<usize>) -> Figure {
    Figure {
        path: DiagnosticPath::const_new(path),
        read: Read::Memory(read),
    }
}

static INDEX: &[Figure] = &[
    time("sightline/index/meshes", |world| {
        Some(world.get_resource::<SyncStats>()?.meshes)
    }),
    time("sightline/index/sync", |world| {
        Some(world.get_resource::<SyncStats>()?.total)
    }),
    time("sightline/index/find", |world| {
        Some(world.get_resource::<SyncStats>()?.find)
    }),
    time("sightline/index/posing", |world| {
        Some(world.get_resource::<SyncStats>()?.posing)
    }),
    time("sightline/index/structures", |world| {
        Some(world.get_resource::<SyncStats>()?.structures)
    }),
    time("sightline/index/optimize", |world| {
        Some(world.get_resource::<SyncStats>()?.optimize)
    }),
    time("sightline/index/posing_for_rays", |world| {
        Some(world.get_resource::<SyncStats>()?.posing_for_rays)
    }),
    count("sightline/index/entities", |world| {
        Some(world.get_resource::<SpatialIndex>()?.len())
    }),
    count("sightline/index/refused", |world| {
        Some(world.get_resource::<SpatialIndex>()?.refused().len())
    }),
    count("sightline/index/moved", |world| {
        Some(world.get_resource::<SyncStats>()?.moved)
    }),
    count("sightline/index/reconciled", |world| {
        Some(world.get_resource::<SyncStats>()?.reconciled)
    }),
    count("sightline/index/posed", |world| {
        Some(world.get_resource::<SyncStats>()?.posed)
    }),
    count("sightline/index/posed_for_rays", |world| {
        Some(world.get_resource::<SyncStats>()?.posed_for_rays)
    }),
    count("sightline/index/optimized", |world| {
        Some(world.get_resource::<SyncStats>()?.optimized.into())
    }),
    count("sightline/meshes/known", |world| {
        Some(world.get_resource::<MeshBvhs>()?.len())
    }),
    count("sightline/meshes/building", |world| {
        Some(world.get_resource::<MeshBvhs>()?.building())
    }),
];

static LOD: &[Figure] = &[
    time("sightline/lod/follow", |world| {
        Some(world.get_resource::<LodStats>()?.follow)
    }),
    time("sightline/lod/choose", |world| {
        Some(world.get_resource::<LodStats>()?.choose)
    }),
    count("sightline/lod/groups", |world| {
        Some(world.get_resource::<LodStats>()?.groups)
    }),
    count("sightline/lod/looked_at", |world| {
        Some(world.get_resource::<LodStats>()?.looked_at)
    }),
    count("sightline/lod/switched", |world| {
        Some(world.get_resource::<LodStats>()?.switched)
    }),
    count("sightline/lod/streamed", |world| {
        Some(world.get_resource::<LodStreamingStats>()?.loaded)
    }),
    count("sightline/lod/streaming", |world| {
        Some(world.get_resource::<LodStreamingStats>()?.loading)
    }),
    count("sightline/lod/failed", |world| {
        Some(world.get_resource::<LodStreamingStats>()?.failed)
    }),
    memory("sightline/lod/memory", |world| {
        Some(world.get_resource::<LodStreamingStats>()?.memory)
    }),
];

static OCCLUSION: &[Figure] = &[
    time("sightline/occlusion/follow", |world| {
        Some(world.get_resource::<OccluderStats>()?.follow)
    }),
    count("sightline/occlusion/occluders", |world| {
        Some(world.get_resource::<OccluderStats>()?.occluders)
    }),
    count("sightline/occlusion/refused", |world| {
        Some(world.get_resource::<OccluderStats>()?.refused)
    }),
    count("sightline/occlusion/making", |world| {
        Some(world.get_resource::<OccluderStats>()?.making)
    }),
    count("sightline/occlusion/reconciled", |world| {
        Some(world.get_resource::<OccluderStats>()?.reconciled)
    }),
    count("sightline/occlusion/drawn", |world| {
        Some(world.get_resource::<ViewCullingStats>()?.occlusion.occluders)
    }),
    count("sightline/occlusion/triangles", |world| {
        Some(world.get_resource::<ViewCullingStats>()?.occlusion.triangles)
    }),
    count("sightline/occlusion/over_budget", |world| {
        Some(world.get_resource::<ViewCullingStats>()?.occlusion.over_budget)
    }),
    count("sightline/occlusion/tested", |world| {
        Some(world.get_resource::<ViewCullingStats>()?.occlusion.tested)
    }),
    count("sightline/occlusion/hidden", |world| {
        Some(world.get_resource::<ViewCullingStats>()?.occlusion.hidden)
    }),
];

static CULLING: &[Figure] = &[
    time("sightline/culling/find", |world| {
        Some(world.get_resource::<ViewCullingStats>()?.find)
    }),
    time("sightline/culling/write", |world| {
        Some(world.get_resource::<ViewCullingStats>()?.write)
    }),
    time("sightline/culling/lights", |world| {
        Some(world.get_resource::<ViewCullingStats>()?.lights)
    }),
    time("sightline/culling/hide", |world| {
        Some(world.get_resource::<ViewCullingStats>()?.hide)
    }),
    count("sightline/culling/views", |world| {
        Some(world.get_resource::<ViewCullingStats>()?.views)
    }),
    count("sightline/culling/visible", |world| {
        Some(world.get_resource::<ViewCullingStats>()?.visible)
    }),
    count("sightline/culling/entered", |world| {
        Some(world.get_resource::<ViewCullingStats>()?.entered)
    }),
    count("sightline/culling/left", |world| {
        Some(world.get_resource::<ViewCullingStats>()?.left)
    }),
    count("sightline/culling/shadow_maps", |world| {
        Some(world.get_resource::<ViewCullingStats>()?.shadow_maps)
    }),
    count("sightline/culling/casters", |world| {
        Some(world.get_resource::<ViewCullingStats>()?.casters)
    }),
    count("sightline/culling/tested", |world| {
        Some(world.get_resource::<ViewCullingStats>()?.tested)
    }),
];

#[cfg(feature = "picking")]
static PICKING: &[Figure] = &[
    time("sightline/picking/backend", |world| {
        Some(world.get_resource::<crate::picking::SpatialPickingStats>()?.time)
    }),
    count("sightline/picking/rays", |world| {
        Some(world.get_resource::<crate::picking::SpatialPickingStats>()?.rays)
    }),
    count("sightline/picking/hits", |world| {
        Some(world.get_resource::<crate::picking::SpatialPickingStats>()?.hits)
    }),
];

#[cfg(feature = "sprite")]
static SPRITE: &[Figure] = &[
    time("sightline/sprite/follow", |world| {
        Some(world.get_resource::<crate::sprite::SpriteIndexStats>()?.follow)
    }),
    count("sightline/sprite/sprites", |world| {
        Some(world.get_resource::<crate::sprite::SpriteIndexStats>()?.sprites)
    }),
    count("sightline/sprite/reconciled", |world| {
        Some(world.get_resource::<crate::sprite::SpriteIndexStats>()?.reconciled)
    }),
];

#[cfg(feature = "simplify")]
static SIMPLIFY: &[Figure] = &[
    time("sightline/simplify/make", |world| {
        Some(world.get_resource::<crate::lod::simplify::ProxyStats>()?.make)
    }),
    count("sightline/simplify/waiting", |world| {
        Some(world.get_resource::<crate::lod::simplify::ProxyProgress>()?.waiting)
    }),
    count("sightline/simplify/done", |world| {
        Some(world.get_resource::<crate::lod::simplify::ProxyProgress>()?.done)
    }),
    count("sightline/simplify/failed", |world| {
        Some(world.get_resource::<crate::lod::simplify::ProxyProgress>()?.failed)
    }),
];

#[cfg(feature = "gizmos")]
static GIZMOS: &[Figure] = &[
    time("sightline/gizmos/draw", |world| {
        Some(world.get_resource::<super::super::gizmos::SightlineGizmoStats>()?.draw)
    }),
    count("sightline/gizmos/drawn", |world| {
        Some(
            world
                .get_resource::<super::super::gizmos::SightlineGizmoStats>()?
                .total()
                .drawn,
        )
    }),
    count("sightline/gizmos/left_out", |world| {
        Some(
            world
                .get_resource::<super::super::gizmos::SightlineGizmoStats>()?
                .total()
                .left_out,
        )
    }),
];

/// All figures that the enabled features have.
pub(super) fn figures() -> impl Iterator<Item = &'static Figure> {
    let tables = [
        INDEX,
        LOD,
        OCCLUSION,
        CULLING,
        #[cfg(feature = "picking")]
        PICKING,
        #[cfg(feature = "sprite")]
        SPRITE,
        #[cfg(feature = "simplify")]
        SIMPLIFY,
        #[cfg(feature = "gizmos")]
        GIZMOS,
    ];
    tables.into_iter().flatten()
}
