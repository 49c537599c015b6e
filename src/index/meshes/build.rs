//! Hierarchies that are being built beside their use.

use std::sync::Arc;

use bevy::tasks::{AsyncComputeTaskPool, Task, TaskPool, futures::check_ready};

use super::Triangles;
use crate::{
    mesh::{MeshBuildSettings, MeshBvh},
    spatial::{BuildProgress, BuildStrategy},
};

/// A hierarchy that is being built on the pool; cancelled when it is dropped.
#[derive(Debug)]
pub(in crate::index) struct Build {
    progress: Arc<BuildProgress>,
    task: Task<Option<MeshBvh>>,
    /// Whether the vertices have been edited since it began.
    pub is_outdated: bool,
}

impl Build {
    pub fn start(triangles: Triangles, strategy: BuildStrategy, compact: bool) -> Self {
        let progress = Arc::new(BuildProgress::default());
        let task = AsyncComputeTaskPool::get_or_init(TaskPool::default).spawn({
            let progress = progress.clone();
            let settings = MeshBuildSettings { strategy, compact };
            async move { MeshBvh::build_alone(&triangles, &settings, Some(&progress)) }
        });
        Self {
            progress,
            task,
            is_outdated: false,
        }
    }

    /// How much is done, from 0 to 1.
    pub fn fraction(&self) -> f32 {
        self.progress.fraction()
    }

    /// The hierarchy, once it is there.
    pub fn take_built(&mut self) -> Option<MeshBvh> {
        check_ready(&mut self.task).map(|built| built.expect("only what is dropped is cancelled"))
    }
}

/// Dropping the task ends one that has not begun; one that runs has to be told.
impl Drop for Build {
    fn drop(&mut self) {
        self.progress.cancel();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriangleMesh;
    use bevy::{math::primitives::Cuboid, mesh::Mesh};

    #[test]
    fn a_build_that_is_dropped_is_cancelled() {
        let mesh = TriangleMesh::from_mesh(&Mesh::from(Cuboid::default())).expect("a usable mesh");
        let build = Build::start(Triangles::Bare(Arc::new(mesh.clone())), BuildStrategy::Ploc, false);
        let progress = build.progress.clone();
        drop(build);
        let built = MeshBvh::build_with(&mesh, &MeshBuildSettings::default(), Some(&progress));
        assert!(built.is_none());
    }
}
