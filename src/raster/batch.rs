//! Many rectangles at once: the tiles that they touch are listed, and then looked at one after the other. Nothing in that
//! loop depends on where one rectangle ends and the next begins, for a branch that a processor guesses wrong takes longer
//! than to look at a tile.

use super::{
    buffer::MaskedDepthBuffer,
    query::{FROM_COLUMN, PixelRect, ROWS, TO_COLUMN, rows},
    tile::{TILE_HEIGHT, TILE_WIDTH},
};
use crate::spatial::simd::{LANES, Simd};

/// So many rectangles are looked at together: one bit for each.
const RECTS: usize = 32;

/// A rectangle that touches more tiles is looked at by itself: mostly the first tile decides.
const MOST_TILES: u32 = 16;

/// So many tiles may be on the list; what is written past its end is not read.
const TILES: usize = RECTS * MOST_TILES as usize + LANES;

/// Rectangles that wait to be looked at.
pub(super) struct Batch {
    /// The tiles, and of each [which pixels](window) of it are in which rectangle.
    tiles: [u32; TILES],
    windows: [u32; TILES],
    tile_count: usize,
    nearest: [f32; RECTS],
    count: usize,
    /// Those of which it is known already that something of them can be seen.
    shown: u32,
}

impl Batch {
    pub fn new() -> Self {
        Self {
            tiles: [0; TILES],
            windows: [0; TILES],
            tile_count: 0,
            nearest: [0.0; RECTS],
            count: 0,
            shown: 0,
        }
    }

    pub fn is_full(&self) -> bool {
        self.count == RECTS
    }

    /// Lists the tiles of one more rectangle. There must be room.
    #[inline(always)]
    pub fn add<S: Simd>(&mut self, simd: S, buffer: &MaskedDepthBuffer, rect: &PixelRect) {
        let number = self.count;
        self.count += 1;
        if rect.is_empty() {
            return;
        }
        self.nearest[number] = rect.nearest_drawn();
        let (last_column, last_row) = (rect.right - 1, rect.bottom - 1);
        let (left, right) = (rect.left / TILE_WIDTH, last_column / TILE_WIDTH);
        let (top, bottom) = (rect.top / TILE_HEIGHT, last_row / TILE_HEIGHT);
        let (across, down) = (right - left + 1, bottom - top + 1);
        if down > LANES as u32 || across * down > MOST_TILES {
            self.shown |= u32::from(buffer.shows(simd, rect)) << number;
            return;
        }
        // Of each column of tiles all rows at once; numbers of tiles are small enough to be exact.
        let steps = simd.load(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        let below = simd.mul(steps, simd.splat(buffer.tiles_across() as f32));
        let height = simd.splat(TILE_HEIGHT as f32);
        let to_row = simd.sub(
            simd.splat((last_row - top * TILE_HEIGHT) as f32),
            simd.mul(steps, height),
        );
        let to_row = simd.min(simd.max(to_row, simd.splat(0.0)), simd.splat((TILE_HEIGHT - 1) as f32));
        let from_row = window(0, 0, rows(rect.top % TILE_HEIGHT, 0), 0) as f32;
        let from_row = simd.load(&[from_row, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let in_rows = simd.add(simd.mul(to_row, simd.splat(window(0, 0, 1, 0) as f32)), from_row);
        for column in left..=right {
            let first = top * buffer.tiles_across() + column;
            let tiles = simd.whole(simd.add(simd.splat(first as f32), below));
            let from = if column == left { rect.left % TILE_WIDTH } else { 0 };
            let to = if column == right {
                last_column % TILE_WIDTH
            } else {
                TILE_WIDTH - 1
            };
            let in_columns = simd.splat(window(from, to, 0, number as u32) as f32);
            let windows = simd.whole(simd.add(in_rows, in_columns));
            let at = self.tile_count..self.tile_count + LANES;
            self.tiles[at.clone()].copy_from_slice(&simd.store_bits(tiles));
            self.windows[at].copy_from_slice(&simd.store_bits(windows));
            self.tile_count += down as usize;
        }
    }

    /// Looks at all that wait, of which the first has this number, and tells which can be seen. Returns how many they were.
    #[inline(always)]
    pub fn tell<S: Simd>(
        &mut self,
        simd: S,
        buffer: &MaskedDepthBuffer,
        first: usize,
        visit: &mut impl FnMut(usize),
    ) -> usize {
        let mut shown = self.shown;
        for at in 0..self.tile_count {
            let [from, to, rows, rect] = parts(self.windows[at]);
            let columns = simd.and(simd.load_bits(&FROM_COLUMN[from]), simd.load_bits(&TO_COLUMN[to]));
            let pixels = simd.and(columns, simd.load_bits(&ROWS[rows]));
            let tile = &buffer.tiles[self.tiles[at] as usize];
            let is_shown = tile.shows(simd, pixels, simd.splat(self.nearest[rect]));
            shown |= u32::from(is_shown) << rect;
        }
        while shown != 0 {
            visit(first + shown.trailing_zeros() as usize);
            shown &= shown - 1;
        }
        (self.tile_count, self.shown) = (0, 0);
        std::mem::take(&mut self.count)
    }
}

/// The columns of a tile from one to another, with the number of its rows, that are in a rectangle: as one number, which is
/// the sum of those of its parts, and exact as `f32`.
const fn window(from: u32, to: u32, rows: u32, rect: u32) -> u32 {
    from + (to << 5) + (rows << 10) + (rect << 16)
}

/// The parts of a [`window`].
#[inline(always)]
fn parts(window: u32) -> [usize; 4] {
    const {
        assert!(TILE_WIDTH == 1 << 5 && ROWS.len() == 1 << 6 && RECTS == 1 << 5);
    }
    let part = |shift: u32, len: usize| (window >> shift) as usize % len;
    [
        part(0, TILE_WIDTH as usize),
        part(5, TILE_WIDTH as usize),
        part(10, ROWS.len()),
        part(16, RECTS),
    ]
}
