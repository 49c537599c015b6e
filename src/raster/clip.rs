//! Polygons from clip space to regions of the screen, in double precision: where exactness matters more than speed.

use std::ops::Range;

use bevy::math::{DVec2, DVec3, DVec4, UVec2};
use smallvec::SmallVec;

use super::fill::{Line, Region};
use crate::geometry::tolerance;

/// A corner in clip space, with whether the edge from it to the next one lies within what is drawn, and not on its
/// outline.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub clip: DVec4,
    pub is_within: bool,
}

/// A vertex of a mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    pub clip: DVec4,
    /// In pixels, where it is plain.
    pub place: DVec2,
    /// Where it is plain.
    pub depth: f64,
    /// The sides of the view that it is surely beyond, bit by bit.
    beyond: u8,
    /// Whether all is well with it: finite, not nearer than the near plane, and as far from the eye as it has to be.
    pub is_plain: bool,
}

impl Vertex {
    /// On a screen of this size; plain only if it is farther from the eye than `least_w`.
    pub fn new(clip: DVec4, least_w: f64, size: UVec2) -> Self {
        let place = to_pixels(clip, size);
        let beyond = BEYOND_SIDES.iter().enumerate();
        Self {
            clip,
            place,
            depth: clip.z / clip.w,
            beyond: beyond.fold(0, |bits, (side, is_beyond)| bits | u8::from(is_beyond(clip)) << side),
            is_plain: clip.is_finite() && beyond_near(clip) >= 0.0 && clip.w > least_w && place.is_finite(),
        }
    }

    /// Whether vertices are all beyond one side of the view.
    pub fn are_outside(vertices: &[&Self; 3]) -> bool {
        vertices.iter().fold(u8::MAX, |bits, vertex| bits & vertex.beyond) != 0
    }
}

/// What is left of a polygon.
pub(super) type Corners = SmallVec<[Corner; 6]>;

/// Cuts away what is nearer than the near plane; with Bevy's projections what is left is before the eye. The cut is on the
/// outline.
pub(super) fn clip_near(corners: &[Corner]) -> Corners {
    let beyond = |corner: &Corner| beyond_near(corner.clip);
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

/// How far beyond the near plane a corner is: not at all if negative.
fn beyond_near(clip: DVec4) -> f64 {
    clip.w - clip.z
}

/// Whether a corner is beyond each side of the view, by more than rounding.
const BEYOND_SIDES: [fn(DVec4) -> bool; 4] = {
    const SURELY: f64 = 1.0 + tolerance::RASTER_BESIDE;
    [
        |clip| clip.x < -SURELY * clip.w,
        |clip| clip.x > SURELY * clip.w,
        |clip| clip.y < -SURELY * clip.w,
        |clip| clip.y > SURELY * clip.w,
    ]
};

/// Whether all of a polygon that is not behind the eye is beyond one side of the view, by more than rounding.
pub(super) fn is_outside(corners: impl Iterator<Item = DVec4> + Clone) -> bool {
    BEYOND_SIDES.iter().any(|is_beyond| corners.clone().all(is_beyond))
}

/// The place of a corner as the eye has it: two directions on the screen, and the distance along the view.
pub(super) fn xyw(clip: DVec4) -> DVec3 {
    DVec3::new(clip.x, clip.y, clip.w)
}

/// Whether no pixel that a polygon touches is in some rows.
pub(super) fn is_beside(corners: &[DVec2], rows: Range<u32>) -> bool {
    let slop = f64::from(tolerance::RASTER_PIXELS);
    let (min, max) = corners
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), corner| {
            (corner.y.min(min), corner.y.max(max))
        });
    (max + slop).ceil() <= f64::from(rows.start) || (min - slop).floor() >= f64::from(rows.end)
}

/// Which way three corners run around, as seen: positive if counter-clockwise, and zero if double precision is not sure.
pub(super) fn winding(corners: [DVec4; 3]) -> f64 {
    let [a, b, c] = corners.map(xyw);
    let volume = a.dot(b.cross(c));
    let rounding = tolerance::RASTER_CORNER * a.length() * b.length() * c.length();
    if volume.abs() > rounding { volume } else { 0.0 }
}

/// The least and the greatest depth of corners.
pub(super) fn depths(corners: impl Iterator<Item = DVec4>) -> [f64; 2] {
    corners.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, greatest], clip| {
        let depth = clip.z / clip.w;
        [least.min(depth), greatest.max(depth)]
    })
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
    rows: Range<u32>,
    columns: Range<u32>,
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
