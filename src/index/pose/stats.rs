//! What posing has cost.

use std::{
    sync::atomic::{AtomicU64, Ordering},
    time::{Duration, Instant},
};

/// What was posed for rays that came near, since the program began: see
/// [`PosedMeshes::stats`](super::PosedMeshes::stats). The difference of two is what was posed between them.
///
/// Not reflected: [`SyncStats`](crate::index::SyncStats) has what was posed in the last frame, and is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct PosingStats {
    /// How often a mesh was posed: once per entity and pose, and once more where its copy was given up meanwhile.
    pub meshes: u64,
    /// The vertices of all these meshes.
    pub vertices: u64,
    /// The time that it took, in all threads together.
    pub time: Duration,
}

/// The same while it is being counted.
#[derive(Debug, Default)]
pub(in crate::index) struct PosingCounters {
    meshes: AtomicU64,
    vertices: AtomicU64,
    nanoseconds: AtomicU64,
}

impl PosingCounters {
    /// Counts one mesh.
    pub fn count<R>(&self, vertices: usize, pose: impl FnOnce() -> R) -> R {
        let start = Instant::now();
        let posed = pose();
        self.meshes.fetch_add(1, Ordering::Relaxed);
        self.vertices.fetch_add(vertices as u64, Ordering::Relaxed);
        let nanoseconds = start.elapsed().as_nanos() as u64;
        self.nanoseconds.fetch_add(nanoseconds, Ordering::Relaxed);
        posed
    }

    pub fn read(&self) -> PosingStats {
        PosingStats {
            meshes: self.meshes.load(Ordering::Relaxed),
            vertices: self.vertices.load(Ordering::Relaxed),
            time: Duration::from_nanos(self.nanoseconds.load(Ordering::Relaxed)),
        }
    }
}
