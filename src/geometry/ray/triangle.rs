//! Ray against triangle: watertight and free of scale.
//!
//! Source: Woop, Benthin and Wald, *Watertight Ray/Triangle Intersection*, JCGT 2(1), 2013; the symbols are theirs. A
//! ray that meets the edge between two triangles hits at least one of them, because both compute the edge function of
//! the shared edge from the same sheared vertices, and a zero is decided in double precision, where it is exact.

use bevy::math::{Vec3, Vec3A};

use super::Ray;

/// Whether a test reports triangles that are seen from behind.
///
/// A triangle is seen from the front where its vertices run counter-clockwise, in the space of the test.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Backfaces {
    /// Pass through triangles that are seen from behind.
    #[default]
    Cull,
    /// Hit triangles from both sides.
    Include,
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleIntersection {
    /// The parameter of the ray.
    pub t: f32,
    /// The weights of the three vertices at the hit: each in `0..=1`, their sum 1 up to rounding.
    pub barycentrics: Vec3,
}

/// A ray prepared for many triangles: the axes permuted and sheared so that the ray runs along +z.
#[derive(Clone, Copy, Debug)]
pub struct TriangleRay {
    /// kx, ky and kz.
    pub(crate) axes: [usize; 3],
    /// The origin, along these axes.
    pub(crate) origin: [f32; 3],
    /// Sx, Sy and Sz.
    pub(crate) shear: [f32; 3],
    t_min: f32,
}

impl TriangleRay {
    /// Prepares `ray`.
    #[inline]
    pub fn new(ray: &Ray) -> Self {
        let kz = ray.direction().abs().max_position();
        let (o, d) = (ray.origin().to_array(), ray.direction().to_array());
        let (mut kx, mut ky) = ((kz + 1) % 3, (kz + 2) % 3);
        // Swap to preserve the winding of the triangles.
        if d[kz] < 0.0 {
            std::mem::swap(&mut kx, &mut ky);
        }
        Self {
            axes: [kx, ky, kz],
            origin: [o[kx], o[ky], o[kz]],
            shear: [d[kx] / d[kz], d[ky] / d[kz], 1.0 / d[kz]],
            t_min: ray.t_min(),
        }
    }

    /// Where the ray meets the triangle with a parameter from the start of the ray to `t_max`, in the space of both.
    ///
    /// Exact at edges and vertices: no ray slips between triangles that share them. Triangles that are degenerate, or
    /// that the ray sees edge-on, are missed; a closed surface is hit beside them.
    #[inline]
    pub fn triangle_intersection(
        &self,
        corners: [Vec3A; 3],
        t_max: f32,
        backfaces: Backfaces,
    ) -> Option<TriangleIntersection> {
        let along_axes = corners.map(|corner| self.axes.map(|axis| corner[axis]));
        self.intersection_along_axes(along_axes, t_max, backfaces)
    }

    /// The same for corners with their coordinates along the axes of this ray.
    #[inline(always)]
    pub(crate) fn intersection_along_axes(
        &self,
        [a, b, c]: [[f32; 3]; 3],
        t_max: f32,
        backfaces: Backfaces,
    ) -> Option<TriangleIntersection> {
        let [sx, sy, sz] = self.shear;
        let shear = |corner: [f32; 3]| {
            let z = corner[2] - self.origin[2];
            (
                corner[0] - self.origin[0] - sx * z,
                corner[1] - self.origin[1] - sy * z,
                z,
            )
        };
        let ((ax, ay, az), (bx, by, bz), (cx, cy, cz)) = (shear(a), shear(b), shear(c));

        // Scaled barycentrics: the edge functions at the ray, which is the origin after the shear.
        let (u, v, w) = (cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax);
        let is_sure = |edge: f32| edge.abs() >= SMALLEST_EDGE_FUNCTION && edge.abs() < f32::INFINITY;
        let (u, v, w) = if is_sure(u) && is_sure(v) && is_sure(w) {
            (f64::from(u), f64::from(v), f64::from(w))
        } else {
            // Too close to an edge to call, underflown, or overflown. A product of two f32 is exact in f64.
            let edge =
                |px: f32, qy: f32, py: f32, qx: f32| f64::from(px) * f64::from(qy) - f64::from(py) * f64::from(qx);
            (edge(cx, by, cy, bx), edge(ax, cy, ay, cx), edge(bx, ay, by, ax))
        };

        let behind = u < 0.0 || v < 0.0 || w < 0.0;
        let front = u > 0.0 || v > 0.0 || w > 0.0;
        if behind && (front || backfaces == Backfaces::Cull) {
            return None;
        }
        let det = u + v + w;
        if det == 0.0 {
            return None;
        }

        let recip = 1.0 / det;
        let (u, v, w) = (u * recip, v * recip, w * recip);
        let depth = u * f64::from(az) + v * f64::from(bz) + w * f64::from(cz);
        let t = (depth * f64::from(sz)) as f32;
        (t >= self.t_min && t <= t_max && t < f32::INFINITY).then_some(TriangleIntersection {
            t,
            barycentrics: Vec3::new(u as f32, v as f32, w as f32),
        })
    }
}

/// Below this an edge function has lost bits to underflow, or is zero.
pub(crate) const SMALLEST_EDGE_FUNCTION: f32 = f32::MIN_POSITIVE / f32::EPSILON;
