//! Pairs of boxes that touch or are near each other.

use std::{cmp::Ordering, ops::ControlFlow};

use bevy::math::bounding::Aabb3d;

use super::{
    UniformGrid,
    brick::Brick,
    bucket::{Boxes, Bucket},
    level::{Level, bits},
};
use crate::{
    geometry::{
        aabb::{EMPTY, EVERYTHING, union},
        tolerance,
    },
    spatial::simd::{LANES, Simd, Task, dispatch},
};

impl<K: Copy> UniformGrid<K> {
    /// Visits every pair of keys whose boxes are no farther from each other than `distance`, with that distance squared;
    /// each pair once, in no promised order.
    ///
    /// Exactly those whose squared distance, rounded, is not above the square of `distance`, rounded. Pairs that touch have the distance zero.
    pub fn visit_pairs_within(&self, distance: f32, visit: impl FnMut(K, K, f32) -> ControlFlow<()>) {
        let limit = distance * distance;
        if limit >= 0.0 {
            self.search_pairs(Within { limit }, visit);
        }
    }

    pub(super) fn search_pairs<T: PairTest>(&self, test: T, visit: impl FnMut(K, K, f32) -> ControlFlow<()>) {
        // Stopped or not, the search is over.
        let _: ControlFlow<()> = dispatch(Pairs {
            grid: self,
            test,
            visit,
        });
    }
}

/// What makes two boxes a pair.
pub(super) trait PairTest {
    /// A box that all boxes touch that are a pair with one in `aabb`.
    fn around(&self, aabb: &Aabb3d) -> Aabb3d;

    /// The lanes that are a pair with `aabb`, and the distances squared. Those that are not in use may be among them.
    fn pairs<S: Simd>(&self, simd: S, boxes: &Boxes, aabb: &Aabb3d) -> (S::F32s, u32);
}

/// The two have a point in common.
pub(super) struct Touching;

impl PairTest for Touching {
    #[inline(always)]
    fn around(&self, aabb: &Aabb3d) -> Aabb3d {
        *aabb
    }

    #[inline(always)]
    fn pairs<S: Simd>(&self, simd: S, boxes: &Boxes, aabb: &Aabb3d) -> (S::F32s, u32) {
        (simd.splat(0.0), boxes.touching(simd, aabb))
    }
}

/// The squared distance is within a limit.
struct Within {
    limit: f32,
}

impl PairTest for Within {
    #[inline(always)]
    fn around(&self, aabb: &Aabb3d) -> Aabb3d {
        if self.limit == f32::INFINITY {
            return EVERYTHING;
        }
        let reach = self.limit.sqrt() * (1.0 + tolerance::REGION_PLANE) + tolerance::SQUARE_UNDERFLOW;
        Aabb3d {
            min: aabb.min - reach,
            max: aabb.max + reach,
        }
    }

    #[inline(always)]
    fn pairs<S: Simd>(&self, simd: S, boxes: &Boxes, aabb: &Aabb3d) -> (S::F32s, u32) {
        let distances = boxes.distances_squared(simd, aabb);
        (distances, simd.le(distances, simd.splat(self.limit)))
    }
}

struct Pairs<'a, K, T, V> {
    grid: &'a UniformGrid<K>,
    test: T,
    visit: V,
}

impl<K: Copy, T: PairTest, V: FnMut(K, K, f32) -> ControlFlow<()>> Task for Pairs<'_, K, T, V> {
    type Output = ControlFlow<()>;

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) -> ControlFlow<()> {
        let grid = self.grid;
        let mut levels = grid.occupied_levels();
        while let Some(level) = levels.next() {
            for brick in &level.bricks {
                for bit in bits(brick.occupied) {
                    self.visit_cell(simd, level, brick, bit)?;
                }
            }
            // What is larger than the boxes of this level.
            for coarser in levels.clone() {
                for brick in &level.bricks {
                    for bit in bits(brick.occupied) {
                        let head = brick.heads[bit as usize];
                        let around = self.around(head);
                        for (theirs, cells) in coarser.bricks_in(&coarser.cells_touching(&around)) {
                            self.visit_cells(simd, head, &around, theirs, cells)?;
                        }
                    }
                }
            }
        }
        ControlFlow::Continue(())
    }
}

impl<K: Copy, T: PairTest, V: FnMut(K, K, f32) -> ControlFlow<()>> Pairs<'_, K, T, V> {
    /// Visits the pairs within a cell, and with the cells of the level that come after it: so each pair of cells is
    /// looked at from one of them.
    #[inline(always)]
    fn visit_cell<S: Simd>(&mut self, simd: S, level: &Level, brick: &Brick, bit: u32) -> ControlFlow<()> {
        let buckets = &self.grid.buckets;
        let head = brick.heads[bit as usize];
        for ours in buckets.chain(head) {
            for lane in 0..ours.len as usize {
                self.visit_lane(simd, ours, lane, ours, ours.lanes() & !0 << (lane + 1))?;
            }
            for theirs in buckets.chain(ours.next) {
                self.visit_bucket(simd, ours, theirs, theirs.lanes())?;
            }
        }
        let around = self.around(head);
        for (theirs, cells) in level.bricks_in(&level.cells_touching(&around)) {
            let order = theirs.coordinates.to_array().cmp(&brick.coordinates.to_array());
            let after = match order {
                Ordering::Less => 0,
                Ordering::Equal => !1 << bit,
                Ordering::Greater => !0,
            };
            self.visit_cells(simd, head, &around, theirs, cells & after)?;
        }
        ControlFlow::Continue(())
    }

    /// A box that all boxes touch that are a pair with one in the list of buckets.
    #[inline(always)]
    fn around(&self, head: u32) -> Aabb3d {
        let mut all = EMPTY;
        for bucket in self.grid.buckets.chain(head) {
            for lane in 0..bucket.len as usize {
                all = union(&all, &bucket.boxes.get(lane));
            }
        }
        self.test.around(&all)
    }

    /// Visits the pairs of a list of buckets with what is in other cells.
    #[inline(always)]
    fn visit_cells<S: Simd>(
        &mut self,
        simd: S,
        head: u32,
        around: &Aabb3d,
        brick: &Brick,
        cells: u64,
    ) -> ControlFlow<()> {
        let grid = self.grid;
        for theirs in grid.buckets.in_cells(brick, cells) {
            let near = theirs.boxes.touching(simd, around) & theirs.lanes();
            if near != 0 {
                for ours in grid.buckets.chain(head) {
                    self.visit_bucket(simd, ours, theirs, near)?;
                }
            }
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn visit_bucket<S: Simd>(&mut self, simd: S, ours: &Bucket<K>, theirs: &Bucket<K>, lanes: u32) -> ControlFlow<()> {
        for lane in 0..ours.len as usize {
            self.visit_lane(simd, ours, lane, theirs, lanes)?;
        }
        ControlFlow::Continue(())
    }

    /// Visits the pairs of one leaf with some of a bucket.
    #[inline(always)]
    fn visit_lane<S: Simd>(
        &mut self,
        simd: S,
        ours: &Bucket<K>,
        lane: usize,
        theirs: &Bucket<K>,
        lanes: u32,
    ) -> ControlFlow<()> {
        let lane = lane % LANES;
        let (distances, pairs) = self.test.pairs(simd, &theirs.boxes, &ours.boxes.get(lane));
        let pairs = pairs & lanes;
        if pairs != 0 {
            let distances = simd.store(distances);
            for other in bits(pairs.into()) {
                (self.visit)(ours.keys[lane], theirs.keys[other as usize], distances[other as usize])?;
            }
        }
        ControlFlow::Continue(())
    }
}
