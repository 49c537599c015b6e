//! The triangles that rays are tested against, with or without a hierarchy.

use bevy::math::{Affine3A, Vec3A};

use super::surface::PlacedSurface;
use crate::{
    geometry::ray::{Ray, triangle::Backfaces},
    mesh::{MeshBvh, PlacedMesh, PosedMesh, TriangleHit, TriangleMesh},
};

/// The triangles that rays are tested against, one by one or through their hierarchy.
#[derive(Clone, Copy)]
pub(super) enum TrianglesRef<'a> {
    Listed(&'a TriangleMesh),
    Hierarchy(&'a MeshBvh),
}

impl<'a> TrianglesRef<'a> {
    pub fn of_posed(posed: &'a PosedMesh) -> Self {
        posed.bvh().map_or(Self::Listed(posed.mesh()), Self::Hierarchy)
    }

    pub fn mesh(self) -> &'a TriangleMesh {
        match self {
            Self::Listed(mesh) => mesh,
            Self::Hierarchy(bvh) => bvh.mesh(),
        }
    }

    /// Their hierarchy, if they have one.
    pub fn hierarchy(self) -> Option<&'a MeshBvh> {
        match self {
            Self::Listed(_) => None,
            Self::Hierarchy(bvh) => Some(bvh),
        }
    }

    /// The mesh with its triangles at `world_from_local`.
    pub fn placed(self, world_from_local: Affine3A) -> PlacedMesh<'a> {
        match self {
            Self::Listed(mesh) => PlacedMesh::without_hierarchy(mesh, world_from_local),
            Self::Hierarchy(bvh) => PlacedMesh::new(bvh, world_from_local),
        }
    }

    /// The nearest hit at their place in the world, with the parameter of the ray. `misses` tells of a ray in the space of
    /// the mesh whether it may be passed over.
    pub fn closest_hit(
        self,
        placed: &PlacedSurface,
        ray: &Ray,
        backfaces: Backfaces,
        misses: impl Fn(&Ray) -> bool,
    ) -> Option<TriangleHit> {
        match placed.ray_to_local(ray) {
            Some(local) if misses(&local) => None,
            Some(local) => match self {
                Self::Listed(mesh) => mesh.closest_hit(&local, backfaces),
                Self::Hierarchy(bvh) => bvh.closest_hit(&local, backfaces),
            },
            // The transform is flat, or so nearly flat that the ray overflows: take the triangles to the world.
            None => {
                let place = |corner: Vec3A| placed.world_from_local().transform_point3a(corner);
                self.mesh().closest_hit_of(ray, backfaces, place)
            }
        }
    }

    /// Whether a ray hits them at their place in the world anywhere.
    pub fn any_hit(
        self,
        placed: &PlacedSurface,
        ray: &Ray,
        backfaces: Backfaces,
        misses: impl Fn(&Ray) -> bool,
    ) -> bool {
        match (self, placed.ray_to_local(ray)) {
            (Self::Hierarchy(bvh), Some(local)) => !misses(&local) && bvh.any_hit(&local, backfaces),
            _ => self.closest_hit(placed, ray, backfaces, misses).is_some(),
        }
    }
}
