//! Boxes.

use bevy::math::{DVec2, DVec3, Vec3, primitives::Cuboid};

use super::{
    Surface, SurfaceHit,
    chart::Chart,
    solid::{Solid, surface_by_solid},
    span::{Crossing, Line, slab_span},
};
use crate::geometry::ray::{Ray, triangle::Backfaces};

/// The whole texture lies on each face, as on the mesh of a [`Cuboid`]. One that is flat has two faces.
impl Surface for Cuboid {
    surface_by_solid!(Cuboid, Block);
}

pub struct Block {
    pub half_size: DVec3,
}

/// An axis, and whether it is the face on its positive side.
#[derive(Clone, Copy)]
pub struct Face {
    axis: usize,
    positive: bool,
}

impl From<&Cuboid> for Block {
    #[inline]
    fn from(cuboid: &Cuboid) -> Self {
        Self {
            half_size: cuboid.half_size.as_dvec3().abs(),
        }
    }
}

impl Solid for Block {
    type Face = Face;

    fn half_size(&self) -> DVec3 {
        self.half_size
    }

    #[inline]
    fn round_size(&self) -> f64 {
        // The faces are where they are: no rounding of a far origin shows.
        f64::INFINITY
    }

    #[inline]
    fn first_crossing(&self, line: &Line, ray: &Ray, backfaces: Backfaces) -> Option<Crossing<Face>> {
        let slab = |axis: usize| {
            slab_span(
                line.origin[axis],
                line.direction[axis],
                self.half_size[axis],
                [false, true].map(|positive| Face { axis, positive }),
            )
        };
        slab(0)?.and(slab(1)?)?.and(slab(2)?)?.crossing(line, ray, backfaces)
    }

    #[inline]
    fn hit(&self, Crossing { t, point, face }: Crossing<Face>) -> SurfaceHit {
        let Face { axis, positive } = face;
        let (x, y, z) = (point.x, point.y, point.z);
        let (hx, hy, hz) = (self.half_size.x, self.half_size.y, self.half_size.z);
        let (point, half_size) = match (axis, positive) {
            (0, true) => (DVec2::new(y, z), DVec2::new(hy, hz)),
            (0, false) => (DVec2::new(y, z), DVec2::new(-hy, -hz)),
            (1, true) => (DVec2::new(x, z), DVec2::new(hx, hz)),
            (1, false) => (DVec2::new(x, z), DVec2::new(-hx, -hz)),
            (_, true) => (DVec2::new(x, y), DVec2::new(hx, hy)),
            (_, false) => (DVec2::new(x, y), DVec2::new(-hx, -hy)),
        };
        let mut normal = Vec3::ZERO;
        normal[axis] = if positive { 1.0 } else { -1.0 };
        SurfaceHit {
            t,
            normal,
            chart: Chart::centered(point, half_size),
        }
    }
}
