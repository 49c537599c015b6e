//! The index itself: the structures, and what is known of each entity in them.

mod stats;
mod update;
mod validate;

pub use stats::SpatialIndexStats;
pub use validate::BrokenIndex;

use std::sync::atomic::{AtomicBool, Ordering};

use bevy::{
    camera::visibility::RenderLayers,
    ecs::{
        entity::{Entity, EntityHashMap},
        resource::Resource,
    },
    math::{Affine3A, bounding::Aabb3d},
};

use super::{DetailLevel, mask, surface::PlacedSurface};
use crate::{
    geometry::{aabb::Aabb3dExt, volume::Volume},
    spatial::{AabbTree, Descend, LeafId, SpatialQueries, SpatialUpdates, UniformGrid},
};

/// All indexed entities in a tree of their world boxes, and in a grid of them while that is asked for, as of the last
/// [`SpatialIndexSystems::Sync`](super::SpatialIndexSystems::Sync).
///
/// Ask it through [`SceneQuery`](super::SceneQuery); what is here is for tools and tests.
///
/// Not reflected, for all of it is made of the components of entities; its figures are: see [`stats`](Self::stats).
#[derive(Resource, Debug)]
pub struct SpatialIndex {
    tree: AabbTree<Key>,
    grid: Option<UniformGrid<Key>>,
    /// Whether somebody has asked for the grid.
    is_grid_asked: AtomicBool,
    /// The slot of each entity by its index in the world, [`NO_SLOT`] for those that are not here.
    slot_of: Vec<Slot>,
    /// What changes need to know, slot by slot.
    tenants: Vec<Tenant>,
    /// What queries filter by, slot by slot: apart from the rest, for most that a ray passes is filtered or missed.
    entries: Vec<Entry>,
    /// What rays hit, slot by slot.
    surfaces: Vec<Option<PlacedSurface>>,
    free_slots: Vec<Slot>,
    refused: EntityHashMap<Refusal>,
    /// What was looked at by the last synchronisation, other than what has but moved.
    reconciled: Vec<Entity>,
    /// How often the index was synchronised.
    syncs: u64,
}

/// The number of an indexed entity.
pub(crate) type Slot = u32;

/// No slot has this number.
const NO_SLOT: Slot = Slot::MAX;

/// What the structures know an entity by. Ordered by entity, which decides between hits at one distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Key {
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
    /// A joint of its skin or a morph weight is NaN or infinite, or vertices of its mesh have joint weights or morph targets
    /// that are missing, NaN or infinite.
    #[error("its joints, its morph weights, or the vertices of its mesh that they pose are NaN, infinite or missing")]
    Pose,
    /// Its `PickShape` is empty or has no end.
    #[error(
        "its PickShape is empty, has no end, or bounds that are NaN or infinite; a large Plane3d can stand for a plane"
    )]
    Shape,
    /// Both are good, and the box overflows in world space.
    #[error("its bounds are too large for its GlobalTransform: the world box overflows")]
    WorldBounds,
}

/// An entity in its slot: all that is needed to move it.
#[derive(Clone, Copy, Debug)]
struct Tenant {
    /// [`Entity::PLACEHOLDER`] in a free slot.
    entity: Entity,
    leaf: LeafId,
    in_grid: Option<LeafId>,
    /// The box whose image is the world box.
    local: Aabb3d,
    has_surface: bool,
    /// It goes where its [pose](super::PosedMeshes) goes.
    is_posed: bool,
}

/// What a query filters an entity by.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub layers: RenderLayers,
    /// Not hidden by itself or an ancestor.
    pub visible: bool,
    pub level: Option<DetailLevel>,
}

impl Entry {
    /// The mask of the leaf.
    fn mask(&self) -> u32 {
        mask::of_entity(&self.layers, self.visible, self.level)
    }
}

/// What the index is to hold of an entity.
#[derive(Clone, Debug)]
pub(super) struct Contents {
    /// The box in the local space of the entity, and its image in the world.
    pub local: Aabb3d,
    pub world: Aabb3d,
    pub surface: Option<PlacedSurface>,
    pub entry: Entry,
}

/// Where entities go that have moved and have not changed otherwise.
#[derive(Debug, Default)]
pub(super) struct Moves {
    in_tree: Vec<(LeafId, Aabb3d)>,
    in_grid: Vec<(LeafId, Aabb3d)>,
}

impl SpatialIndex {
    pub(super) fn new() -> Self {
        Self {
            tree: AabbTree::default(),
            grid: None,
            is_grid_asked: AtomicBool::new(false),
            slot_of: Vec::new(),
            tenants: Vec::new(),
            entries: Vec::new(),
            surfaces: Vec::new(),
            free_slots: Vec::new(),
            refused: EntityHashMap::default(),
            reconciled: Vec::new(),
            syncs: 0,
        }
    }

    /// The number of entities in the index.
    pub fn len(&self) -> usize {
        self.tree.len()
    }

    /// Whether no entity is in the index.
    pub fn is_empty(&self) -> bool {
        self.tree.is_empty()
    }

    /// Whether the entity is in the index.
    pub fn contains(&self, entity: Entity) -> bool {
        self.slot(entity).is_some()
    }

    /// The world box of an entity, if it is in the index.
    pub fn aabb(&self, entity: Entity) -> Option<Aabb3d> {
        let slot = self.slot(entity)?;
        self.tree.aabb(self.tenants[slot as usize].leaf)
    }

    /// A world box around everything in the index, or `None` if it is empty.
    pub fn bounds(&self) -> Option<Aabb3d> {
        self.tree.bounds()
    }

    /// All entities that are here, or are left out because of bad data.
    pub(super) fn known(&self) -> impl Iterator<Item = Entity> + '_ {
        let tenants = self.tenants.iter().filter(|tenant| !tenant.is_gone());
        tenants.map(|tenant| tenant.entity).chain(self.refused.keys().copied())
    }

    /// The entities that are left out because of bad data, and why.
    pub fn refused(&self) -> impl ExactSizeIterator<Item = (Entity, Refusal)> + '_ {
        self.refused.iter().map(|(&entity, &why)| (entity, why))
    }

    /// Visits every node of the tree with its depth, zero for the root, and its world box: see
    /// [`AabbTree::visit_nodes`].
    pub fn visit_nodes(&self, visit: impl FnMut(usize, &Aabb3d)) {
        self.tree.visit_nodes(visit);
    }

    /// The same, and goes below a node only where `visit` says so: see [`AabbTree::descend_nodes`].
    pub fn descend_nodes(&self, visit: impl FnMut(usize, &Aabb3d) -> Descend) {
        self.tree.descend_nodes(visit);
    }

    /// Builds the tree anew, at once: in O(n log n). Changes no answer; a tree that has worn is built anew
    /// [anyway](super::SpatialIndexSystems::Optimize), beside its use.
    pub fn rebuild(&mut self) {
        self.tree.rebuild();
    }

    pub(crate) fn tree(&self) -> &AabbTree<Key> {
        &self.tree
    }

    /// Whatever may have come, gone, or changed otherwise than by moving when the index was synchronised last; some of it
    /// several times.
    pub(crate) fn reconciled(&self) -> &[Entity] {
        &self.reconciled
    }

    /// How often the index was synchronised.
    pub(crate) fn syncs(&self) -> u64 {
        self.syncs
    }

    /// The grid, if one is kept: by the next synchronisation there is one, if the settings allow it.
    pub(crate) fn ask_grid(&self) -> Option<&UniformGrid<Key>> {
        // Mostly there is nothing to write to what many threads read.
        if !self.is_grid_asked.load(Ordering::Relaxed) {
            self.is_grid_asked.store(true, Ordering::Relaxed);
        }
        self.grid.as_ref()
    }

    pub(super) fn entry(&self, slot: Slot) -> &Entry {
        &self.entries[slot as usize]
    }

    pub(super) fn surface(&self, slot: Slot) -> Option<&PlacedSurface> {
        self.surfaces[slot as usize].as_ref()
    }

    /// What rays hit on an entity, if it is in the index.
    pub(super) fn surface_of(&self, entity: Entity) -> Option<&PlacedSurface> {
        let slot = self.slot(entity)?;
        self.surface(slot)
    }

    /// An entity that is here under the index that `entity` has in the world, of whatever generation.
    pub(super) fn namesake(&self, entity: Entity) -> Option<Entity> {
        let slot = *self.slot_of.get(entity.index_u32() as usize)?;
        self.tenants.get(slot as usize).map(|tenant| tenant.entity)
    }

    /// What the structures know an entity by, if it is here.
    pub(super) fn key(&self, entity: Entity) -> Option<Key> {
        self.slot(entity).map(|slot| Key { entity, slot })
    }

    #[inline]
    fn slot(&self, entity: Entity) -> Option<Slot> {
        let slot = *self.slot_of.get(entity.index_u32() as usize)?;
        let tenant = self.tenants.get(slot as usize)?;
        (tenant.entity == entity).then_some(slot)
    }

    /// The box in the local space of an entity whose image is its world box, if it is in the index and not posed.
    pub(crate) fn local_aabb(&self, entity: Entity) -> Option<Aabb3d> {
        let tenant = &self.tenants[self.slot(entity)? as usize];
        (!tenant.is_posed).then_some(tenant.local)
    }

    /// Notes where an entity has moved to, and puts there what rays hit. This may go on in many places at once, while nobody
    /// asks for anything.
    ///
    /// False, and nothing is done, if that takes more than to move it: it is not in the index, or its world box would not
    /// be sound.
    #[inline]
    pub(super) fn note_move(&self, entity: Entity, world_from_local: Affine3A, moves: &mut Moves) -> bool {
        let Some(slot) = self.slot(entity) else {
            return false;
        };
        let tenant = &self.tenants[slot as usize];
        if tenant.is_posed {
            return world_from_local.is_finite();
        }
        let world = tenant.local.transformed_by_affine(&world_from_local);
        let is_sound = world.is_sound();
        if is_sound {
            moves.push(tenant, world);
            if tenant.has_surface {
                self.put_surface(slot, &world_from_local);
            }
        }
        is_sound
    }

    /// Whether an entity is in the index, and goes where its pose goes.
    #[inline]
    pub(crate) fn is_posed(&self, entity: Entity) -> bool {
        let slot = self.slot(entity);
        slot.is_some_and(|slot| self.tenants[slot as usize].is_posed)
    }

    /// The same of an entity that is posed, with its world box, which is sound.
    pub(super) fn note_pose(
        &self,
        entity: Entity,
        world: Aabb3d,
        world_from_local: Affine3A,
        moves: &mut Moves,
    ) -> bool {
        let Some(slot) = self.slot(entity) else {
            return false;
        };
        moves.push(&self.tenants[slot as usize], world);
        self.put_surface(slot, &world_from_local);
        true
    }

    #[inline]
    fn put_surface(&self, slot: Slot, world_from_local: &Affine3A) {
        if let Some(surface) = &self.surfaces[slot as usize] {
            surface.place(world_from_local);
        }
    }
}

impl Contents {
    fn is_posed(&self) -> bool {
        self.surface.as_ref().is_some_and(|surface| surface.pose.is_some())
    }
}

impl Tenant {
    fn is_gone(&self) -> bool {
        self.entity == Entity::PLACEHOLDER
    }
}

impl Moves {
    /// The number of entities that have moved.
    pub fn len(&self) -> usize {
        self.in_tree.len()
    }

    #[inline]
    fn push(&mut self, tenant: &Tenant, world: Aabb3d) {
        self.in_tree.push((tenant.leaf, world));
        self.in_grid.extend(tenant.in_grid.map(|leaf| (leaf, world)));
    }
}
