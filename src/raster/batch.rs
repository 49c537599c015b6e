//! Many rectangles at once: the tiles that they touch are listed, and then looked at one after the other. Nothing in that
//! loop depends on where one rectangle ends and the next begins, for a branch that a processor guesses wrong takes longer
//! than to look at a tile.

use super::{
    buffer::MaskedDepthBuffer,
    query::{FROM_COLUMN, PixelRect, ROWS, TO_COLUMN, rows},
    tile::{TILE_HEIGHT, TILE_WIDTH},
};
use crate::spatial::simd::{LANES, Simd, prefetch};

/// So many rectangles are looked at together: one bit for each.
const RECTS: usize = 32;

/// A rectangle that touches more tiles is looked at by itself: mostly the first tile decides.
const MOST_TILES: u32 = 16;

/// So many tiles may be on the list; what is written past its end is not read.
const TILES: usize = RECTS * MOST_TILES as usize + LANES;

/// How far ahead a tile is brought close.
const AHEAD: usize = 8;

/// Rectangles that wait to be looked at.
pub(super) struct Batch {
    /// The tiles, with numbers in the tables of pixels, and the rectangle that it is for.
    tiles: [u32; TILES],
    rows: [u32; TILES],
    from: [u32; TILES],
    to: [u32; TILES],
    rects: [u32; TILES],
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
            rows: [0; TILES],
            from: [0; TILES],
            to: [0; TILES],
            rects: [0; TILES],
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
        let from_row = simd.load_bits(&[rows(rect.top % TILE_HEIGHT, 0), 0, 0, 0, 0, 0, 0, 0]);
        let in_rows = simd.store_bits(simd.or(simd.whole(to_row), from_row));
        for column in left..=right {
            let first = top * buffer.tiles_across() + column;
            let tiles = simd.whole(simd.add(simd.splat(first as f32), below));
            let from = if column == left { rect.left % TILE_WIDTH } else { 0 };
            let to = if column == right {
                last_column % TILE_WIDTH
            } else {
                TILE_WIDTH - 1
            };
            let at = self.tile_count..self.tile_count + LANES;
            self.tiles[at.clone()].copy_from_slice(&simd.store_bits(tiles));
            self.rows[at.clone()].copy_from_slice(&in_rows);
            self.from[at.clone()].copy_from_slice(&[from; LANES]);
            self.to[at.clone()].copy_from_slice(&[to; LANES]);
            self.rects[at].copy_from_slice(&[number as u32; LANES]);
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
            if let Some(next) = self
                .tiles
                .get(at + AHEAD)
                .and_then(|&tile| buffer.tiles.get(tile as usize))
            {
                prefetch(next);
            }
            let rect = self.rects[at] as usize % RECTS;
            let columns = simd.and(
                simd.load_bits(&FROM_COLUMN[(self.from[at] % TILE_WIDTH) as usize]),
                simd.load_bits(&TO_COLUMN[(self.to[at] % TILE_WIDTH) as usize]),
            );
            let pixels = simd.and(columns, simd.load_bits(&ROWS[self.rows[at] as usize % ROWS.len()]));
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
