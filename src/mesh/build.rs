//! Building the hierarchy of a mesh: how, by whom, and how far it has come.

use bevy::tasks::{ComputeTaskPool, TaskPool};

use super::{
    bvh::{LEAF_SIZE, MeshBvh, pack_leaf},
    triangles::TriangleMesh,
};
use crate::spatial::{
    BuildProgress, BuildStrategy,
    build::{Alone, BuildItem, Builder, Cancelled, Errand, Leaves, Order, Stage, Workers},
    wide::EVERY_MASK,
};

/// Meshes of fewer triangles are built by the calling thread alone.
const MANY: usize = 1 << 15;
/// How often progress is told, in triangles.
const STEP: usize = 1 << 14;

/// What a leaf holds, and what a packet of triangles costs to test, where a node costs one.
const LEAVES: Leaves = Leaves {
    most: LEAF_SIZE as u32,
    packet: LEAF_SIZE as u32,
    packet_cost: 1.0,
};

/// How the hierarchy of a mesh is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MeshBuildSettings {
    /// All give the same answers: the better ones take longer to build.
    pub strategy: BuildStrategy,
    /// Whether to take less than half the memory, for rays that take up to twice as long: the corners of triangles are
    /// then looked up vertex by vertex.
    pub compact: bool,
}

/// For a mesh that stays as it is.
impl Default for MeshBuildSettings {
    fn default() -> Self {
        Self {
            strategy: BuildStrategy::Reinsertion,
            compact: false,
        }
    }
}

impl MeshBvh {
    /// Builds the hierarchy with the default settings, in O(n log n).
    pub fn build(mesh: &TriangleMesh) -> Self {
        Self::build_with(mesh, &MeshBuildSettings::default(), None).expect("nothing calls it off")
    }

    /// Builds the hierarchy; `None` if `progress` was told to [cancel](BuildProgress::cancel).
    ///
    /// Large meshes are built by the threads of the [`ComputeTaskPool`] too, where there is one. The hierarchy is the same
    /// for any number of threads.
    pub fn build_with(
        mesh: &TriangleMesh,
        settings: &MeshBuildSettings,
        progress: Option<&BuildProgress>,
    ) -> Option<Self> {
        let pool = ComputeTaskPool::try_get().filter(|_| mesh.len() >= MANY);
        match pool {
            Some(pool) => Self::build_by(mesh, settings, progress, &Pool(pool)),
            None => Self::build_by(mesh, settings, progress, &Alone),
        }
    }

    /// The same by the calling thread alone: in the background, where frames have a use for the other threads.
    pub fn build_alone(
        mesh: &TriangleMesh,
        settings: &MeshBuildSettings,
        progress: Option<&BuildProgress>,
    ) -> Option<Self> {
        Self::build_by(mesh, settings, progress, &Alone)
    }

    fn build_by(
        mesh: &TriangleMesh,
        settings: &MeshBuildSettings,
        progress: Option<&BuildProgress>,
        workers: &dyn Workers,
    ) -> Option<Self> {
        let mut items = items(mesh, &Stage::new(progress, 0.0, 0.05, mesh.len())).ok()?;
        let mut nodes = Vec::new();
        let order = Order {
            strategy: settings.strategy,
            leaves: LEAVES,
            workers,
            progress,
        };
        let leaf = |items: &[BuildItem], first: usize, _, _| pack_leaf(first as u32, items.len() as u32);
        let built = Builder::default().build(&order, &mut items, &mut nodes, leaf, |_, _, _| {});
        built.ok()?;
        let slots: Vec<u32> = items.iter().map(BuildItem::index).collect();
        drop(items);
        let bvh = Self::pack(mesh, &slots, &nodes, settings.compact);
        if let Some(progress) = progress {
            if progress.is_cancelled() {
                return None;
            }
            progress.reach(1.0);
        }
        Some(bvh)
    }
}

fn items(mesh: &TriangleMesh, stage: &Stage) -> Result<Vec<BuildItem>, Cancelled> {
    let mut items = Vec::with_capacity(mesh.len());
    for slot in mesh.slots() {
        items.push(BuildItem::new(&mesh.triangle_box(slot), EVERY_MASK, slot));
        if items.len() % STEP == 0 {
            stage.advance(STEP)?;
        }
    }
    Ok(items)
}

/// The threads of a pool, and the calling thread meanwhile.
struct Pool<'a>(&'a TaskPool);

impl Workers for Pool<'_> {
    fn count(&self) -> usize {
        self.0.thread_num() + 1
    }

    fn run(&self, errands: Vec<Errand<'_>>) {
        if let [_] = errands[..] {
            return Alone.run(errands);
        }
        self.0.scope(|scope| {
            for errand in errands {
                scope.spawn(async move { errand() });
            }
        });
    }
}
