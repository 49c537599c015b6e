//! One level of the hierarchy: a grid of cells of one size.

use bevy::math::{IVec3, Vec3A, bounding::Aabb3d};

use super::{
    brick::{Brick, BrickTable},
    bucket::Slot,
    lattice::{CellRange, Lattice, bit_of, brick_of, cell_of},
};
use crate::geometry::aabb::{EMPTY, union};

/// The leaves of one size class, each in the cell that its centre is in.
///
/// `bounds`, `cells` and `reach` never shrink while leaves move: [`tighten`](super::tune) fits them from time to time.
#[derive(Clone, Debug)]
pub(super) struct Level {
    pub lattice: Lattice,
    pub bricks: Vec<Brick>,
    pub free: Vec<u32>,
    pub table: BrickTable,
    /// The number of leaves.
    pub len: usize,
    /// A box around all boxes.
    pub bounds: Aabb3d,
    /// All cells that hold leaves are among these.
    pub cells: CellRange,
    /// No box reaches farther from its centre.
    pub reach: Vec3A,
}

impl Level {
    pub fn new(cell: f32) -> Self {
        Self {
            lattice: Lattice::new(cell),
            bricks: Vec::new(),
            free: Vec::new(),
            table: BrickTable::default(),
            len: 0,
            bounds: EMPTY,
            cells: CellRange::EMPTY,
            reach: Vec3A::ZERO,
        }
    }

    /// The cell of a box.
    #[inline(always)]
    pub fn cell_for(&self, aabb: &Aabb3d) -> IVec3 {
        self.lattice.cell_at(center(aabb))
    }

    /// The cells in which the centres of boxes may be that touch `aabb`.
    #[inline(always)]
    pub fn cells_touching(&self, aabb: &Aabb3d) -> CellRange {
        let range = self.lattice.reaching(aabb.min, aabb.max, self.reach);
        range.clipped(&self.cells)
    }

    /// The cell with this slot.
    #[inline(always)]
    pub fn cell_in(&self, slot: Slot) -> IVec3 {
        cell_of(self.bricks[slot.brick()].coordinates, slot.bit() as u32)
    }

    /// The slot of a cell, whose brick is made if there is none.
    pub fn occupy(&mut self, cell: IVec3) -> Slot {
        let coordinates = brick_of(cell);
        let brick = self.table.find(coordinates).unwrap_or_else(|| {
            let brick = Brick::new(coordinates);
            let index = match self.free.pop() {
                Some(free) => {
                    self.bricks[free as usize] = brick;
                    free
                }
                None => {
                    self.bricks.push(brick);
                    (self.bricks.len() - 1) as u32
                }
            };
            self.table.insert(coordinates, index);
            index
        });
        self.cells = self.cells.with(cell);
        let bit = bit_of(cell);
        self.bricks[brick as usize].occupied |= 1 << bit;
        Slot::new(brick, bit)
    }

    /// Has all bounds include a box that is stored in this slot.
    #[inline(always)]
    pub fn include(&mut self, slot: Slot, aabb: &Aabb3d) {
        let brick = &mut self.bricks[slot.brick()];
        brick.bounds = union(&brick.bounds, aabb);
        self.bounds = union(&self.bounds, aabb);
        self.reach = self.reach.max(reach(aabb));
    }

    /// Gives up a cell that holds nothing any more, and its brick with the last of its cells.
    pub fn vacate(&mut self, slot: Slot) {
        let brick = &mut self.bricks[slot.brick()];
        brick.occupied &= !(1 << slot.bit());
        if brick.occupied == 0 {
            self.table.remove(brick.coordinates);
            self.free.push(slot.brick() as u32);
        }
    }

    /// Removes everything, and keeps the memory.
    pub fn clear(&mut self) {
        self.bricks.clear();
        self.free.clear();
        self.table.clear();
        self.len = 0;
        self.loosen();
    }

    /// Fits the bounds to no leaf.
    pub fn loosen(&mut self) {
        self.bounds = EMPTY;
        self.cells = CellRange::EMPTY;
        self.reach = Vec3A::ZERO;
    }

    /// Every brick with occupied cells in the range, with those cells, bit by bit.
    ///
    /// Looks up the bricks of the range, or goes through all that there are if those are fewer: a range may be vast.
    #[inline(always)]
    pub fn bricks_in(&self, range: &CellRange) -> BricksIn<'_> {
        let bricks = if range.is_empty() {
            CellRange::EMPTY
        } else {
            range.bricks()
        };
        let is_vast = bricks.count() > self.bricks.len() as u64;
        BricksIn {
            level: self,
            range: *range,
            next: if is_vast { IVec3::ZERO } else { bricks.min },
            bricks,
            is_vast,
        }
    }

    pub fn memory(&self) -> usize {
        self.bricks.capacity() * size_of::<Brick>() + self.free.capacity() * size_of::<u32>() + self.table.memory()
    }
}

/// The point that decides on the cell of a box. Need not be the exact centre, for [`reach`] is measured from it.
#[inline(always)]
pub(super) fn center(aabb: &Aabb3d) -> Vec3A {
    aabb.min * 0.5 + aabb.max * 0.5
}

/// How far a box reaches from its [`center`], rounded up.
#[inline(always)]
pub(super) fn reach(aabb: &Aabb3d) -> Vec3A {
    let center = center(aabb);
    // Twice the rounding of the difference, which is exact where the product is not.
    (center - aabb.min).max(aabb.max - center) * (1.0 + f32::EPSILON)
}

/// See [`Level::bricks_in`].
pub(super) struct BricksIn<'a> {
    level: &'a Level,
    range: CellRange,
    bricks: CellRange,
    /// The brick that is looked up next; or its index, along x.
    next: IVec3,
    is_vast: bool,
}

impl<'a> Iterator for BricksIn<'a> {
    type Item = (&'a Brick, u64);

    #[inline(always)]
    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let brick = if self.is_vast {
                let index = self.next.x as usize;
                self.next.x += 1;
                Some(self.level.bricks.get(index)?)
            } else {
                if self.next.z > self.bricks.max.z {
                    return None;
                }
                let index = self.level.table.find(self.next);
                self.step();
                index.map(|index| &self.level.bricks[index as usize])
            };
            if let Some(brick) = brick {
                let cells = brick.occupied & self.range.bits_in(brick.coordinates);
                if cells != 0 {
                    return Some((brick, cells));
                }
            }
        }
    }
}

impl BricksIn<'_> {
    #[inline(always)]
    fn step(&mut self) {
        self.next.x += 1;
        if self.next.x > self.bricks.max.x {
            self.next.x = self.bricks.min.x;
            self.next.y += 1;
            if self.next.y > self.bricks.max.y {
                self.next.y = self.bricks.min.y;
                self.next.z += 1;
            }
        }
    }
}

/// The numbers of the bits that are set.
#[inline(always)]
pub(super) fn bits(set: u64) -> Bits {
    Bits(set)
}

/// See [`bits`].
pub(super) struct Bits(u64);

impl Iterator for Bits {
    type Item = u32;

    #[inline(always)]
    fn next(&mut self) -> Option<u32> {
        let bit = self.0.trailing_zeros();
        self.0 &= self.0.wrapping_sub(1);
        (bit < 64).then_some(bit)
    }
}
