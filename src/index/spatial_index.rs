//! The index itself: the tree, and what is known of each entity in it.

use bevy::{
    asset::AssetId,
    camera::visibility::RenderLayers,
    ecs::{
        entity::{Entity, EntityHashMap},
        resource::Resource,
    },
    math::{Affine3A, DAffine3, bounding::Aabb3d},
    mesh::Mesh,
};

use crate::{
    geometry::ray::triangle::Backfaces,
    spatial::{AabbTree, LeafId, SpatialQueries, UnsoundBox, aabb_tree::BrokenInvariant},
};

/// All indexed entities in a tree of their world boxes, as of the last
/// [`SpatialIndexSystems::Sync`](super::SpatialIndexSystems::Sync).
///
/// Ask it through [`SceneQuery`](super::SceneQuery); what is here is for tools and tests.
#[derive(Resource, Debug, Default)]
pub struct SpatialIndex {
    tree: AabbTree<Entity>,
    entries: EntityHashMap<Entry>,
    refused: EntityHashMap<Refusal>,
}

/// Why an entity is not in the index although it should be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
pub enum Refusal {
    /// Its `GlobalTransform` has a NaN or infinite value.
    #[error("its GlobalTransform has NaN or infinite values")]
    Transform,
    /// Its `Aabb` has a NaN, infinite or negative extent.
    #[error("its Aabb is NaN, infinite or of negative size")]
    Bounds,
    /// Both are good, and the box overflows in world space.
    #[error("its bounds are too large for its GlobalTransform: the world box overflows")]
    WorldBounds,
}

/// What the index knows of an entity.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    leaf: LeafId,
    pub data: EntryData,
}

/// What a query filters and tests an entity by.
#[derive(Clone, Debug)]
pub(super) struct EntryData {
    pub surface: Option<MeshSurface>,
    pub layers: RenderLayers,
    /// Not hidden by itself or an ancestor.
    pub visible: bool,
}

/// The mesh that rays hit, placed in the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeshSurface {
    pub mesh: AssetId<Mesh>,
    pub world_from_local: Affine3A,
    /// In double precision, for [`Ray::transformed_by`](crate::geometry::ray::Ray::transformed_by). `None` where the
    /// transform flattens the mesh.
    pub local_from_world: Option<DAffine3>,
    pub backfaces: Backfaces,
}

impl SpatialIndex {
    /// The number of entities in the index.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether no entity is in the index.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Whether the entity is in the index.
    pub fn contains(&self, entity: Entity) -> bool {
        self.entries.contains_key(&entity)
    }

    /// The world box of an entity, if it is in the index.
    pub fn aabb(&self, entity: Entity) -> Option<Aabb3d> {
        self.tree.aabb(self.entries.get(&entity)?.leaf)
    }

    /// A world box around everything in the index, or `None` if it is empty.
    pub fn bounds(&self) -> Option<Aabb3d> {
        self.tree.bounds()
    }

    /// The tree of world boxes.
    pub fn tree(&self) -> &AabbTree<Entity> {
        &self.tree
    }

    /// The entities that are left out because of bad data, and why.
    pub fn refused(&self) -> impl ExactSizeIterator<Item = (Entity, Refusal)> + '_ {
        self.refused.iter().map(|(&entity, &why)| (entity, why))
    }

    /// Checks that the tree is whole and holds the indexed entities and no others, in O(n).
    ///
    /// # Errors
    ///
    /// The first invariant that does not hold, which is a bug in this crate.
    pub fn validate(&self) -> Result<(), BrokenInvariant> {
        self.tree.validate()?;
        let linked = self
            .entries
            .iter()
            .all(|(entity, entry)| self.tree.key(entry.leaf) == Some(*entity));
        if linked && self.tree.len() == self.entries.len() {
            Ok(())
        } else {
            Err(BrokenInvariant::Lost)
        }
    }

    pub(super) fn entry(&self, entity: Entity) -> Option<&Entry> {
        self.entries.get(&entity)
    }

    /// The mesh that rays hit on an entity that is in the index.
    pub(super) fn mesh(&self, entity: Entity) -> Option<AssetId<Mesh>> {
        let surface = self.entries.get(&entity)?.data.surface.as_ref()?;
        Some(surface.mesh)
    }

    /// Brings an entity that is in the index up to date.
    ///
    /// # Panics
    ///
    /// If the entity is not in the index, or the box is not sound.
    pub(super) fn update(&mut self, entity: Entity, aabb: Aabb3d, data: EntryData) {
        let entry = self
            .entries
            .get_mut(&entity)
            .expect("only what is in the index is updated");
        self.tree
            .update(entry.leaf, aabb)
            .expect("an entry has a leaf, and the box was checked");
        entry.data = data;
    }

    /// Puts entities into the index that are not there yet.
    pub(super) fn insert_many(&mut self, new: &mut Vec<(Entity, Aabb3d, EntryData)>) {
        let boxes = new.iter().map(|(entity, aabb, _)| (*entity, *aabb));
        let leaves: Vec<Result<LeafId, UnsoundBox>> = self.tree.insert_many(boxes);
        for (leaf, (entity, _, data)) in leaves.into_iter().zip(new.drain(..)) {
            let leaf = leaf.expect("the box was checked");
            let old = self.entries.insert(entity, Entry { leaf, data });
            debug_assert!(old.is_none(), "{entity} is in the index twice");
        }
    }

    /// Takes an entity out of the index, if it is there.
    pub(super) fn remove(&mut self, entity: Entity) {
        if let Some(entry) = self.entries.remove(&entity) {
            self.tree.remove(entry.leaf).expect("an entry has a leaf");
        }
    }

    /// Notes that an entity is refused, or no longer; returns whether the refusal is news.
    pub(super) fn set_refused(&mut self, entity: Entity, refusal: Option<Refusal>) -> bool {
        match refusal {
            Some(why) => self.refused.insert(entity, why) != Some(why),
            None => {
                // Mostly there is nothing to look up.
                if !self.refused.is_empty() {
                    self.refused.remove(&entity);
                }
                false
            }
        }
    }
}
