//! What is hidden?

use bevy::math::{Mat4, Vec2, Vec3A, bounding::Aabb3d};

use super::{
    batch::Batch,
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

/// The pixels of which a [`ScreenRect`] has some, from the first column and row to before the last, and how near it is:
/// none where the first is not before the last.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PixelRect {
    pub(super) left: u32,
    pub(super) top: u32,
    pub(super) right: u32,
    pub(super) bottom: u32,
    pub nearest: f32,
}

impl PixelRect {
    /// Whether none of it is on the screen.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.left >= self.right || self.top >= self.bottom
    }

    /// How near it is, as far as that matters: nothing is drawn beyond the far plane, and so nothing hides what is there. NaN
    /// is everywhere.
    #[inline(always)]
    pub(super) fn nearest_drawn(&self) -> f32 {
        if self.nearest < 0.0 { 0.0 } else { self.nearest }
    }

    /// How many pixels it has.
    #[inline(always)]
    pub fn area(&self) -> u32 {
        self.right.saturating_sub(self.left) * self.bottom.saturating_sub(self.top)
    }
}

/// [`ScreenRect`]s, lane by lane.
struct ScreenRects<S: Simd> {
    min: [S::F32s; 2],
    max: [S::F32s; 2],
    nearest: S::F32s,
}

impl<S: Simd> ScreenRects<S> {
    #[inline(always)]
    fn splat(simd: S, rect: &ScreenRect) -> Self {
        Self {
            min: [simd.splat(rect.min.x), simd.splat(rect.min.y)],
            max: [simd.splat(rect.max.x), simd.splat(rect.max.y)],
            nearest: simd.splat(rect.nearest),
        }
    }
}

impl MaskedDepthBuffer {
    /// Whether something in this rectangle of the screen can be seen. What is beside the screen cannot.
    pub fn is_rect_visible(&self, rect: &ScreenRect) -> bool {
        dispatch(TestRect { buffer: self, rect }) == Some(true)
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
        let ScreenRects { min, max, nearest } = self.rects_of_boxes(Portable, boxes, clip_from_world);
        ScreenRect {
            min: min.map(|ends| ends[0]).into(),
            max: max.map(|ends| ends[0]).into(),
            nearest: nearest[0],
        }
    }

    /// Whether what has been drawn hides all of a rectangle that is on the screen. What is beside it is not hidden by that.
    pub fn hides_rect(&self, rect: &ScreenRect) -> bool {
        dispatch(TestRect { buffer: self, rect }) == Some(false)
    }

    /// The same of pixels.
    pub(crate) fn hides(&self, rect: &PixelRect) -> bool {
        !rect.is_empty() && !dispatch(TestPixels { buffer: self, rect })
    }

    /// Where eight boxes are on the screen.
    #[inline(always)]
    fn rects_of_boxes<S: Simd>(&self, simd: S, boxes: Boxes, clip_from_world: &Mat4) -> ScreenRects<S> {
        let mut ends = [[simd.splat(0.0); 3]; 2];
        for (ends, values) in ends.iter_mut().zip([boxes.min, boxes.max]) {
            for (end, values) in ends.iter_mut().zip(values) {
                *end = simd.load(values);
            }
        }
        self.rects_between(simd, ends, clip_from_world)
    }

    /// Where eight boxes between these corners are on the screen.
    #[inline(always)]
    fn rects_between<S: Simd>(&self, simd: S, ends: [[S::F32s; 3]; 2], clip_from_world: &Mat4) -> ScreenRects<S> {
        let mut largest = [simd.splat(0.0); 3];
        for (axis, largest) in largest.iter_mut().enumerate() {
            *largest = simd.max(simd.sub(simd.splat(0.0), ends[0][axis]), ends[1][axis]);
        }
        let mut hull = ScreenHull::<S>::empty(simd);
        for corner in 0..8 {
            let at = [ends[corner & 1][0], ends[corner >> 1 & 1][1], ends[corner >> 2 & 1][2]];
            hull.add(simd, clip_of(simd, clip_from_world, at));
        }
        hull.rects(simd, magnitudes(simd, clip_from_world, largest), self.size().as_vec2())
    }

    /// The pixels that eight boxes have on the screen.
    #[inline(always)]
    pub(crate) fn pixels_of_boxes<S: Simd>(&self, simd: S, boxes: Boxes, clip_from_world: &Mat4) -> [PixelRect; LANES] {
        let rects = self.rects_of_boxes(simd, boxes, clip_from_world);
        self.pixels_of(simd, &rects)
    }

    /// The pixels that rectangles have on the screen. What is NaN has all.
    #[inline(always)]
    fn pixels_of<S: Simd>(&self, simd: S, rects: &ScreenRects<S>) -> [PixelRect; LANES] {
        let [left, right] = pixels_between(simd, rects.min[0], rects.max[0], self.size.x);
        let [top, bottom] = pixels_between(simd, rects.min[1], rects.max[1], self.size.y);
        let rows = simd.rows([left, top, right, bottom]);
        let nearest = simd.store(rects.nearest);
        std::array::from_fn(|lane| {
            let [left, top, right, bottom] = rows[lane].map(f32::to_bits);
            PixelRect {
                left,
                top,
                right,
                bottom,
                nearest: nearest[lane],
            }
        })
    }

    /// Whether something in these pixels can be seen.
    #[inline(always)]
    pub(crate) fn shows<S: Simd>(&self, simd: S, rect: &PixelRect) -> bool {
        if rect.is_empty() {
            return false;
        }
        let nearest = simd.splat(rect.nearest_drawn());
        let (last_column, last_row) = (rect.right - 1, rect.bottom - 1);
        let tiles = rect.left / TILE_WIDTH..=last_column / TILE_WIDTH;
        let from_left = &FROM_COLUMN[(rect.left % TILE_WIDTH) as usize];
        let to_right = &TO_COLUMN[(last_column % TILE_WIDTH) as usize];
        for tile_y in rect.top / TILE_HEIGHT..=last_row / TILE_HEIGHT {
            let top = tile_y * TILE_HEIGHT;
            let in_rows = rows(rect.top.saturating_sub(top), (last_row - top).min(TILE_HEIGHT - 1));
            let in_rows = simd.load_bits(&ROWS[in_rows as usize]);
            for tile_x in tiles.clone() {
                let mut pixels = in_rows;
                if tile_x == *tiles.start() {
                    pixels = simd.and(pixels, simd.load_bits(from_left));
                }
                if tile_x == *tiles.end() {
                    pixels = simd.and(pixels, simd.load_bits(to_right));
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

/// The first of so many pixels that some of what lies between two ends is in, and the one after the last: whole numbers, as
/// bits.
#[inline(always)]
fn pixels_between<S: Simd>(simd: S, min: S::F32s, max: S::F32s, size: u32) -> [S::F32s; 2] {
    let (zero, size) = (simd.splat(0.0), simd.splat(size as f32));
    // Which of the two comes first decides what is made of NaN.
    let first = simd.min(simd.max(min, zero), size);
    let first = simd.sub(zero, simd.ceil(simd.sub(zero, first)));
    let end = simd.ceil(simd.max(simd.min(max, size), zero));
    // What is no wider than the border between two pixels is in one of them.
    let end = simd.min(simd.max(end, simd.add(first, simd.splat(1.0))), size);
    let end = simd.select(simd.le(max, zero), zero, end);
    [simd.floats(simd.whole(first)), simd.floats(simd.whole(end))]
}

/// The pixels of a tile from each column on, block by block.
pub(super) const FROM_COLUMN: [[u32; LANES]; TILE_WIDTH as usize] = {
    let mut table = [[0; LANES]; TILE_WIDTH as usize];
    let mut column = 0;
    while column < TILE_WIDTH {
        table[column as usize] = blocks_of_columns(u32::MAX << column);
        column += 1;
    }
    table
};

/// Those up to each column.
pub(super) const TO_COLUMN: [[u32; LANES]; TILE_WIDTH as usize] = {
    let mut table = [[0; LANES]; TILE_WIDTH as usize];
    let mut column = 0;
    while column < TILE_WIDTH {
        table[column as usize] = blocks_of_columns(u32::MAX >> (TILE_WIDTH - 1 - column));
        column += 1;
    }
    table
};

/// The pixels of a tile from one row to another, block by block, by the [number](rows) of the two.
pub(super) const ROWS: [[u32; LANES]; (TILE_HEIGHT * TILE_HEIGHT) as usize] = {
    let mut table = [[0; LANES]; (TILE_HEIGHT * TILE_HEIGHT) as usize];
    let mut number = 0;
    while number < TILE_HEIGHT * TILE_HEIGHT {
        let (from, to) = (number / TILE_HEIGHT, number % TILE_HEIGHT);
        let up_to = u64::MAX >> (BLOCK_WIDTH * (TILE_HEIGHT - 1 - to));
        table[number as usize] = blocks_of_rows(u64::MAX << (BLOCK_WIDTH * from) & up_to);
        number += 1;
    }
    table
};

/// The number of the rows from one to another, both included. In its bits, the two are beside each other.
pub(super) const fn rows(from: u32, to: u32) -> u32 {
    from * TILE_HEIGHT + to
}

/// The pixels of a tile in some columns, one bit for each, block by block.
const fn blocks_of_columns(columns: u32) -> [u32; LANES] {
    let mut blocks = [0; LANES];
    let mut lane = 0;
    while lane < LANES {
        // The same columns in each of four rows.
        blocks[lane] = (columns >> (BLOCK_WIDTH * (lane as u32 % 4)) & 0xff) * 0x0101_0101;
        lane += 1;
    }
    blocks
}

/// The pixels of a tile in some rows, with a bit for each pixel of a column of blocks, block by block.
const fn blocks_of_rows(rows: u64) -> [u32; LANES] {
    let (upper, lower) = (rows as u32, (rows >> 32) as u32);
    [upper, upper, upper, upper, lower, lower, lower, lower]
}

struct TestPixels<'a> {
    buffer: &'a MaskedDepthBuffer,
    rect: &'a PixelRect,
}

impl Task for TestPixels<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> bool {
        self.buffer.shows(simd, self.rect)
    }
}

struct TestRect<'a> {
    buffer: &'a MaskedDepthBuffer,
    rect: &'a ScreenRect,
}

impl Task for TestRect<'_> {
    /// Whether it can be seen, if it is on the screen.
    type Output = Option<bool>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Option<bool> {
        let pixels = &self.buffer.pixels_of(simd, &ScreenRects::splat(simd, self.rect))[0];
        if pixels.is_empty() {
            return None;
        }
        Some(self.buffer.shows(simd, pixels))
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
        let mut corners = [[[0.0; 4]; LANES]; 2];
        let mut batch = Batch::new();
        let mut first = 0;
        for aabbs in self.aabbs.chunks(LANES) {
            for (lane, aabb) in aabbs.iter().enumerate() {
                corners[0][lane] = aabb.min.extend(0.0).to_array();
                corners[1][lane] = aabb.max.extend(0.0).to_array();
            }
            let [x0, y0, z0, _] = simd.transpose(corners[0].each_ref());
            let [x1, y1, z1, _] = simd.transpose(corners[1].each_ref());
            let ends = [[x0, y0, z0], [x1, y1, z1]];
            let rects = self.buffer.rects_between(simd, ends, self.clip_from_world);
            let rects = self.buffer.pixels_of(simd, &rects);
            for rect in &rects[..aabbs.len()] {
                batch.add(simd, self.buffer, rect);
            }
            if batch.is_full() {
                first += batch.tell(simd, self.buffer, first, &mut self.visit);
            }
        }
        batch.tell(simd, self.buffer, first, &mut self.visit);
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
        let hull = ScreenHull::around(simd, corners);
        let [half_x, half_y, half_z] = self.half_axes;
        let largest = self.center.abs() + half_x.abs() + half_y.abs() + half_z.abs();
        let largest = largest.to_array().map(|coordinate| simd.splat(coordinate));
        let rects = hull.rects(simd, magnitudes(simd, matrix, largest), self.buffer.size().as_vec2());
        self.buffer.shows(simd, &self.buffer.pixels_of(simd, &rects)[0])
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
    /// The lanes with a point that is nearer than the near plane, or NaN; bits beyond the lanes say nothing.
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

    /// Around the points of all lanes: the same in each lane.
    #[inline(always)]
    fn around(simd: S, [x, y, z, w]: [S::F32s; 4]) -> Self {
        let mut each = Self::empty(simd);
        each.add(simd, [x, y, z, w]);
        if each.near as u8 != 0 {
            return Self {
                near: u32::MAX,
                ..Self::empty(simd)
            };
        }
        Self {
            min: each.min.map(|values| simd.splat(simd.min_lane(values))),
            max: each.max.map(|values| simd.splat(max_lane(simd, values))),
            nearest: simd.splat(max_lane(simd, each.nearest)),
            least_w: simd.splat(simd.min_lane(each.least_w)),
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
    fn rects(&self, simd: S, magnitudes: [S::F32s; 4], size: Vec2) -> ScreenRects<S> {
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
        let min_x = simd.mul(simd.add(simd.sub(self.min[0], grow_x), one), half[0]);
        let max_x = simd.mul(simd.add(simd.add(self.max[0], grow_x), one), half[0]);
        let min_y = simd.mul(simd.sub(one, simd.add(self.max[1], grow_y)), half[1]);
        let max_y = simd.mul(simd.sub(one, simd.sub(self.min[1], grow_y)), half[1]);
        let (least, greatest) = (simd.splat(f32::NEG_INFINITY), simd.splat(f32::INFINITY));
        ScreenRects {
            min: [simd.select(near, least, min_x), simd.select(near, least, min_y)],
            max: [simd.select(near, greatest, max_x), simd.select(near, greatest, max_y)],
            nearest: simd.select(near, greatest, simd.add(self.nearest, grow_z)),
        }
    }
}
