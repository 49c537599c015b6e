//! Cylinders, cones and conical frusta: solids of revolution around the y axis with a straight side.

use bevy::math::{
    DVec2, DVec3,
    primitives::{Cone, ConicalFrustum, Cylinder},
};

use super::{
    Surface, SurfaceHit,
    chart::{Chart, Coordinate},
    solid::{Solid, surface_by_solid},
    span::{Crossing, Line, Quadratic, Span, half_space_span, slab_span},
};
use crate::geometry::ray::{Ray, triangle::Backfaces};

/// A conical frustum around the origin with caps.
struct Frustum {
    bottom: f64,
    top: f64,
    half_height: f64,
    /// Of the texture on the side.
    wrapping: Wrapping,
}

/// How a texture lies on the side of a solid of revolution.
#[derive(Clone, Copy)]
enum Wrapping {
    /// u once around, v up.
    Around,
    /// As seen from above.
    FromAbove,
}

#[derive(Clone, Copy)]
enum Face {
    Side,
    Bottom,
    Top,
}

impl Frustum {
    fn new(bottom: f32, top: f32, half_height: f64, wrapping: Wrapping) -> Self {
        Self {
            bottom: f64::from(bottom).abs(),
            top: f64::from(top).abs(),
            half_height: half_height.abs(),
            wrapping,
        }
    }

    /// The radius at half height, and how much it grows for every unit upward. Of a flat frustum, its larger radius.
    #[inline]
    fn profile(&self) -> (f64, f64) {
        if self.half_height == 0.0 {
            (self.largest_radius(), 0.0)
        } else {
            (
                0.5 * (self.bottom + self.top),
                0.5 * (self.top - self.bottom) / self.half_height,
            )
        }
    }

    #[inline]
    fn largest_radius(&self) -> f64 {
        self.bottom.max(self.top)
    }

    #[inline]
    fn span(&self, line: &Line) -> Option<Span<Face>> {
        // Without a radius there is no normal.
        if self.largest_radius() == 0.0 {
            return None;
        }
        let side = self.side_span(line)?;
        let slab = slab_span(
            line.origin.y,
            line.direction.y,
            self.half_height,
            [Face::Bottom, Face::Top],
        )?;
        side.and(slab)
    }

    /// The part of the line inside of the side, as far as this is the cone that has it and not its mirror image beyond
    /// the apex, which is out of the slab between the caps.
    ///
    /// That is where x² + z² - w² <= 0, with w the radius at the height of the point: a quadratic in the Minkowski
    /// form with the signature (+, +, -).
    #[inline]
    fn side_span(&self, line: &Line) -> Option<Span<Face>> {
        let Line { origin, direction, .. } = *line;
        let (radius, slope) = self.profile();
        let (from, along) = (radius + slope * origin.y, slope * direction.y);
        let a = direction.x * direction.x + direction.z * direction.z - along * along;
        let b = origin.x * direction.x + origin.z * direction.z - from * along;
        let c = origin.x * origin.x + origin.z * origin.z - from * from;
        // b² - a c by Lagrange's identity: without the cancellation of huge products of a far origin.
        let (xw, zw, xz) = (
            origin.x * along - from * direction.x,
            origin.z * along - from * direction.z,
            origin.x * direction.z - origin.z * direction.x,
        );
        let discriminant = xw * xw + zw * zw - xz * xz;
        if a > 0.0 {
            Some(Quadratic::new(a, b, c, discriminant)?.span(Face::Side))
        } else if a < 0.0 {
            // Steeper than the side: the line passes from one of the two cones through the outside into the other.
            let outside = Quadratic::new(-a, -b, -c, discriminant.max(0.0))?;
            Some(Span::within(
                if along > 0.0 {
                    (outside.leave(), f64::INFINITY)
                } else {
                    (f64::NEG_INFINITY, outside.enter())
                },
                Face::Side,
            ))
        } else {
            half_space_span(2.0 * b, c, Face::Side)
        }
    }

    #[inline]
    fn side_normal(&self, ground: DVec2) -> DVec3 {
        let (_, slope) = self.profile();
        let radius = ground.length();
        if radius == 0.0 {
            // The apex, where the axis is the mean of all normals.
            return DVec3::Y * -slope.signum();
        }
        DVec3::new(ground.x, -slope * radius, ground.y) / (radius * (1.0 + slope * slope).sqrt())
    }

    #[inline]
    fn side_chart(&self, point: DVec3, ground: DVec2) -> Chart {
        match self.wrapping {
            Wrapping::Around => Chart::Angles {
                u: Coordinate::turn(ground),
                v: Coordinate::plain(0.5 + 0.5 * point.y / self.half_height.max(f64::MIN_POSITIVE)),
            },
            Wrapping::FromAbove => Chart::centered(ground, DVec2::splat(self.largest_radius())),
        }
    }
}

impl Solid for Frustum {
    type Face = Face;

    fn half_size(&self) -> DVec3 {
        let radius = self.largest_radius();
        DVec3::new(radius, self.half_height, radius)
    }

    #[inline]
    fn round_size(&self) -> f64 {
        self.largest_radius()
    }

    #[inline]
    fn first_crossing(&self, line: &Line, ray: &Ray, backfaces: Backfaces) -> Option<Crossing<Face>> {
        self.span(line)?.crossing(line, ray, backfaces)
    }

    #[inline]
    fn hit(&self, Crossing { t, point, face }: Crossing<Face>) -> SurfaceHit {
        let ground = DVec2::new(point.x, point.z);
        let (normal, chart) = match face {
            Face::Side => (self.side_normal(ground), self.side_chart(point, ground)),
            Face::Bottom => (DVec3::NEG_Y, cap_chart(ground, self.bottom)),
            Face::Top => (DVec3::Y, cap_chart(ground, self.top)),
        };
        SurfaceHit {
            t,
            normal: normal.as_vec3(),
            chart,
        }
    }
}

#[inline]
fn cap_chart(ground: DVec2, radius: f64) -> Chart {
    Chart::centered(ground, DVec2::new(radius, -radius))
}

/// With caps. The texture goes once around the side, from the +x axis towards +z, and up; it lies on the caps as seen
/// along +y, with the +z axis up.
impl Surface for Cylinder {
    surface_by_solid!(Cylinder, Frustum);
}

/// With its base. The texture lies on the side as seen from above, and on the base as on that of a [`Cylinder`]. At the
/// apex the normal is that of the axis.
impl Surface for Cone {
    surface_by_solid!(Cone, Frustum);
}

/// With caps, of which either may be the larger one or a point. Textured as a [`Cylinder`].
impl Surface for ConicalFrustum {
    surface_by_solid!(ConicalFrustum, Frustum);
}

impl From<&Cylinder> for Frustum {
    #[inline]
    fn from(cylinder: &Cylinder) -> Self {
        let Cylinder { radius, half_height } = *cylinder;
        Self::new(radius, radius, half_height.into(), Wrapping::Around)
    }
}

impl From<&Cone> for Frustum {
    #[inline]
    fn from(cone: &Cone) -> Self {
        Self::new(cone.radius, 0.0, 0.5 * f64::from(cone.height), Wrapping::FromAbove)
    }
}

impl From<&ConicalFrustum> for Frustum {
    #[inline]
    fn from(frustum: &ConicalFrustum) -> Self {
        Self::new(
            frustum.radius_bottom,
            frustum.radius_top,
            0.5 * f64::from(frustum.height),
            Wrapping::Around,
        )
    }
}
