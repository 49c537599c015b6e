//! All leaves are sorted into their cells at once: a counting sort (Knuth, *The Art of Computer Programming*, vol. 3,
//! §5.2, algorithm D) by cell, the cells of a brick side by side, and bricks along a Z-order curve.

use bevy::math::{IVec3, bounding::Aabb3d};

use super::{
    UniformGrid,
    brick::Brick,
    bucket::{Boxes, Bucket, NONE, Place, Slot},
    level::{Level, bits},
};
use crate::{
    geometry::aabb::Aabb3dExt,
    spatial::{
        LeafId, UnsoundBox,
        simd::{LANES, prefetch},
    },
};

/// What a rebuild needs room for.
#[derive(Clone, Debug)]
pub(super) struct Scratch<K> {
    pub records: Vec<Record<K>>,
    /// The bricks of a level by their place along the curve.
    order: Vec<(u64, u32)>,
}

impl<K> Default for Scratch<K> {
    fn default() -> Self {
        Self {
            records: Vec::new(),
            order: Vec::new(),
        }
    }
}

impl<K> Scratch<K> {
    pub fn memory(&self) -> usize {
        self.records.capacity() * size_of::<Record<K>>() + self.order.capacity() * size_of::<(u64, u32)>()
    }
}

/// A leaf on its way to its cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Record<K> {
    pub aabb: Aabb3d,
    key: K,
    leaf: u32,
    slot: Slot,
    level: u8,
}

/// How many records ahead the memory that they go to is asked for.
const AHEAD: usize = 16;

impl<K: Copy> UniformGrid<K> {
    /// Adds leaves one by one, or builds anew where they are no fewer than those that are there.
    pub(super) fn add_many(
        &mut self,
        leaves: impl IntoIterator<Item = (K, Aabb3d)>,
    ) -> Vec<Result<LeafId, UnsoundBox>> {
        let leaves: Vec<_> = leaves.into_iter().collect();
        if leaves.len() < self.leaves.len() {
            return leaves.into_iter().map(|(key, aabb)| self.add(key, aabb)).collect();
        }
        self.gather();
        self.scratch.records.reserve_exact(leaves.len());
        let ids = leaves.into_iter().map(|(key, aabb)| {
            if !aabb.is_sound() {
                return Err(UnsoundBox(aabb));
            }
            let id = self.leaves.add((), Place::new(0, 0));
            self.scratch.records.push(Record::new(id.index, key, aabb));
            Ok(id)
        });
        let ids = ids.collect();
        self.choose_cell_size();
        self.sort();
        self.scratch = Scratch::default();
        ids
    }

    /// Takes all leaves out of their cells, for [`sort`](Self::sort) to put them back.
    pub(super) fn gather(&mut self) {
        let records = &mut self.scratch.records;
        records.clear();
        records.reserve_exact(self.leaves.len());
        for bucket in &self.buckets.buckets {
            for lane in 0..bucket.len as usize {
                let (leaf, key) = (bucket.leaves[lane], bucket.keys[lane]);
                records.push(Record::new(leaf, key, bucket.boxes.get(lane)));
            }
        }
        self.clear_cells();
    }

    /// Puts all leaves that were gathered into their cells.
    pub(super) fn sort(&mut self) {
        self.count();
        self.allot();
        self.scatter();
        self.settled();
    }

    /// Finds the cell of every leaf, and counts how many each has, in the place of its first bucket.
    fn count(&mut self) {
        let mut records = std::mem::take(&mut self.scratch.records);
        let mut last: Option<(u8, IVec3, Slot)> = None;
        for record in &mut records {
            let number = self.level_for(&record.aabb);
            let level = self.occupy_level(number);
            let cell = level.cell_for(&record.aabb);
            record.level = number as u8;
            record.slot = match last {
                Some((of, at, slot)) if of == record.level && at == cell => slot,
                _ => level.occupy(cell),
            };
            last = Some((record.level, cell, record.slot));
            level.include(record.slot, &record.aabb);
            level.len += 1;
            let count = &mut level.bricks[record.slot.brick()].heads[record.slot.bit()];
            // From none, which is one below zero.
            *count = count.wrapping_add(1);
        }
        self.scratch.records = records;
    }

    /// Gives each cell the buckets that it needs, one behind the other.
    fn allot(&mut self) {
        let Some(first) = self.scratch.records.first() else {
            return;
        };
        let (key, order) = (first.key, &mut self.scratch.order);
        let buckets = &mut self.buckets.buckets;
        let needed = |level: &Level| -> usize {
            let cells = level
                .bricks
                .iter()
                .flat_map(|brick| bits(brick.occupied).map(|bit| brick.heads[bit as usize]));
            cells
                .map(|count| count.wrapping_add(1).div_ceil(LANES as u32) as usize)
                .sum()
        };
        buckets.reserve_exact(self.levels.iter().map(needed).sum());
        for (number, level) in self.levels.iter_mut().enumerate() {
            order.clear();
            let curve = |(brick, at): (&Brick, u32)| (along_curve(brick.coordinates), at);
            order.extend(level.bricks.iter().zip(0..).map(curve));
            order.sort_unstable();
            for &(_, index) in &*order {
                let brick = &mut level.bricks[index as usize];
                for bit in bits(brick.occupied) {
                    let head = &mut brick.heads[bit as usize];
                    let count = head.wrapping_add(1);
                    *head = buckets.len() as u32;
                    for at in 0..count.div_ceil(LANES as u32) {
                        buckets.push(Bucket {
                            boxes: Boxes::ZERO,
                            keys: [key; LANES],
                            leaves: [0; LANES],
                            next: if at == 0 { NONE } else { *head + at - 1 },
                            slot: Slot::new(index, bit),
                            level: number as u8,
                            len: 0,
                        });
                    }
                }
            }
        }
    }

    /// Moves the leaves into the buckets of their cells, whose heads move on as buckets fill.
    fn scatter(&mut self) {
        let records = &self.scratch.records;
        for (at, record) in records.iter().enumerate() {
            if let Some(soon) = records.get(at + AHEAD) {
                let head = self.levels[soon.level as usize].bricks[soon.slot.brick()].heads[soon.slot.bit()];
                prefetch(self.buckets.get(head));
            }
            let brick = &mut self.levels[record.level as usize].bricks[record.slot.brick()];
            let head = &mut brick.heads[record.slot.bit()];
            *head += u32::from(self.buckets.get(*head).len as usize == LANES);
            let lane = self.buckets.get_mut(*head).put(record.leaf, record.key, &record.aabb);
            self.leaves.set_place_at(record.leaf, Place::new(*head, lane));
        }
        self.scratch.records.clear();
    }
}

impl<K> Record<K> {
    fn new(leaf: u32, key: K, aabb: Aabb3d) -> Self {
        Self {
            aabb,
            key,
            leaf,
            slot: Slot::new(0, 0),
            level: 0,
        }
    }
}

/// The place along a Z-order curve (Morton 1966).
fn along_curve(brick: IVec3) -> u64 {
    let spread = |x: i32| {
        // Not negative: coordinates of bricks have at most 20 bits and a sign.
        let mut x = (x + (1 << 20)) as u64;
        for (shift, kept) in [
            (32, 0x001f_0000_0000_ffff),
            (16, 0x001f_0000_ff00_00ff),
            (8, 0x100f_00f0_0f00_f00f),
            (4, 0x10c3_0c30_c30c_30c3),
            (2, 0x1249_2492_4924_9249),
        ] {
            x = (x | x << shift) & kept;
        }
        x
    };
    spread(brick.x) | spread(brick.y) << 1 | spread(brick.z) << 2
}
