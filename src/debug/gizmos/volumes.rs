//! Bounding volumes around what rays hit.

use bevy::{
    asset::AssetId,
    color::Color,
    ecs::{
        change_detection::{DetectChangesMut, ResMut},
        entity::Entity,
        resource::Resource,
    },
    gizmos::{config::GizmoConfigGroup, gizmos::GizmoBuffer},
    math::bounding::Aabb3d,
    mesh::Mesh,
    platform::collections::HashSet,
};

use super::shapes::{BOX_LINES, Pen, lines_of};
use crate::{
    geometry::volume::{AnyVolume, BoundingKind},
    index::{MeshBvhs, SpatialIndex},
};

/// Volumes that could not be drawn, for they are not made yet.
#[derive(Resource, Debug, Default)]
pub(super) struct Wanted(HashSet<(AssetId<Mesh>, BoundingKind)>);

/// Where volumes come from.
pub(super) struct Volumes<'a> {
    pub index: &'a SpatialIndex,
    pub meshes: &'a MeshBvhs,
    pub wanted: &'a mut Wanted,
}

impl Volumes<'_> {
    /// Draws the volume of an entity with this world box; returns the lines that it took, if there were so many.
    pub fn draw<Config, Clear>(
        &mut self,
        gizmos: &mut GizmoBuffer<Config, Clear>,
        (entity, aabb): (Entity, &Aabb3d),
        kind: BoundingKind,
        color: Color,
        left: usize,
    ) -> Option<usize>
    where
        Config: GizmoConfigGroup,
        Clear: 'static + Send + Sync,
    {
        let mut pen = Pen { gizmos };
        let Some((mesh, world_from_local)) = self.index.placed_mesh(entity) else {
            return (left >= BOX_LINES).then(|| pen.aabb(aabb, color)).flatten();
        };
        let local_box;
        let volume = match kind {
            BoundingKind::Aabb => {
                local_box = self.meshes.box_of(mesh).map(AnyVolume::Aabb);
                local_box.as_ref()
            }
            _ => self.meshes.tightest_volume(mesh, kind),
        };
        let Some(volume) = volume else {
            self.wanted.0.insert((mesh, kind));
            return None;
        };
        let fits = lines_of(volume) <= left;
        fits.then(|| pen.volume(volume, &world_from_local, color)).flatten()
    }
}

/// Has the volumes made that were missing.
pub(super) fn request_wanted(mut wanted: ResMut<Wanted>, mut meshes: ResMut<MeshBvhs>) {
    for (mesh, kind) in wanted.0.drain() {
        meshes.bypass_change_detection().request_tightest_volume(mesh, kind);
    }
}
