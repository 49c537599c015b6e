//! One bounding volume hierarchy per mesh asset, shared by all entities that use it.

use bevy::{
    asset::{AssetId, Assets},
    ecs::{entity::Entity, resource::Resource},
    math::bounding::Aabb3d,
    mesh::Mesh,
    platform::collections::{HashMap, HashSet},
};

use super::mesh_slot::MeshSlot;
use crate::{geometry::volume::BoundingKind, mesh::TriangleMesh};

/// The bounding volume hierarchies of all meshes that indexed entities use or have used, by asset.
///
/// They are built on the [`AsyncComputeTaskPool`](bevy::tasks::AsyncComputeTaskPool), rebuilt when the asset changes, and dropped with it; one that no
/// entity uses any more is dropped when the asset changes. While one is being built, rays test every triangle of the
/// mesh instead: the answers are the same, only slower.
#[derive(Resource, Debug)]
pub struct MeshBvhs {
    slots: HashMap<AssetId<Mesh>, MeshSlot>,
    building: HashSet<AssetId<Mesh>>,
    /// The meshes that were loaded, modified or unloaded since they were last asked for.
    changed: Vec<AssetId<Mesh>>,
}

/// How far the hierarchy of a mesh has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum MeshStatus {
    /// The asset is not loaded, or gone. Rays hit nothing.
    Missing,
    /// The asset has no surface, as a warning has said. Rays hit nothing.
    Unusable,
    /// Rays test all triangles.
    Building,
    /// Rays use the hierarchy.
    Ready,
}

impl MeshBvhs {
    pub(super) fn new() -> Self {
        Self {
            slots: HashMap::default(),
            building: HashSet::default(),
            changed: Vec::new(),
        }
    }

    /// How far the hierarchy of a mesh has come, or `None` if no indexed entity has used it.
    pub fn status(&self, id: impl Into<AssetId<Mesh>>) -> Option<MeshStatus> {
        self.slots.get(&id.into()).map(MeshSlot::status)
    }

    /// Of how many meshes the hierarchy or a bounding volume is being built.
    pub fn building(&self) -> usize {
        self.building.len()
    }

    /// The triangles of a mesh, if an indexed entity uses it and it is usable.
    pub fn triangles(&self, id: impl Into<AssetId<Mesh>>) -> Option<&TriangleMesh> {
        self.slots.get(&id.into()).and_then(MeshSlot::triangles)
    }

    /// The kinds of bounding volume that entities have [asked](super::BoundedBy) for of a mesh. They are kept as long as
    /// the mesh is.
    pub fn volumes(&self, id: impl Into<AssetId<Mesh>>) -> impl Iterator<Item = BoundingKind> + '_ {
        self.slots.get(&id.into()).into_iter().flat_map(MeshSlot::volumes)
    }

    /// The local box of a mesh that an entity uses, if it is loaded and usable.
    pub(super) fn aabb(&self, id: AssetId<Mesh>) -> Option<Aabb3d> {
        self.triangles(id).map(TriangleMesh::aabb)
    }

    /// Counts `entity` among the users of a mesh, and begins to build it for the first one.
    pub(super) fn acquire(&mut self, id: AssetId<Mesh>, entity: Entity, assets: Option<&Assets<Mesh>>) {
        let slot = self.slots.entry(id).or_default();
        slot.users += 1;
        if let (MeshStatus::Missing, Some(mesh)) = (slot.status(), assets.and_then(|assets| assets.get(id))) {
            slot.load(id, mesh, Some(entity));
            self.building.insert(id);
        }
    }

    /// Has rays tested against a volume of the mesh before its triangles are, as soon as the volume is built.
    pub(super) fn bound_by(&mut self, id: AssetId<Mesh>, kind: BoundingKind) {
        // The box is that of the root of the hierarchy: for most entities that move, there is nothing to look up.
        if kind == BoundingKind::Aabb {
            return;
        }
        let slot = self.slots.get_mut(&id).expect("a mesh that was acquired");
        slot.bound_by(kind);
        if slot.is_building() {
            self.building.insert(id);
        }
    }

    /// Takes one user off a mesh.
    pub(super) fn release(&mut self, id: AssetId<Mesh>) {
        if let Some(slot) = self.slots.get_mut(&id) {
            slot.users -= 1;
            if slot.users == 0 && slot.status() == MeshStatus::Missing {
                self.slots.remove(&id);
            }
        }
    }

    /// Follows a mesh asset that was added, modified or removed.
    pub(super) fn follow(&mut self, id: AssetId<Mesh>, assets: &Assets<Mesh>) {
        self.changed.push(id);
        self.building.remove(&id);
        let Some(slot) = self.slots.get_mut(&id) else {
            return;
        };
        match assets.get(id) {
            _ if slot.users == 0 => {
                self.slots.remove(&id);
            }
            Some(mesh) => {
                slot.load(id, mesh, None);
                self.building.insert(id);
            }
            None => slot.unload(),
        }
    }

    /// Whether there is anything for [`drain_changed`](Self::drain_changed) to give.
    pub(super) fn has_changed(&self) -> bool {
        !self.changed.is_empty()
    }

    /// The meshes that were loaded, modified or unloaded since this was last called.
    pub(super) fn drain_changed(&mut self) -> impl Iterator<Item = AssetId<Mesh>> + '_ {
        self.changed.drain(..)
    }

    /// Takes over the hierarchies and the volumes that have been built.
    pub(super) fn collect_built(&mut self) {
        let slots = &mut self.slots;
        (self.building).retain(|id| slots.get_mut(id).is_some_and(MeshSlot::collect_built));
    }

    /// What is known of a mesh that an entity uses.
    pub(super) fn slot(&self, id: AssetId<Mesh>) -> Option<&MeshSlot> {
        self.slots.get(&id)
    }
}
