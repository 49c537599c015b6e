//! What changes the index.

use bevy::{
    ecs::entity::Entity,
    tasks::{ComputeTaskPool, TaskPool},
};

use super::{Contents, Key, Moves, NO_SLOT, Refusal, Slot, SpatialIndex, Tenant};
use crate::index::surface::PlacedSurface;
use crate::spatial::{
    AabbTree, LeafId, NoSuchLeaf, SpatialUpdates, UniformGrid, UnsoundBox, UpdateError, uniform_grid::GridSettings,
};

/// Fewer boxes than this are not worth a task for each structure.
const LEAST_SHARED: usize = 2048;

impl SpatialIndex {
    /// Puts entities into the index that are not there yet, each with a sound box.
    pub(in crate::index) fn insert_many(&mut self, new: &mut Vec<(Entity, Contents)>) {
        let free = self.free_slots.drain(self.free_slots.len().saturating_sub(new.len())..);
        let slots: Vec<Slot> = free.chain(self.tenants.len() as Slot..).take(new.len()).collect();
        let leaves = || {
            slots.iter().zip(&*new).map(|(&slot, &(entity, ref contents))| {
                let mask = contents.entry.mask();
                (Key { entity, slot }, contents.world, mask)
            })
        };
        let in_grid = self.grid.as_mut().map(|grid| {
            let leaves = leaves().map(|(key, aabb, _)| (key, aabb));
            grid.insert_many(leaves)
        });
        let in_tree = self.tree.insert_many_masked(leaves());
        let in_grid = in_grid.into_iter().flatten().map(|leaf| Some(checked(leaf)));
        let in_grid = in_grid.chain(std::iter::repeat(None));
        let leaves = in_tree.into_iter().map(checked).zip(in_grid);
        for ((slot, (leaf, in_grid)), (entity, contents)) in slots.into_iter().zip(leaves).zip(new.drain(..)) {
            let tenant = Tenant {
                entity,
                leaf,
                in_grid,
                local: contents.local,
                has_surface: contents.surface.is_some(),
                is_posed: contents.is_posed(),
            };
            put(&mut self.tenants, slot, tenant);
            put(&mut self.entries, slot, contents.entry);
            put(&mut self.surfaces, slot, contents.surface);
            let index = entity.index_u32() as usize;
            if self.slot_of.len() <= index {
                self.slot_of.resize(index + 1, NO_SLOT);
            }
            debug_assert!(self.slot_of[index] == NO_SLOT, "{entity} is in the index twice");
            self.slot_of[index] = slot;
        }
    }

    /// Brings an entity that is in the index up to date, but for its box, which goes to `moves`.
    ///
    /// # Panics
    ///
    /// If the entity is not in the index.
    pub(in crate::index) fn update(&mut self, entity: Entity, contents: Contents, moves: &mut Moves) {
        let slot = self.slot(entity).expect("an entity in the index") as usize;
        let tenant = &mut self.tenants[slot];
        (tenant.local, tenant.has_surface) = (contents.local, contents.surface.is_some());
        tenant.is_posed = contents.is_posed();
        moves.push(tenant, contents.world);
        let mask = contents.entry.mask();
        if self.tree.mask(tenant.leaf) != Some(mask) {
            self.tree.set_mask(tenant.leaf, mask).expect("a tenant has a leaf");
        }
        self.entries[slot] = contents.entry;
        self.surfaces[slot] = contents.surface;
    }

    /// What rays hit on an entity, if it is in the index.
    pub(in crate::index) fn surface_mut(&mut self, entity: Entity) -> Option<&mut PlacedSurface> {
        let slot = self.slot(entity)?;
        self.surfaces[slot as usize].as_mut()
    }

    /// Moves entities, as was noted in several places: where something was noted twice, the last counts. What has been
    /// removed since is passed over.
    pub(in crate::index) fn apply_moves(&mut self, moves: &mut [&mut Moves]) {
        let mut in_grid = Vec::new();
        if let Some((first, others)) = moves.split_first_mut() {
            in_grid = std::mem::take(&mut first.in_grid);
            others.iter_mut().for_each(|other| in_grid.append(&mut other.in_grid));
        }
        let Self { tree, grid, .. } = self;
        let in_tree = moves.iter().map(|moves| &moves.in_tree[..]);
        let move_in_tree = |tree: &mut AabbTree<Key>| only_the_gone(tree.refit_parts(in_tree));
        let move_in_grid = |grid: &mut UniformGrid<Key>| only_the_gone(grid.update_many(&in_grid));
        match grid {
            Some(grid) if in_grid.len() >= LEAST_SHARED => {
                ComputeTaskPool::get_or_init(TaskPool::default).scope(|scope| {
                    scope.spawn(async { move_in_tree(tree) });
                    scope.spawn(async { move_in_grid(grid) });
                });
            }
            Some(grid) => {
                move_in_tree(tree);
                move_in_grid(grid);
            }
            None => move_in_tree(tree),
        }
        in_grid.clear();
        moves.iter_mut().for_each(|moves| moves.in_tree.clear());
        if let Some(first) = moves.first_mut() {
            // For its memory.
            first.in_grid = in_grid;
        }
    }

    /// Takes an entity out of the index, if it is there.
    pub(in crate::index) fn remove(&mut self, entity: Entity) {
        if let Some(slot) = self.slot(entity) {
            let tenant = &mut self.tenants[slot as usize];
            self.tree.remove(tenant.leaf).expect("a tenant has a leaf");
            if let (Some(grid), Some(leaf)) = (&mut self.grid, tenant.in_grid) {
                grid.remove(leaf).expect("a tenant has a leaf");
            }
            tenant.entity = Entity::PLACEHOLDER;
            self.surfaces[slot as usize] = None;
            self.slot_of[entity.index_u32() as usize] = NO_SLOT;
            self.free_slots.push(slot);
        }
    }

    /// Notes that an entity is refused, or no longer; returns whether the refusal is news.
    pub(in crate::index) fn set_refused(&mut self, entity: Entity, refusal: Option<Refusal>) -> bool {
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

    /// Whether the grid was asked for since this was last called.
    pub(in crate::index) fn take_grid_asked(&mut self) -> bool {
        std::mem::take(self.is_grid_asked.get_mut())
    }

    /// With which settings a grid is kept, if one is.
    pub(in crate::index) fn grid_settings(&self) -> Option<GridSettings> {
        self.grid.as_ref().map(UniformGrid::settings)
    }

    /// Keeps a grid with these settings from now on, or none.
    ///
    /// # Panics
    ///
    /// If a fixed cell size is not positive and finite.
    pub(in crate::index) fn set_grid(&mut self, settings: Option<GridSettings>) {
        self.grid = settings.map(UniformGrid::new);
        let tree = &self.tree;
        let tenants = || self.tenants.iter().zip(0..).filter(|(tenant, _)| !tenant.is_gone());
        let boxes = tenants().map(|(tenant, slot)| {
            let entity = tenant.entity;
            (
                Key { entity, slot },
                tree.aabb(tenant.leaf).expect("a tenant has a leaf"),
            )
        });
        let mut leaves = self
            .grid
            .as_mut()
            .map(|grid| grid.insert_many(boxes).into_iter().map(checked));
        for tenant in self.tenants.iter_mut().filter(|tenant| !tenant.is_gone()) {
            tenant.in_grid = leaves.as_mut().and_then(Iterator::next);
        }
    }

    /// Notes what a synchronisation has looked at; `reconciled` gets an empty buffer for it.
    pub(in crate::index) fn note_sync(&mut self, reconciled: &mut Vec<Entity>) {
        self.reconciled.clear();
        std::mem::swap(&mut self.reconciled, reconciled);
        self.syncs += 1;
    }

    /// The tree, to be kept fast.
    pub(in crate::index) fn tree_mut(&mut self) -> &mut AabbTree<Key> {
        &mut self.tree
    }
}

fn checked(leaf: Result<LeafId, UnsoundBox>) -> LeafId {
    leaf.expect("the box was checked")
}

/// Passes over what is gone: nothing else is refused.
fn only_the_gone(refused: Vec<(LeafId, UpdateError)>) {
    let is_gone = |(_, why)| why == UpdateError::NoSuchLeaf(NoSuchLeaf);
    debug_assert!(refused.into_iter().all(is_gone), "the boxes were checked");
}

/// Stores `value` in a slot, which is one of those that are there, or the next.
fn put<T>(slots: &mut Vec<T>, slot: Slot, value: T) {
    if slot as usize == slots.len() {
        slots.push(value);
    } else {
        slots[slot as usize] = value;
    }
}
