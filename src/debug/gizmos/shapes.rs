//! Shapes as lines. Each returns how many lines it took, and draws nothing that is NaN or infinite.

use std::f32::consts::{FRAC_PI_2, PI};

use bevy::{
    color::Color,
    gizmos::{config::GizmoConfigGroup, gizmos::GizmoBuffer},
    math::{
        Affine3A, Isometry3d, Quat, Vec2, Vec3, Vec3A,
        bounding::{Aabb3d, BoundingSphere},
        primitives::ViewFrustum,
    },
};

use crate::geometry::volume::{AnyVolume, Volume};

/// The lines of a box or a frustum.
pub(super) const BOX_LINES: usize = 12;

/// The lines of one circle of a sphere, and of a sphere.
const CIRCLE_LINES: usize = 32;
pub(super) const SPHERE_LINES: usize = 3 * CIRCLE_LINES;

/// The lines of a rounded rectangle.
const ARC_LINES: usize = 8;
pub(super) const ROUNDED_LINES: usize = 4 * (ARC_LINES + 1);

/// What shapes are drawn to.
pub(super) struct Pen<'a, Config, Clear>
where
    Config: GizmoConfigGroup,
    Clear: 'static + Send + Sync,
{
    pub gizmos: &'a mut GizmoBuffer<Config, Clear>,
}

impl<Config, Clear> Pen<'_, Config, Clear>
where
    Config: GizmoConfigGroup,
    Clear: 'static + Send + Sync,
{
    pub fn aabb(&mut self, aabb: &Aabb3d, color: Color) -> Option<usize> {
        self.edges(edges_of(aabb), color)
    }

    /// A box in its own space.
    pub fn placed_box(&mut self, local: &Aabb3d, world_from_local: &Affine3A, color: Color) -> Option<usize> {
        let edges = edges_of(local);
        self.edges(
            edges.map(|edge| edge.map(|end| world_from_local.transform_point3a(end))),
            color,
        )
    }

    pub fn frustum(&mut self, frustum: &ViewFrustum, color: Color) -> Option<usize> {
        let corners = frustum.corners()?.map(Vec3A::from);
        let around = (0..4).map(|corner| (corner, (corner + 1) % 4));
        let mut edges = [[Vec3A::ZERO; 2]; BOX_LINES];
        for (a, b) in around {
            edges[a] = [corners[a], corners[b]];
            edges[4 + a] = [corners[4 + a], corners[4 + b]];
            edges[8 + a] = [corners[a], corners[4 + a]];
        }
        self.edges(edges, color)
    }

    pub fn sphere(&mut self, sphere: &BoundingSphere, color: Color) -> Option<usize> {
        if !sphere.center.is_finite() || !sphere.radius().is_finite() {
            return None;
        }
        for turn in [
            Quat::IDENTITY,
            Quat::from_rotation_x(FRAC_PI_2),
            Quat::from_rotation_y(FRAC_PI_2),
        ] {
            let point = |step: usize| {
                let angle = 2.0 * PI * step as f32 / CIRCLE_LINES as f32;
                let direction = turn * Vec3::new(angle.cos(), angle.sin(), 0.0);
                Vec3::from(sphere.center) + sphere.radius() * direction
            };
            for step in 0..CIRCLE_LINES {
                self.gizmos.line(point(step), point(step + 1), color);
            }
        }
        Some(SPHERE_LINES)
    }

    /// A volume in its own space.
    pub fn volume(&mut self, volume: &AnyVolume, world_from_local: &Affine3A, color: Color) -> Option<usize> {
        let place = |point| world_from_local.transform_point3a(point);
        match volume {
            AnyVolume::Aabb(aabb) => self.placed_box(aabb, world_from_local, color),
            AnyVolume::Obb(obb) => self.edges(obb.edges().map(|edge| edge.map(place)), color),
            AnyVolume::Sphere(sphere) => self.sphere(&sphere.transformed_by_affine(world_from_local), color),
            AnyVolume::Hull(hull) => {
                let vertices = hull.vertices();
                let edges = hull.edges().iter();
                self.edges(edges.map(|edge| edge.map(|end| place(vertices[end as usize]))), color)
            }
        }
    }

    /// Everything within a distance of a box, cut through the middle of the box: in the horizontal plane.
    pub fn around_box(&mut self, aabb: &Aabb3d, distance: f32, color: Color) -> Option<usize> {
        let (center, size) = ((aabb.min + aabb.max) * 0.5, aabb.max - aabb.min);
        let outer = Vec2::new(size.x, size.z) + 2.0 * distance;
        if !center.is_finite() || !outer.is_finite() {
            return None;
        }
        let flat = Isometry3d::new(center, Quat::from_rotation_x(FRAC_PI_2));
        self.gizmos
            .rounded_rect(flat, outer, color)
            .corner_radius(distance)
            .arc_resolution(ARC_LINES as u32);
        Some(ROUNDED_LINES)
    }

    fn edges(&mut self, edges: impl IntoIterator<Item = [Vec3A; 2]> + Clone, color: Color) -> Option<usize> {
        let is_finite = |[from, to]: [Vec3A; 2]| from.is_finite() && to.is_finite();
        if !edges.clone().into_iter().all(is_finite) {
            return None;
        }
        let mut lines = 0;
        for [from, to] in edges {
            self.gizmos.line(from.into(), to.into(), color);
            lines += 1;
        }
        Some(lines)
    }
}

/// How many lines a volume takes.
pub(super) fn lines_of(volume: &AnyVolume) -> usize {
    match volume {
        AnyVolume::Aabb(_) | AnyVolume::Obb(_) => BOX_LINES,
        AnyVolume::Sphere(_) => SPHERE_LINES,
        AnyVolume::Hull(hull) => hull.edges().len(),
    }
}

/// The edges of a box, whose ends are its corners to the last bit.
fn edges_of(aabb: &Aabb3d) -> [[Vec3A; 2]; BOX_LINES] {
    let corner = |bits: usize| {
        let side = |axis: usize| if bits >> axis & 1 == 0 { aabb.min } else { aabb.max };
        Vec3A::new(side(0).x, side(1).y, side(2).z)
    };
    std::array::from_fn(|edge| {
        // Four along each axis: the other two axes tell which.
        let (axis, which) = (edge / 4, edge % 4);
        let from = (which & 1) << ((axis + 1) % 3) | (which >> 1) << ((axis + 2) % 3);
        [corner(from), corner(from | 1 << axis)]
    })
}
