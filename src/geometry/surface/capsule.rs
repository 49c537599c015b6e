//! Capsules.

use std::f32::consts::FRAC_2_PI;

use bevy::math::{DVec2, DVec3, Vec2, primitives::Capsule3d};

use super::{
    Surface, SurfaceHit,
    chart::{Chart, Coordinate},
    solid::{Solid, surface_by_solid},
    span::{Crossing, Line, Quadratic},
    sphere::Ball,
};
use crate::geometry::ray::{Ray, triangle::Backfaces};

/// The texture goes once around, from the +x axis towards +z. It goes up evenly with the height on the side, and with
/// the latitude on the hemispheres, each of which has the share of the texture that its radius has of the height: that
/// is `CapsuleUvProfile::Aspect`.
impl Surface for Capsule3d {
    surface_by_solid!(Capsule3d, Capsule);
}

struct Capsule {
    radius: f64,
    half_length: f64,
}

#[derive(Clone, Copy)]
enum Face {
    Side,
    /// The hemisphere around the centre at this height.
    Hemisphere(f64),
}

impl From<&Capsule3d> for Capsule {
    #[inline]
    fn from(capsule: &Capsule3d) -> Self {
        Self {
            radius: f64::from(capsule.radius).abs(),
            half_length: f64::from(capsule.half_length).abs(),
        }
    }
}

impl Capsule {
    /// Where the line enters and leaves the cylinder without end that the side is a part of, and which contains the
    /// capsule; or `None` if the ray misses it, or runs along it.
    #[inline]
    fn cylinder_ends(&self, line: &Line) -> Option<Quadratic> {
        let Line {
            origin,
            direction,
            start,
        } = *line;
        let (from, along) = (DVec2::new(origin.x, origin.z), DVec2::new(direction.x, direction.z));
        let (a, b, c) = (
            along.length_squared(),
            from.dot(along),
            from.length_squared() - self.radius * self.radius,
        );
        if c > 0.0 && b > 0.0 && start == 0.0 || !(a > 0.0 && self.radius > 0.0) {
            return None;
        }
        let across = from.perp_dot(along);
        let discriminant = self.radius * self.radius * a - across * across;
        Quadratic::new(a, b, c, discriminant)
    }

    /// Where the line enters or leaves the capsule, as it does so with the cylinder at `t`: there, or else on the
    /// hemisphere beyond that end of the side.
    #[inline]
    fn end(&self, line: &Line, t: f64, end: fn(&Quadratic) -> f64) -> Option<(f64, Face)> {
        let y = line.origin.y + line.direction.y * t;
        if y.abs() <= self.half_length {
            return Some((t, Face::Side));
        }
        let center = self.half_length.copysign(y);
        let ends = Ball { radius: self.radius }.ends(&line.relative_to(DVec3::Y * center))?;
        Some((end(&ends), Face::Hemisphere(center)))
    }
}

impl Solid for Capsule {
    type Face = Face;

    fn half_size(&self) -> DVec3 {
        DVec3::new(self.radius, self.half_length + self.radius, self.radius)
    }

    #[inline]
    fn round_size(&self) -> f64 {
        self.radius
    }

    #[inline]
    fn first_crossing(&self, line: &Line, ray: &Ray, backfaces: Backfaces) -> Option<Crossing<Face>> {
        let cylinder = self.cylinder_ends(line);
        // Along the axis, the line is in the cylinder from one infinity to the other, or outside.
        let parallel = line.direction.x == 0.0 && line.direction.z == 0.0;
        if cylinder.is_none() && !parallel {
            return None;
        }
        let enter = cylinder.map_or(f64::NEG_INFINITY, |ends| ends.enter());
        let entered = self
            .end(line, enter, Quadratic::enter)
            .and_then(|end| Crossing::at(end, line, ray));
        if entered.is_some() || backfaces == Backfaces::Cull {
            return entered;
        }
        let leave = cylinder.map_or(f64::INFINITY, |ends| ends.leave());
        Crossing::at(self.end(line, leave, Quadratic::leave)?, line, ray)
    }

    #[inline]
    fn hit(&self, Crossing { t, point, face }: Crossing<Face>) -> SurfaceHit {
        let center = match face {
            Face::Side => point.y,
            Face::Hemisphere(center) => center,
        };
        let normal = ((point - DVec3::Y * center) * (1.0 / self.radius)).as_vec3();
        let share = 0.5 * self.radius / (self.half_length + self.radius);
        let v = match face {
            Face::Side => Coordinate::plain(0.5 + (0.5 - share) * point.y / self.half_length.max(f64::MIN_POSITIVE)),
            // By the angle from the pole at which the texture ends, and so it begins at the other.
            Face::Hemisphere(center) => Coordinate {
                offset: if center.is_sign_positive() { 1.0 } else { 0.0 },
                per_radian: (share as f32 * FRAC_2_PI).copysign(-center as f32),
                angle_of: Vec2::new(normal.y.abs(), normal.x.hypot(normal.z)),
            },
        };
        SurfaceHit {
            t,
            normal,
            chart: Chart::Angles {
                u: Coordinate::turn(DVec2::new(point.x, point.z)),
                v,
            },
        }
    }
}
