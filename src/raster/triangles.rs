//! Triangles by the centres of pixels, eight at a time.

use std::ops::Range;

use bevy::{
    math::{DMat4, DVec2, DVec4, Mat4, UVec2},
    tasks::{ComputeTaskPool, TaskPool},
};
use smallvec::SmallVec;

use super::{
    buffer::{Begun, Faces, MaskedDepthBuffer, RasterMode},
    canvas::{Canvas, Drawing, draw_in_bands},
    clip::{Corner, Coverage, PolygonRegion, clip_near, depths, is_outside, to_pixels, xyw},
    fill::{Line, Region, fill},
    mesh::OccluderMesh,
    outline::draw_outlined,
    plane::{DepthPlane, Paint},
};
use crate::spatial::simd::{LANES, Simd, Task, dispatch};

impl MaskedDepthBuffer {
    /// Draws the triangles of a mesh, as they are in its model's space.
    ///
    /// Strictly, the mesh is one: what its triangles cover together is covered, unless a vertex is so far from where its
    /// camera is that double precision is not sure of its place. A mesh that mirrors itself, and a matrix that does,
    /// turns front faces into back faces. Nothing is drawn with a matrix that is NaN or infinite.
    ///
    /// Many triangles are drawn to bands of the screen side by side, on Bevy's `ComputeTaskPool`; the same comes of it.
    pub fn draw_mesh(&mut self, mesh: &OccluderMesh, clip_from_model: &DMat4, faces: Faces) {
        if !clip_from_model.is_finite() || self.is_out_of_view(mesh, clip_from_model) {
            return;
        }
        let bands = bands(mesh.len(), self.mode);
        dispatch(DrawMesh {
            buffer: self,
            mesh,
            clip_from_model,
            faces,
            bands,
        });
    }

    fn is_out_of_view(&self, mesh: &OccluderMesh, clip_from_model: &DMat4) -> bool {
        let Some(aabb) = mesh.aabb() else {
            return true;
        };
        let ends = [aabb.min.as_dvec3(), aabb.max.as_dvec3()];
        is_outside((0..8).map(|corner| {
            let end = |axis: usize| ends[corner >> axis & 1][axis];
            *clip_from_model * DVec4::new(end(0), end(1), end(2), 1.0)
        }))
    }
}

/// Where a vertex is outside, bit by bit.
mod outside {
    pub const LEFT: u32 = 1;
    pub const RIGHT: u32 = 1 << 1;
    pub const BELOW: u32 = 1 << 2;
    pub const ABOVE: u32 = 1 << 3;
    /// Nearer than the near plane, or behind the eye.
    pub const NEAR: u32 = 1 << 4;
    /// So far beside the screen that single precision does not do.
    pub const FAR_AWAY: u32 = 1 << 5;
}

/// How far beside the screen vertices may be for single precision to do, in pixels.
const GUARD: f32 = 16384.0;

/// Eight triangles on the screen.
struct Batch<S: Simd> {
    x: [S::F32s; 3],
    y: [S::F32s; 3],
    depth: [S::F32s; 3],
}

pub(super) struct DrawMesh<'a> {
    pub buffer: &'a mut MaskedDepthBuffer,
    pub mesh: &'a OccluderMesh,
    pub clip_from_model: &'a DMat4,
    pub faces: Faces,
    /// To how many bands side by side.
    pub bands: usize,
}

/// To how many bands so many triangles are drawn side by side: to one if they take less than about half a millisecond, for
/// to share them out takes a tenth of that.
fn bands(triangles: usize, mode: RasterMode) -> usize {
    let least_shared = match mode {
        RasterMode::Strict => 4096,
        RasterMode::Fast => 12_288,
    };
    let threads = ComputeTaskPool::get_or_init(TaskPool::default).thread_num();
    if triangles < least_shared { 1 } else { threads }
}

/// The triangles of a mesh, of which the vertices are on the screen.
struct ByCenters<'a> {
    mesh: &'a OccluderMesh,
    clip_from_model: &'a DMat4,
    faces: Faces,
    on_screen: &'a [[f32; 4]],
}

impl Drawing for ByCenters<'_> {
    fn len(&self) -> usize {
        self.mesh.len()
    }

    fn row_of(&self, part: usize) -> Option<f32> {
        let corners = self.mesh.triangles[part].map(|corner| self.on_screen[corner as usize][1]);
        Some(corners.iter().sum::<f32>() / 3.0)
    }

    #[inline(always)]
    fn draw<S: Simd>(&self, simd: S, canvas: &mut Canvas) {
        for triangles in self.mesh.triangles.chunks(LANES) {
            draw_eight(simd, canvas, self, triangles);
        }
    }
}

impl Task for DrawMesh<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self {
            buffer,
            mesh,
            clip_from_model,
            faces,
            bands,
        } = self;
        if buffer.mode == RasterMode::Strict {
            draw_outlined(simd, buffer, mesh, clip_from_model, faces, bands);
            return;
        }
        let Begun {
            mut canvas,
            touched,
            on_screen,
            ..
        } = buffer.begin_drawing(bands);
        project(simd, mesh, &clip_from_model.as_mat4(), canvas.size, on_screen);
        let drawing = ByCenters {
            mesh,
            clip_from_model,
            faces,
            on_screen,
        };
        draw_in_bands(simd, &drawing, bands, &mut canvas, touched);
    }
}

/// Brings vertices to the screen: x and y in pixels, depth, and where they are outside.
#[inline(always)]
fn project<S: Simd>(simd: S, mesh: &OccluderMesh, clip_from_model: &Mat4, size: UVec2, on_screen: &mut Vec<[f32; 4]>) {
    on_screen.clear();
    let half = size.as_vec2() * 0.5;
    let row = |row: usize| {
        let row = clip_from_model.row(row);
        [row.x, row.y, row.z, row.w]
    };
    let rows = [row(0), row(1), row(2), row(3)];
    let zero = simd.splat(0.0);
    for vertices in &mesh.vertices {
        let at = [
            simd.load(&vertices[0]),
            simd.load(&vertices[1]),
            simd.load(&vertices[2]),
        ];
        let mut clip = [zero; 4];
        for (row, clip) in rows.iter().zip(&mut clip) {
            *clip = simd.add(
                simd.add(simd.mul(at[0], simd.splat(row[0])), simd.mul(at[1], simd.splat(row[1]))),
                simd.add(simd.mul(at[2], simd.splat(row[2])), simd.splat(row[3])),
            );
        }
        let [x, y, z, w] = clip;
        let back = simd.sub(zero, w);
        let per_w = simd.div(simd.splat(1.0), w);
        let screen_x = simd.add(simd.mul(simd.mul(x, per_w), simd.splat(half.x)), simd.splat(half.x));
        let screen_y = simd.sub(simd.splat(half.y), simd.mul(simd.mul(y, per_w), simd.splat(half.y)));
        let is_close = simd.and(is_close(simd, screen_x), is_close(simd, screen_y));
        let is_beyond_near = simd.and_not(simd.lt_lanes(zero, w), simd.lt_lanes(w, z));
        let sides = simd.or(
            simd.or(
                simd.and(simd.lt_lanes(x, back), simd.splat_bits(outside::LEFT)),
                simd.and(simd.lt_lanes(w, x), simd.splat_bits(outside::RIGHT)),
            ),
            simd.or(
                simd.and(simd.lt_lanes(y, back), simd.splat_bits(outside::BELOW)),
                simd.and(simd.lt_lanes(w, y), simd.splat_bits(outside::ABOVE)),
            ),
        );
        let depths = simd.or(
            simd.and_not(simd.splat_bits(outside::NEAR), is_beyond_near),
            simd.and_not(simd.splat_bits(outside::FAR_AWAY), is_close),
        );
        on_screen.extend_from_slice(&simd.rows([
            screen_x,
            screen_y,
            simd.mul(z, per_w),
            simd.floats(simd.or(sides, depths)),
        ]));
    }
}

/// The lanes that are not far beside the screen. What is NaN is.
#[inline(always)]
fn is_close<S: Simd>(simd: S, at: S::F32s) -> S::U32s {
    simd.and(
        simd.lt_lanes(at, simd.splat(GUARD)),
        simd.lt_lanes(simd.splat(-GUARD), at),
    )
}

#[inline(always)]
fn draw_eight<S: Simd>(simd: S, canvas: &mut Canvas, drawing: &ByCenters, triangles: &[[u32; 3]]) {
    let on_screen = drawing.on_screen;
    let mut rows = [[&on_screen[0]; LANES]; 3];
    for (lane, triangle) in triangles.iter().enumerate() {
        for corner in 0..3 {
            rows[corner][lane] = &on_screen[triangle[corner] as usize];
        }
    }
    let [a, b, c] = [
        simd.transpose(rows[0]),
        simd.transpose(rows[1]),
        simd.transpose(rows[2]),
    ];
    let (out_a, out_b, out_c) = (simd.bits(a[3]), simd.bits(b[3]), simd.bits(c[3]));
    let none = simd.splat_bits(0);
    let everywhere = simd.and(simd.and(out_a, out_b), out_c);
    let anywhere = simd.or(simd.or(out_a, out_b), out_c);
    // A vertex behind the eye is beside the screen in a way that says nothing, but for all three together it does.
    let sides = outside::LEFT | outside::RIGHT | outside::BELOW | outside::ABOVE | outside::NEAR;
    let is_in_view = simd.eq_bits(simd.and(everywhere, simd.splat_bits(sides)), none);
    let is_plain = simd.eq_bits(
        simd.and(anywhere, simd.splat_bits(outside::NEAR | outside::FAR_AWAY)),
        none,
    );
    let present = 0xff >> (LANES - triangles.len());
    let in_view = simd.high_bits(is_in_view) & present;
    let plain = simd.high_bits(is_plain);

    let special = in_view & !plain;
    if special != 0 {
        draw_special(simd, canvas, drawing, triangles, special);
    }
    let plain = in_view & plain;
    if plain == 0 {
        return;
    }
    let batch = Batch::<S> {
        x: [a[0], b[0], c[0]],
        y: [a[1], b[1], c[1]],
        depth: [a[2], b[2], c[2]],
    };
    draw_plain(simd, canvas, &batch, drawing.faces, plain);
}

/// Draws triangles that the near plane cuts, or that are far beside the screen.
#[cold]
#[inline(never)]
fn draw_special<S: Simd>(simd: S, canvas: &mut Canvas, drawing: &ByCenters, triangles: &[[u32; 3]], mut lanes: u32) {
    let ByCenters {
        mesh,
        clip_from_model,
        faces,
        ..
    } = *drawing;
    while lanes != 0 {
        let triangle = triangles[lanes.trailing_zeros() as usize];
        lanes &= lanes - 1;
        let mut corners = triangle.map(|vertex| {
            let (group, lane) = (vertex as usize / LANES, vertex as usize % LANES);
            let at = mesh.vertices[group].map(|axis| f64::from(axis[lane]));
            Corner {
                clip: *clip_from_model * DVec4::new(at[0], at[1], at[2], 1.0),
                is_within: false,
            }
        });
        let [p, q, r] = corners.map(|corner| xyw(corner.clip));
        let is_front = p.dot(q.cross(r)) > 0.0;
        match faces {
            Faces::Front if !is_front => continue,
            Faces::Back if is_front => continue,
            _ => {}
        }
        if !is_front {
            corners.swap(1, 2);
        }
        draw_by_centers(simd, canvas, &corners);
    }
}

/// Draws a convex polygon, whose corners run counter-clockwise as seen, to the pixels whose centres are in it.
#[inline(always)]
pub(super) fn draw_by_centers<S: Simd>(simd: S, canvas: &mut Canvas, polygon: &[Corner]) {
    let Canvas { size, band, tiles, .. } = canvas;
    let clipped = clip_near(polygon);
    let places = clipped.iter().map(|corner| corner.clip);
    if clipped.is_empty() || places.clone().any(|clip| clip.w <= 0.0) || is_outside(places.clone()) {
        return;
    }
    let pixels: SmallVec<[DVec2; 6]> = places.clone().map(|clip| to_pixels(clip, *size)).collect();
    let Some(region) = PolygonRegion::new(&pixels, Coverage::Centers, *size) else {
        return;
    };
    let region = region.as_region();
    let corners = [polygon[0].clip, polygon[1].clip, polygon[2].clip];
    let plane = DepthPlane::new(corners, &region, depths(places), *size);
    let mut paint = Paint {
        tiles,
        planes: &[plane],
    };
    fill(simd, &region, band, &mut paint);
}

/// The pixels, from the first to before the end, whose centres are between three coordinates, of those that there are.
#[inline(always)]
fn pixels_between<S: Simd>(simd: S, values: &[S::F32s; 3], pixels: Range<u32>) -> (S::F32s, S::F32s) {
    let half = simd.splat(0.5);
    let least = simd.min(simd.min(values[0], values[1]), values[2]);
    let greatest = simd.max(simd.max(values[0], values[1]), values[2]);
    let first = simd.max(simd.ceil(simd.sub(least, half)), simd.splat(pixels.start as f32));
    let end = simd.min(simd.ceil(simd.sub(greatest, half)), simd.splat(pixels.end as f32));
    (first, end)
}

/// Draws triangles of which all is well within the reach of single precision.
#[inline(always)]
fn draw_plain<S: Simd>(simd: S, canvas: &mut Canvas, batch: &Batch<S>, faces: Faces, lanes: u32) {
    let Canvas { size, band, tiles, .. } = canvas;
    let in_band = band.rows();
    let Batch { x, y, depth } = batch;
    let zero = simd.splat(0.0);
    let (ab, ac) = (
        [simd.sub(x[1], x[0]), simd.sub(y[1], y[0]), simd.sub(depth[1], depth[0])],
        [simd.sub(x[2], x[0]), simd.sub(y[2], y[0]), simd.sub(depth[2], depth[0])],
    );
    // Rows are counted downward: what runs counter-clockwise as seen is negative here.
    let area = simd.sub(simd.mul(ac[0], ab[1]), simd.mul(ab[0], ac[1]));
    let wanted = match faces {
        Faces::Front => simd.lt(zero, area),
        Faces::Back => simd.lt(area, zero),
        Faces::Both => simd.lt(zero, area) | simd.lt(area, zero),
    };
    let (first_column, end_column) = pixels_between(simd, x, 0..size.x);
    let (first_row, end_row) = pixels_between(simd, y, in_band.start..in_band.end.min(size.y));
    let mut lanes = lanes & wanted & simd.lt(first_column, end_column) & simd.lt(first_row, end_row);
    if lanes == 0 {
        return;
    }

    let half = simd.splat(0.5);
    // Lines of the edges, of which those that go down are on the left, and of back faces on the right.
    let is_back = simd.lt_lanes(area, zero);
    let (no_left, no_right) = (simd.splat(Line::NO_LEFT), simd.splat(Line::NO_RIGHT));
    let mut edges = [[[0.0; LANES]; 5]; 3];
    for (from, edge) in edges.iter_mut().enumerate() {
        let to = (from + 1) % 3;
        let drop = simd.sub(y[to], y[from]);
        let is_level = simd.eq_bits(simd.bits(simd.mul(drop, drop)), simd.splat_bits(0));
        let slope = simd.div(simd.sub(x[to], x[from]), drop);
        let slope = simd.blend(is_level, zero, slope);
        let goes_down = simd.lt_lanes(zero, drop);
        let goes_up = simd.lt_lanes(drop, zero);
        let is_left = simd.or(simd.and_not(goes_down, is_back), simd.and(goes_up, is_back));
        let is_right = simd.or(simd.and_not(goes_up, is_back), simd.and(goes_down, is_back));
        let is_left = simd.and_not(is_left, is_level);
        let is_right = simd.and_not(is_right, is_level);
        *edge = [
            simd.store(simd.sub(x[from], half)),
            simd.store(simd.sub(y[from], half)),
            simd.store(slope),
            simd.store(simd.blend(is_left, zero, no_left)),
            simd.store(simd.blend(is_right, zero, no_right)),
        ];
    }

    let per_area = simd.div(simd.splat(-1.0), area);
    let per_column = simd.mul(simd.sub(simd.mul(ab[2], ac[1]), simd.mul(ac[2], ab[1])), per_area);
    let per_row = simd.mul(simd.sub(simd.mul(ac[2], ab[0]), simd.mul(ab[2], ac[0])), per_area);
    let plane = [
        simd.store(x[0]),
        simd.store(y[0]),
        simd.store(depth[0]),
        simd.store(per_column),
        simd.store(per_row),
        simd.store(simd.min(simd.min(depth[0], depth[1]), depth[2])),
        simd.store(simd.max(simd.max(depth[0], depth[1]), depth[2])),
    ];
    let (first_column, end_column) = (simd.store(first_column), simd.store(end_column));
    let (first_row, end_row) = (simd.store(first_row), simd.store(end_row));
    while lanes != 0 {
        let lane = lanes.trailing_zeros() as usize % LANES;
        lanes &= lanes - 1;
        let mut lines = [Line::left(0.0, 0.0, 0.0); 3];
        for (line, edge) in lines.iter_mut().zip(&edges) {
            *line = Line {
                x: edge[0][lane],
                y: edge[1][lane],
                slope: edge[2][lane],
                as_left: edge[3][lane],
                as_right: edge[4][lane],
            };
        }
        let plane = DepthPlane {
            x: plane[0][lane],
            y: plane[1][lane],
            depth: plane[2][lane],
            per_column: plane[3][lane],
            per_row: plane[4][lane],
            least: plane[5][lane],
            greatest: plane[6][lane],
            columns: [first_column[lane], end_column[lane]],
            rows: [first_row[lane], end_row[lane]],
        };
        let region = Region {
            lines: &lines,
            rows: first_row[lane] as u32..end_row[lane] as u32,
            columns: first_column[lane] as u32..end_column[lane] as u32,
        };
        let mut paint = Paint {
            tiles,
            planes: std::slice::from_ref(&plane),
        };
        fill(simd, &region, band, &mut paint);
    }
}
