//! One posed entity: its pose as of the last frame, and its mesh in that pose, once it is asked for.

use std::sync::{
    Arc, Mutex, OnceLock, PoisonError,
    atomic::{AtomicBool, AtomicU32, Ordering},
};

use bevy::{
    asset::AssetId,
    ecs::entity::Entity,
    math::{Affine3A, bounding::Aabb3d},
    mesh::Mesh,
};

use super::{PoseInputs, stats::PosingCounters};
use crate::{
    geometry::{aabb::Aabb3dExt, volume::Volume},
    index::{Refusal, mesh_slot::MeshSlot, triangles::TrianglesRef},
    mesh::{MeshDeformer, Pose, PosedMesh},
};

/// One posed entity.
#[derive(Debug)]
pub(in crate::index) struct PosedEntity {
    pub entity: Entity,
    pub mesh: AssetId<Mesh>,
    pub deformer: Arc<MeshDeformer>,
    pub pose: Pose,
    /// The box around the mesh in its pose: in the world if it is skinned, in the space of the entity otherwise.
    bounds: Result<Aabb3d, Refusal>,
    /// The mesh in its pose, since the first ray that came near.
    posed: OnceLock<PosedMesh>,
    /// The mesh in an earlier pose, for its memory.
    spare: Mutex<Option<PosedMesh>>,
    /// Of which hierarchy of the mesh these are copies.
    generation: AtomicU32,
    /// Whether the mesh was asked for since the last frame.
    is_asked: AtomicBool,
    /// For how many frames it was not.
    idle: u32,
}

impl PosedEntity {
    pub fn new(entity: Entity, mesh: AssetId<Mesh>, deformer: Arc<MeshDeformer>) -> Self {
        let pose = Pose::default();
        Self {
            entity,
            mesh,
            bounds: bounds(&deformer, &pose),
            deformer,
            pose,
            posed: OnceLock::new(),
            spare: Mutex::new(None),
            generation: AtomicU32::new(0),
            is_asked: AtomicBool::new(false),
            idle: 0,
        }
    }

    /// Whether its triangles are in the world, wherever the entity itself is.
    pub fn is_skinned(&self) -> bool {
        !self.pose.joints.is_empty()
    }

    /// Where its triangles are placed, for a place of the entity.
    pub fn world_from_posed(&self, place: Affine3A) -> Affine3A {
        if self.is_skinned() { Affine3A::IDENTITY } else { place }
    }

    /// Brings the pose up to date, and returns whether it has changed.
    pub fn follow(&mut self, inputs: &PoseInputs) -> bool {
        let changed = inputs.follow(self.entity, &self.deformer, &mut self.pose);
        if changed {
            self.bounds = bounds(&self.deformer, &self.pose);
            self.retire();
        }
        changed
    }

    /// The world box, for a place of the entity.
    pub fn world_aabb(&self, place: &Affine3A) -> Result<Aabb3d, Refusal> {
        let bounds = self.bounds?;
        let world = if self.is_skinned() {
            bounds
        } else {
            bounds.transformed_by_affine(place)
        };
        world.is_sound().then_some(world).ok_or(Refusal::WorldBounds)
    }

    /// Gives up the posed mesh, but not its memory.
    fn retire(&mut self) {
        if let Some(posed) = self.posed.take() {
            *self.spare.get_mut().unwrap_or_else(PoisonError::into_inner) = Some(posed);
        }
    }

    /// Whether there is a mesh in this pose or an earlier one.
    pub fn has_copy(&self) -> bool {
        self.posed.get().is_some() || self.spare.lock().is_ok_and(|spare| spare.is_some())
    }

    /// Frees what was not asked for in so many frames, and copies of a hierarchy that was replaced; `generation` is that of
    /// the present one.
    pub fn tidy(&mut self, kept: u32, generation: Option<u32>) {
        let is_asked = std::mem::take(self.is_asked.get_mut());
        let spare = self.spare.get_mut().unwrap_or_else(PoisonError::into_inner);
        if self.posed.get().is_none() && spare.is_none() {
            return;
        }
        let is_outdated = generation.is_some_and(|generation| generation != *self.generation.get_mut());
        self.idle = if is_asked { 0 } else { self.idle.saturating_add(1) };
        if is_outdated || self.idle > kept {
            *spare = None;
            self.posed.take();
        }
    }

    /// The mesh in its pose, which is posed by the first who asks; others wait for it. `None` if it is not loaded, or was
    /// edited since the pose was brought up to date.
    pub fn posed(&self, slot: &MeshSlot, counters: &PosingCounters) -> Option<&PosedMesh> {
        if !self.is_asked.load(Ordering::Relaxed) {
            self.is_asked.store(true, Ordering::Relaxed);
        }
        if let Some(posed) = self.posed.get() {
            return Some(posed);
        }
        let surface = slot.tested().filter(|_| self.is_of(slot))?;
        Some(self.posed.get_or_init(|| {
            counters.count(self.deformer.vertex_count(), || {
                let spare = self.spare.lock().ok().and_then(|mut spare| spare.take());
                let mut posed = spare.unwrap_or_else(|| {
                    self.generation.store(slot.generation(), Ordering::Relaxed);
                    match surface {
                        TrianglesRef::Listed(mesh) => PosedMesh::of_triangles(mesh),
                        TrianglesRef::Hierarchy(bvh) => PosedMesh::of_bvh(bvh),
                    }
                });
                posed.pose(&self.deformer, &self.pose);
                posed
            })
        }))
    }
}

impl PosedEntity {
    /// Whether the pose is of the mesh as it is now.
    pub fn is_of(&self, slot: &MeshSlot) -> bool {
        slot.deformer()
            .is_some_and(|deformer| Arc::ptr_eq(deformer, &self.deformer))
    }
}

fn bounds(deformer: &MeshDeformer, pose: &Pose) -> Result<Aabb3d, Refusal> {
    let aabb = deformer.aabb(pose).filter(|_| pose.is_finite());
    let aabb = aabb.ok_or(Refusal::Pose)?;
    aabb.is_sound().then_some(aabb).ok_or(Refusal::WorldBounds)
}
