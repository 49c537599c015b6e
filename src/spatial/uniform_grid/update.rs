//! Leaves come, move and go.

use bevy::math::bounding::Aabb3d;

use super::{
    UniformGrid,
    bucket::{NONE, Place},
    lattice::FARTHEST_CELL,
    level::Level,
};
use crate::{
    geometry::aabb::Aabb3dExt,
    spatial::{LeafId, NoSuchLeaf, UnsoundBox, UpdateError, simd::prefetch},
};

/// Each level has cells so many times larger than those of the finer one.
const LEVEL_FACTOR_LOG2: i32 = 2;

/// No cell is larger than some 2¹²⁶, so that none is infinite.
const LARGEST_CELL_LOG2: i32 = 126;

/// How many of many updates are looked at to guess whether most leaves leave their cells.
const MOVERS_SAMPLED: usize = 64;

/// How many updates ahead the memory that they need is asked for.
const AHEAD: usize = 8;

impl<K: Copy> UniformGrid<K> {
    pub(super) fn add(&mut self, key: K, aabb: Aabb3d) -> Result<LeafId, UnsoundBox> {
        if !aabb.is_sound() {
            return Err(UnsoundBox(aabb));
        }
        let id = self.leaves.add((), Place::new(0, 0));
        self.link(id.index, key, &aabb);
        self.settle(1);
        Ok(id)
    }

    pub(super) fn take(&mut self, id: LeafId) -> Result<K, NoSuchLeaf> {
        let ((), place) = self.leaves.remove(id)?;
        let key = self.key_of(place);
        self.unlink(place);
        self.settle(1);
        Ok(key)
    }

    pub(super) fn replace(&mut self, id: LeafId, aabb: &Aabb3d) -> Result<(), UpdateError> {
        let place = self.place_for(id, aabb)?;
        if self.keeps_cell(place, aabb) {
            self.store(place, aabb);
        } else {
            self.relink(id.index, place, aabb);
        }
        self.settle(1);
        Ok(())
    }

    /// Stores every box, and moves leaves to their new cells one by one, or all at once if most leave theirs.
    pub(super) fn replace_many(&mut self, updates: &[(LeafId, Aabb3d)]) -> Vec<(LeafId, UpdateError)> {
        let at_once = 2 * updates.len() >= self.leaves.len() && self.most_leave_their_cell(updates);
        let mut refused = Vec::new();
        for (at, &(id, ref aabb)) in updates.iter().enumerate() {
            self.prefetch(updates, at);
            match self.place_for(id, aabb) {
                Err(why) => refused.push((id, why)),
                Ok(place) if at_once => self.buckets.get_mut(place.bucket()).boxes.set(place.lane(), aabb),
                Ok(place) if self.keeps_cell(place, aabb) => self.store(place, aabb),
                Ok(place) => self.relink(id.index, place, aabb),
            }
        }
        if at_once {
            let is_other_scene = self.is_other_scene();
            self.gather();
            if is_other_scene {
                self.choose_cell_size();
            }
            self.sort();
        } else {
            self.settle(updates.len());
        }
        refused
    }

    /// Has the memory that updates soon need be brought close: the place of one that is far ahead, the bucket of one
    /// half as far.
    #[inline(always)]
    fn prefetch(&self, updates: &[(LeafId, Aabb3d)], at: usize) {
        if let Some((id, _)) = updates.get(at + AHEAD)
            && let Ok(place) = self.leaves.place(*id)
        {
            prefetch(self.buckets.get(place.bucket()));
        }
    }

    /// Whether most of the leaves that some updates are of leave their cells, judged by a few.
    fn most_leave_their_cell(&self, updates: &[(LeafId, Aabb3d)]) -> bool {
        let step = updates.len() / MOVERS_SAMPLED + 1;
        let (mut leave, mut seen) = (0, 0);
        for (id, aabb) in updates.iter().step_by(step) {
            if let Ok(place) = self.place_for(*id, aabb) {
                seen += 1;
                leave += usize::from(!self.keeps_cell(place, aabb));
            }
        }
        2 * leave > seen
    }

    fn place_for(&self, id: LeafId, aabb: &Aabb3d) -> Result<Place, UpdateError> {
        let place = self.leaves.place(id)?;
        if aabb.is_sound() {
            Ok(place)
        } else {
            Err(UnsoundBox(*aabb).into())
        }
    }

    /// Whether the leaf at `place` stays in its cell with this box.
    #[inline(always)]
    fn keeps_cell(&self, place: Place, aabb: &Aabb3d) -> bool {
        let bucket = self.buckets.get(place.bucket());
        let level = &self.levels[bucket.level as usize];
        self.level_for(aabb) == bucket.level as usize && level.cell_for(aabb) == level.cell_in(bucket.slot)
    }

    #[inline(always)]
    fn store(&mut self, place: Place, aabb: &Aabb3d) {
        let bucket = self.buckets.get_mut(place.bucket());
        bucket.boxes.set(place.lane(), aabb);
        self.levels[bucket.level as usize].include(bucket.slot, aabb);
    }

    fn relink(&mut self, leaf: u32, place: Place, aabb: &Aabb3d) {
        let key = self.key_of(place);
        self.unlink(place);
        self.link(leaf, key, aabb);
    }

    /// The level of a box: the finest with cells not smaller than the box, nor too small for coordinates so large.
    #[inline(always)]
    pub(super) fn level_for(&self, aabb: &Aabb3d) -> usize {
        let farthest = aabb.min.abs().max(aabb.max.abs());
        let needed = (aabb.max - aabb.min).max(farthest / FARTHEST_CELL).max_element();
        let ratio = needed * self.tuning.base.recip();
        if ratio <= 1.0 {
            return 0;
        }
        let log2 = |x: f32| (x.to_bits() >> 23) as i32 - 127;
        let log2_up = log2(ratio) + i32::from(ratio.to_bits() & ((1 << 23) - 1) != 0);
        let coarsest = (LARGEST_CELL_LOG2 - log2(self.tuning.base)) / LEVEL_FACTOR_LOG2;
        ((log2_up + LEVEL_FACTOR_LOG2 - 1) / LEVEL_FACTOR_LOG2).min(coarsest) as usize
    }

    /// The level with this number, made if there is none, and marked as one that holds leaves.
    pub(super) fn occupy_level(&mut self, level: usize) -> &mut Level {
        while self.levels.len() <= level {
            let factor = ((1 << LEVEL_FACTOR_LOG2) as f32).powi(self.levels.len() as i32);
            self.levels.push(Level::new(self.tuning.base * factor));
        }
        self.occupied |= 1 << level;
        &mut self.levels[level]
    }

    /// Removes everything from the cells, and keeps the memory.
    pub(super) fn clear_cells(&mut self) {
        self.buckets.clear();
        self.levels.iter_mut().for_each(Level::clear);
        self.occupied = 0;
    }

    pub(super) fn link(&mut self, leaf: u32, key: K, aabb: &Aabb3d) {
        let number = self.level_for(aabb);
        let level = self.occupy_level(number);
        let slot = level.occupy(level.cell_for(aabb));
        level.include(slot, aabb);
        level.len += 1;
        let head = &mut self.levels[number].bricks[slot.brick()].heads[slot.bit()];
        let place = self.buckets.push(head, slot, number as u8, leaf, key, aabb);
        self.leaves.set_place_at(leaf, place);
    }

    fn unlink(&mut self, place: Place) {
        let bucket = self.buckets.get(place.bucket());
        let (slot, number) = (bucket.slot, bucket.level as usize);
        let level = &mut self.levels[number];
        let head = &mut level.bricks[slot.brick()].heads[slot.bit()];
        if let Some(moved) = self.buckets.remove(head, place) {
            self.leaves.set_place_at(moved, place);
        }
        if *head == NONE {
            level.vacate(slot);
        }
        level.len -= 1;
        if level.len == 0 {
            level.loosen();
            self.occupied &= !(1 << number);
        }
    }
}
