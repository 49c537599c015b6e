//! Meshes that are swapped after the index was synchronised.

use bevy::{
    asset::{AssetId, Assets},
    ecs::{
        change_detection::{DetectChangesMut, Res, ResMut},
        entity::Entity,
        system::SystemParam,
    },
    mesh::Mesh,
};

use crate::index::{
    MeshBvhs, SpatialIndex,
    meshes::Role,
    surface::{PlacedSurface, Shape},
};

/// Has rays hit what an entity shows in this very frame.
#[derive(SystemParam)]
pub(crate) struct MeshSwaps<'w> {
    index: ResMut<'w, SpatialIndex>,
    meshes: ResMut<'w, MeshBvhs>,
    assets: Option<Res<'w, Assets<Mesh>>>,
}

impl MeshSwaps<'_> {
    /// Rays hit `to` where they have hit the triangles of `from`. The box stays as it is; what is posed, or hit as something
    /// else, stays all as it is until the next synchronisation.
    pub fn swap(&mut self, entity: Entity, from: AssetId<Mesh>, to: AssetId<Mesh>) {
        let surface = self.index.bypass_change_detection().surface_mut(entity);
        let Some(PlacedSurface {
            shape: Shape::Mesh(mesh, kind),
            pose: None,
            ..
        }) = surface
        else {
            return;
        };
        if *mesh != from || from == to {
            return;
        }
        let kind = *kind;
        *mesh = to;
        self.index.set_changed();
        self.meshes.acquire(to, entity, self.assets.as_deref());
        self.meshes.demand_hierarchy(to);
        self.meshes.request_volume(to, Role::Guard, kind);
        self.meshes.release(from);
    }
}
