//! Bounding volumes that are hit themselves.

use std::ops::ControlFlow;

use bevy::math::{
    DMat3, DVec3, Vec3,
    bounding::{Aabb3d, BoundingSphere},
};

use super::{
    Surface, SurfaceHit,
    chart::Chart,
    cuboid::Block,
    solid::Solid,
    span::{Crossing, Line, Span, half_space_span},
    sphere::Ball,
};
use crate::geometry::{
    convex_hull::{ConvexHull, HullPlane},
    obb::Obb,
    ray::{Ray, triangle::Backfaces},
    support::Support,
    volume::{AnyVolume, Volume},
};

/// The boundary of a bounding volume, as a surface: what stands in for something that the volume encloses.
///
/// A solid: with [`Backfaces::Cull`] a ray hits it where it enters, and one from inside leaves it unhindered. A volume
/// that is flat is hit from both sides; a sphere without a radius is missed. The normals of a hull are those of its
/// planes. Textured like the primitives, but for the hull, which has no texture coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeSurface(AnyVolume);

impl VolumeSurface {
    /// The boundary of `volume`, in its space.
    pub fn new(volume: AnyVolume) -> Self {
        Self(volume)
    }

    /// The volume.
    pub fn volume(&self) -> &AnyVolume {
        &self.0
    }
}

impl Surface for VolumeSurface {
    fn aabb(&self) -> Option<Aabb3d> {
        let aabb = self.0.aabb();
        (aabb.min.is_finite() && aabb.max.is_finite()).then_some(aabb)
    }

    fn closest_hit(&self, ray: &Ray, backfaces: Backfaces) -> Option<SurfaceHit> {
        match &self.0 {
            AnyVolume::Sphere(sphere) => sphere_hit(sphere, ray, backfaces),
            AnyVolume::Aabb(aabb) => {
                let (min, max) = (aabb.min.as_dvec3(), aabb.max.as_dvec3());
                box_hit((min + max) / 2.0, (max - min) / 2.0, None, ray, backfaces)
            }
            AnyVolume::Obb(obb) => obb_hit(obb, ray, backfaces),
            AnyVolume::Hull(hull) => hull_hit(hull, ray, backfaces),
        }
    }

    fn visit_hulls(&self, visit: &mut dyn FnMut(&dyn Support) -> ControlFlow<()>) -> ControlFlow<()> {
        match &self.0 {
            AnyVolume::Sphere(sphere) => visit(sphere),
            AnyVolume::Aabb(aabb) => visit(aabb),
            AnyVolume::Obb(obb) => visit(obb),
            AnyVolume::Hull(hull) => visit(hull),
        }
    }
}

fn sphere_hit(sphere: &BoundingSphere, ray: &Ray, backfaces: Backfaces) -> Option<SurfaceHit> {
    let ball = Ball {
        radius: f64::from(sphere.radius()),
    };
    let line = Line::around(ray, sphere.center.as_dvec3(), ball.round_size());
    ball.first_crossing(&line, ray, backfaces)
        .map(|crossing| ball.hit(crossing))
}

fn obb_hit(obb: &Obb, ray: &Ray, backfaces: Backfaces) -> Option<SurfaceHit> {
    let axes = obb.axes();
    let axes = DMat3::from_cols(axes.x_axis.as_dvec3(), axes.y_axis.as_dvec3(), axes.z_axis.as_dvec3());
    box_hit(
        obb.center().as_dvec3(),
        obb.half_size().as_dvec3(),
        Some(axes),
        ray,
        backfaces,
    )
}

/// The hit on a box along the `axes`, if there are any, else along those of the space.
fn box_hit(
    center: DVec3,
    half_size: DVec3,
    axes: Option<DMat3>,
    ray: &Ray,
    backfaces: Backfaces,
) -> Option<SurfaceHit> {
    let block = Block { half_size };
    let mut line = Line::around(ray, center, block.round_size());
    if let Some(axes) = axes {
        let own_from_space = axes.transpose();
        (line.origin, line.direction) = (own_from_space * line.origin, own_from_space * line.direction);
    }
    let mut hit = block.hit(block.first_crossing(&line, ray, backfaces)?);
    if let Some(axes) = axes {
        hit.normal = (axes * hit.normal.as_dvec3()).as_vec3();
    }
    Some(hit)
}

fn hull_hit(hull: &ConvexHull, ray: &Ray, backfaces: Backfaces) -> Option<SurfaceHit> {
    // Eight planes at once: most rays that miss are turned away here.
    hull.ray_intersection_at(ray)?;
    // The faces are where they are: no rounding of a far origin shows.
    let line = Line::of(ray, f64::INFINITY);
    let mut inside = Span::everywhere(0);
    for (index, HullPlane { normal, offset }) in hull.planes().iter().enumerate() {
        let normal = normal.as_dvec3();
        let distance = normal.dot(line.origin) - f64::from(*offset);
        inside = inside.and(half_space_span(normal.dot(line.direction), distance, index)?)?;
    }
    let Crossing { t, face, .. } = inside.crossing(&line, ray, backfaces)?;
    Some(SurfaceHit {
        t,
        normal: Vec3::from(hull.planes()[face].normal),
        chart: Chart::Plain(Default::default()),
    })
}
