//! What hides what is behind it, kept from frame to frame.

use std::sync::Arc;

use bevy::{
    camera::visibility::RenderLayers,
    ecs::{
        entity::{Entity, EntityHashMap},
        resource::Resource,
    },
    math::{Affine3A, bounding::Aabb3d},
};

use super::shapes::{ShapeKey, Shapes};
use crate::{
    mesh::{NotSolid, UnusableMesh},
    raster::OccluderMesh,
};

/// What hides what is behind it, in the local space of its entity. Clones share it.
#[derive(Clone, Debug)]
pub enum OccluderShape {
    /// Solid boxes.
    Boxes(Arc<[Aabb3d]>),
    /// Triangles that are seen from the front.
    Mesh(Arc<OccluderMesh>),
}

impl OccluderShape {
    /// Whether both are the same, and not only alike.
    fn is(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Boxes(a), Self::Boxes(b)) => Arc::ptr_eq(a, b),
            (Self::Mesh(a), Self::Mesh(b)) => Arc::ptr_eq(a, b),
            (Self::Boxes(_), Self::Mesh(_)) | (Self::Mesh(_), Self::Boxes(_)) => false,
        }
    }
}

/// Why an entity with an [`Occluder`](super::Occluder) does not occlude, although it should.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum OccluderRefusal {
    /// There are no boxes inside of its mesh.
    #[error("{0}")]
    NotSolid(NotSolid),
    /// Its mesh has no triangles.
    #[error("{0}")]
    Unusable(UnusableMesh),
    /// It is skinned or morphed: it is not where the vertices of its mesh are.
    #[error("it is skinned or morphed; Occluder::Box and Occluder::Proxy are not")]
    Posed,
    /// Its `GlobalTransform` has a NaN or infinite value.
    #[error("its GlobalTransform has NaN or infinite values")]
    Transform,
    /// Its `Aabb`, by which it occludes, has a NaN, infinite or negative extent.
    #[error("its Aabb is NaN, infinite or of negative size")]
    Bounds,
}

/// The entities that hide what is behind them, as of the last
/// [`FollowOccluders`](super::OcclusionSystems::FollowOccluders).
///
/// Not reflected, for all of it is made of components and assets.
#[derive(Resource, Debug, Default)]
pub struct Occluders {
    /// By the index of the entity in the world.
    records: Vec<Option<Record>>,
    /// How many records there are.
    known: usize,
    /// How many of them are of entities that occlude.
    len: usize,
    refused: EntityHashMap<OccluderRefusal>,
    version: u64,
    pub(super) shapes: Shapes,
}

/// What is known of an entity with an `Occluder`.
#[derive(Clone, Debug)]
pub(super) struct Record {
    pub entity: Entity,
    /// The shape of a mesh that it uses, or waits for.
    pub key: Option<ShapeKey>,
    /// If it occludes.
    pub active: Option<Active>,
}

/// An entity that occludes.
#[derive(Clone, Debug)]
pub(super) struct Active {
    pub shape: OccluderShape,
    pub world_from_local: Affine3A,
    pub layers: RenderLayers,
}

impl Active {
    fn is(&self, other: &Self) -> bool {
        self.shape.is(&other.shape) && self.world_from_local == other.world_from_local && self.layers == other.layers
    }
}

impl Occluders {
    /// By what an entity occludes, with its place in the world; `None` if it does not.
    #[inline]
    pub fn get(&self, entity: Entity) -> Option<(&OccluderShape, &Affine3A)> {
        let active = self.active(entity)?;
        Some((&active.shape, &active.world_from_local))
    }

    /// The layers of an entity that occludes: it does so for cameras that share one.
    pub fn layers(&self, entity: Entity) -> Option<&RenderLayers> {
        self.active(entity).map(|active| &active.layers)
    }

    /// All entities that occlude, in the order of their indices.
    pub fn iter(&self) -> impl Iterator<Item = Entity> + '_ {
        let records = self.records.iter().flatten();
        records
            .filter(|record| record.active.is_some())
            .map(|record| record.entity)
    }

    /// How many entities occlude.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether nothing occludes.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Grows with every change of what occludes: whenever something that has occluded, or does now, comes, goes, moves,
    /// or changes its shape or layers.
    pub fn version(&self) -> u64 {
        self.version
    }

    /// The entities that do not occlude although they should, and why.
    pub fn refused(&self) -> impl ExactSizeIterator<Item = (Entity, OccluderRefusal)> + '_ {
        self.refused.iter().map(|(&entity, &why)| (entity, why))
    }

    /// Of how many meshes the shape is being made.
    pub fn making(&self) -> usize {
        self.shapes.making()
    }

    #[inline]
    fn active(&self, entity: Entity) -> Option<&Active> {
        self.record(entity)?.active.as_ref()
    }

    /// What is known of an entity.
    #[inline]
    pub(super) fn record(&self, entity: Entity) -> Option<&Record> {
        let record = self.records.get(entity.index_u32() as usize)?.as_ref();
        record.filter(|record| record.entity == entity)
    }

    /// An entity that is here under the index that `entity` has in the world, of another generation.
    pub(super) fn namesake(&self, entity: Entity) -> Option<Entity> {
        let record = self.records.get(entity.index_u32() as usize)?.as_ref()?;
        (record.entity != entity).then_some(record.entity)
    }

    /// How many entities are known, whether they occlude or not.
    pub(super) fn known(&self) -> usize {
        self.known
    }

    /// The entities that are known.
    pub(super) fn all_known(&self) -> impl Iterator<Item = Entity> + '_ {
        self.records.iter().flatten().map(|record| record.entity)
    }

    /// Moves an entity of which nothing else has changed. False if that takes more.
    pub(super) fn set_place(&mut self, entity: Entity, world_from_local: Affine3A) -> bool {
        let record = self
            .records
            .get_mut(entity.index_u32() as usize)
            .and_then(Option::as_mut);
        let active = record
            .filter(|record| record.entity == entity)
            .and_then(|record| record.active.as_mut());
        let Some(active) = active.filter(|_| world_from_local.is_finite()) else {
            return false;
        };
        if active.world_from_local != world_from_local {
            active.world_from_local = world_from_local;
            self.version += 1;
        }
        true
    }

    /// Replaces what is known of an entity; nothing is if it has no `Occluder`.
    pub(super) fn set_record(&mut self, entity: Entity, record: Option<Record>) {
        let index = entity.index_u32() as usize;
        if index >= self.records.len() {
            if record.is_none() {
                return;
            }
            self.records.resize_with(index + 1, || None);
        }
        let old = std::mem::replace(&mut self.records[index], record);
        let new = &self.records[index];
        self.known = self.known + usize::from(new.is_some()) - usize::from(old.is_some());
        let old = old.as_ref().and_then(|record| record.active.as_ref());
        let new = new.as_ref().and_then(|record| record.active.as_ref());
        self.len = self.len + usize::from(new.is_some()) - usize::from(old.is_some());
        let is_same = match (old, new) {
            (Some(old), Some(new)) => old.is(new),
            (None, None) => true,
            _ => false,
        };
        self.version += u64::from(!is_same);
    }

    /// Notes why an entity does not occlude; returns whether that is new.
    pub(super) fn set_refused(&mut self, entity: Entity, why: Option<OccluderRefusal>) -> bool {
        match why {
            Some(why) => self.refused.insert(entity, why) != Some(why),
            None => {
                self.refused.remove(&entity);
                false
            }
        }
    }
}
