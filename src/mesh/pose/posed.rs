//! The triangles of a mesh in a pose.

use bevy::math::Vec3;

use super::{MeshDeformer, Pose};
use crate::mesh::{MeshBvh, TriangleHit, TriangleMesh, triangles::interpolate};

/// The triangles of a mesh in a pose, with a hierarchy if the mesh had one when this copy of it was made.
#[derive(Clone, Debug)]
pub struct PosedMesh {
    surface: PosedSurface,
    /// A buffer, kept for its memory.
    positions: Vec<Vec3>,
}

#[derive(Clone, Debug)]
enum PosedSurface {
    Listed(TriangleMesh),
    Hierarchy(MeshBvh),
}

impl PosedMesh {
    /// A copy of a mesh and its hierarchy, which can then be [posed](Self::pose).
    pub fn of_bvh(bvh: &MeshBvh) -> Self {
        Self {
            surface: PosedSurface::Hierarchy(bvh.clone()),
            positions: Vec::new(),
        }
    }

    /// A copy of a mesh without a hierarchy.
    pub fn of_triangles(mesh: &TriangleMesh) -> Self {
        Self {
            surface: PosedSurface::Listed(mesh.clone()),
            positions: Vec::new(),
        }
    }

    /// Moves the triangles to a pose, in O(n). `deformer` must be of the same mesh.
    ///
    /// # Panics
    ///
    /// If the deformer is not [sound](MeshDeformer::is_sound), if its [box](MeshDeformer::aabb) in this pose is not
    /// finite, or if the pose has joints, and too few.
    pub fn pose(&mut self, deformer: &MeshDeformer, pose: &Pose) {
        deformer.write_positions(pose, &mut self.positions);
        match &mut self.surface {
            PosedSurface::Listed(mesh) => mesh.move_vertices(&self.positions),
            PosedSurface::Hierarchy(bvh) => bvh.refit(&self.positions),
        }
    }

    /// The hierarchy, if there is one.
    pub fn bvh(&self) -> Option<&MeshBvh> {
        match &self.surface {
            PosedSurface::Listed(_) => None,
            PosedSurface::Hierarchy(bvh) => Some(bvh),
        }
    }

    /// The triangles where they were last moved to; hits are looked up there, but for their normals.
    pub fn mesh(&self) -> &TriangleMesh {
        match &self.surface {
            PosedSurface::Listed(mesh) => mesh,
            PosedSurface::Hierarchy(bvh) => bvh.mesh(),
        }
    }

    /// The normal at a hit: interpolated from the [normals of the vertices](MeshDeformer::normal), or that of the
    /// triangle where there are none.
    pub fn normal(&self, hit: &TriangleHit, deformer: &MeshDeformer, pose: &Pose) -> Vec3 {
        let mesh = self.mesh();
        let normals = mesh.vertex_numbers(hit).map(|vertex| deformer.normal(vertex, pose));
        let normal = interpolate(hit.barycentrics, normals);
        if normal.is_finite() && normal != Vec3::ZERO {
            normal
        } else {
            mesh.geometric_normal(hit)
        }
    }
}
