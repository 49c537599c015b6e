//! Polygons from clip space to regions of the screen, in double precision: where exactness matters more than speed.

use bevy::math::{DVec2, DVec3, DVec4, UVec2};
use smallvec::SmallVec;

use super::{
    fill::{Line, Region},
    tile::{TILE_HEIGHT, TILE_WIDTH},
};
use crate::geometry::tolerance;

/// A corner in clip space, with whether the edge from it to the next one lies within what is drawn, and not on its
/// outline.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub clip: DVec4,
    pub is_within: bool,
}

/// What is left of a polygon.
pub(super) type Corners = SmallVec<[Corner; 6]>;

/// Cuts away what is nearer than the near plane; with Bevy's projections what is left is before the eye. The cut is on the
/// outline.
pub(super) fn clip_near(corners: &[Corner]) -> Corners {
    let beyond = |corner: &Corner| corner.clip.w - corner.clip.z;
    let mut left = Corners::new();
    for (index, corner) in corners.iter().enumerate() {
        let next = &corners[(index + 1) % corners.len()];
        let (here, there) = (beyond(corner), beyond(next));
        if here >= 0.0 {
            left.push(*corner);
        }
        if (here >= 0.0) != (there >= 0.0) {
            // In the same order from both sides, so that the two polygons of an edge are cut at the same place.
            let cut = if here >= 0.0 {
                corner.clip.lerp(next.clip, here / (here - there))
            } else {
                next.clip.lerp(corner.clip, there / (there - here))
            };
            left.push(Corner {
                clip: cut,
                is_within: here < 0.0 && corner.is_within,
            });
        }
    }
    if left.len() < 3 {
        left.clear();
    }
    left
}

/// Whether all of a polygon that is not behind the eye is beyond one side of the view, by more than rounding.
pub(super) fn is_outside(corners: impl Iterator<Item = DVec4> + Clone) -> bool {
    const SURELY: f64 = 1.0 + tolerance::RASTER_BESIDE;
    let all = |beyond: fn(DVec4) -> bool| corners.clone().all(beyond);
    all(|clip| clip.x < -SURELY * clip.w)
        || all(|clip| clip.x > SURELY * clip.w)
        || all(|clip| clip.y < -SURELY * clip.w)
        || all(|clip| clip.y > SURELY * clip.w)
}

/// The place of a corner in pixels.
pub(super) fn to_pixels(clip: DVec4, size: UVec2) -> DVec2 {
    let size = size.as_dvec2();
    DVec2::new(
        (0.5 + 0.5 * clip.x / clip.w) * size.x,
        (0.5 - 0.5 * clip.y / clip.w) * size.y,
    )
}

/// Which pixels belong to a polygon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Coverage {
    /// Those whose centres are in it.
    Centers,
    /// Those that are wholly in it.
    Within,
    /// All that share a point with it, and perhaps some beside its corners.
    Touched,
}

/// A region with its lines.
#[derive(Clone, Debug)]
pub(super) struct PolygonRegion {
    lines: SmallVec<[Line; 8]>,
    rows: std::ops::Range<u32>,
    columns: std::ops::Range<u32>,
}

impl PolygonRegion {
    pub fn as_region(&self) -> Region<'_> {
        Region {
            lines: &self.lines,
            rows: self.rows.clone(),
            columns: self.columns.clone(),
        }
    }

    /// The pixels of a convex polygon whose corners run counter-clockwise as seen, or of a line from one corner to
    /// another; `None` if there are none on the screen, or a corner is NaN or infinite.
    pub fn new(corners: &[DVec2], coverage: Coverage, size: UVec2) -> Option<Self> {
        let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for corner in corners {
            if !corner.is_finite() {
                return None;
            }
            (min, max) = (min.min(*corner), max.max(*corner));
        }
        let slop = f64::from(tolerance::RASTER_PIXELS);
        let (first, end) = match coverage {
            Coverage::Centers => ((min - 0.5).ceil(), (max - 0.5).ceil()),
            Coverage::Within => ((min + slop).ceil(), (max - slop).floor()),
            Coverage::Touched => ((min - slop).floor(), (max + slop).ceil()),
        };
        let size = size.as_dvec2();
        let on_screen = |first: f64, end: f64, size: f64| first.max(0.0) < end.min(size);
        if !(on_screen(first.x, end.x, size.x) && on_screen(first.y, end.y, size.y)) {
            return None;
        }
        let mut lines = SmallVec::new();
        for (index, &from) in corners.iter().enumerate() {
            lines.extend(line(from, corners[(index + 1) % corners.len()], coverage, size.y));
        }
        let range = |first: f64, end: f64, size: f64| first.max(0.0) as u32..end.min(size) as u32;
        Some(Self {
            lines,
            rows: range(first.y, end.y, size.y),
            columns: range(first.x, end.x, size.x),
        })
    }
}

/// The bound that an edge sets, which is on the left if it goes down, unless it is level.
fn line(from: DVec2, to: DVec2, coverage: Coverage, height: f64) -> Option<Line> {
    let goes_down = from.y < to.y;
    // Both polygons of an edge get the same line.
    let (upper, lower) = if goes_down { (from, to) } else { (to, from) };
    let drop = lower.y - upper.y;
    if drop <= tolerance::RASTER_LEVEL {
        return None;
    }
    let slope = (lower.x - upper.x) / drop;
    // Near the screen numbers are small, and lines exact.
    let y = (0.5 * height).clamp(upper.y, lower.y);
    let x = upper.x + (y - upper.y) * slope;
    let grow = match coverage {
        Coverage::Centers => 0.0,
        _ => {
            let rounding = f64::from(tolerance::RASTER_LINE) * (x.abs() + slope.abs() * (y.abs() + height));
            0.5 * slope.abs() + f64::from(tolerance::RASTER_PIXELS) + rounding
        }
    };
    // A left bound begins at the next whole number, and a right bound ends there.
    let x = x + match (coverage, goes_down) {
        (Coverage::Centers, _) => -0.5,
        (Coverage::Within, true) => grow,
        (Coverage::Within, false) => -grow - 1.0,
        (Coverage::Touched, true) => -grow - 1.0,
        (Coverage::Touched, false) => grow,
    };
    let (x, y, slope) = (x as f32, (y - 0.5) as f32, slope as f32);
    Some(if goes_down {
        Line::left(x, y, slope)
    } else {
        Line::right(x, y, slope)
    })
}

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
        let [a, b, c] = corners.map(|clip| DVec3::new(clip.x, clip.y, clip.w));
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
