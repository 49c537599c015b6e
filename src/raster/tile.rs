//! Tiles of 32×8 pixels, each of eight blocks of 8×4.

use crate::spatial::simd::{LANES, Simd};

/// The pixels of a tile, across and down.
pub(super) const TILE_WIDTH: u32 = 32;
pub(super) const TILE_HEIGHT: u32 = 8;

/// The pixels of a block, across and down.
pub(super) const BLOCK_WIDTH: u32 = 8;
pub(super) const BLOCK_HEIGHT: u32 = 4;

const _: () = assert!(TILE_WIDTH * TILE_HEIGHT == BLOCK_WIDTH * BLOCK_HEIGHT * LANES as u32);

/// Where the blocks of a tile begin, in pixels from its own corner.
pub(super) const BLOCK_LEFT: [f32; LANES] = [0.0, 8.0, 16.0, 24.0, 0.0, 8.0, 16.0, 24.0];
pub(super) const BLOCK_TOP: [f32; LANES] = [0.0, 0.0, 0.0, 0.0, 4.0, 4.0, 4.0, 4.0];

/// The rows of a tile.
pub(super) const ROWS: [f32; LANES] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

/// The depth of what nothing has been drawn to: farther than all that is drawn or tested.
pub(super) const NOTHING: f32 = -1.0;

/// What is known of a tile: all pixels of a block are at least as near as `depth`, those of the first mask at least as
/// near as the first of the masked depths, and those of the second, which has no others, as the second, which is no
/// farther. Bit `8 * row + column` of a mask is for a pixel of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub(super) struct Tile {
    depth: [f32; LANES],
    masked_depths: [[f32; LANES]; 2],
    masks: [[u32; LANES]; 2],
}

impl Tile {
    pub const EMPTY: Self = Self {
        depth: [NOTHING; LANES],
        masked_depths: [[NOTHING; LANES]; 2],
        masks: [[0; LANES]; 2],
    };

    /// Draws what covers these pixels and is nowhere farther than `depth`, block by block.
    ///
    /// It is one more level between those that are there, which takes part in all that are farther. That makes three
    /// masked levels; of those the one goes that is nearest before the next, so that least is lost. A level whose mask is
    /// full is what is known of the whole block. One masked level, and the choice between two, is Hasselgren et al. 2016,
    /// §3.2.
    #[inline(always)]
    pub fn draw<S: Simd>(&mut self, simd: S, covered: S::U32s, depth: S::F32s) {
        let base = simd.load(&self.depth);
        let none = simd.splat_bits(0);
        // What is no nearer than all that is known already says nothing.
        let covered = simd.and(covered, simd.lt_lanes(base, depth));
        let untouched = simd.eq_bits(covered, none);
        if simd.high_bits(untouched) == 0xff {
            return;
        }
        let all = simd.splat_bits(u32::MAX);
        let (near, nearer) = (simd.load(&self.masked_depths[0]), simd.load(&self.masked_depths[1]));
        let (near_mask, nearer_mask) = (simd.load_bits(&self.masks[0]), simd.load_bits(&self.masks[1]));
        // What is not covered has no part in any level.
        let depth = simd.blend(untouched, base, depth);

        let is_before_near = simd.lt_lanes(near, depth);
        let is_before_nearer = simd.lt_lanes(nearer, depth);
        let levels = [
            simd.min(depth, near),
            simd.max(simd.min(depth, nearer), near),
            simd.max(depth, nearer),
        ];
        let masks = [
            simd.or(near_mask, covered),
            simd.select_bits(is_before_near, simd.or(nearer_mask, covered), near_mask),
            simd.select_bits(is_before_nearer, covered, nearer_mask),
        ];
        let gaps = [
            simd.sub(levels[0], base),
            simd.sub(levels[1], levels[0]),
            simd.sub(levels[2], levels[1]),
        ];
        let keeps_first = simd.lt_lanes(simd.min(gaps[1], gaps[2]), gaps[0]);
        let keeps_second = simd.lt_lanes(gaps[2], gaps[1]);
        let keeps_third = simd.and_not(all, simd.and(keeps_first, keeps_second));
        let near = simd.blend(keeps_first, levels[0], levels[1]);
        let near_mask = simd.select_bits(keeps_first, masks[0], masks[1]);
        let nearer = simd.blend(keeps_third, levels[2], levels[1]);
        let nearer_mask = simd.select_bits(keeps_third, masks[2], masks[1]);

        let is_full = simd.eq_bits(near_mask, all);
        let is_all_full = simd.eq_bits(nearer_mask, all);
        let base = simd.blend(is_full, near, base);
        let near = simd.blend(is_full, nearer, near);
        let near_mask = simd.select_bits(is_full, nearer_mask, near_mask);
        let base = simd.blend(is_all_full, nearer, base);
        self.depth = simd.store(base);
        self.masked_depths = [simd.store(near), simd.store(nearer)];
        self.masks = [simd.store_bits(near_mask), simd.store_bits(nearer_mask)];
    }

    /// Whether something at `depth` can be seen in any of these pixels.
    #[inline(always)]
    pub fn shows<S: Simd>(&self, simd: S, pixels: S::U32s, depth: S::F32s) -> bool {
        let mut hidden = simd.lt_lanes(depth, simd.load(&self.depth));
        for (mask, masked_depth) in self.masks.iter().zip(&self.masked_depths) {
            let is_behind = simd.lt_lanes(depth, simd.load(masked_depth));
            hidden = simd.or(hidden, simd.and(simd.load_bits(mask), is_behind));
        }
        let shown = simd.and_not(pixels, hidden);
        simd.high_bits(simd.eq_bits(shown, simd.splat_bits(0))) != 0xff
    }

    /// The depth that is known of a pixel.
    pub fn depth_at(&self, column: u32, row: u32) -> f32 {
        let block = (row / BLOCK_HEIGHT * (TILE_WIDTH / BLOCK_WIDTH) + column / BLOCK_WIDTH) as usize;
        let bit = row % BLOCK_HEIGHT * BLOCK_WIDTH + column % BLOCK_WIDTH;
        let masked = self.masks.iter().zip(&self.masked_depths);
        let masked = masked.filter(|(mask, _)| mask[block] >> bit & 1 != 0);
        masked.fold(self.depth[block], |depth, (_, masked_depth)| {
            depth.max(masked_depth[block])
        })
    }
}
