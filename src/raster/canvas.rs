//! What is drawn to: all of a screen, or bands of it that threads draw to side by side.

use std::ops::Range;

use bevy::{
    math::UVec2,
    tasks::{ComputeTaskPool, TaskPool},
};
use smallvec::SmallVec;

use super::{
    outline::ObjectTile,
    tile::{TILE_HEIGHT, Tile},
};
use crate::spatial::simd::{Simd, Task, dispatch};

/// To share the work out, so many triangles are looked at.
const SAMPLES: usize = 256;

/// Rows of tiles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Band {
    /// Which ones of the screen.
    pub tile_rows: Range<u32>,
    /// The tiles in each.
    pub tiles_across: u32,
}

impl Band {
    /// The rows of pixels.
    #[inline(always)]
    pub fn rows(&self) -> Range<u32> {
        self.tile_rows.start * TILE_HEIGHT..self.tile_rows.end * TILE_HEIGHT
    }
}

/// A band of a depth buffer, with what it takes to draw to that.
pub(super) struct Canvas<'a> {
    /// The size of the screen in pixels.
    pub size: UVec2,
    pub band: Band,
    /// The tiles of the band.
    pub tiles: &'a mut [Tile],
    /// What has been drawn to them of one mesh: none where meshes are not drawn as one.
    pub object: &'a mut [ObjectTile],
    /// To which of them.
    pub touched: &'a mut Vec<u32>,
}

/// What can be drawn band by band.
pub(super) trait Drawing: Sync {
    /// How many parts it has.
    fn len(&self) -> usize;

    /// In which row of pixels the middle of a part is, if it is drawn.
    fn row_of(&self, part: usize) -> Option<f32>;

    /// Draws what of it is in a band. Must be `#[inline(always)]`.
    fn draw<S: Simd>(&self, simd: S, canvas: &mut Canvas);
}

/// Draws to so many bands side by side, or to the only one, with a list of touched tiles for each but the last. The same
/// is drawn, tile by tile, in the same order.
#[inline(always)]
pub(super) fn draw_in_bands<S: Simd>(
    simd: S,
    drawing: &impl Drawing,
    bands: usize,
    canvas: &mut Canvas,
    touched: &mut [Vec<u32>],
) {
    if bands <= 1 {
        drawing.draw(simd, canvas);
        return;
    }
    let cuts = cuts(drawing, &canvas.band, bands);
    ComputeTaskPool::get_or_init(TaskPool::default).scope(|scope| {
        let Canvas {
            size,
            ref band,
            ref mut tiles,
            ref mut object,
            touched: ref mut touched_last,
        } = *canvas;
        let (mut tiles, mut object) = (&mut **tiles, &mut **object);
        let tile_rows = &band.tile_rows;
        let begins = [tile_rows.start].into_iter().chain(cuts.iter().copied());
        let ends = cuts.iter().copied().chain([tile_rows.end]);
        let touched = touched.iter_mut().take(cuts.len()).chain([&mut **touched_last]);
        for ((begin, end), touched) in begins.zip(ends).zip(touched) {
            let band = Band {
                tile_rows: begin..end,
                ..*band
            };
            let count = band.tile_rows.len() * band.tiles_across as usize;
            let (tiles_here, object_here);
            (tiles_here, tiles) = tiles.split_at_mut(count);
            (object_here, object) = object.split_at_mut(object.len().min(count));
            let canvas = Canvas {
                size,
                band,
                tiles: tiles_here,
                object: object_here,
                touched,
            };
            scope.spawn(async move { dispatch(DrawBand { drawing, canvas }) });
        }
    });
}

/// The rows of tiles at which to cut a band so that about as much is to be drawn in each.
fn cuts(drawing: &impl Drawing, band: &Band, bands: usize) -> SmallVec<[u32; 32]> {
    let step = drawing.len().div_ceil(SAMPLES).max(1);
    let samples = (0..drawing.len()).step_by(step).filter_map(|part| drawing.row_of(part));
    let last = band.tile_rows.end.saturating_sub(1).max(band.tile_rows.start);
    let mut rows: SmallVec<[u32; SAMPLES]> = samples
        .map(|row| (row as u32 / TILE_HEIGHT).clamp(band.tile_rows.start, last))
        .collect();
    rows.sort_unstable();
    let mut cuts: SmallVec<[u32; 32]> = (1..bands)
        .filter_map(|number| rows.get(rows.len() * number / bands).copied())
        .filter(|&cut| cut > band.tile_rows.start)
        .collect();
    cuts.dedup();
    cuts
}

struct DrawBand<'a, D> {
    drawing: &'a D,
    canvas: Canvas<'a>,
}

impl<D: Drawing> Task for DrawBand<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        self.drawing.draw(simd, &mut self.canvas);
    }
}
