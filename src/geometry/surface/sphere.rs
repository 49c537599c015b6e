//! Spheres.

use bevy::math::{DVec3, primitives::Sphere};

use super::{
    Surface, SurfaceHit,
    chart::Chart,
    solid::{Solid, surface_by_solid},
    span::{Crossing, Line, Quadratic},
};
use crate::geometry::ray::{Ray, triangle::Backfaces};

/// Textured by longitude and latitude, as the mesh that a [`Sphere`] becomes by default.
impl Surface for Sphere {
    surface_by_solid!(Sphere, Ball);
}

pub struct Ball {
    pub radius: f64,
}

impl From<&Sphere> for Ball {
    #[inline]
    fn from(sphere: &Sphere) -> Self {
        Self {
            radius: f64::from(sphere.radius).abs(),
        }
    }
}

impl Ball {
    /// Where the line enters and leaves the ball, or `None` if the ray misses it. A ball without a radius has no
    /// normals, and is missed.
    #[inline]
    pub fn ends(&self, line: &Line) -> Option<Quadratic> {
        let Line {
            origin,
            direction,
            start,
        } = *line;
        let (b, c) = (
            origin.dot(direction),
            origin.length_squared() - self.radius * self.radius,
        );
        if b > 0.0 && c > 0.0 && start == 0.0 {
            return None;
        }
        let a = direction.length_squared();
        // b² - a c by Lagrange's identity: without the cancellation of huge products of a far origin.
        let discriminant = self.radius * self.radius * a - origin.cross(direction).length_squared();
        Quadratic::new(a, b, c, discriminant).filter(|_| self.radius > 0.0)
    }
}

impl Solid for Ball {
    type Face = ();

    fn half_size(&self) -> DVec3 {
        DVec3::splat(self.radius)
    }

    #[inline]
    fn round_size(&self) -> f64 {
        self.radius
    }

    #[inline]
    fn first_crossing(&self, line: &Line, ray: &Ray, backfaces: Backfaces) -> Option<Crossing<()>> {
        let ends = self.ends(line)?;
        match Crossing::at((ends.enter(), ()), line, ray) {
            None if backfaces == Backfaces::Include => Crossing::at((ends.leave(), ()), line, ray),
            entered => entered,
        }
    }

    #[inline]
    fn hit(&self, Crossing { t, point, .. }: Crossing<()>) -> SurfaceHit {
        SurfaceHit {
            t,
            normal: (point * (1.0 / self.radius)).as_vec3(),
            chart: Chart::Globe,
        }
    }
}
