//! The surface of a sprite.

use std::sync::Arc;

use bevy::math::{DVec3, Vec3, Vec3A, bounding::Aabb3d};

use super::{layout::SpriteLayout, mask::AlphaMask};
use crate::geometry::{
    ray::{Ray, triangle::Backfaces},
    surface::{Surface, SurfaceHit},
};

/// A flat rectangle with holes where its image is transparent.
///
/// It is seen from the front on the side of +z. A ray in its plane misses it. Its texture coordinates are those of the
/// image, of an atlas those of the whole.
#[derive(Debug)]
pub(super) struct SpriteSurface {
    pub layout: SpriteLayout,
    /// `None` if there are no holes.
    pub mask: Option<Arc<AlphaMask>>,
}

impl Surface for SpriteSurface {
    fn aabb(&self) -> Option<Aabb3d> {
        let rect = self.layout.rect;
        let (min, max) = (rect.min.extend(0.0), rect.max.extend(0.0));
        Some(Aabb3d {
            min: Vec3A::from(min),
            max: Vec3A::from(max),
        })
    }

    fn closest_hit(&self, ray: &Ray, backfaces: Backfaces) -> Option<SurfaceHit> {
        let origin: DVec3 = Vec3::from(ray.origin()).as_dvec3();
        let direction = Vec3::from(ray.direction()).as_dvec3();
        if direction.z == 0.0 || backfaces == Backfaces::Cull && direction.z > 0.0 {
            return None;
        }
        let t = -origin.z / direction.z;
        let point = origin.truncate() + direction.truncate() * t;
        let rect = self.layout.rect;
        let is_inside = point.cmpge(rect.min.as_dvec2()).all() && point.cmple(rect.max.as_dvec2()).all();
        // The sum turns the negative zero into zero.
        let t = t as f32 + 0.0;
        if !is_inside || !ray.has_parameter(t) {
            return None;
        }
        let pixel = self.layout.pixel_at(point);
        let is_opaque = self.mask.as_ref().is_none_or(|mask| mask.is_opaque_at(pixel));
        is_opaque.then(|| SurfaceHit::new(t, Vec3::Z, self.layout.uv(pixel)))
    }

    fn plane(&self) -> Option<(Vec3, f32)> {
        Some((Vec3::Z, 0.0))
    }
}

impl PartialEq for SpriteSurface {
    /// Whether the two are hit in the same places.
    fn eq(&self, other: &Self) -> bool {
        let same_mask = match (&self.mask, &other.mask) {
            (Some(mask), Some(other)) => Arc::ptr_eq(mask, other),
            (mask, other) => mask.is_none() && other.is_none(),
        };
        same_mask && self.layout == other.layout
    }
}
