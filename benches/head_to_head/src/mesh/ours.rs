//! Our side.

use std::sync::LazyLock;

use bevy::{
    asset::RenderAssetUsages,
    math::Vec3,
    mesh::{Indices, Mesh, PrimitiveTopology},
    tasks::{TaskPool, TaskPoolBuilder},
};
use bevy_sightline::{
    geometry::ray::{Ray, triangle::Backfaces},
    mesh::{MeshBuildSettings, MeshBvh, TriangleMesh},
    spatial::BuildStrategy,
};

use super::{Hit, MeshRays, models::Model, refit::Refit};

/// The peers have no more.
static ONE_THREAD: LazyLock<TaskPool> = LazyLock::new(|| TaskPoolBuilder::new().num_threads(1).build());

/// What is built from.
pub(crate) fn source(model: &Model) -> TriangleMesh {
    let indices = model.triangles.as_flattened().to_vec();
    let mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, model.positions.clone())
        .with_inserted_indices(Indices::U32(indices));
    TriangleMesh::from_mesh(&mesh).expect("triangles")
}

pub(crate) fn build(source: &TriangleMesh) -> MeshBvh {
    MeshBvh::build(source)
}

/// What takes the least memory.
pub(crate) fn build_compact(source: &TriangleMesh) -> MeshBvh {
    let settings = MeshBuildSettings {
        compact: true,
        ..MeshBuildSettings::default()
    };
    MeshBvh::build_with(source, &settings, None).expect("nothing calls it off")
}

/// The quickest build.
pub(crate) fn build_fast(source: &TriangleMesh) -> MeshBvh {
    let settings = MeshBuildSettings {
        strategy: BuildStrategy::Ploc,
        ..MeshBuildSettings::default()
    };
    MeshBvh::build_with(source, &settings, None).expect("nothing calls it off")
}

impl MeshRays for MeshBvh {
    fn closest(&self, ray: &Ray) -> Option<Hit> {
        let hit = self.closest_hit(ray, Backfaces::Include)?;
        Some((hit.t, hit.triangle))
    }

    fn closest_of_each(&self, rays: &[Ray], hits: &mut Vec<Option<Hit>>) {
        let mut found = Vec::new();
        self.closest_hits(rays, Backfaces::Include, Some(&ONE_THREAD), &mut found);
        hits.extend(found.iter().map(|hit| hit.map(|hit| (hit.t, hit.triangle))));
    }

    fn any(&self, ray: &Ray) -> bool {
        self.any_hit(ray, Backfaces::Include)
    }
}

impl Refit for MeshBvh {
    fn refit(&mut self, positions: &[Vec3]) {
        MeshBvh::refit(self, positions);
    }
}
