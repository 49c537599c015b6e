//! Skinned and morphed entities, hit where they are drawn.
//!
//! Each frame the index takes over the matrices of the joints and the weights of the morph targets that have changed,
//! and computes the world box from them. Vertices are posed only for an entity whose box a ray enters, by the first ray that
//! does, and stay so until the pose changes.

mod entity;
mod inputs;
mod stats;

pub(super) use entity::PosedEntity;
pub(super) use inputs::PoseInputs;
pub use stats::PosingStats;

use std::sync::Arc;

use bevy::{
    asset::AssetId,
    ecs::{
        entity::{Entity, EntityHashMap},
        resource::Resource,
    },
    math::Affine3A,
    mesh::Mesh,
    tasks::{ComputeTaskPool, TaskPool},
};

use super::{MeshBvhs, SpatialIndex, mesh_slot::MeshSlot, sync::Found};
use crate::mesh::{MeshDeformer, PosedMesh};
use stats::PosingCounters;

/// Fewer entities than this are not worth a task.
const LEAST_POSES: usize = 128;

/// The entities that are skinned or morphed, in their poses as of the last
/// [`SpatialIndexSystems::Sync`](super::SpatialIndexSystems::Sync).
///
/// An entity is skinned if it has a `SkinnedMesh` and the mesh that rays hit has joint indices and weights, and morphed
/// if it has `MeshMorphWeights` and that mesh has morph targets.
///
/// Not reflected, for all of it is made of components and assets.
#[derive(Resource, Debug, Default)]
pub struct PosedMeshes {
    poses: Vec<Option<PosedEntity>>,
    free: Vec<PoseId>,
    id_of: EntityHashMap<PoseId>,
    counters: PosingCounters,
}

/// The number of a posed entity.
pub(super) type PoseId = u32;

impl PosedMeshes {
    /// The number of entities that are skinned or morphed.
    pub fn len(&self) -> usize {
        self.id_of.len()
    }

    /// Whether no entity is skinned or morphed.
    pub fn is_empty(&self) -> bool {
        self.id_of.is_empty()
    }

    /// How many copies of meshes are kept in which they are or were posed for rays: see
    /// [`SpatialIndexSettings::posed_meshes_kept`](super::SpatialIndexSettings::posed_meshes_kept).
    pub fn copies(&self) -> usize {
        let posed = self.poses.iter().flatten();
        posed.filter(|posed| posed.has_copy()).count()
    }

    /// What was posed for rays that came near, since the program began.
    pub fn stats(&self) -> PosingStats {
        self.counters.read()
    }

    pub(super) fn get(&self, id: PoseId) -> Option<&PosedEntity> {
        self.poses.get(id as usize)?.as_ref()
    }

    /// An entity's mesh in its pose; `slot` is what is known of the mesh.
    pub(super) fn posed(&self, id: PoseId, slot: &MeshSlot) -> Option<&PosedMesh> {
        self.get(id)?.posed(slot, &self.counters)
    }

    /// Takes over how an entity is posed, from its components as they are now. `deformer` is of the mesh that rays hit.
    pub(super) fn adopt(
        &mut self,
        entity: Entity,
        mesh: AssetId<Mesh>,
        deformer: &Arc<MeshDeformer>,
        inputs: &PoseInputs,
    ) -> Option<PoseId> {
        let (has_skin, has_weights) = inputs.kinds(entity);
        let is_skinned = has_skin && deformer.is_skinned();
        let is_morphed = has_weights && deformer.target_count() > 0;
        if !is_skinned && !is_morphed {
            self.remove(entity);
            return None;
        }
        let id = *self.id_of.entry(entity).or_insert_with(|| {
            self.free.pop().unwrap_or_else(|| {
                self.poses.push(None);
                (self.poses.len() - 1) as PoseId
            })
        });
        let place = &mut self.poses[id as usize];
        let is_same = |posed: &PosedEntity| {
            let was_morphed = !posed.pose.weights.is_empty();
            Arc::ptr_eq(&posed.deformer, deformer) && posed.is_skinned() == is_skinned && (is_morphed || !was_morphed)
        };
        let posed = match place {
            Some(posed) if is_same(posed) => posed,
            _ => place.insert(PosedEntity::new(entity, mesh, deformer.clone())),
        };
        posed.follow(inputs);
        Some(id)
    }

    /// Forgets how an entity is posed.
    pub(super) fn remove(&mut self, entity: Entity) {
        // Mostly there is nothing to look up.
        if !self.id_of.is_empty()
            && let Some(id) = self.id_of.remove(&entity)
        {
            self.poses[id as usize] = None;
            self.free.push(id);
        }
    }

    /// Brings all poses up to date, and returns how many have changed. Notes the moves of what is in the index, and the
    /// entities that take more than to be moved. `parts` are buffers, of which as many are filled as there are tasks.
    pub(super) fn follow(
        &mut self,
        inputs: &PoseInputs,
        index: &SpatialIndex,
        meshes: &MeshBvhs,
        kept: u32,
        parts: &mut Vec<Found>,
    ) {
        if self.is_empty() {
            return;
        }
        let pool = ComputeTaskPool::get_or_init(TaskPool::default);
        let follow = |poses: &mut [Option<PosedEntity>], found: &mut Found| {
            for posed in poses.iter_mut().flatten() {
                follow_one(posed, inputs, index, found);
                posed.tidy(kept, meshes.slot(posed.mesh).map(MeshSlot::generation));
            }
        };
        let tasks = (self.poses.len() / LEAST_POSES).min(4 * pool.thread_num());
        if tasks <= 1 || pool.thread_num() <= 1 {
            follow(&mut self.poses, &mut parts[0]);
            return;
        }
        if parts.len() < tasks {
            parts.resize_with(tasks, Found::default);
        }
        let step = self.poses.len().div_ceil(tasks);
        let follow = &follow;
        pool.scope(|scope| {
            for (poses, found) in self.poses.chunks_mut(step).zip(parts) {
                scope.spawn(async move { follow(poses, found) });
            }
        });
    }
}

fn follow_one(posed: &mut PosedEntity, inputs: &PoseInputs, index: &SpatialIndex, found: &mut Found) {
    let pose_changed = posed.follow(inputs);
    let place = inputs.place(posed.entity);
    let (place, place_changed) = place.unwrap_or((Affine3A::IDENTITY, false));
    found.posed += usize::from(pose_changed);
    if pose_changed || (place_changed && !posed.is_skinned()) {
        let noted = posed
            .world_aabb(&place)
            .is_ok_and(|world| index.note_pose(posed.entity, world, posed.world_from_posed(place), &mut found.moves));
        if !noted {
            found.dirty.push(posed.entity);
        }
    }
}
