//! From lines to pixels: the scanline loop that everything is drawn by.

use std::ops::Range;

use crate::spatial::simd::{LANES, Simd};

use super::{
    canvas::Band,
    tile::{ROWS, TILE_HEIGHT, TILE_WIDTH},
};

/// A bound of a region: beyond it, row by row.
///
/// In row `r` a left bound begins the region at the least pixel that is no less than `x + slope * (r - y)`; a right
/// bound ends it there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub x: f32,
    pub y: f32,
    pub slope: f32,
    /// Added for the left bound: 0, or far to the left if it is none.
    pub as_left: f32,
    /// Added for the right bound: 0, or far to the right if it is none.
    pub as_right: f32,
}

impl Line {
    /// Farther than every line gets, and so far that rounding does not bring it back.
    const FAR: f32 = 1e30;

    pub const NO_LEFT: f32 = -Self::FAR;
    pub const NO_RIGHT: f32 = Self::FAR;

    pub fn left(x: f32, y: f32, slope: f32) -> Self {
        Self {
            x,
            y,
            slope,
            as_left: 0.0,
            as_right: Self::NO_RIGHT,
        }
    }

    pub fn right(x: f32, y: f32, slope: f32) -> Self {
        Self {
            x,
            y,
            slope,
            as_left: Self::NO_LEFT,
            as_right: 0.0,
        }
    }
}

/// Pixels of the screen: those of a rectangle that lie within all lines.
#[derive(Clone, Debug)]
pub(super) struct Region<'a> {
    pub lines: &'a [Line],
    pub rows: Range<u32>,
    pub columns: Range<u32>,
}

/// What is done with the pixels of a region, tile by tile.
pub(super) trait Brush {
    /// Is given the number of a tile of its band, where it begins in pixels, and which of its pixels are in the region: at
    /// least one.
    fn paint<S: Simd>(&mut self, simd: S, tile: usize, left: f32, top: f32, pixels: S::U32s);
}

/// Paints what of a region is in a band.
#[inline(always)]
pub(super) fn fill<S: Simd, B: Brush>(simd: S, region: &Region, band: &Band, brush: &mut B) {
    let Region { lines, rows, columns } = region;
    let in_band = band.rows();
    let rows = rows.start.max(in_band.start)..rows.end.min(in_band.end);
    if rows.is_empty() || columns.is_empty() {
        return;
    }
    let (first_row, end_row) = (simd.splat(rows.start as f32 - 0.5), simd.splat(rows.end as f32 - 0.5));
    let none = simd.splat_bits(0);
    for tile_y in rows.start / TILE_HEIGHT..=(rows.end - 1) / TILE_HEIGHT {
        let top = (tile_y * TILE_HEIGHT) as f32;
        let y = simd.add(simd.load(&ROWS), simd.splat(top));
        let mut left = simd.splat(columns.start as f32);
        let mut right = simd.splat(columns.end as f32);
        for line in *lines {
            let x = simd.add(
                simd.mul(simd.sub(y, simd.splat(line.y)), simd.splat(line.slope)),
                simd.splat(line.x),
            );
            left = simd.max(simd.add(x, simd.splat(line.as_left)), left);
            right = simd.min(simd.add(x, simd.splat(line.as_right)), right);
        }
        let (left, right) = (simd.ceil(left), simd.ceil(right));
        let in_rows = simd.and(simd.lt_lanes(first_row, y), simd.lt_lanes(y, end_row));

        let (mut begin, mut end) = (columns.start, columns.end);
        if end - begin > 2 * TILE_WIDTH {
            // What is slanted leaves most of its rectangle empty.
            let (lefts, rights) = (simd.store(left), simd.store(right));
            let (mut least, mut greatest) = (columns.end as f32, columns.start as f32);
            for lane in 0..LANES {
                if lefts[lane] < rights[lane] && rows.contains(&(tile_y * TILE_HEIGHT + lane as u32)) {
                    least = least.min(lefts[lane]);
                    greatest = greatest.max(rights[lane]);
                }
            }
            if least >= greatest {
                continue;
            }
            (begin, end) = (least as u32, greatest as u32);
        }
        for tile_x in begin / TILE_WIDTH..=(end - 1) / TILE_WIDTH {
            let tile_left = (tile_x * TILE_WIDTH) as f32;
            let before = simd.low_bits(simd.sub(left, simd.splat(tile_left)));
            let until = simd.low_bits(simd.sub(right, simd.splat(tile_left)));
            let pixels = simd.and(simd.and_not(until, before), in_rows);
            if simd.high_bits(simd.eq_bits(pixels, none)) == 0xff {
                continue;
            }
            let tile = ((tile_y - band.tile_rows.start) * band.tiles_across + tile_x) as usize;
            brush.paint(simd, tile, tile_left, top, simd.blocks_of_rows(pixels));
        }
    }
}
