//! What is in a cell: buckets of eight boxes with their keys, chained.

use bevy::math::{Vec3A, bounding::Aabb3d};

use super::brick::Brick;
use crate::spatial::simd::{LANES, Simd, prefetch};

/// No bucket.
pub(super) const NONE: u32 = u32::MAX;

/// Eight boxes, axis by axis, lane by lane.
#[derive(Clone, Debug)]
pub(super) struct Boxes {
    pub min: [[f32; LANES]; 3],
    pub max: [[f32; LANES]; 3],
}

impl Boxes {
    pub const ZERO: Self = Self {
        min: [[0.0; LANES]; 3],
        max: [[0.0; LANES]; 3],
    };

    #[inline]
    pub fn get(&self, lane: usize) -> Aabb3d {
        let at = |bounds: &[[f32; LANES]; 3]| Vec3A::new(bounds[0][lane], bounds[1][lane], bounds[2][lane]);
        Aabb3d {
            min: at(&self.min),
            max: at(&self.max),
        }
    }

    #[inline]
    pub fn set(&mut self, lane: usize, aabb: &Aabb3d) {
        let lane = lane % LANES;
        for axis in 0..3 {
            self.min[axis][lane] = aabb.min[axis];
            self.max[axis][lane] = aabb.max[axis];
        }
    }

    /// The lanes whose boxes touch `aabb`.
    #[inline(always)]
    pub fn touching<S: Simd>(&self, simd: S, aabb: &Aabb3d) -> u32 {
        let mut lanes = !0;
        for axis in 0..3 {
            lanes &= simd.le(simd.load(&self.min[axis]), simd.splat(aabb.max[axis]))
                & simd.le(simd.splat(aabb.min[axis]), simd.load(&self.max[axis]));
        }
        lanes
    }

    /// The squared distances from `aabb`, which may be a point: in the order of operations of `distance_squared`.
    #[inline(always)]
    pub fn distances_squared<S: Simd>(&self, simd: S, aabb: &Aabb3d) -> S::F32s {
        let zero = simd.splat(0.0);
        let mut sum = zero;
        for axis in 0..3 {
            let before = simd.sub(simd.load(&self.min[axis]), simd.splat(aabb.max[axis]));
            let behind = simd.sub(simd.splat(aabb.min[axis]), simd.load(&self.max[axis]));
            // Of a NaN the distance is NaN, so that nothing is near it.
            let offset = simd.max(zero, simd.max(before, behind));
            sum = simd.add(sum, simd.mul(offset, offset));
        }
        sum
    }
}

/// Up to eight leaves of one cell, in the first lanes.
#[derive(Clone, Debug)]
pub(super) struct Bucket<K> {
    pub boxes: Boxes,
    pub keys: [K; LANES],
    pub leaves: [u32; LANES],
    /// The next bucket of the cell, which is full; or none.
    pub next: u32,
    /// The cell: its brick, and its number there.
    pub slot: Slot,
    pub level: u8,
    pub len: u8,
}

impl<K> Bucket<K> {
    /// The lanes that are in use.
    #[inline(always)]
    pub fn lanes(&self) -> u32 {
        (1 << self.len) - 1
    }
}

impl<K: Copy> Bucket<K> {
    /// Adds a leaf to a bucket that is not full, and returns its lane.
    #[inline]
    pub fn put(&mut self, leaf: u32, key: K, aabb: &Aabb3d) -> usize {
        let lane = self.len as usize;
        self.set(lane, leaf, key, aabb);
        self.len += 1;
        lane
    }

    #[inline]
    fn set(&mut self, lane: usize, leaf: u32, key: K, aabb: &Aabb3d) {
        let lane = lane % LANES;
        self.boxes.set(lane, aabb);
        self.keys[lane] = key;
        self.leaves[lane] = leaf;
    }
}

/// A cell of a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Slot(u32);

impl Slot {
    #[inline(always)]
    pub fn new(brick: u32, bit: u32) -> Self {
        Self(brick << 6 | bit)
    }

    #[inline(always)]
    pub fn brick(self) -> usize {
        (self.0 >> 6) as usize
    }

    #[inline(always)]
    pub fn bit(self) -> usize {
        (self.0 & 63) as usize
    }
}

/// A lane of a bucket.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place(u32);

impl Place {
    #[inline(always)]
    pub fn new(bucket: u32, lane: usize) -> Self {
        Self(bucket * LANES as u32 + lane as u32)
    }

    #[inline(always)]
    pub fn bucket(self) -> u32 {
        self.0 / LANES as u32
    }

    #[inline(always)]
    pub fn lane(self) -> usize {
        self.0 as usize % LANES
    }
}

/// All buckets of a grid.
///
/// The buckets of a cell form a list. The first alone may be partly filled, and none is empty, so that coming and going
/// touch the first bucket and take the same time however many there are.
#[derive(Clone, Debug)]
pub(super) struct Buckets<K> {
    pub buckets: Vec<Bucket<K>>,
    pub free: Vec<u32>,
}

impl<K> Default for Buckets<K> {
    fn default() -> Self {
        Self {
            buckets: Vec::new(),
            free: Vec::new(),
        }
    }
}

impl<K: Copy> Buckets<K> {
    #[inline(always)]
    pub fn get(&self, bucket: u32) -> &Bucket<K> {
        &self.buckets[bucket as usize]
    }

    #[inline(always)]
    pub fn get_mut(&mut self, bucket: u32) -> &mut Bucket<K> {
        &mut self.buckets[bucket as usize]
    }

    /// The buckets of a list.
    #[inline(always)]
    pub fn chain(&self, head: u32) -> Chain<'_, K> {
        Chain {
            buckets: &self.buckets,
            next: head,
        }
    }

    /// The buckets of some cells of a brick.
    #[inline(always)]
    pub fn in_cells<'a>(&'a self, brick: &'a Brick, cells: u64) -> InCells<'a, K> {
        InCells {
            brick,
            rest: cells,
            chain: self.chain(NONE),
        }
    }

    /// Adds a leaf to the list that begins at `head`.
    #[inline]
    pub fn push(&mut self, head: &mut u32, slot: Slot, level: u8, leaf: u32, key: K, aabb: &Aabb3d) -> Place {
        if *head == NONE || self.get(*head).len as usize == LANES {
            let bucket = Bucket {
                boxes: Boxes::ZERO,
                keys: [key; LANES],
                leaves: [leaf; LANES],
                next: *head,
                slot,
                level,
                len: 0,
            };
            *head = match self.free.pop() {
                Some(free) => {
                    *self.get_mut(free) = bucket;
                    free
                }
                None => {
                    self.buckets.push(bucket);
                    (self.buckets.len() - 1) as u32
                }
            };
        }
        Place::new(*head, self.get_mut(*head).put(leaf, key, aabb))
    }

    /// Removes what is at `place` from the list that begins at `head`. The last leaf of the first bucket takes its
    /// place: returned if that is another.
    #[inline]
    pub fn remove(&mut self, head: &mut u32, place: Place) -> Option<u32> {
        let first = self.get_mut(*head);
        first.len -= 1;
        let last = Place::new(*head, first.len as usize);
        let (aabb, key, leaf) = (
            first.boxes.get(last.lane()),
            first.keys[last.lane()],
            first.leaves[last.lane()],
        );
        if first.len == 0 {
            let next = first.next;
            self.free.push(*head);
            *head = next;
        }
        if place == last {
            return None;
        }
        self.get_mut(place.bucket()).set(place.lane(), leaf, key, &aabb);
        Some(leaf)
    }

    pub fn clear(&mut self) {
        self.buckets.clear();
        self.free.clear();
    }

    pub fn memory(&self) -> usize {
        self.buckets.capacity() * size_of::<Bucket<K>>() + self.free.capacity() * size_of::<u32>()
    }
}

/// See [`Buckets::chain`].
pub(super) struct Chain<'a, K> {
    buckets: &'a [Bucket<K>],
    next: u32,
}

impl<'a, K> Iterator for Chain<'a, K> {
    type Item = &'a Bucket<K>;

    #[inline(always)]
    fn next(&mut self) -> Option<Self::Item> {
        let bucket = self.buckets.get(self.next as usize)?;
        self.next = bucket.next;
        Some(bucket)
    }
}

/// See [`Buckets::in_cells`].
pub(super) struct InCells<'a, K> {
    brick: &'a Brick,
    rest: u64,
    chain: Chain<'a, K>,
}

impl<'a, K> Iterator for InCells<'a, K> {
    type Item = &'a Bucket<K>;

    #[inline(always)]
    fn next(&mut self) -> Option<Self::Item> {
        if self.chain.next == NONE {
            let bit = self.rest.trailing_zeros() as usize;
            self.chain.next = *self.brick.heads.get(bit)?;
            self.rest &= self.rest - 1;
            let after = self.rest.trailing_zeros() as usize % 64;
            if let Some(after) = self.chain.buckets.get(self.brick.heads[after] as usize) {
                prefetch(&after.boxes);
            }
        }
        self.chain.next()
    }
}
