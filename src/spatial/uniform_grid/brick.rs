//! Bricks of 4 × 4 × 4 cells, and how they are found by their coordinates.
//!
//! One look-up finds 64 cells, and a bit mask tells which of them hold anything: scanning a neighbourhood is a handful
//! of look-ups and masks (as the leaf nodes of Museth, *VDB*, 2013, §3.1 have them).

use bevy::math::{IVec3, bounding::Aabb3d};

use super::bucket::NONE;
use crate::geometry::aabb::EMPTY;

/// A brick of 64 cells.
#[derive(Clone, Debug)]
pub(super) struct Brick {
    /// A box around all boxes with centres in the brick; not smaller than needed after leaves have gone or moved.
    pub bounds: Aabb3d,
    /// In bricks.
    pub coordinates: IVec3,
    /// The cells that hold leaves. Free bricks hold none.
    pub occupied: u64,
    /// The first bucket of each cell.
    pub heads: [u32; 64],
}

impl Brick {
    pub fn new(coordinates: IVec3) -> Self {
        Self {
            bounds: EMPTY,
            coordinates,
            occupied: 0,
            heads: [NONE; 64],
        }
    }
}

/// Finds bricks by their coordinates: open addressing with linear probing (Knuth, *The Art of Computer Programming*,
/// vol. 3, §6.4, algorithms L and R).
#[derive(Clone, Debug, Default)]
pub(super) struct BrickTable {
    /// A power of two of them, at most half in use; or none.
    entries: Vec<Entry>,
    len: usize,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    key: u64,
    /// `NONE` if the entry is free.
    brick: u32,
}

const FREE: Entry = Entry { key: 0, brick: NONE };

/// All coordinates, exactly: keys are equal only where bricks are.
#[inline(always)]
fn key(coordinates: IVec3) -> u64 {
    const AXIS: u64 = (1 << 21) - 1;
    let [x, y, z] = coordinates.to_array().map(|x| x as u64 & AXIS);
    x | y << 21 | z << 42
}

impl BrickTable {
    /// Where the search for a key begins.
    #[inline(always)]
    fn home(&self, key: u64) -> usize {
        let mixed = (key ^ key >> 32).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (mixed >> 32) as usize & self.entries.len().wrapping_sub(1)
    }

    /// The brick with these coordinates.
    #[inline(always)]
    pub fn find(&self, coordinates: IVec3) -> Option<u32> {
        let key = key(coordinates);
        let mut at = self.home(key);
        loop {
            let entry = self.entries.get(at)?;
            if entry.brick == NONE {
                return None;
            }
            if entry.key == key {
                return Some(entry.brick);
            }
            at = (at + 1) & (self.entries.len() - 1);
        }
    }

    /// Adds a brick that is not in the table.
    pub fn insert(&mut self, coordinates: IVec3, brick: u32) {
        if self.entries.len() < 2 * (self.len + 1) {
            let grown = vec![FREE; (4 * self.len).next_power_of_two().max(8)];
            for entry in std::mem::replace(&mut self.entries, grown) {
                if entry.brick != NONE {
                    self.place(entry);
                }
            }
        }
        self.len += 1;
        self.place(Entry {
            key: key(coordinates),
            brick,
        });
    }

    fn place(&mut self, entry: Entry) {
        let mut at = self.home(entry.key);
        while self.entries[at].brick != NONE {
            at = (at + 1) & (self.entries.len() - 1);
        }
        self.entries[at] = entry;
    }

    /// Removes a brick that is in the table, and closes the gap.
    pub fn remove(&mut self, coordinates: IVec3) {
        let key = key(coordinates);
        let mask = self.entries.len() - 1;
        let mut gap = self.home(key);
        while self.entries[gap].key != key || self.entries[gap].brick == NONE {
            gap = (gap + 1) & mask;
        }
        let mut at = gap;
        loop {
            at = (at + 1) & mask;
            let entry = self.entries[at];
            if entry.brick == NONE {
                break;
            }
            // An entry may move to the gap if that is not before its home, counted round the table.
            let from_home = at.wrapping_sub(self.home(entry.key)) & mask;
            let from_gap = at.wrapping_sub(gap) & mask;
            if from_home >= from_gap {
                self.entries[gap] = entry;
                gap = at;
            }
        }
        self.entries[gap] = FREE;
        self.len -= 1;
    }

    pub fn clear(&mut self) {
        self.entries.fill(FREE);
        self.len = 0;
    }

    pub fn len(&self) -> usize {
        self.len
    }

    pub fn memory(&self) -> usize {
        self.entries.capacity() * size_of::<Entry>()
    }
}
