//! Surfaces in bounding volumes.

use std::ops::ControlFlow;

use bevy::math::bounding::Aabb3d;

use super::{Surface, SurfaceHit};
use crate::geometry::{
    ray::{Ray, triangle::Backfaces},
    support::Support,
    volume::Volume,
};

/// A surface in a volume that is cheaper to test: only a ray that meets the volume is tested against the surface.
///
/// It is hit where the surface is, by the same rays, and only faster.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundedSurface<V, S> {
    volume: V,
    surface: S,
}

impl<V: Volume, S: Surface> BoundedSurface<V, S> {
    /// The surface in a volume, in the same space.
    ///
    /// The volume must contain the surface as the test of that sees it: what sticks out may be missed. A test in single
    /// precision, as that of a hierarchy of triangles, sees it larger by some units in the last place of the distance of
    /// the ray: [grow](Volume::grown) the volume by so much.
    pub fn new(volume: V, surface: S) -> Self {
        Self { volume, surface }
    }

    /// The volume.
    pub fn volume(&self) -> &V {
        &self.volume
    }

    /// The surface.
    pub fn surface(&self) -> &S {
        &self.surface
    }

    /// The surface, taken out of its volume.
    pub fn into_surface(self) -> S {
        self.surface
    }
}

impl<S: Surface> BoundedSurface<Aabb3d, S> {
    /// The surface in its [own box](Surface::aabb), or `None` if it has none.
    pub fn in_aabb(surface: S) -> Option<Self> {
        surface.aabb().map(|volume| Self { volume, surface })
    }
}

impl<V: Volume + Send + Sync, S: Surface> Surface for BoundedSurface<V, S> {
    fn aabb(&self) -> Option<Aabb3d> {
        self.surface.aabb()
    }

    fn is_empty(&self) -> bool {
        self.surface.is_empty()
    }

    #[inline]
    fn closest_hit(&self, ray: &Ray, backfaces: Backfaces) -> Option<SurfaceHit> {
        self.volume.ray_intersection_at(ray)?;
        self.surface.closest_hit(ray, backfaces)
    }

    #[inline]
    fn any_hit(&self, ray: &Ray, backfaces: Backfaces) -> bool {
        self.volume.ray_intersection_at(ray).is_some() && self.surface.any_hit(ray, backfaces)
    }

    fn visit_hulls(&self, visit: &mut dyn FnMut(&dyn Support) -> ControlFlow<()>) -> ControlFlow<()> {
        self.surface.visit_hulls(visit)
    }
}
