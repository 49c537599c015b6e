//! Depths on planes, as they are on the screen.

use bevy::math::{DVec3, DVec4, UVec2};

use super::{
    clip::xyw,
    fill::{Brush, Region},
    tile::{BLOCK_HEIGHT, BLOCK_LEFT, BLOCK_TOP, BLOCK_WIDTH, TILE_HEIGHT, TILE_WIDTH, Tile},
};
use crate::{geometry::tolerance, spatial::simd::Simd};

/// A depth, rounded and more to the far side.
fn farther(depth: f64) -> f32 {
    ((depth - f64::from(tolerance::RASTER_LINE) * depth.abs()) as f32).next_down()
}

/// The depth on a plane, as it is on the screen, in pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct DepthPlane {
    pub x: f32,
    pub y: f32,
    /// At that place.
    pub depth: f32,
    pub per_column: f32,
    pub per_row: f32,
    /// Nowhere farther, whatever the plane says.
    pub least: f32,
    /// Nowhere nearer, whatever the plane says.
    pub greatest: f32,
    /// Where the pixels are that it is the depth of, across and down.
    pub columns: [f32; 2],
    pub rows: [f32; 2],
}

impl DepthPlane {
    /// Of the plane through three corners in clip space, and of what lies on it in these `pixels` at no other depths than
    /// from `least` to `greatest`. Errs to the far side.
    pub fn new(corners: [DVec4; 3], pixels: &Region, [least, greatest]: [f64; 2], size: UVec2) -> Self {
        // With p = (x, y, w) the depths of the corners are z / w = (n · p) / w.
        let [a, b, c] = corners.map(xyw);
        let (bc, ca, ab) = (b.cross(c), c.cross(a), a.cross(b));
        let volume = a.dot(bc);
        let normal = (bc * corners[0].z + ca * corners[1].z + ab * corners[2].z) / volume;
        let is_sound = volume.abs() > tolerance::RASTER_PLANE * a.length() * b.length() * c.length();

        let size = size.as_dvec2();
        let x = 0.5 * (f64::from(pixels.columns.start) + f64::from(pixels.columns.end));
        let y = 0.5 * (f64::from(pixels.rows.start) + f64::from(pixels.rows.end));
        let depth = normal.dot(DVec3::new(2.0 * x / size.x - 1.0, 1.0 - 2.0 * y / size.y, 1.0));
        let per_column = 2.0 * normal.x / size.x;
        let per_row = -2.0 * normal.y / size.y;
        // A tile reaches beyond the pixels.
        let reach = per_column.abs() * (pixels.columns.len() as f64 + f64::from(2 * TILE_WIDTH))
            + per_row.abs() * (pixels.rows.len() as f64 + f64::from(2 * TILE_HEIGHT));
        let rounding = f64::from(tolerance::RASTER_LINE) * (depth.abs() + reach);
        let plane = Self {
            x: x as f32,
            y: y as f32,
            depth: (depth - rounding) as f32,
            per_column: per_column as f32,
            per_row: per_row as f32,
            least: farther(least),
            greatest: greatest as f32,
            columns: [pixels.columns.start as f32, pixels.columns.end as f32],
            rows: [pixels.rows.start as f32, pixels.rows.end as f32],
        };
        let is_finite = plane.depth.is_finite() && plane.per_column.is_finite() && plane.per_row.is_finite();
        if is_sound && is_finite {
            plane
        } else {
            Self::level(least)
        }
    }

    /// At the same depth everywhere.
    pub fn level(depth: f64) -> Self {
        let depth = farther(depth);
        Self {
            x: 0.0,
            y: 0.0,
            depth,
            per_column: 0.0,
            per_row: 0.0,
            least: depth,
            greatest: depth,
            columns: [0.0; 2],
            rows: [0.0; 2],
        }
    }
}

/// Paints the depth of planes, of which the farthest counts.
pub(super) struct Paint<'a> {
    pub tiles: &'a mut [Tile],
    pub planes: &'a [DepthPlane],
}

impl Brush for Paint<'_> {
    #[inline(always)]
    fn paint<S: Simd>(&mut self, simd: S, tile: usize, left: f32, top: f32, pixels: S::U32s) {
        let mut depth = simd.splat(f32::INFINITY);
        for plane in self.planes {
            depth = simd.min(farthest_of_blocks(simd, plane, left, top), depth);
        }
        self.tiles[tile].draw(simd, pixels, depth);
    }
}

/// The farthest depths of a plane in the blocks of a tile.
#[inline(always)]
pub(super) fn farthest_of_blocks<S: Simd>(simd: S, plane: &DepthPlane, left: f32, top: f32) -> S::F32s {
    let across = if plane.per_column < 0.0 {
        BLOCK_WIDTH as f32
    } else {
        0.0
    };
    let down = if plane.per_row < 0.0 { BLOCK_HEIGHT as f32 } else { 0.0 };
    let x = simd.add(simd.load(&BLOCK_LEFT), simd.splat(left + across));
    let y = simd.add(simd.load(&BLOCK_TOP), simd.splat(top + down));
    // What of a block is beside all pixels does not matter.
    let x = simd.max(simd.min(x, simd.splat(plane.columns[1])), simd.splat(plane.columns[0]));
    let y = simd.max(simd.min(y, simd.splat(plane.rows[1])), simd.splat(plane.rows[0]));
    let x = simd.sub(x, simd.splat(plane.x));
    let y = simd.sub(y, simd.splat(plane.y));
    let depth = simd.add(
        simd.add(
            simd.mul(x, simd.splat(plane.per_column)),
            simd.mul(y, simd.splat(plane.per_row)),
        ),
        simd.splat(plane.depth),
    );
    simd.max(simd.min(depth, simd.splat(plane.greatest)), simd.splat(plane.least))
}
