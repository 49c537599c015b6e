//! Surfaces that rays hit: the primitives of Bevy, and groups of surfaces in bounding volumes.
//!
//! Every primitive with a surface is one: [`Sphere`], [`Plane3d`], [`InfinitePlane3d`], [`Cuboid`], [`Cylinder`],
//! [`Capsule3d`], [`Cone`], [`ConicalFrustum`], [`Torus`], [`Triangle3d`], [`Tetrahedron`] and the [`Extrusion`]s of flat
//! primitives. `Line3d`, `Segment3d` and `Polyline3d` have none.
//!
//! - **Place.** Each lies as its mesh lies by default: around the origin, with its axis along y.
//! - **Exactness.** The coordinates of the ray and the sizes count as exact, and what is computed from them in double
//!   precision is rounded once, at the end. The parameter of a hit is right to 1 unit in the last place, unless the ray
//!   grazes the surface or starts so close to it that even double precision cancels. The parameter overflows where a tiny
//!   direction meets a huge shape: that is no hit.
//! - **Start.** A ray that starts on a surface, to the last digit, hits it there if it comes from the front.
//! - **Seams.** A ray that enters a solid does so through one of its faces, and never slips through between two.
//! - **Sizes.** A negative size counts as its absolute value. A round shape without a radius, and a rectangle or a flat
//!   outline without an area, are missed, and so is what has a NaN for a size. Of a solid without height its two faces
//!   are left.
//! - **Textures.** The texture coordinates are those of the mesh, where curves take the place of facets.
//!
//! [`Sphere`]: bevy::math::primitives::Sphere
//! [`Plane3d`]: bevy::math::primitives::Plane3d
//! [`InfinitePlane3d`]: bevy::math::primitives::InfinitePlane3d
//! [`Cuboid`]: bevy::math::primitives::Cuboid
//! [`Cylinder`]: bevy::math::primitives::Cylinder
//! [`Capsule3d`]: bevy::math::primitives::Capsule3d
//! [`Cone`]: bevy::math::primitives::Cone
//! [`ConicalFrustum`]: bevy::math::primitives::ConicalFrustum
//! [`Torus`]: bevy::math::primitives::Torus
//! [`Triangle3d`]: bevy::math::primitives::Triangle3d
//! [`Tetrahedron`]: bevy::math::primitives::Tetrahedron
//! [`Extrusion`]: bevy::math::primitives::Extrusion

mod bounded;
mod capsule;
mod chart;
mod cuboid;
mod extrusion;
mod group;
mod outline;
mod plane;
mod revolution;
mod solid;
mod span;
mod sphere;
mod torus;
mod triangle;
mod volume;

use std::{ops::ControlFlow, sync::Arc};

use bevy::math::{DVec3, Vec2, Vec3, bounding::Aabb3d};

use self::chart::Chart;
pub use self::{bounded::BoundedSurface, group::SurfaceGroup, volume::VolumeSurface};
use super::{
    ray::{Ray, triangle::Backfaces},
    support::Support,
};

/// Something that a ray can hit.
pub trait Surface: Send + Sync {
    /// A box around the surface, or `None` if it has no end or [is empty](Surface::is_empty).
    fn aabb(&self) -> Option<Aabb3d>;

    /// Whether there is nothing at all to hit, and so nothing to be in a box.
    fn is_empty(&self) -> bool {
        false
    }

    /// The plane that all of the surface lies in: its unit normal, and its distance from the origin along that. `None`,
    /// the default, if there is none, or none that matters.
    ///
    /// With it, layers in parallel planes are told apart from afar: hits on things that have been moved, rotated or
    /// scaled get digits that the ray no longer has in the space of the surface.
    fn plane(&self) -> Option<(Vec3, f32)> {
        None
    }

    /// The hit with the smallest parameter among those that belong to the ray, in the space of the surface.
    ///
    /// With [`Backfaces::Cull`] the ray passes through what it sees from behind, so that a ray from inside a closed
    /// surface leaves it unhindered.
    fn closest_hit(&self, ray: &Ray, backfaces: Backfaces) -> Option<SurfaceHit>;

    /// Whether there is any hit.
    fn any_hit(&self, ray: &Ray, backfaces: Backfaces) -> bool {
        // What is not on the ray is no hit, whatever a surface says.
        let hit = self.closest_hit(ray, backfaces);
        hit.is_some_and(|hit| ray.has_parameter(hit.t))
    }

    /// Visits convex shapes that contain the surface together, as tightly as they can, each of them touching it: for
    /// questions that no ray answers, as what is selected on the screen. A solid is convex itself, or has a convex hull; a
    /// group has the shapes of its members. By default the [box](Surface::aabb), if there is one.
    fn visit_hulls(&self, visit: &mut dyn FnMut(&dyn Support) -> ControlFlow<()>) -> ControlFlow<()> {
        self.aabb().map_or(ControlFlow::Continue(()), |aabb| visit(&aabb))
    }
}

/// Implements [`Surface::visit_hulls`] for a primitive that is its own hull if its sizes are in order.
macro_rules! own_hull {
    () => {
        fn visit_hulls(
            &self,
            visit: &mut dyn FnMut(&dyn $crate::geometry::support::Support) -> std::ops::ControlFlow<()>,
        ) -> std::ops::ControlFlow<()> {
            $crate::geometry::surface::visit_own_hull(self, visit)
        }
    };
}
use own_hull;

/// Visits the surface itself if its farthest points are the ends of its box, and else the box: they are not where a size
/// is negative, which counts as its absolute value for rays.
fn visit_own_hull<S: Surface + Support>(
    surface: &S,
    visit: &mut dyn FnMut(&dyn Support) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let Some(aabb) = surface.aabb() else {
        return ControlFlow::Continue(());
    };
    let own = DVec3::AXES.map(|axis| [axis, -axis].map(|axis| axis.dot(surface.support_point(axis))));
    let (min, max) = (aabb.min.to_array(), aabb.max.to_array());
    let reaches = |(axis, [to, from]): (usize, [f64; 2])| {
        // The box is rounded outward.
        let slack = f64::from(2.0 * f32::EPSILON * max[axis].abs().max(min[axis].abs()));
        to >= f64::from(max[axis]) - slack && -from <= f64::from(min[axis]) + slack
    };
    if own.into_iter().enumerate().all(reaches) {
        visit(surface)
    } else {
        visit(&aabb)
    }
}

/// Implements [`Surface`] for pointers to one.
macro_rules! surface_behind {
    ($($pointer:ty),*) => {$(
        impl<S: Surface + ?Sized> Surface for $pointer {
            fn aabb(&self) -> Option<Aabb3d> {
                (**self).aabb()
            }

            fn is_empty(&self) -> bool {
                (**self).is_empty()
            }

            fn plane(&self) -> Option<(Vec3, f32)> {
                (**self).plane()
            }

            #[inline]
            fn closest_hit(&self, ray: &Ray, backfaces: Backfaces) -> Option<SurfaceHit> {
                (**self).closest_hit(ray, backfaces)
            }

            #[inline]
            fn any_hit(&self, ray: &Ray, backfaces: Backfaces) -> bool {
                (**self).any_hit(ray, backfaces)
            }

            fn visit_hulls(&self, visit: &mut dyn FnMut(&dyn Support) -> ControlFlow<()>) -> ControlFlow<()> {
                (**self).visit_hulls(visit)
            }
        }
    )*};
}
surface_behind!(&S, Box<S>, Arc<S>);

/// Where a ray meets a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit {
    /// The parameter of the ray.
    pub t: f32,
    /// The unit normal of the surface, on its front side, from whichever side it was hit.
    pub normal: Vec3,
    chart: Chart,
}

impl SurfaceHit {
    /// A hit at the parameter `t` of the ray, with the unit normal on the front side, and the texture coordinates.
    pub fn new(t: f32, normal: Vec3, uv: Vec2) -> Self {
        Self {
            t,
            normal,
            chart: Chart::Plain(uv),
        }
    }

    /// The texture coordinates. Those of the primitives are in `0..=1`, and are worked out here: an arc tangent takes
    /// longer than finding the hit.
    pub fn uv(&self) -> Vec2 {
        self.chart.uv(self.normal)
    }
}
