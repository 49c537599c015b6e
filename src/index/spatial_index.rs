//! The index itself: the tree, and what is known of each entity in it.

use bevy::{
    asset::AssetId,
    camera::visibility::RenderLayers,
    ecs::{
        entity::{Entity, EntityHashMap},
        resource::Resource,
    },
    math::{Affine3A, DAffine3, Vec3, bounding::Aabb3d},
    mesh::Mesh,
};

use super::PickShape;
use crate::{
    geometry::{
        ray::{Ray, triangle::Backfaces},
        volume::BoundingKind,
    },
    spatial::{AabbTree, LeafId, SpatialQueries, SpatialUpdates, aabb_tree::BrokenInvariant},
};

/// All indexed entities in a tree of their world boxes, as of the last
/// [`SpatialIndexSystems::Sync`](super::SpatialIndexSystems::Sync).
///
/// Ask it through [`SceneQuery`](super::SceneQuery); what is here is for tools and tests.
#[derive(Resource, Debug)]
pub struct SpatialIndex {
    tree: AabbTree<Key>,
    slot_of: EntityHashMap<Slot>,
    /// What queries filter by, slot by slot: apart from the rest, for most that a ray passes is filtered or missed.
    entries: Vec<Entry>,
    /// What rays hit, slot by slot.
    surfaces: Vec<Option<PlacedSurface>>,
    free_slots: Vec<Slot>,
    refused: EntityHashMap<Refusal>,
}

/// The number of an indexed entity.
pub(super) type Slot = u32;

/// What the tree knows an entity by. Ordered by entity, which decides between hits at one distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Key {
    pub entity: Entity,
    pub slot: Slot,
}

/// Why an entity is not in the index although it should be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
#[non_exhaustive]
pub enum Refusal {
    /// Its `GlobalTransform` has a NaN or infinite value.
    #[error("its GlobalTransform has NaN or infinite values")]
    Transform,
    /// Its `Aabb` has a NaN, infinite or negative extent.
    #[error("its Aabb is NaN, infinite or of negative size")]
    Bounds,
    /// Its `PickShape` is empty or has no end.
    #[error(
        "its PickShape is empty, has no end, or bounds that are NaN or infinite; a large Plane3d can stand for a plane"
    )]
    Shape,
    /// Both are good, and the box overflows in world space.
    #[error("its bounds are too large for its GlobalTransform: the world box overflows")]
    WorldBounds,
}

/// What a query filters an entity by.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    leaf: LeafId,
    pub layers: RenderLayers,
    /// Not hidden by itself or an ancestor.
    pub visible: bool,
}

/// What the index is to hold of an entity.
#[derive(Clone, Debug)]
pub(super) struct Contents {
    pub aabb: Aabb3d,
    pub surface: Option<PlacedSurface>,
    pub layers: RenderLayers,
    pub visible: bool,
}

/// What rays hit on an entity, placed in the world.
#[derive(Clone, Debug)]
pub(super) struct PlacedSurface {
    pub shape: Shape,
    pub world_from_local: Affine3A,
    /// In double precision, for [`Ray::transformed_by`]. `None` where the transform flattens the surface.
    pub local_from_world: Option<DAffine3>,
    pub backfaces: Backfaces,
}

/// What rays hit on an entity, in its local space.
#[derive(Clone, Debug)]
pub(super) enum Shape {
    /// A mesh, whose triangles are tested when the ray enters its volume of this kind.
    Mesh(AssetId<Mesh>, BoundingKind),
    Analytic(PickShape),
}

impl PlacedSurface {
    /// The ray in the space of the surface, with the same parameters, if there is such a ray.
    #[inline]
    pub fn ray_to_local(&self, ray: &Ray) -> Option<Ray> {
        ray.transformed_by(self.local_from_world.as_ref()?)
    }

    /// A unit normal in world space, for one in the space of the surface: normals transform by the inverse transpose
    /// (PBRT, 4th edition, §3.10.3). Zero if there is no inverse.
    pub fn normal_to_world(&self, normal: Vec3) -> Vec3 {
        self.local_from_world.map_or(Vec3::ZERO, |local_from_world| {
            let world = local_from_world.matrix3.transpose() * normal.as_dvec3();
            world.normalize_or_zero().as_vec3()
        })
    }

    /// The mesh, if it is one.
    pub fn mesh(&self) -> Option<AssetId<Mesh>> {
        self.shape.mesh()
    }
}

impl Shape {
    /// The mesh, if it is one.
    pub fn mesh(&self) -> Option<AssetId<Mesh>> {
        match *self {
            Self::Mesh(mesh, _) => Some(mesh),
            Self::Analytic(_) => None,
        }
    }
}

impl SpatialIndex {
    pub(super) fn new() -> Self {
        Self {
            tree: AabbTree::default(),
            slot_of: EntityHashMap::default(),
            entries: Vec::new(),
            surfaces: Vec::new(),
            free_slots: Vec::new(),
            refused: EntityHashMap::default(),
        }
    }

    /// The number of entities in the index.
    pub fn len(&self) -> usize {
        self.slot_of.len()
    }

    /// Whether no entity is in the index.
    pub fn is_empty(&self) -> bool {
        self.slot_of.is_empty()
    }

    /// Whether the entity is in the index.
    pub fn contains(&self, entity: Entity) -> bool {
        self.slot_of.contains_key(&entity)
    }

    /// The world box of an entity, if it is in the index.
    pub fn aabb(&self, entity: Entity) -> Option<Aabb3d> {
        let slot = *self.slot_of.get(&entity)?;
        self.tree.aabb(self.entry(slot).leaf)
    }

    /// A world box around everything in the index, or `None` if it is empty.
    pub fn bounds(&self) -> Option<Aabb3d> {
        self.tree.bounds()
    }

    /// The surface area cost of the tree: see [`AabbTree::sah_cost`].
    pub fn sah_cost(&self) -> f32 {
        self.tree.sah_cost()
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
        let linked = self.slot_of.iter().all(|(&entity, &slot)| {
            let key = self.tree.key(self.entry(slot).leaf);
            key == Some(Key { entity, slot })
        });
        let none_lost = self.len() + self.free_slots.len() == self.entries.len();
        if linked && none_lost && self.tree.len() == self.len() {
            Ok(())
        } else {
            Err(BrokenInvariant::Lost)
        }
    }

    pub(super) fn tree(&self) -> &AabbTree<Key> {
        &self.tree
    }

    pub(super) fn entry(&self, slot: Slot) -> &Entry {
        &self.entries[slot as usize]
    }

    pub(super) fn surface(&self, slot: Slot) -> Option<&PlacedSurface> {
        self.surfaces[slot as usize].as_ref()
    }

    /// What rays hit on an entity, if it is in the index.
    pub(super) fn surface_of(&self, entity: Entity) -> Option<&PlacedSurface> {
        let slot = *self.slot_of.get(&entity)?;
        self.surface(slot)
    }

    /// Brings an entity that is in the index up to date.
    ///
    /// # Panics
    ///
    /// If the entity is not in the index, or the box is not sound.
    pub(super) fn update(&mut self, entity: Entity, contents: Contents) {
        let slot = self.slot_of[&entity] as usize;
        let entry = &mut self.entries[slot];
        self.tree
            .update(entry.leaf, contents.aabb)
            .expect("an entry has a leaf, and the box was checked");
        (entry.layers, entry.visible) = (contents.layers, contents.visible);
        self.surfaces[slot] = contents.surface;
    }

    /// Puts entities into the index that are not there yet, each with a sound box.
    pub(super) fn insert_many(&mut self, new: &mut Vec<(Entity, Contents)>) {
        let free = self.free_slots.drain(self.free_slots.len().saturating_sub(new.len())..);
        let slots: Vec<Slot> = free.chain(self.entries.len() as Slot..).take(new.len()).collect();
        let boxes = slots
            .iter()
            .zip(&*new)
            .map(|(&slot, &(entity, ref contents))| (Key { entity, slot }, contents.aabb));
        let leaves = self.tree.insert_many(boxes);
        for ((slot, leaf), (entity, contents)) in slots.into_iter().zip(leaves).zip(new.drain(..)) {
            let entry = Entry {
                leaf: leaf.expect("the box was checked"),
                layers: contents.layers,
                visible: contents.visible,
            };
            if slot as usize == self.entries.len() {
                self.entries.push(entry);
                self.surfaces.push(contents.surface);
            } else {
                self.entries[slot as usize] = entry;
                self.surfaces[slot as usize] = contents.surface;
            }
            let old = self.slot_of.insert(entity, slot);
            debug_assert!(old.is_none(), "{entity} is in the index twice");
        }
    }

    /// Takes an entity out of the index, if it is there.
    pub(super) fn remove(&mut self, entity: Entity) {
        if let Some(slot) = self.slot_of.remove(&entity) {
            let leaf = self.entry(slot).leaf;
            self.tree.remove(leaf).expect("an entry has a leaf");
            self.free_slots.push(slot);
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
