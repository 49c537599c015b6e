//! Tiles of 32×8 pixels, each of eight blocks of 8×4.

use crate::spatial::simd::{LANES, Simd};

/// The pixels of a tile, across and down.
pub(super) const TILE_WIDTH: u32 = 32;
pub(super) const TILE_HEIGHT: u32 = 8;

/// The pixels of a block, across and down.
pub(super) const BLOCK_WIDTH: u32 = 8;
pub(super) const BLOCK_HEIGHT: u32 = 4;

/// Where the blocks of a tile begin, in pixels from its own corner.
pub(super) const BLOCK_LEFT: [f32; LANES] = [0.0, 8.0, 16.0, 24.0, 0.0, 8.0, 16.0, 24.0];
pub(super) const BLOCK_TOP: [f32; LANES] = [0.0, 0.0, 0.0, 0.0, 4.0, 4.0, 4.0, 4.0];

/// The rows of a tile.
pub(super) const ROWS: [f32; LANES] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

/// The depth of what nothing has been drawn to: farther than all that is drawn or tested.
pub(super) const NOTHING: f32 = -1.0;

/// What is known of a tile: all pixels of a block are at least as near as `depth`, and those of the mask, of which bit
/// `8 * row + column` is for a pixel, at least as near as `masked_depth`, which is nearer.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct Tile {
    pub depth: [f32; LANES],
    pub masked_depth: [f32; LANES],
    pub mask: [u32; LANES],
}

impl Tile {
    pub const EMPTY: Self = Self {
        depth: [NOTHING; LANES],
        masked_depth: [NOTHING; LANES],
        mask: [0; LANES],
    };

    /// Draws what covers these pixels and is nowhere farther than `depth`, block by block.
    ///
    /// The second layer takes up what comes until it is full, and then becomes the first. It is begun anew by what lies
    /// so far in front of it that the two would make a bad layer (Hasselgren et al. 2016, §3.2).
    #[inline(always)]
    pub fn draw<S: Simd>(&mut self, simd: S, covered: S::U32s, depth: S::F32s) {
        let old_depth = simd.load(&self.depth);
        let old_masked = simd.load(&self.masked_depth);
        let old_mask = simd.load_bits(&self.mask);
        let none = simd.splat_bits(0);
        let all = simd.splat_bits(u32::MAX);

        // What is no nearer than all that is known already says nothing.
        let covered = simd.and(covered, simd.lt_lanes(old_depth, depth));
        let untouched = simd.eq_bits(covered, none);
        if simd.high_bits(untouched) == 0xff {
            return;
        }
        let is_far_ahead = simd.lt_lanes(simd.add(old_masked, old_masked), simd.add(depth, old_depth));
        let begins = simd.or(
            simd.or(simd.eq_bits(old_mask, none), simd.eq_bits(covered, all)),
            is_far_ahead,
        );
        let mask = simd.or(simd.and_not(old_mask, begins), covered);
        let masked = simd.blend(begins, depth, simd.min(old_masked, depth));
        let is_full = simd.and_not(simd.eq_bits(mask, all), untouched);

        let mask = simd.or(
            simd.and_not(simd.and_not(mask, is_full), untouched),
            simd.and(old_mask, untouched),
        );
        self.mask = simd.store_bits(mask);
        self.depth = simd.store(simd.blend(is_full, masked, old_depth));
        self.masked_depth = simd.store(simd.blend(untouched, old_masked, masked));
    }

    /// Whether something at `depth` can be seen in any of these pixels.
    #[inline(always)]
    pub fn shows<S: Simd>(&self, simd: S, pixels: S::U32s, depth: S::F32s) -> bool {
        let mask = simd.load_bits(&self.mask);
        let none = simd.splat_bits(0);
        let behind_all = simd.lt_lanes(depth, simd.load(&self.depth));
        let behind_masked = simd.and(mask, simd.lt_lanes(depth, simd.load(&self.masked_depth)));
        let shown = simd.and_not(simd.and_not(pixels, behind_all), behind_masked);
        simd.high_bits(simd.eq_bits(shown, none)) != 0xff
    }

    /// The depth that is known of a pixel.
    pub fn depth_at(&self, column: u32, row: u32) -> f32 {
        let block = (row / BLOCK_HEIGHT * (TILE_WIDTH / BLOCK_WIDTH) + column / BLOCK_WIDTH) as usize;
        let bit = row % BLOCK_HEIGHT * BLOCK_WIDTH + column % BLOCK_WIDTH;
        if self.mask[block] >> bit & 1 != 0 {
            self.masked_depth[block]
        } else {
            self.depth[block]
        }
    }
}
