//! Extrusions of flat shapes along the z axis.

use bevy::math::{
    DVec3,
    bounding::Aabb3d,
    primitives::{Extrusion, Primitive2d},
};

use super::{
    Surface, SurfaceHit,
    chart::{Chart, Coordinate},
    outline::{Edge, FlatLine, Outline},
    own_hull,
    solid::enclosing_box,
    span::{Crossing, Line, Span, slab_span},
};
use crate::geometry::ray::{Ray, triangle::Backfaces};

/// With a front, a back and a mantle. Of the flat shapes that Bevy can make a mesh of: `Circle`, `Ellipse`, `Annulus`,
/// `CircularSector`, `CircularSegment`, `Rectangle`, `Rhombus`, `Triangle2d`, `RegularPolygon`, `ConvexPolygon`,
/// `Capsule2d`, and a `Ring` of any of these.
///
/// Textured as the mesh, with curves in place of their chords: the front in the upper left quarter of the texture, the
/// back in the upper right one, the mantle in the lower half, where v runs from front to back and u along the outline.
impl<P: Primitive2d + Outline> Surface for Extrusion<P> {
    fn aabb(&self) -> Option<Aabb3d> {
        let ((min, max), half_depth) = (self.base_shape.bounds(), self.half_depth());
        enclosing_box(min.extend(-half_depth), max.extend(half_depth))
    }

    fn closest_hit(&self, ray: &Ray, backfaces: Backfaces) -> Option<SurfaceHit> {
        let Crossing { t, point, face } = self.first_crossing(ray, backfaces)?;
        let flat = point.truncate();
        let (normal, u, v) = match face {
            Face::Mantle(piece) => {
                let Edge { normal, u } = self.base_shape.edge(piece, flat);
                let back = 0.5 - 0.5 * point.z / self.half_depth().max(f64::MIN_POSITIVE);
                (normal.extend(0.0), u, Coordinate::plain(0.5 + 0.5 * back))
            }
            Face::Front => {
                let [u, v] = self.base_shape.texture(flat);
                (DVec3::Z, u.scaled(0.5, 0.0), v.scaled(0.5, 0.0))
            }
            Face::Back => {
                let [u, v] = self.base_shape.texture(flat);
                (DVec3::NEG_Z, u.scaled(0.5, 0.5), v.scaled(0.5, 0.0))
            }
        };
        Some(SurfaceHit {
            t,
            normal: normal.as_vec3(),
            chart: Chart::Angles { u, v },
        })
    }

    fn any_hit(&self, ray: &Ray, backfaces: Backfaces) -> bool {
        self.first_crossing(ray, backfaces).is_some()
    }

    own_hull!();
}

#[derive(Clone, Copy)]
enum Face {
    Mantle(u32),
    Front,
    Back,
}

/// An extrusion, as a solid.
trait Prism {
    fn half_depth(&self) -> f64;
    fn first_crossing(&self, ray: &Ray, backfaces: Backfaces) -> Option<Crossing<Face>>;
}

impl<P: Primitive2d + Outline> Prism for Extrusion<P> {
    fn half_depth(&self) -> f64 {
        f64::from(self.half_depth).abs()
    }

    fn first_crossing(&self, ray: &Ray, backfaces: Backfaces) -> Option<Crossing<Face>> {
        let line = Line::of(ray, self.base_shape.round_size());
        let slab = slab_span(
            line.origin.z,
            line.direction.z,
            self.half_depth(),
            [Face::Back, Face::Front],
        )?;
        let flat = FlatLine {
            origin: line.origin.truncate(),
            direction: line.direction.truncate(),
        };
        self.base_shape.spans(&flat).into_iter().find_map(|span| {
            let span: Span<Face> = span.map(Face::Mantle).and(slab)?;
            span.crossing(&line, ray, backfaces)
        })
    }
}
