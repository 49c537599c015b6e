//! How large the cells are, and when that is looked at again.

use bevy::math::bounding::Aabb3d;
use smallvec::SmallVec;

use super::{
    CellSize, UniformGrid,
    lattice::{Lattice, power_of_two_from},
    level::{Level, center},
    rebuild::Scratch,
};
use crate::geometry::aabb::{EMPTY, union};

/// How many leaves an occupied cell should hold on average: enough to fill a bucket, for eight are tested at once.
const LEAVES_PER_CELL: usize = 6;

/// The smallest cells are no smaller than the median leaf by this factor, so that leaves somewhat larger are in them too.
const ABOVE_MEDIAN: f32 = 1.5;

/// By how much the median size must have changed for the cell size to be chosen again.
const MEDIAN_CHANGE: f32 = 2.0;

/// By how much the number of leaves per occupied cell must have changed.
const DENSITY_CHANGE: f32 = 4.0;

/// Of how many leaves the median is taken.
const SAMPLED: usize = 256;

/// About how many leaves are looked at to see how many share a cell.
const SAMPLED_IN_CELLS: usize = 1 << 12;

/// The smallest cells are between these.
const BASES: [f32; 2] = [7.888_609e-31, 1.267_650_6e30];

/// No cell is chosen smaller than this fraction of where most leaves are.
const SMALLEST_OF_SPREAD: f32 = 1.0 / (1 << 12) as f32;

/// The quantile that is the median.
const MIDDLE: [usize; 2] = [1, 2];

/// What the cells were chosen for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tuning {
    /// The size of the smallest cells.
    pub base: f32,
    median: f32,
    len: usize,
    /// Leaves per occupied cell of the finest level, as soon as they are in the cells.
    density: Option<f32>,
    /// Since the bounds were last fitted.
    changes: usize,
}

impl Tuning {
    pub fn new(cell_size: CellSize) -> Self {
        let base = match cell_size {
            CellSize::Auto => 1.0,
            CellSize::Fixed(cell) => cell.clamp(BASES[0], BASES[1]),
        };
        Self {
            base,
            median: 0.0,
            len: 0,
            density: None,
            changes: 0,
        }
    }
}

impl<K: Copy> UniformGrid<K> {
    /// The length of the edges of the smallest cells, in the space of the leaves.
    pub fn cell_size(&self) -> f32 {
        self.tuning.base
    }

    /// Takes note of changes. After as many as there are leaves, fits all bounds to the leaves, and chooses the cell size
    /// again if that was chosen for another scene: O(1) per change, amortised.
    pub(super) fn settle(&mut self, changes: usize) {
        self.tuning.changes += changes;
        if self.tuning.changes < self.leaves.len().max(LEAVES_PER_CELL) {
            return;
        }
        if self.is_other_scene() {
            self.gather();
            self.choose_cell_size();
            self.sort();
            self.scratch = Scratch::default();
        } else {
            self.tighten();
        }
    }

    /// The bounds fit all leaves.
    pub(super) fn settled(&mut self) {
        self.tuning.changes = 0;
        self.tuning.density = self.tuning.density.or(Some(self.density()));
    }

    /// Whether the scene is another than that which the cell size was chosen for.
    pub(super) fn is_other_scene(&self) -> bool {
        let (len, chosen) = (self.leaves.len(), &self.tuning);
        if self.settings.cell_size != CellSize::Auto || len == 0 {
            return false;
        }
        let changed = |now: f32, then: f32, factor: f32| now > factor * then || then > factor * now;
        len > 2 * chosen.len
            || 4 * len < chosen.len
            || changed(self.median_size(), chosen.median, MEDIAN_CHANGE)
            || (chosen.density).is_none_or(|density| changed(self.density(), density, DENSITY_CHANGE))
    }

    /// Chooses the cell size for the leaves that were gathered.
    ///
    /// The smallest power of two that is not below the median size of the leaves, times [`ABOVE_MEDIAN`], and with which
    /// an occupied cell holds [`LEAVES_PER_CELL`] on average.
    pub(super) fn choose_cell_size(&mut self) {
        let boxes = || self.scratch.records.iter().map(|record| &record.aabb);
        let len = boxes().len();
        if self.settings.cell_size != CellSize::Auto || len == 0 {
            return;
        }
        let sample = || boxes().step_by(len / SAMPLED + 1);
        let median = quantile(sample().map(size), MIDDLE);
        let world = size(&boxes().fold(EMPTY, |world, aabb| union(&world, aabb))).min(f32::MAX);
        // Points have no size: a small part of where most of them are.
        let spread = (0..3).map(|axis| {
            let along = |part| quantile(sample().map(|aabb| center(aabb)[axis]), part);
            along([7, 8]) - along([1, 8])
        });
        let spread = spread.fold(0.0, f32::max).min(world);
        let least = (ABOVE_MEDIAN * median).max(SMALLEST_OF_SPREAD * spread);
        let mut base = power_of_two_from(least.clamp(BASES[0], BASES[1] / 4.0));
        while base < world && base < BASES[1] && density_in(base, boxes(), len) < LEAVES_PER_CELL as f32 {
            base *= 2.0;
        }
        self.tuning.median = median;
        self.tuning.len = len;
        self.tuning.density = None;
        self.set_base(base);
    }

    fn set_base(&mut self, base: f32) {
        if base != self.tuning.base {
            self.tuning.base = base;
            self.levels.clear();
        }
    }

    /// The median size of a sample of the leaves.
    fn median_size(&self) -> f32 {
        let buckets = &self.buckets.buckets;
        let sampled = buckets
            .iter()
            .step_by(buckets.len() / SAMPLED + 1)
            .filter(|bucket| bucket.len > 0);
        quantile(sampled.map(|bucket| size(&bucket.boxes.get(0))), MIDDLE)
    }

    /// The leaves per occupied cell of the finest level; zero if it is empty.
    fn density(&self) -> f32 {
        self.levels.first().map_or(0.0, |level| {
            let cells: u32 = level.bricks.iter().map(|brick| brick.occupied.count_ones()).sum();
            level.len as f32 / cells.max(1) as f32
        })
    }

    /// Fits all bounds to the leaves.
    fn tighten(&mut self) {
        for level in &mut self.levels {
            level.loosen();
            level.bricks.iter_mut().for_each(|brick| brick.bounds = EMPTY);
        }
        for bucket in self.buckets.buckets.iter().filter(|bucket| bucket.len > 0) {
            let level: &mut Level = &mut self.levels[bucket.level as usize];
            level.cells = level.cells.with(level.cell_in(bucket.slot));
            for lane in 0..bucket.len as usize {
                level.include(bucket.slot, &bucket.boxes.get(lane));
            }
        }
        self.tuning.changes = 0;
    }
}

/// The longest side of a box.
fn size(aabb: &Aabb3d) -> f32 {
    (aabb.max - aabb.min).max_element()
}

/// The quantile of a sample that this fraction of it is below. Zero of nothing.
fn quantile(sample: impl Iterator<Item = f32>, [part, of]: [usize; 2]) -> f32 {
    let mut sample: SmallVec<[f32; SAMPLED]> = sample.take(SAMPLED).collect();
    if sample.is_empty() {
        return 0.0;
    }
    let at = sample.len() * part / of;
    *sample.select_nth_unstable_by(at, f32::total_cmp).1
}

/// About how many boxes an occupied cell of this size holds: counted in a part of the cells that their hashes choose.
fn density_in<'a>(cell: f32, boxes: impl Iterator<Item = &'a Aabb3d>, len: usize) -> f32 {
    let lattice = Lattice::new(cell);
    let part = (len / SAMPLED_IN_CELLS).next_power_of_two() as u64;
    let hashes = boxes.map(|aabb| {
        let [x, y, z] = lattice.cell_at(center(aabb)).to_array().map(|x| x as u64);
        let mixed = (x ^ y.rotate_left(21) ^ z.rotate_left(42)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        mixed ^ mixed >> 32
    });
    let mut chosen: Vec<u64> = hashes.filter(|hash| hash & (part - 1) == 0).collect();
    let leaves = chosen.len();
    chosen.sort_unstable();
    chosen.dedup();
    leaves as f32 / chosen.len().max(1) as f32
}
