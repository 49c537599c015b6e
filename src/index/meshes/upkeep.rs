//! What is done about meshes once a frame: taking over what was built, and dropping what is not used.

use std::sync::atomic::Ordering::Relaxed;

use bevy::{asset::AssetId, mesh::Mesh};

use super::{MeshBvhs, MeshStatus};
use crate::index::{MeshSettings, mesh_slot::MeshSlot};

/// For how many frames a mesh is kept that nobody uses, and the hierarchy of one that no ray comes near: a second, mostly.
///
/// What goes and comes back within that, as bullets do and what rays ask for in turn, is not built each time.
const GRACE: u32 = 60;

impl MeshBvhs {
    /// Notes the beginning of a frame.
    pub(in crate::index) fn begin_frame(&mut self, settings: MeshSettings) {
        self.frame = self.frame.wrapping_add(1);
        if self.settings != settings {
            for slot in self.slots.values_mut() {
                slot.set_compact(settings.compact);
            }
            self.settings = settings;
            self.next_eviction = Some(self.frame);
        }
    }

    /// Takes over what has been built, has built what queries have missed, and drops what is not used; returns whether
    /// there was any of it.
    pub(in crate::index) fn keep_up(&mut self) -> bool {
        let mut has_changed = self.collect_built();
        if std::mem::take(self.is_missed.get_mut()) {
            has_changed = true;
            for (&id, slot) in &mut self.slots {
                if slot.build_if_missed() {
                    self.building.insert(id);
                }
            }
        }
        has_changed |= self.drop_unused();
        has_changed |= self.keep_within_budget();
        has_changed
    }

    /// What is known of a mesh whose triangles a query asks for.
    #[inline]
    pub(in crate::index) fn used_slot(&self, id: AssetId<Mesh>) -> Option<&MeshSlot> {
        let slot = self.slot(id)?;
        if slot.note_use(self.frame) {
            self.is_missed.store(true, Relaxed);
        }
        Some(slot)
    }

    fn collect_built(&mut self) -> bool {
        let Self { slots, building, .. } = self;
        let mut has_built = false;
        building.retain(|id| {
            let Some(slot) = slots.get_mut(id) else {
                return false;
            };
            let built = slot.collect_built(self.frame);
            if built.surface {
                self.changed.push(*id);
            }
            if built.hierarchy {
                self.next_eviction = Some(self.frame);
            }
            has_built |= built.surface || built.hierarchy;
            slot.is_building()
        });
        has_built
    }

    fn drop_unused(&mut self) -> bool {
        let mut has_dropped = false;
        while let Some(&(since, id)) = self.unused.front()
            && self.frame.wrapping_sub(since) >= GRACE
        {
            self.unused.pop_front();
            // It may have found a user since, and lost that too.
            let is_unused = |slot: &MeshSlot| slot.users == 0 && slot.unused_since == since;
            if self.slots.get(&id).is_some_and(is_unused) {
                self.slots.remove(&id);
                self.building.remove(&id);
                has_dropped = true;
            }
        }
        has_dropped
    }

    /// Drops the hierarchies that were not used for longest, until the rest is within the budget or was used of late.
    fn keep_within_budget(&mut self) -> bool {
        let Some(budget) = self.settings.memory_budget else {
            return false;
        };
        // Frames are counted round and round.
        let is_due = |due: u32| self.frame.wrapping_sub(due) <= u32::MAX / 2;
        if !self.next_eviction.is_some_and(is_due) {
            return false;
        }
        self.next_eviction = None;
        let mut memory = self.memory();
        if memory <= budget {
            return false;
        }
        let ready = self.slots.iter().filter(|(_, slot)| slot.status() == MeshStatus::Ready);
        let mut oldest_first: Vec<(u32, AssetId<Mesh>)> = ready.map(|(&id, slot)| (slot.age(self.frame), id)).collect();
        oldest_first.sort_unstable_by(|a, b| b.cmp(a));
        let mut has_evicted = false;
        for (age, id) in oldest_first {
            if memory <= budget {
                break;
            }
            if age < GRACE {
                self.next_eviction = Some(self.frame.wrapping_add(GRACE - age));
                break;
            }
            let slot = self.slots.get_mut(&id).expect("a slot that was listed");
            memory -= slot.memory();
            slot.evict();
            memory += slot.memory();
            has_evicted = true;
        }
        has_evicted
    }
}
