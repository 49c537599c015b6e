//! What is hidden?

use std::ops::Range;

use bevy::math::{Mat4, Vec2, Vec3A, Vec4Swizzles, bounding::Aabb3d};

use super::{
    buffer::MaskedDepthBuffer,
    tile::{BLOCK_WIDTH, TILE_HEIGHT, TILE_WIDTH},
};
use crate::{
    geometry::tolerance,
    spatial::{
        lanes::Boxes,
        simd::{LANES, Portable, Simd, Task, dispatch},
    },
};

/// Where something is on the screen: between two corners in pixels, and no nearer than a depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScreenRect {
    /// The upper left, in pixels.
    pub min: Vec2,
    /// The lower right, in pixels.
    pub max: Vec2,
    /// The depth of what is nearest, `z / w`.
    pub nearest: f32,
}

impl ScreenRect {
    /// Of what is everywhere, as far as can be told.
    pub const ANYWHERE: Self = Self {
        min: Vec2::NEG_INFINITY,
        max: Vec2::INFINITY,
        nearest: f32::INFINITY,
    };
}

impl MaskedDepthBuffer {
    /// Whether something in this rectangle of the screen can be seen. What is beside the screen cannot.
    pub fn is_rect_visible(&self, rect: &ScreenRect) -> bool {
        dispatch(TestRect { buffer: self, rect })
    }

    /// Whether something in a box can be seen. What reaches through the near plane can; what is beside the screen cannot.
    ///
    /// Rounding errs to the visible. A box with a coordinate that is NaN or infinite can be seen.
    pub fn is_aabb_visible(&self, aabb: &Aabb3d, clip_from_world: &Mat4) -> bool {
        let half = (aabb.max - aabb.min) * 0.5;
        let center = (aabb.max + aabb.min) * 0.5;
        let axes = [Vec3A::X * half.x, Vec3A::Y * half.y, Vec3A::Z * half.z];
        self.is_parallelepiped_visible(center, axes, clip_from_world)
    }

    /// Tells of many boxes, by their numbers in ascending order, which can be seen: the same in less time.
    pub fn for_each_visible(&self, aabbs: &[Aabb3d], clip_from_world: &Mat4, visit: impl FnMut(usize)) {
        dispatch(TestBoxes {
            buffer: self,
            aabbs,
            clip_from_world,
            visit,
        });
    }

    /// Whether something in a box that is turned can be seen: one about a centre, between plus and minus each of three
    /// axes, which need not be at right angles.
    pub fn is_parallelepiped_visible(&self, center: Vec3A, half_axes: [Vec3A; 3], clip_from_world: &Mat4) -> bool {
        dispatch(TestBox {
            buffer: self,
            center,
            half_axes,
            clip_from_world,
        })
    }

    /// Where a box is on the screen. Rounding errs to what is nearer and wider; a box that reaches through the near plane,
    /// or is NaN or infinite, is [anywhere](ScreenRect::ANYWHERE).
    pub fn rect_of(&self, aabb: &Aabb3d, clip_from_world: &Mat4) -> ScreenRect {
        let [min, max] = [aabb.min, aabb.max].map(|end| end.to_array().map(|coordinate| [coordinate; LANES]));
        let boxes = Boxes { min: &min, max: &max };
        self.rects_of_boxes(Portable, boxes, clip_from_world)[0]
    }

    /// Whether some of a rectangle is on the screen. Nothing is on one without pixels.
    pub fn meets(&self, rect: &ScreenRect) -> bool {
        let size = self.size().as_vec2();
        let is_beside = rect.min.x >= size.x || rect.min.y >= size.y || rect.max.x <= 0.0 || rect.max.y <= 0.0;
        // Also what is NaN is somewhere.
        !is_beside && self.size.x > 0
    }

    /// The share of the screen that a rectangle takes up, from 0 to 1.
    pub fn share_of(&self, rect: &ScreenRect) -> f32 {
        let size = self.size().as_vec2();
        let part = (rect.max.min(size) - rect.min.max(Vec2::ZERO)).max(Vec2::ZERO) / size;
        part.x * part.y
    }

    /// Whether what has been drawn hides all of a rectangle that is on the screen. What is beside it is not hidden by that.
    pub fn hides_rect(&self, rect: &ScreenRect) -> bool {
        self.meets(rect) && !self.is_rect_visible(rect)
    }

    /// Where eight boxes are on the screen.
    #[inline(always)]
    pub(crate) fn rects_of_boxes<S: Simd>(&self, simd: S, boxes: Boxes, clip_from_world: &Mat4) -> [ScreenRect; LANES] {
        let mut ends = [[simd.splat(0.0); 3]; 2];
        let mut largest = [simd.splat(0.0); 3];
        for axis in 0..3 {
            ends[0][axis] = simd.load(&boxes.min[axis]);
            ends[1][axis] = simd.load(&boxes.max[axis]);
            largest[axis] = simd.max(simd.sub(simd.splat(0.0), ends[0][axis]), ends[1][axis]);
        }
        let mut hull = ScreenHull::<S>::empty(simd);
        for corner in 0..8 {
            let at = [ends[corner & 1][0], ends[corner >> 1 & 1][1], ends[corner >> 2 & 1][2]];
            hull.add(simd, clip_of(simd, clip_from_world, at));
        }
        hull.rects(simd, magnitudes(simd, clip_from_world, largest), self.size().as_vec2())
    }

    #[inline(always)]
    pub(crate) fn shows_rect<S: Simd>(&self, simd: S, rect: &ScreenRect) -> bool {
        // Also what is NaN is everywhere.
        let ends = |min: f32, max: f32, size: u32| -> Range<u32> {
            let first = if min > 0.0 { (min as u32).min(size) } else { 0 };
            let end = if max < size as f32 {
                max.max(0.0).ceil() as u32
            } else {
                size
            };
            // What is no wider than the border between two pixels is in one of them.
            if max <= 0.0 {
                0..0
            } else {
                first..end.max(first + 1).min(size)
            }
        };
        let rows = ends(rect.min.y, rect.max.y, self.size.y);
        let columns = ends(rect.min.x, rect.max.x, self.size.x);
        if rows.is_empty() || columns.is_empty() {
            return false;
        }
        // Nothing is drawn beyond the far plane, and so nothing hides what is there.
        let nearest = simd.splat(if rect.nearest < 0.0 { 0.0 } else { rect.nearest });
        let (first, last) = (columns.start / TILE_WIDTH, (columns.end - 1) / TILE_WIDTH);
        let from_left = simd.load_bits(&blocks_of_columns(columns.start % TILE_WIDTH, TILE_WIDTH));
        let to_right = simd.load_bits(&blocks_of_columns(0, (columns.end - 1) % TILE_WIDTH + 1));
        for tile_y in rows.start / TILE_HEIGHT..=(rows.end - 1) / TILE_HEIGHT {
            let top = tile_y * TILE_HEIGHT;
            let in_rows = blocks_of_rows(rows.start.saturating_sub(top), (rows.end - top).min(TILE_HEIGHT));
            let in_rows = simd.load_bits(&in_rows);
            for tile_x in first..=last {
                let mut pixels = in_rows;
                if tile_x == first {
                    pixels = simd.and(pixels, from_left);
                }
                if tile_x == last {
                    pixels = simd.and(pixels, to_right);
                }
                let tile = (tile_y * self.tiles_across() + tile_x) as usize;
                if self.tiles[tile].shows(simd, pixels, nearest) {
                    return true;
                }
            }
        }
        false
    }
}

/// The pixels of a tile from one column to before another, block by block.
#[inline(always)]
fn blocks_of_columns(first: u32, end: u32) -> [u32; LANES] {
    let columns = (u32::MAX >> (TILE_WIDTH - (end - first))) << first;
    let mut blocks = [0; LANES];
    for (lane, block) in blocks.iter_mut().enumerate() {
        // The same columns in each of four rows.
        *block = (columns >> (BLOCK_WIDTH * (lane as u32 % 4)) & 0xff) * 0x0101_0101;
    }
    blocks
}

/// The pixels of a tile from one row to before another, block by block.
#[inline(always)]
fn blocks_of_rows(first: u32, end: u32) -> [u32; LANES] {
    let rows = (u64::MAX >> (BLOCK_WIDTH * (TILE_HEIGHT - (end - first)))) << (BLOCK_WIDTH * first);
    let mut blocks = [rows as u32; LANES];
    for block in &mut blocks[LANES / 2..] {
        *block = (rows >> 32) as u32;
    }
    blocks
}

struct TestRect<'a> {
    buffer: &'a MaskedDepthBuffer,
    rect: &'a ScreenRect,
}

impl Task for TestRect<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> bool {
        self.buffer.shows_rect(simd, self.rect)
    }
}

pub(super) struct TestBoxes<'a, F> {
    pub buffer: &'a MaskedDepthBuffer,
    pub aabbs: &'a [Aabb3d],
    pub clip_from_world: &'a Mat4,
    pub visit: F,
}

impl<F: FnMut(usize)> Task for TestBoxes<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let (mut min, mut max) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
        for (group, aabbs) in self.aabbs.chunks(LANES).enumerate() {
            for (lane, aabb) in aabbs.iter().enumerate() {
                for axis in 0..3 {
                    min[axis][lane] = aabb.min[axis];
                    max[axis][lane] = aabb.max[axis];
                }
            }
            let boxes = Boxes { min: &min, max: &max };
            let rects = self.buffer.rects_of_boxes(simd, boxes, self.clip_from_world);
            for (lane, rect) in rects[..aabbs.len()].iter().enumerate() {
                if self.buffer.shows_rect(simd, rect) {
                    (self.visit)(group * LANES + lane);
                }
            }
        }
    }
}

struct TestBox<'a> {
    buffer: &'a MaskedDepthBuffer,
    center: Vec3A,
    half_axes: [Vec3A; 3],
    clip_from_world: &'a Mat4,
}

/// The signs of the three half axes at each corner.
const SIGNS: [[f32; LANES]; 3] = [
    [-1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0],
    [-1.0, -1.0, 1.0, 1.0, -1.0, -1.0, 1.0, 1.0],
    [-1.0, -1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 1.0],
];

impl Task for TestBox<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> bool {
        let matrix = self.clip_from_world;
        let middle = *matrix * self.center.extend(1.0);
        let sides = self.half_axes.map(|axis| *matrix * axis.extend(0.0));
        let mut corners = [simd.splat(0.0); 4];
        for (coordinate, corners) in corners.iter_mut().enumerate() {
            *corners = simd.splat(middle[coordinate]);
            for (side, signs) in sides.iter().zip(&SIGNS) {
                *corners = simd.add(*corners, simd.mul(simd.load(signs), simd.splat(side[coordinate])));
            }
        }
        let [x, y, z, w] = corners;
        let zero = simd.splat(0.0);
        if simd.le(z, w) & simd.lt(zero, w) != 0xff {
            return true;
        }
        let per_w = simd.div(simd.splat(1.0), w);
        let (x, y) = (simd.mul(x, per_w), simd.mul(y, per_w));
        let min = Vec2::new(simd.min_lane(x), simd.min_lane(y));
        let max = Vec2::new(max_lane(simd, x), max_lane(simd, y));
        let nearest = max_lane(simd, simd.mul(z, per_w));

        let [half_x, half_y, half_z] = self.half_axes;
        let largest = (self.center.abs() + half_x.abs() + half_y.abs() + half_z.abs()).extend(1.0);
        let error = abs(matrix) * largest * tolerance::RASTER_BOX;
        let sure_w = simd.min_lane(w) - error.w;
        if sure_w <= 0.0 || sure_w.is_nan() {
            return true;
        }
        // |x / w| is 1 on the edge of the screen, and what is beyond it need not be known well.
        let grow = (error.xy() + error.w) / sure_w;
        let size = self.buffer.size().as_vec2() * 0.5;
        let rect = ScreenRect {
            min: (Vec2::new(min.x, -max.y) - grow + 1.0) * size,
            max: (Vec2::new(max.x, -min.y) + grow + 1.0) * size,
            nearest: nearest + (error.z + error.w * nearest.abs()) / sure_w,
        };
        self.buffer.shows_rect(simd, &rect)
    }
}

/// The greatest of the lanes, none of which may be NaN.
#[inline(always)]
fn max_lane<S: Simd>(simd: S, values: S::F32s) -> f32 {
    -simd.min_lane(simd.sub(simd.splat(0.0), values))
}

#[inline(always)]
fn abs(matrix: &Mat4) -> Mat4 {
    Mat4::from_cols(
        matrix.x_axis.abs(),
        matrix.y_axis.abs(),
        matrix.z_axis.abs(),
        matrix.w_axis.abs(),
    )
}

/// Eight points in clip space.
#[inline(always)]
fn clip_of<S: Simd>(simd: S, clip_from_world: &Mat4, at: [S::F32s; 3]) -> [S::F32s; 4] {
    let mut clip = [simd.splat(0.0); 4];
    for (row, clip) in clip.iter_mut().enumerate() {
        let row = clip_from_world.row(row);
        *clip = simd.add(
            simd.add(simd.mul(at[0], simd.splat(row.x)), simd.mul(at[1], simd.splat(row.y))),
            simd.add(simd.mul(at[2], simd.splat(row.z)), simd.splat(row.w)),
        );
    }
    clip
}

/// What is added up to each coordinate in clip space, in magnitude, of points with coordinates of at most these.
#[inline(always)]
fn magnitudes<S: Simd>(simd: S, clip_from_world: &Mat4, largest: [S::F32s; 3]) -> [S::F32s; 4] {
    clip_of(simd, &abs(clip_from_world), largest)
}

/// What surrounds points on the screen, lane by lane.
struct ScreenHull<S: Simd> {
    min: [S::F32s; 2],
    max: [S::F32s; 2],
    nearest: S::F32s,
    least_w: S::F32s,
    /// The lanes with a point that is nearer than the near plane, or NaN.
    near: u32,
}

impl<S: Simd> ScreenHull<S> {
    #[inline(always)]
    fn empty(simd: S) -> Self {
        Self {
            min: [simd.splat(f32::INFINITY); 2],
            max: [simd.splat(f32::NEG_INFINITY); 2],
            nearest: simd.splat(f32::NEG_INFINITY),
            least_w: simd.splat(f32::INFINITY),
            near: 0,
        }
    }

    #[inline(always)]
    fn add(&mut self, simd: S, [x, y, z, w]: [S::F32s; 4]) {
        let per_w = simd.div(simd.splat(1.0), w);
        for (axis, value) in [x, y].into_iter().enumerate() {
            let value = simd.mul(value, per_w);
            self.min[axis] = simd.min(value, self.min[axis]);
            self.max[axis] = simd.max(value, self.max[axis]);
        }
        self.nearest = simd.max(simd.mul(z, per_w), self.nearest);
        self.least_w = simd.min(w, self.least_w);
        self.near |= !(simd.le(z, w) & simd.lt(simd.splat(0.0), w));
    }

    /// The rectangles, grown by rounding, on a screen of this size.
    #[inline(always)]
    fn rects(&self, simd: S, magnitudes: [S::F32s; 4], size: Vec2) -> [ScreenRect; LANES] {
        let slack = simd.splat(tolerance::RASTER_BOX);
        let [error_x, error_y, error_z, error_w] = magnitudes;
        let error_w = simd.mul(error_w, slack);
        let sure_w = simd.sub(self.least_w, error_w);
        let near = self.near | !simd.lt(simd.splat(0.0), sure_w);
        let per_w = simd.div(simd.splat(1.0), sure_w);
        let one = simd.splat(1.0);
        // |x / w| is 1 on the edge of the screen, and what is beyond it need not be known well.
        let grow_x = simd.mul(simd.add(simd.mul(error_x, slack), error_w), per_w);
        let grow_y = simd.mul(simd.add(simd.mul(error_y, slack), error_w), per_w);
        let grow_z = simd.mul(
            simd.add(
                simd.mul(error_z, slack),
                simd.mul(error_w, simd.max(self.nearest, simd.sub(simd.splat(0.0), self.nearest))),
            ),
            per_w,
        );
        let half = [simd.splat(0.5 * size.x), simd.splat(0.5 * size.y)];
        let min_x = simd.store(simd.mul(simd.add(simd.sub(self.min[0], grow_x), one), half[0]));
        let max_x = simd.store(simd.mul(simd.add(simd.add(self.max[0], grow_x), one), half[0]));
        let min_y = simd.store(simd.mul(simd.sub(one, simd.add(self.max[1], grow_y)), half[1]));
        let max_y = simd.store(simd.mul(simd.sub(one, simd.sub(self.min[1], grow_y)), half[1]));
        let nearest = simd.store(simd.add(self.nearest, grow_z));
        let mut rects = [ScreenRect::ANYWHERE; LANES];
        for (lane, rect) in rects.iter_mut().enumerate() {
            if near >> lane & 1 == 0 {
                *rect = ScreenRect {
                    min: Vec2::new(min_x[lane], min_y[lane]),
                    max: Vec2::new(max_x[lane], max_y[lane]),
                    nearest: nearest[lane],
                };
            }
        }
        rects
    }
}
