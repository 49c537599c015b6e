//! What covers whole pixels: the connected triangles of a mesh together, by their fill and their outline.
//!
//! The picture of some polygons is a closed set whose boundary lies on those of their edges that no other polygon
//! continues: the outline. A pixel is a connected set. So if the centre of a pixel is in the picture, and no edge of the
//! outline touches the pixel, then all of it is in the picture.

use bevy::math::{DMat4, DVec2, DVec4, UVec2, Vec3, Vec3A};
use smallvec::SmallVec;

use super::{
    buffer::{Begun, Faces, MaskedDepthBuffer},
    canvas::{Band, Canvas, Drawing, draw_in_bands},
    clip::{Corner, Coverage, PolygonRegion, Vertex, clip_near, depths, is_beside, is_outside, to_pixels, winding},
    fill::{Brush, fill},
    mesh::OccluderMesh,
    plane::{DepthPlane, Paint, farthest_of_blocks},
    tile::Tile,
};
use crate::{
    geometry::tolerance,
    spatial::simd::{LANES, Simd},
};

/// From how many pixels on the rectangle around a polygon makes it worth to draw it by itself too: its own depth is
/// nearer than that of all of the mesh around it.
const LARGE: usize = 64;

/// What has been drawn of a mesh to a tile.
#[derive(Clone, Copy, Debug)]
pub(super) struct ObjectTile {
    /// Pixels whose centres are covered.
    filled: [u32; LANES],
    /// Pixels that the outline touches.
    outlined: [u32; LANES],
    /// Of each block: the farthest of all that covers any of it.
    farthest: [f32; LANES],
    is_listed: bool,
}

impl ObjectTile {
    pub const EMPTY: Self = Self {
        filled: [0; LANES],
        outlined: [0; LANES],
        farthest: [f32::INFINITY; LANES],
        is_listed: false,
    };
}

enum Stroke<'a> {
    Fill,
    Depth(&'a DepthPlane),
    Outline,
}

struct Sketch<'a> {
    object: &'a mut [ObjectTile],
    touched: &'a mut Vec<u32>,
    stroke: Stroke<'a>,
}

impl Brush for Sketch<'_> {
    #[inline(always)]
    fn paint<S: Simd>(&mut self, simd: S, tile: usize, left: f32, top: f32, pixels: S::U32s) {
        let object = &mut self.object[tile];
        if !object.is_listed {
            object.is_listed = true;
            self.touched.push(tile as u32);
        }
        match self.stroke {
            Stroke::Fill => object.filled = simd.store_bits(simd.or(simd.load_bits(&object.filled), pixels)),
            Stroke::Outline => object.outlined = simd.store_bits(simd.or(simd.load_bits(&object.outlined), pixels)),
            Stroke::Depth(plane) => {
                let is_untouched = simd.eq_bits(pixels, simd.splat_bits(0));
                let known = simd.load(&object.farthest);
                let farthest = simd.min(farthest_of_blocks(simd, plane, left, top), known);
                object.farthest = simd.store(simd.blend(is_untouched, known, farthest));
            }
        }
    }
}

/// Some polygons that are drawn together.
pub(super) struct Object<'a> {
    size: UVec2,
    band: &'a Band,
    tiles: &'a mut [Tile],
    object: &'a mut [ObjectTile],
    touched: &'a mut Vec<u32>,
    least_w: f64,
    /// Whether all corners were far enough from the eye.
    is_sure: bool,
}

impl<'a> Object<'a> {
    /// Begins with corners that must be so far from the eye: see [`least_w`].
    pub fn begin(canvas: &'a mut Canvas, least_w: f64) -> Self {
        Self {
            size: canvas.size,
            band: &canvas.band,
            tiles: canvas.tiles,
            object: canvas.object,
            touched: canvas.touched,
            least_w,
            is_sure: true,
        }
    }

    /// Draws a convex polygon whose corners run counter-clockwise as seen. What is in no pixel of the band still tells whether
    /// the whole is sure.
    #[inline(always)]
    pub fn add<S: Simd>(&mut self, simd: S, polygon: &[Corner]) {
        if !polygon.iter().all(|corner| corner.clip.is_finite()) {
            self.is_sure = false;
            return;
        }
        let clipped = clip_near(polygon);
        if clipped.is_empty() || is_outside(clipped.iter().map(|corner| corner.clip)) {
            return;
        }
        if !clipped.iter().all(|corner| corner.clip.w > self.least_w) {
            self.is_sure = false;
            return;
        }
        let pixels: SmallVec<[DVec2; 6]> = clipped.iter().map(|corner| to_pixels(corner.clip, self.size)).collect();
        if !pixels.iter().all(|pixel| pixel.is_finite()) {
            self.is_sure = false;
            return;
        }
        let corners = [polygon[0].clip, polygon[1].clip, polygon[2].clip];
        let depths = depths(clipped.iter().map(|corner| corner.clip));
        self.add_pixels(simd, &pixels, corners, depths, |side| clipped[side].is_within);
    }

    /// The same of a triangle of which all vertices are plain, with which of its edges are no outline.
    #[inline(always)]
    fn add_plain<S: Simd>(&mut self, simd: S, vertices: [&Vertex; 3], is_within: [bool; 3]) {
        if Vertex::are_outside(&vertices) {
            return;
        }
        let depths = vertices
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[least, greatest], vertex| {
                [least.min(vertex.depth), greatest.max(vertex.depth)]
            });
        let pixels = vertices.map(|vertex| vertex.place);
        let corners = vertices.map(|vertex| vertex.clip);
        self.add_pixels(simd, &pixels, corners, depths, |side| is_within[side]);
    }

    /// Draws a polygon on the screen, on the plane of these corners and within these depths.
    #[inline(always)]
    fn add_pixels<S: Simd>(
        &mut self,
        simd: S,
        pixels: &[DVec2],
        corners: [DVec4; 3],
        depths: [f64; 2],
        is_within: impl Fn(usize) -> bool,
    ) {
        let band = self.band;
        if is_beside(pixels, band.rows()) {
            return;
        }
        if let Some(region) = PolygonRegion::new(pixels, Coverage::Touched, self.size) {
            let region = region.as_region();
            let plane = DepthPlane::new(corners, &region, depths, self.size);
            fill(simd, &region, band, &mut self.sketch(Stroke::Depth(&plane)));
            if region.rows.len() * region.columns.len() >= LARGE
                && let Some(region) = PolygonRegion::new(pixels, Coverage::Within, self.size)
            {
                let mut paint = Paint {
                    tiles: self.tiles,
                    planes: &[plane],
                };
                fill(simd, &region.as_region(), band, &mut paint);
            }
        }
        if let Some(region) = PolygonRegion::new(pixels, Coverage::Centers, self.size) {
            fill(simd, &region.as_region(), band, &mut self.sketch(Stroke::Fill));
        }
        for side in (0..pixels.len()).filter(|&side| !is_within(side)) {
            let edge = [pixels[side], pixels[(side + 1) % pixels.len()]];
            if let Some(region) = PolygonRegion::new(&edge, Coverage::Touched, self.size) {
                let mut outline = self.sketch(Stroke::Outline);
                fill(simd, &region.as_region(), band, &mut outline);
            }
        }
    }

    /// Draws all that has been added to the buffer, if it is sure of all.
    #[inline(always)]
    pub fn finish<S: Simd>(self, simd: S) {
        for &tile in &*self.touched {
            let object = std::mem::replace(&mut self.object[tile as usize], ObjectTile::EMPTY);
            if self.is_sure {
                let covered = simd.and_not(simd.load_bits(&object.filled), simd.load_bits(&object.outlined));
                self.tiles[tile as usize].draw(simd, covered, simd.load(&object.farthest));
            }
        }
        self.touched.clear();
    }

    fn sketch<'b>(&'b mut self, stroke: Stroke<'b>) -> Sketch<'b> {
        Sketch {
            object: self.object,
            touched: self.touched,
            stroke,
        }
    }
}

/// How far from the eye, along the view, corners must be for double precision to be sure enough of their places on a
/// screen of this size, if they are at most so far from the origin of a model.
///
/// An error of `e` in clip space moves a line on the screen, where it crosses the screen, by no more than some `e / w` of
/// each of its ends: what is farther out is turned about the middle by as much less as it is farther.
pub(super) fn least_w(clip_from_model: &DMat4, largest: Vec3A, size: UVec2) -> f64 {
    let largest = largest.as_dvec3().extend(1.0);
    let magnitude = (0..4).map(|row| clip_from_model.row(row).abs().dot(largest));
    let unsure = tolerance::RASTER_CORNER * magnitude.fold(0.0, f64::max) * f64::from(size.max_element());
    unsure / f64::from(tolerance::RASTER_PIXELS)
}

/// The triangles of a mesh, of which it is known which are drawn.
struct Outlined<'a> {
    mesh: &'a OccluderMesh,
    vertices: &'a [Vertex],
    is_drawn: &'a [bool],
    /// Whether they are back faces.
    is_back: bool,
    least_w: f64,
}

impl Drawing for Outlined<'_> {
    fn len(&self) -> usize {
        self.mesh.len()
    }

    fn row_of(&self, part: usize) -> Option<f32> {
        let rows = self.mesh.triangles[part].map(|corner| self.vertices[corner as usize].place.y as f32);
        self.is_drawn[part].then(|| rows.iter().sum::<f32>() / 3.0)
    }

    #[inline(always)]
    fn draw<S: Simd>(&self, simd: S, canvas: &mut Canvas) {
        let Self {
            mesh,
            vertices,
            is_drawn,
            is_back,
            ..
        } = *self;
        let mut begin = 0;
        for &end in &mesh.parts {
            let mut drawing = Object::begin(canvas, self.least_w);
            for triangle in begin as usize..end as usize {
                if !is_drawn[triangle] {
                    continue;
                }
                let (corners, neighbours) = (mesh.triangles[triangle], mesh.neighbours[triangle]);
                let is_within = |side: usize| is_drawn.get(neighbours[side] as usize).copied().unwrap_or(false);
                let vertex = |corner: usize| &vertices[corners[corner] as usize];
                // Seen from behind, they run the other way, and each edge belongs to the corner at its other end.
                let (vertices, is_within) = if is_back {
                    (
                        [vertex(0), vertex(2), vertex(1)],
                        [is_within(2), is_within(1), is_within(0)],
                    )
                } else {
                    (
                        [vertex(0), vertex(1), vertex(2)],
                        [is_within(0), is_within(1), is_within(2)],
                    )
                };
                if vertices.iter().all(|vertex| vertex.is_plain) {
                    drawing.add_plain(simd, vertices, is_within);
                } else {
                    let corner = |side: usize| Corner {
                        clip: vertices[side].clip,
                        is_within: is_within[side],
                    };
                    drawing.add(simd, &[corner(0), corner(1), corner(2)]);
                }
            }
            drawing.finish(simd);
            begin = end;
        }
    }
}

/// Draws the triangles of a mesh strictly, to so many bands side by side.
#[inline(always)]
pub(super) fn draw_outlined<S: Simd>(
    simd: S,
    buffer: &mut MaskedDepthBuffer,
    mesh: &OccluderMesh,
    clip_from_model: &DMat4,
    faces: Faces,
    bands: usize,
) {
    let Some(aabb) = mesh.aabb() else {
        return;
    };
    let sides: &[bool] = match faces {
        Faces::Front => &[false],
        Faces::Back => &[true],
        Faces::Both => &[false, true],
    };
    let Begun {
        mut canvas,
        touched,
        vertices,
        is_drawn,
        ..
    } = buffer.begin_drawing(bands);
    let least_w = least_w(clip_from_model, aabb.min.abs().max(aabb.max.abs()), canvas.size);
    vertices.clear();
    for [x, y, z] in &mesh.vertices {
        let places = x.iter().zip(y).zip(z);
        vertices.extend(places.map(|((&x, &y), &z)| {
            let clip = *clip_from_model * Vec3::new(x, y, z).as_dvec3().extend(1.0);
            Vertex::new(clip, least_w, canvas.size)
        }));
    }
    for &is_back in sides {
        is_drawn.clear();
        for corners in &mesh.triangles {
            let winding = winding(corners.map(|corner| vertices[corner as usize].clip));
            is_drawn.push(if is_back { winding < 0.0 } else { winding > 0.0 });
        }
        let drawing = Outlined {
            mesh,
            vertices,
            is_drawn,
            is_back,
            least_w,
        };
        draw_in_bands(simd, &drawing, bands, &mut canvas, touched);
    }
}
