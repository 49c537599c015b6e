//! One bounding volume hierarchy per mesh asset, shared by all entities that use it.

mod build;
mod loaded;
mod upkeep;
mod volumes;

pub(super) use loaded::{Loaded, Triangles};
pub(super) use volumes::{Role, Volumes};

use std::{collections::VecDeque, ops::Deref, sync::atomic::AtomicBool};

use bevy::{
    asset::{AssetId, Assets},
    ecs::{entity::Entity, resource::Resource},
    math::bounding::Aabb3d,
    mesh::Mesh,
    platform::collections::{HashMap, HashSet},
    reflect::Reflect,
};

use super::{MeshSettings, mesh_slot::MeshSlot};
use crate::{
    geometry::{aabb::union, surface::Surface, volume::BoundingKind},
    mesh::TriangleMesh,
};

/// The bounding volume hierarchies of all meshes that indexed entities use, by asset: one for all instances of a mesh.
///
/// They are built on the [`AsyncComputeTaskPool`](bevy::tasks::AsyncComputeTaskPool), twice: in haste, and then, unless the
/// mesh has been edited, a better one beside the use of the first. Until the first is there, rays test every triangle of
/// the mesh instead: the answers are the same, only slower. They are always those of the mesh as it was at the last
/// [`Sync`](super::SpatialIndexSystems::Sync):
///
/// - **An edit that only moves vertices** is followed at once by the hierarchy, in O(n), whose boxes are fitted to the
///   triangles. The more they have moved among each other the longer rays take; at
///   [`rebuild_factor`](MeshSettings::rebuild_factor) the hierarchy is built anew beside its use. An edit of normals or
///   texture coordinates costs no more than their copy.
/// - **Any other edit**, of indices, of the number of vertices, or from or to positions that are NaN or infinite, has the
///   hierarchy built anew. What was being built is cancelled.
/// - **Short of memory** ([`MeshSettings::memory_budget`]), the hierarchies are dropped that no ray came near for longest,
///   but not their triangles. A ray that enters the box of an entity has that of its mesh built again.
/// - **Without an entity that uses it** a mesh is dropped after a second's worth of frames, and with its asset at once.
///
/// Not reflected: all of it is made of the assets, and made again where a scene is loaded.
#[derive(Resource, Debug)]
pub struct MeshBvhs {
    slots: HashMap<AssetId<Mesh>, MeshSlot>,
    building: HashSet<AssetId<Mesh>>,
    /// The meshes whose box may have changed since they were last asked for.
    changed: Vec<AssetId<Mesh>>,
    /// Whether more may have changed, of which nothing has been heard.
    has_missed_some: bool,
    settings: MeshSettings,
    /// Counts the times that the index was brought up to date.
    frame: u32,
    /// The meshes that have lost their last user, with the frame, in the order of the frames.
    unused: VecDeque<(u32, AssetId<Mesh>)>,
    /// Whether a query has missed the hierarchy of a mesh.
    is_missed: AtomicBool,
    /// The frame from which on to look whether there is too much in memory.
    next_eviction: Option<u32>,
}

/// How far the hierarchy of a mesh has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Reflect)]
#[reflect(Debug, Clone, PartialEq, Hash)]
#[non_exhaustive]
pub enum MeshStatus {
    /// The asset is not loaded, or gone. Rays hit nothing.
    Missing,
    /// The asset has no surface, as a warning has said. Rays hit nothing.
    Unusable,
    /// There is no hierarchy: it was dropped to save memory, or nobody has asked for it, for rays hit but
    /// [volumes](super::HitSurface) of the mesh. The next ray at triangles tests all of them, and has it built.
    Dormant,
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
            has_missed_some: false,
            settings: MeshSettings::default(),
            // Not that of a slot that was never asked.
            frame: 1,
            unused: VecDeque::new(),
            is_missed: AtomicBool::new(false),
            next_eviction: None,
        }
    }

    /// How far the hierarchy of a mesh has come, or `None` if no indexed entity uses it or has used it of late.
    pub fn status(&self, id: impl Into<AssetId<Mesh>>) -> Option<MeshStatus> {
        self.slots.get(&id.into()).map(MeshSlot::status)
    }

    /// The number of meshes that indexed entities use, or have used of late.
    pub fn len(&self) -> usize {
        self.slots.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.slots.is_empty()
    }

    /// Of how many meshes the hierarchy or a bounding volume is being built.
    pub fn building(&self) -> usize {
        self.building.len()
    }

    /// How much of the hierarchy of a mesh that is being built is done, from 0 to 1; `None` if none is being built. Also
    /// of one that is built anew while rays use the old one.
    pub fn progress(&self, id: impl Into<AssetId<Mesh>>) -> Option<f32> {
        self.slots.get(&id.into()).and_then(MeshSlot::progress)
    }

    /// The memory of all triangles and hierarchies, in bytes: what is held between frames, without what a build takes
    /// while it runs, and without bounding volumes.
    pub fn memory(&self) -> usize {
        self.slots.values().map(MeshSlot::memory).sum()
    }

    /// The part of one mesh in that, or `None` if no indexed entity uses it or has used it of late.
    pub fn memory_of(&self, id: impl Into<AssetId<Mesh>>) -> Option<usize> {
        self.slots.get(&id.into()).map(MeshSlot::memory)
    }

    /// The triangles of a mesh, if an indexed entity uses it and it is usable.
    pub fn triangles(&self, id: impl Into<AssetId<Mesh>>) -> Option<&TriangleMesh> {
        self.slots.get(&id.into()).and_then(MeshSlot::triangles)
    }

    /// The same to be kept: they stay as they are when the mesh changes.
    pub(crate) fn shared_triangles(
        &self,
        id: AssetId<Mesh>,
    ) -> Option<impl Deref<Target = TriangleMesh> + Send + Sync + 'static> {
        self.slots.get(&id).and_then(MeshSlot::shared_triangles)
    }

    /// The kinds of bounding volume that entities have asked for of a mesh, by [`BoundedBy`](super::BoundedBy) or
    /// [`HitSurface`](super::HitSurface). They are kept as long as the mesh is.
    pub fn volumes(&self, id: impl Into<AssetId<Mesh>>) -> impl Iterator<Item = BoundingKind> + '_ {
        self.slots.get(&id.into()).into_iter().flat_map(MeshSlot::volumes)
    }

    /// The local box of a mesh that an entity uses, if it is loaded and usable.
    pub(super) fn aabb(&self, id: AssetId<Mesh>) -> Option<Aabb3d> {
        self.triangles(id).map(TriangleMesh::aabb)
    }

    /// The local box of a mesh and of its volume of this kind, as far as that is built.
    pub(super) fn aabb_with_volume(&self, id: AssetId<Mesh>, kind: BoundingKind) -> Option<Aabb3d> {
        let slot = self.slots.get(&id)?;
        let own = slot.triangles()?.aabb();
        let of_volume = slot.surface(kind).and_then(Surface::aabb);
        Some(of_volume.map_or(own, |of_volume| union(&own, &of_volume)))
    }

    /// Counts `entity` among the users of a mesh, and takes over its triangles for the first one.
    pub(super) fn acquire(&mut self, id: AssetId<Mesh>, entity: Entity, assets: Option<&Assets<Mesh>>) {
        let slot = self.slots.entry(id).or_default();
        slot.users += 1;
        if let (MeshStatus::Missing, Some(mesh)) = (slot.status(), assets.and_then(|assets| assets.get(id))) {
            slot.load(id, mesh, Some(entity), self.settings);
            self.note_build(id);
        }
    }

    /// Has a hierarchy built for a user whose triangles rays hit.
    pub(super) fn demand_hierarchy(&mut self, id: AssetId<Mesh>) {
        self.slot_mut(id).demand_hierarchy();
        self.note_build(id);
    }

    /// Has a volume of a mesh built that is tested before its triangles are, or hit in their place.
    pub(super) fn request_volume(&mut self, id: AssetId<Mesh>, role: Role, kind: BoundingKind) {
        // The box is that of the root of the hierarchy: for most entities, there is nothing to look up.
        if (role, kind) != (Role::Guard, BoundingKind::Aabb) {
            self.slot_mut(id).request_volume(role, kind);
            self.note_build(id);
        }
    }

    /// Takes one user off a mesh.
    pub(super) fn release(&mut self, id: AssetId<Mesh>) {
        if let Some(slot) = self.slots.get_mut(&id) {
            slot.users -= 1;
            if slot.users > 0 {
                return;
            }
            if slot.status() == MeshStatus::Missing {
                self.slots.remove(&id);
            } else {
                slot.unused_since = self.frame;
                self.unused.push_back((self.frame, id));
            }
        }
    }

    /// Follows a mesh asset that was added, modified or removed.
    pub(super) fn follow(&mut self, id: AssetId<Mesh>, assets: &Assets<Mesh>) {
        self.changed.push(id);
        let Some(slot) = self.slots.get_mut(&id) else {
            return;
        };
        match assets.get(id) {
            _ if slot.users == 0 => {
                self.slots.remove(&id);
            }
            Some(mesh) => slot.load(id, mesh, None, self.settings),
            None => slot.unload(),
        }
        self.note_build(id);
    }

    /// All meshes that are here.
    pub(super) fn known(&self) -> impl Iterator<Item = AssetId<Mesh>> + '_ {
        self.slots.keys().copied()
    }

    /// Notes that assets may have changed of which nothing has been heard, those too that are waited for.
    pub(super) fn note_missed(&mut self) {
        self.has_missed_some = true;
    }

    /// Whether that was noted since this was last called.
    pub(super) fn take_missed(&mut self) -> bool {
        std::mem::take(&mut self.has_missed_some)
    }

    /// Whether there is anything for [`drain_changed`](Self::drain_changed) to give.
    pub(super) fn has_changed(&self) -> bool {
        !self.changed.is_empty()
    }

    /// The meshes whose box may have changed since this was last called.
    pub(super) fn drain_changed(&mut self) -> impl Iterator<Item = AssetId<Mesh>> + '_ {
        self.changed.drain(..)
    }

    /// What is known of a mesh that an entity uses.
    pub(super) fn slot(&self, id: AssetId<Mesh>) -> Option<&MeshSlot> {
        self.slots.get(&id)
    }

    fn slot_mut(&mut self, id: AssetId<Mesh>) -> &mut MeshSlot {
        self.slots.get_mut(&id).expect("a mesh that was acquired")
    }

    /// Notes whether something is being built of a mesh that has changed.
    fn note_build(&mut self, id: AssetId<Mesh>) {
        if self.slots.get(&id).is_some_and(MeshSlot::is_building) {
            self.building.insert(id);
        } else {
            self.building.remove(&id);
        }
        self.next_eviction = Some(self.frame);
    }
}
