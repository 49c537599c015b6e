//! What entities are posed by.

use bevy::{
    asset::{AssetEvent, AssetId, Assets},
    ecs::{
        change_detection::{DetectChanges, Ref, Res},
        entity::Entity,
        message::{MessageCursor, Messages},
        query::{Added, Or},
        system::{Local, Query, SystemParam},
    },
    math::{Affine3A, Mat4},
    mesh::{
        morph::{MeshMorphWeights, MorphWeights},
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    transform::components::GlobalTransform,
};

use crate::mesh::{MeshDeformer, Pose};

/// What entities are posed by, with the times of the changes.
#[derive(SystemParam)]
pub(in crate::index) struct PoseInputs<'w, 's> {
    places: Query<'w, 's, Ref<'static, GlobalTransform>>,
    skins: Query<'w, 's, Ref<'static, SkinnedMesh>>,
    morphs: Query<'w, 's, Ref<'static, MeshMorphWeights>>,
    weights: Query<'w, 's, Ref<'static, MorphWeights>>,
    newly_posed: Query<'w, 's, Entity, Or<(Added<SkinnedMesh>, Added<MeshMorphWeights>)>>,
    bind_poses: Option<Res<'w, Assets<SkinnedMeshInverseBindposes>>>,
    bind_pose_events: Option<Res<'w, Messages<AssetEvent<SkinnedMeshInverseBindposes>>>>,
    events_read: Local<'s, MessageCursor<AssetEvent<SkinnedMeshInverseBindposes>>>,
    changed_bind_poses: Local<'s, Vec<AssetId<SkinnedMeshInverseBindposes>>>,
}

impl PoseInputs<'_, '_> {
    /// Finds out which inverse bind poses have changed since the last frame.
    pub fn read_events(&mut self) {
        self.changed_bind_poses.clear();
        if let Some(events) = &self.bind_pose_events {
            if self.events_read.missed_messages(events) > 0 {
                // Any of them may have changed in a pause.
                let used = self.skins.iter().map(|skin| skin.inverse_bindposes.id());
                self.changed_bind_poses.extend(used);
            }
            let changed = self.events_read.read(events).filter_map(|event| match *event {
                AssetEvent::Added { id } | AssetEvent::Modified { id } | AssetEvent::Removed { id } => Some(id),
                AssetEvent::Unused { .. } | AssetEvent::LoadedWithDependencies { .. } => None,
            });
            self.changed_bind_poses.extend(changed);
        }
    }

    /// The entities that have been given a skin or morph weights.
    pub fn newly_posed(&self) -> impl Iterator<Item = Entity> + '_ {
        self.newly_posed.iter()
    }

    /// Whether an entity has a skin, and whether it has morph weights.
    pub fn kinds(&self, entity: Entity) -> (bool, bool) {
        (self.skins.contains(entity), self.morphs.contains(entity))
    }

    /// The place of an entity, with whether it has changed.
    pub fn place(&self, entity: Entity) -> Option<(Affine3A, bool)> {
        let place = self.places.get(entity).ok()?;
        Some((place.affine(), place.is_changed()))
    }

    /// Brings the pose of an entity up to date, and returns whether it has changed.
    pub fn follow(&self, entity: Entity, deformer: &MeshDeformer, pose: &mut Pose) -> bool {
        let skinned = deformer.is_skinned() && self.follow_joints(entity, deformer, &mut pose.joints);
        let morphed = self.follow_weights(entity, deformer, &mut pose.weights);
        skinned || morphed
    }

    /// As Bevy's renderer has it: a joint that is missing when the skin is new, or has no inverse bind pose, is the
    /// identity, and one that goes missing stays where it was.
    fn follow_joints(&self, entity: Entity, deformer: &MeshDeformer, joints: &mut Vec<Affine3A>) -> bool {
        let Ok(skin) = self.skins.get(entity) else {
            return false;
        };
        let id = skin.inverse_bindposes.id();
        let bind_poses = self.bind_poses.as_ref().and_then(|assets| assets.get(id));
        let bind_poses = bind_poses.map_or(&[][..], |bind_poses| &**bind_poses);
        let is_new = joints.is_empty() || skin.is_changed() || self.changed_bind_poses.contains(&id);
        if is_new {
            joints.clear();
            let needed = skin.joints.len().max(deformer.joint_count());
            joints.resize(needed, Affine3A::IDENTITY);
        }
        let mut changed = is_new;
        let named = skin.joints.iter().zip(bind_poses);
        for (joint, (&named, bind_pose)) in joints.iter_mut().zip(named) {
            let Ok(place) = self.places.get(named) else {
                continue;
            };
            if is_new || place.is_changed() {
                let matrix = joint_matrix(&place, bind_pose);
                changed |= *joint != matrix;
                *joint = matrix;
            }
        }
        changed
    }

    fn follow_weights(&self, entity: Entity, deformer: &MeshDeformer, weights: &mut Vec<f32>) -> bool {
        let Ok(morph) = self.morphs.get(entity) else {
            return false;
        };
        let named = match &*morph {
            MeshMorphWeights::Value { weights } => Some(&**weights),
            MeshMorphWeights::Reference(holder) => {
                let holder = self.weights.get(*holder).ok();
                holder.map(|holder| holder.into_inner().weights())
            }
        };
        let named = named.unwrap_or_default();
        let named = &named[..named.len().min(deformer.target_count())];
        // By their bits, for a NaN that stays is no change.
        let changed =
            weights.len() != named.len() || weights.iter().zip(named).any(|(a, b)| a.to_bits() != b.to_bits());
        if changed {
            weights.clear();
            weights.extend_from_slice(named);
        }
        changed
    }
}

/// From the space of the mesh to the world. The last row of an inverse bind pose, if it is not affine, has an effect on
/// the translation alone, as in the vertex shader.
fn joint_matrix(place: &GlobalTransform, bind_pose: &Mat4) -> Affine3A {
    Affine3A::from_mat4(place.affine() * *bind_pose)
}
