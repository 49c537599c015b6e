//! Morton codes of boxes.

use bevy::math::{Mat3A, Vec3A, bounding::Aabb3d};

use super::tagged_box::BuildItem;
use crate::spatial::simd::LANES;

/// The most bits along one axis: a `f32` of this size has two left for fractions.
const MOST_BITS: u32 = 21;

/// A grid of cubic cells over the centers of boxes, whose cells are numbered along a Z-order curve.
///
/// Along a shorter side of the bounds there are fewer cells, not narrower ones: what is flat is not torn apart by little
/// differences of height. The bits that a short side does not use go to all sides (compare Vinkler, Bittner and Havran,
/// *Extended Morton Codes for High Performance Bounding Volume Hierarchy Construction*, 2017, §3.2).
#[derive(Clone, Copy, Debug)]
pub(super) struct MortonGrid {
    low: Vec3A,
    /// To cells, the longest side first.
    to_cells: Mat3A,
    last_cells: Vec3A,
    /// The bits of the sides in that order, none more than the one before.
    bits: [u32; 3],
}

impl MortonGrid {
    /// A grid over the bounds of [doubled centers](BuildItem::doubled_center), with codes of up to `code_bits`, 31 at
    /// most. `None` if the centers coincide, or are too far apart or too close for a grid.
    pub(super) fn new(centers: &Aabb3d, code_bits: u32) -> Option<Self> {
        let size = centers.max - centers.min;
        let mut axes = [0, 1, 2];
        axes.sort_by(|&a, &b| size[b].total_cmp(&size[a]));
        let longest = size[axes[0]];
        // How many halvings a side is shorter than the longest.
        let shorter = axes.map(|axis| (longest / size[axis]).log2().clamp(0.0, MOST_BITS as f32) as u32);
        let bits_of = |most: u32| shorter.map(|shorter| most.saturating_sub(shorter));
        let bits = (1..=MOST_BITS)
            .map(bits_of)
            .take_while(|bits| bits.iter().sum::<u32>() <= code_bits)
            .last()?;

        let cells_per_length = (1_u32 << bits[0]) as f32 / longest;
        let mut to_cells = Mat3A::ZERO;
        for (row, axis) in axes.into_iter().enumerate() {
            to_cells.col_mut(axis)[row] = cells_per_length;
        }
        let usable = longest < f32::INFINITY && cells_per_length < f32::INFINITY;
        usable.then(|| Self {
            low: centers.min,
            to_cells,
            last_cells: Vec3A::from_array(bits.map(|bits| ((1_u32 << bits) - 1) as f32)),
            bits,
        })
    }

    /// The numbers of the cells that the centers of boxes are in.
    #[inline(always)]
    pub(super) fn codes(&self, items: &[BuildItem; LANES]) -> [u32; LANES] {
        // The sum has no bits left for fractions: its last bits are the number of the cell.
        const NO_FRACTIONS: f32 = (1_u32 << (f32::MANTISSA_DIGITS - 1)) as f32;
        let mut cells = [[0; LANES]; 3];
        for (lane, item) in items.iter().enumerate() {
            let cell = self.to_cells * (item.doubled_center() - self.low);
            let cell = cell.max(Vec3A::ZERO).min(self.last_cells) + Vec3A::splat(NO_FRACTIONS);
            cells[0][lane] = cell.x.to_bits() - NO_FRACTIONS.to_bits();
            cells[1][lane] = cell.y.to_bits() - NO_FRACTIONS.to_bits();
            cells[2][lane] = cell.z.to_bits() - NO_FRACTIONS.to_bits();
        }
        let [_, b_bits, c_bits] = self.bits;
        let low = |value: u32, bits: u32| value & ((1 << bits) - 1);
        let mut codes = [0; LANES];
        for (lane, code) in codes.iter_mut().enumerate() {
            let (a, b, c) = (cells[0][lane], cells[1][lane], cells[2][lane]);
            let in_three = spread_by_3(low(a, c_bits)) << 2 | spread_by_3(low(b, c_bits)) << 1 | spread_by_3(c);
            let in_two = spread_by_2(low(a, b_bits) >> c_bits) << 1 | spread_by_2(b >> c_bits);
            let in_one = a >> b_bits;
            *code = (in_one << (2 * (b_bits - c_bits)) | in_two) << (3 * c_bits) | in_three;
        }
        codes
    }
}

/// Moves each of the eleven lowest bits to three times its place.
#[inline(always)]
fn spread_by_3(mut x: u32) -> u32 {
    x = (x | x << 16) & 0xff00_00ff;
    x = (x | x << 8) & 0x0f00_f00f;
    x = (x | x << 4) & 0xc30c_30c3;
    (x | x << 2) & 0x4924_9249
}

/// Moves each of the sixteen lowest bits to twice its place.
#[inline(always)]
fn spread_by_2(mut x: u32) -> u32 {
    x = (x | x << 8) & 0x00ff_00ff;
    x = (x | x << 4) & 0x0f0f_0f0f;
    x = (x | x << 2) & 0x3333_3333;
    (x | x << 1) & 0x5555_5555
}
