//! What is drawn of the volumes around meshes.

use bevy::{
    asset::AssetId,
    ecs::entity::Entity,
    math::{Affine3A, bounding::Aabb3d},
    mesh::Mesh,
};

use super::{MeshBvhs, SpatialIndex, meshes::Role};
use crate::geometry::{
    surface::VolumeSurface,
    volume::{AnyVolume, BoundingKind},
};

impl SpatialIndex {
    /// The mesh that rays hit of an entity, or a volume of it, with its place in the world; `None` if there is none, or it
    /// is posed.
    pub(crate) fn placed_mesh(&self, entity: Entity) -> Option<(AssetId<Mesh>, Affine3A)> {
        let surface = self.surface_of(entity).filter(|surface| surface.pose.is_none())?;
        Some((surface.mesh()?, surface.world_from_local()))
    }
}

impl MeshBvhs {
    /// The local box of a mesh, if it is loaded and usable.
    pub(crate) fn box_of(&self, id: AssetId<Mesh>) -> Option<Aabb3d> {
        self.aabb(id)
    }

    /// The tightest volume of this kind around a mesh, in its space, as far as it is built.
    pub(crate) fn tightest_volume(&self, id: AssetId<Mesh>, kind: BoundingKind) -> Option<&AnyVolume> {
        self.slot(id)?.surface(kind).map(VolumeSurface::volume)
    }

    /// Has that volume built.
    pub(crate) fn request_tightest_volume(&mut self, id: AssetId<Mesh>, kind: BoundingKind) {
        if self.slot(id).is_some() {
            self.request_volume(id, Role::Surface, kind);
        }
    }
}
