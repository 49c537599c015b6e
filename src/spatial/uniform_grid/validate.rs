//! What must hold between any two calls.

use bevy::math::bounding::Aabb3d;

use super::{
    UniformGrid,
    bucket::{Bucket, Place, Slot},
    level::{Level, bits, reach},
};
use crate::{
    geometry::aabb::Aabb3dExt,
    spatial::{SpatialQueries, simd::LANES},
};

/// An invariant of the grid that does not hold: a bug in this crate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BrokenInvariant {
    /// A leaf is not where its place says.
    #[error("leaf {0} is not at its place")]
    WrongPlace(u32),
    /// A leaf is in another cell than that of its box.
    #[error("leaf {0} is in the wrong cell")]
    WrongCell(u32),
    /// A stored box is not sound.
    #[error("the box of leaf {0} is not sound")]
    UnsoundBox(u32),
    /// The bounds of a brick or of a level do not include a box.
    #[error("leaf {0} is beyond the bounds of its brick or its level")]
    OutOfBounds(u32),
    /// A bucket is empty, or not full and not the first of its cell.
    #[error("bucket {0} is not as full as it should be")]
    Sparse(u32),
    /// A bucket is in the list of another cell than it says.
    #[error("bucket {0} is in the list of another cell")]
    WrongList(u32),
    /// A brick says that a cell is occupied which is empty, or the other way round.
    #[error("brick {brick} of level {level} is wrong about its cells")]
    WrongMask {
        /// The level of the brick.
        level: u32,
        /// The index of the brick.
        brick: u32,
    },
    /// A brick is not found by its coordinates, or one that is free is.
    #[error("the table of level {0} does not match its bricks")]
    WrongTable(u32),
    /// A level says that it has leaves but has none, or counts them wrong.
    #[error("level {0} miscounts its leaves")]
    WrongCount(u32),
    /// What is in use and what is free is not all there is.
    #[error("some leaves, buckets or bricks are neither in use nor free, or both")]
    Lost,
}

impl<K: Copy> UniformGrid<K> {
    /// Checks every invariant, in O(n).
    ///
    /// # Errors
    ///
    /// The first invariant that does not hold.
    pub fn validate(&self) -> Result<(), BrokenInvariant> {
        let (mut leaves, mut buckets) = (0, 0);
        for (number, level) in (0..).zip(&self.levels) {
            let (leaves_in, buckets_in) = self.validate_level(number, level)?;
            let is_marked = self.occupied >> number & 1 == 1;
            if leaves_in != level.len || is_marked != (leaves_in > 0) {
                return Err(BrokenInvariant::WrongCount(number.into()));
            }
            leaves += leaves_in;
            buckets += buckets_in;
        }
        let is_all = leaves == self.len()
            && buckets + self.buckets.free.len() == self.buckets.buckets.len()
            && self.leaves.is_whole()
            && self.buckets.free.iter().all(|&free| self.buckets.get(free).len == 0);
        if is_all { Ok(()) } else { Err(BrokenInvariant::Lost) }
    }

    /// Returns the numbers of leaves and buckets.
    fn validate_level(&self, number: u8, level: &Level) -> Result<(usize, usize), BrokenInvariant> {
        let (mut leaves, mut buckets, mut in_use) = (0, 0, 0);
        for (index, brick) in (0..).zip(&level.bricks) {
            let wrong_mask = BrokenInvariant::WrongMask {
                level: number.into(),
                brick: index,
            };
            let is_found = level.table.find(brick.coordinates) == Some(index);
            if is_found != (brick.occupied != 0) {
                return Err(BrokenInvariant::WrongTable(number.into()));
            }
            in_use += usize::from(is_found);
            for bit in bits(brick.occupied) {
                let slot = Slot::new(index, bit);
                let mut at = brick.heads[bit as usize];
                if self.buckets.buckets.get(at as usize).is_none() {
                    return Err(wrong_mask);
                }
                let mut is_first = true;
                while let Some(bucket) = self.buckets.buckets.get(at as usize) {
                    self.validate_bucket(at, bucket, level)?;
                    if bucket.slot != slot || bucket.level != number {
                        return Err(BrokenInvariant::WrongList(at));
                    }
                    if !is_first && (bucket.len as usize) < LANES || buckets >= self.buckets.buckets.len() {
                        return Err(BrokenInvariant::Sparse(at));
                    }
                    leaves += bucket.len as usize;
                    buckets += 1;
                    is_first = false;
                    at = bucket.next;
                }
            }
        }
        if in_use != level.table.len() || in_use + level.free.len() != level.bricks.len() {
            return Err(BrokenInvariant::WrongTable(number.into()));
        }
        Ok((leaves, buckets))
    }

    fn validate_bucket(&self, at: u32, bucket: &Bucket<K>, level: &Level) -> Result<(), BrokenInvariant> {
        if bucket.len == 0 || bucket.len as usize > LANES {
            return Err(BrokenInvariant::Sparse(at));
        }
        let cell = level.cell_in(bucket.slot);
        let brick = &level.bricks[bucket.slot.brick()];
        for lane in 0..bucket.len as usize {
            let (leaf, aabb) = (bucket.leaves[lane], bucket.boxes.get(lane));
            if !aabb.is_sound() {
                return Err(BrokenInvariant::UnsoundBox(leaf));
            }
            if !self.leaves.is_live(leaf) || self.leaves.place_at(leaf) != Place::new(at, lane) {
                return Err(BrokenInvariant::WrongPlace(leaf));
            }
            if self.level_for(&aabb) != bucket.level as usize || level.cell_for(&aabb) != cell {
                return Err(BrokenInvariant::WrongCell(leaf));
            }
            let is_within = |bounds: &Aabb3d| bounds.min.cmple(aabb.min).all() && bounds.max.cmpge(aabb.max).all();
            let is_reached = reach(&aabb).cmple(level.reach).all() && level.cells.contains(cell);
            if !is_within(&brick.bounds) || !is_within(&level.bounds) || !is_reached {
                return Err(BrokenInvariant::OutOfBounds(leaf));
            }
        }
        Ok(())
    }
}
