//! Boxes, drawn by their outline: convex, so that one region is all of it.

use bevy::math::{DMat4, DVec2, bounding::Aabb3d};
use smallvec::SmallVec;

use super::{
    buffer::{Begun, MaskedDepthBuffer, RasterMode},
    canvas::Canvas,
    clip::{Corner, Coverage, PolygonRegion, depths, is_outside, to_pixels, winding},
    fill::fill,
    outline::{Object, least_w},
    plane::{DepthPlane, Paint},
    triangles::draw_by_centers,
};
use crate::spatial::simd::{Simd, Task, dispatch};

/// The corners of each face, counter-clockwise as seen from outside. Bits 0, 1 and 2 of a corner's number say whether it
/// is at the maximum along x, y and z.
const FACES: [[usize; 4]; 6] = [
    [0, 4, 6, 2],
    [1, 3, 7, 5],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 2, 3, 1],
    [4, 5, 7, 6],
];

/// The faces beyond the edges of each face, from each corner to the next.
const BEYOND: [[usize; 4]; 6] = [
    [2, 5, 3, 4],
    [4, 3, 5, 2],
    [4, 1, 5, 0],
    [0, 5, 1, 4],
    [0, 3, 1, 2],
    [2, 1, 3, 0],
];

impl MaskedDepthBuffer {
    /// Draws a solid box of a model's space, as it is seen from outside.
    ///
    /// A box with a coordinate that is NaN or infinite, or that a matrix puts there or makes flat, is not drawn. Nor is
    /// anything drawn of it if the eye is inside.
    pub fn draw_box(&mut self, aabb: &Aabb3d, clip_from_model: &DMat4) {
        dispatch(DrawBox {
            buffer: self,
            aabb,
            clip_from_model,
        });
    }
}

pub(super) struct DrawBox<'a> {
    pub buffer: &'a mut MaskedDepthBuffer,
    pub aabb: &'a Aabb3d,
    pub clip_from_model: &'a DMat4,
}

impl Task for DrawBox<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self {
            buffer,
            aabb,
            clip_from_model,
        } = self;
        let (min, max) = (aabb.min.as_dvec3(), aabb.max.as_dvec3());
        if !(min.is_finite() && max.is_finite() && min.cmplt(max).all() && clip_from_model.is_finite()) {
            return;
        }
        // Corners differ by whole columns.
        let least = *clip_from_model * min.extend(1.0);
        let extent = max - min;
        let sides = [
            clip_from_model.x_axis * extent.x,
            clip_from_model.y_axis * extent.y,
            clip_from_model.z_axis * extent.z,
        ];
        let mut corners = [least; 8];
        for (number, corner) in corners.iter_mut().enumerate() {
            for (axis, side) in sides.iter().enumerate() {
                if number >> axis & 1 != 0 {
                    *corner += *side;
                }
            }
        }
        if is_outside(corners.iter().copied()) {
            return;
        }

        let mode = buffer.mode;
        let Begun { mut canvas, .. } = buffer.begin_drawing(1);
        let size = canvas.size;
        let sign = clip_from_model.determinant().signum();
        let mut is_front = [false; 6];
        for (is_front, face) in is_front.iter_mut().zip(FACES) {
            *is_front = sign * winding([face[0], face[1], face[2]].map(|corner| corners[corner])) > 0.0;
        }
        let largest = aabb.min.abs().max(aabb.max.abs());
        let least_w = least_w(clip_from_model, largest, size);
        let faces = (0..6).filter(|&face| is_front[face]);
        let coverage = match mode {
            RasterMode::Strict => Coverage::Within,
            RasterMode::Fast => Coverage::Centers,
        };
        if corners.iter().any(|clip| clip.z > clip.w || clip.w <= 0.0) {
            let polygon = |face: usize| -> [Corner; 4] {
                let mut polygon = std::array::from_fn(|side| Corner {
                    clip: corners[FACES[face][side]],
                    is_within: is_front[BEYOND[face][side]],
                });
                if sign < 0.0 {
                    // Seen in a mirror, corners run the other way: each edge now belongs to the corner at its other end.
                    polygon.reverse();
                    let within = polygon.map(|corner: Corner| corner.is_within);
                    for side in 0..4 {
                        polygon[side].is_within = within[(side + 1) % 4];
                    }
                }
                polygon
            };
            match mode {
                RasterMode::Strict => {
                    let mut drawing = Object::begin(&mut canvas, least_w);
                    for face in faces {
                        drawing.add(simd, &polygon(face));
                    }
                    drawing.finish(simd);
                }
                RasterMode::Fast => {
                    for face in faces {
                        draw_by_centers(simd, &mut canvas, &polygon(face));
                    }
                }
            }
            return;
        }
        if corners.iter().any(|clip| !clip.is_finite() || clip.w <= least_w) {
            return;
        }

        // From the front faces, whose edges run all the same way around, those edges that only one has.
        let mut outline: SmallVec<[[usize; 2]; 6]> = SmallVec::new();
        let depths = depths(faces.clone().flat_map(|face| FACES[face].map(|corner| corners[corner])));
        for face in faces.clone() {
            for side in 0..4 {
                let (from, to) = (FACES[face][side], FACES[face][(side + 1) % 4]);
                if !is_front[BEYOND[face][side]] {
                    outline.push(if sign < 0.0 { [to, from] } else { [from, to] });
                }
            }
        }
        let mut around: SmallVec<[DVec2; 6]> = SmallVec::new();
        let mut next = outline.first().map(|edge| edge[0]);
        while let Some(corner) = next
            && around.len() < outline.len()
        {
            around.push(to_pixels(corners[corner], size));
            next = outline.iter().find(|edge| edge[0] == corner).map(|edge| edge[1]);
        }
        if around.len() < 3 {
            return;
        }
        let Some(region) = PolygonRegion::new(&around, coverage, size) else {
            return;
        };
        let region = region.as_region();
        let planes: SmallVec<[DepthPlane; 3]> = faces
            .map(|face| {
                let [a, b, c, _] = FACES[face].map(|corner| corners[corner]);
                DepthPlane::new([a, b, c], &region, depths, size)
            })
            .collect();
        let Canvas { band, tiles, .. } = canvas;
        let mut paint = Paint { tiles, planes: &planes };
        fill(simd, &region, &band, &mut paint);
    }
}
