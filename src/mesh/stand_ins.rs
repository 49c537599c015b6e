//! Stand-ins for what the building of hierarchies offers.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};

use super::{MeshBvh, TriangleMesh};
use crate::{geometry::volume::Volume, spatial::wide::WideNode};

/// How a hierarchy is built.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeshBuildSettings;

/// How far a build has come, and whether it is still wanted.
#[derive(Debug, Default)]
pub struct BuildProgress {
    fraction: AtomicU32,
    cancelled: AtomicBool,
}

impl BuildProgress {
    /// How much is done, from 0 to 1.
    pub fn fraction(&self) -> f32 {
        f32::from_bits(self.fraction.load(Relaxed))
    }

    /// Has the build end soon, without a result.
    pub fn cancel(&self) {
        self.cancelled.store(true, Relaxed);
    }
}

impl MeshBvh {
    /// Builds the hierarchy, unless it is cancelled.
    pub fn build_with(mesh: &TriangleMesh, _: &MeshBuildSettings, progress: Option<&BuildProgress>) -> Option<Self> {
        let cancelled = || progress.is_some_and(|progress| progress.cancelled.load(Relaxed));
        if cancelled() {
            return None;
        }
        let built = Self::build(mesh);
        if let Some(progress) = progress {
            progress.fraction.store(1f32.to_bits(), Relaxed);
        }
        (!cancelled()).then_some(built)
    }

    /// Its size, in bytes.
    pub fn memory(&self) -> usize {
        size_of_val(self.nodes()) + self.mesh().memory()
    }

    /// The expected cost of a ray, by the surface area heuristic.
    pub fn sah_cost(&self) -> f32 {
        let area = |node: &WideNode| node.bounds().surface_area();
        let whole = self.nodes().first().map_or(0.0, area);
        let sum: f32 = self.nodes().iter().map(area).sum();
        if whole > 0.0 { sum / whole } else { 0.0 }
    }

    /// The triangles, without the hierarchy.
    pub fn into_mesh(self) -> TriangleMesh {
        self.mesh().clone()
    }
}
