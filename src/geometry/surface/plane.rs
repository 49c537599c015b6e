//! Planes.

use bevy::math::{
    DVec2, DVec3, Dir3,
    bounding::Aabb3d,
    primitives::{InfinitePlane3d, Plane3d},
};

use super::{
    Surface, SurfaceHit,
    chart::Chart,
    own_hull,
    solid::enclosing_box,
    span::{Line, parameter_of},
};
use crate::geometry::ray::{Ray, triangle::Backfaces};

/// A rectangle, seen from the front where its normal points. It lies as the mesh of a [`Plane3d`] does: as in the plane
/// y = 0, with its width along x and its height along z, turned by the shortest way that takes +y to the normal. u runs
/// along the width and v along the height.
///
/// A ray in its plane misses it.
impl Surface for Plane3d {
    fn aabb(&self) -> Option<Aabb3d> {
        let (x, z) = axes(self.normal);
        let half_size = self.half_size.as_dvec2().abs();
        let reach = x.abs() * half_size.x + z.abs() * half_size.y;
        enclosing_box(-reach, reach)
    }

    #[inline]
    fn closest_hit(&self, ray: &Ray, backfaces: Backfaces) -> Option<SurfaceHit> {
        let (t, point) = self.hit(ray, backfaces)?;
        Some(SurfaceHit {
            t,
            normal: *self.normal,
            chart: Chart::centered(point, self.half_size.as_dvec2().abs()),
        })
    }

    #[inline]
    fn any_hit(&self, ray: &Ray, backfaces: Backfaces) -> bool {
        self.hit(ray, backfaces).is_some()
    }

    own_hull!();
}

/// Seen from the front where its normal points. The texture lies as on a [`Plane3d`], and repeats at every unit.
///
/// A ray in the plane misses it.
impl Surface for InfinitePlane3d {
    fn aabb(&self) -> Option<Aabb3d> {
        None
    }

    #[inline]
    fn closest_hit(&self, ray: &Ray, backfaces: Backfaces) -> Option<SurfaceHit> {
        let (t, point) = plane_hit(self.normal, ray, backfaces)?;
        let (x, z) = axes(self.normal);
        let uv = DVec2::new(point.dot(x).rem_euclid(1.0), point.dot(z).rem_euclid(1.0));
        Some(SurfaceHit {
            t,
            normal: *self.normal,
            chart: Chart::plain(uv),
        })
    }

    #[inline]
    fn any_hit(&self, ray: &Ray, backfaces: Backfaces) -> bool {
        plane_hit(self.normal, ray, backfaces).is_some()
    }
}

trait Rectangle {
    /// The parameter, and the point along the width and the height.
    fn hit(&self, ray: &Ray, backfaces: Backfaces) -> Option<(f32, DVec2)>;
}

impl Rectangle for Plane3d {
    #[inline]
    fn hit(&self, ray: &Ray, backfaces: Backfaces) -> Option<(f32, DVec2)> {
        let (t, point) = plane_hit(self.normal, ray, backfaces)?;
        let half_size = self.half_size.as_dvec2().abs();
        if point.length_squared() > 2.0 * half_size.length_squared() {
            return None;
        }
        let (x, z) = axes(self.normal);
        let point = DVec2::new(point.dot(x), point.dot(z));
        (point.abs().cmple(half_size).all() && half_size.cmpgt(DVec2::ZERO).all()).then_some((t, point))
    }
}

/// The parameter at which the ray meets the plane through the origin, and the point.
#[inline]
fn plane_hit(normal: Dir3, ray: &Ray, backfaces: Backfaces) -> Option<(f32, DVec3)> {
    let line = Line::of(ray, f64::INFINITY);
    let normal = normal.as_dvec3();
    let (distance, along) = (normal.dot(line.origin), normal.dot(line.direction));
    if along == 0.0 || backfaces == Backfaces::Cull && along > 0.0 {
        return None;
    }
    let t = -distance / along;
    Some((parameter_of(ray, t)?, line.at(t)))
}

/// Where the shortest rotation that takes +y to the normal takes +x and +z; close to -y, the one that Bevy takes.
#[inline]
fn axes(normal: Dir3) -> (DVec3, DVec3) {
    let n = normal.as_dvec3().normalize();
    // As in `Quat::from_rotation_arc`.
    let x = if n.y < f64::from(2.0 * f32::EPSILON - 1.0) {
        (DVec3::NEG_X + n * n.x).normalize()
    } else {
        let scale = n.x / (1.0 + n.y);
        DVec3::new(1.0 - n.x * scale, -n.x, -n.z * scale)
    };
    (x, x.cross(n))
}
