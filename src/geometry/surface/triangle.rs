//! Triangles and tetrahedra.

use bevy::math::{
    DVec3, Vec2, Vec3,
    bounding::Aabb3d,
    primitives::{Tetrahedron, Triangle3d},
};

use super::{
    Surface, SurfaceHit,
    chart::Chart,
    own_hull,
    solid::enclosing_box,
    span::{Crossing, Line, Span, half_space_span, parameter_of},
};
use crate::geometry::ray::{Ray, triangle::Backfaces};

/// Seen from the front where its vertices run counter-clockwise. Watertight: a ray that meets the edge between two
/// triangles hits one of them at least. One that is degenerate, or that the ray sees edge-on, is missed. Textured as its
/// mesh.
impl Surface for Triangle3d {
    fn aabb(&self) -> Option<Aabb3d> {
        box_of(&self.vertices.map(Vec3::as_dvec3))
    }

    #[inline]
    fn closest_hit(&self, ray: &Ray, backfaces: Backfaces) -> Option<SurfaceHit> {
        let weights = edge_functions(self, ray, backfaces)?;
        let triangle = self.vertices.map(Vec3::as_dvec3);
        let normal = normal(triangle);
        let line = Line::of(ray, f64::INFINITY);
        let (speed, length) = (normal.dot(line.direction), normal.length());
        // One division for both.
        let recip = (speed * length).recip();
        let (per_speed, per_length) = (recip * length, recip * speed);
        Some(SurfaceHit {
            t: parameter_of(ray, normal.dot(triangle[0] - line.origin) * per_speed)?,
            normal: (normal * per_length).as_vec3(),
            // The sum of the weights is twice the speed along the normal, backward.
            chart: triangle_chart(triangle, weights * (-0.5 * per_speed)),
        })
    }

    #[inline]
    fn any_hit(&self, ray: &Ray, backfaces: Backfaces) -> bool {
        if edge_functions(self, ray, backfaces).is_none() {
            return false;
        }
        let triangle = self.vertices.map(Vec3::as_dvec3);
        let (normal, line) = (normal(triangle), Line::of(ray, f64::INFINITY));
        let (speed, length) = (normal.dot(line.direction), normal.length());
        let per_speed = (speed * length).recip() * length;
        parameter_of(ray, normal.dot(triangle[0] - line.origin) * per_speed).is_some()
    }

    own_hull!();
}

/// The weights of the vertices at the point where the line of the ray meets the triangle, times the same factor: the
/// volumes between the direction and the edges as seen from the origin.
///
/// The edge between two triangles has opposite volumes in the two, to the last digit, so that it is inside of one of
/// them at least (the idea of Woop, Benthin and Wald, JCGT 2(1), 2013, without the shear).
#[inline]
fn edge_functions(triangle: &Triangle3d, ray: &Ray, backfaces: Backfaces) -> Option<DVec3> {
    let line = Line::of(ray, f64::INFINITY);
    let [a, b, c] = triangle.vertices.map(|vertex| vertex.as_dvec3() - line.origin);
    // Twice to × from, with the rounding of the edge and not of the distance.
    let edge = |from: DVec3, to: DVec3| line.direction.dot((to - from).cross(to + from));
    let (u, v) = (edge(b, c), edge(c, a));
    let back = u < 0.0 || v < 0.0;
    if back && (u > 0.0 || v > 0.0 || backfaces == Backfaces::Cull) {
        return None;
    }
    let w = edge(a, b);
    let (back, front) = (back || w < 0.0, u > 0.0 || v > 0.0 || w > 0.0);
    let seen = if back {
        !front && backfaces == Backfaces::Include
    } else {
        front
    };
    seen.then(|| DVec3::new(u, v, w))
}

/// Seen from the front from outside, whichever way its vertices run. Textured as its mesh. One that is flat contains
/// nothing, and is missed.
impl Surface for Tetrahedron {
    fn aabb(&self) -> Option<Aabb3d> {
        box_of(&self.vertices.map(Vec3::as_dvec3))
    }

    #[inline]
    fn closest_hit(&self, ray: &Ray, backfaces: Backfaces) -> Option<SurfaceHit> {
        let faces = faces(self)?;
        let Crossing { t, point, face } = first_crossing(&faces, ray, backfaces)?;
        let triangle = faces[face];
        let normal = normal(triangle);
        let [a, b, c] = triangle.map(|vertex| vertex - point);
        let weights = DVec3::new(b.cross(c).dot(normal), c.cross(a).dot(normal), a.cross(b).dot(normal));
        Some(SurfaceHit {
            t,
            normal: normal.normalize().as_vec3(),
            chart: triangle_chart(triangle, weights * normal.length_squared().recip()),
        })
    }

    #[inline]
    fn any_hit(&self, ray: &Ray, backfaces: Backfaces) -> bool {
        faces(self).is_some_and(|faces| first_crossing(&faces, ray, backfaces).is_some())
    }

    own_hull!();
}

/// The faces in the order of [`Tetrahedron::faces`], counter-clockwise as seen from outside; `None` if it is flat.
#[inline]
fn faces(tetrahedron: &Tetrahedron) -> Option<[[DVec3; 3]; 4]> {
    let [a, b, c, d] = tetrahedron.vertices.map(Vec3::as_dvec3);
    let volume = (b - a).cross(c - a).dot(d - a);
    let outward = |[a, b, c]: [DVec3; 3]| if volume < 0.0 { [c, b, a] } else { [a, b, c] };
    (volume != 0.0 && volume.is_finite()).then(|| [[b, c, d], [d, c, a], [a, b, d], [c, b, a]].map(outward))
}

#[inline]
fn first_crossing(faces: &[[DVec3; 3]; 4], ray: &Ray, backfaces: Backfaces) -> Option<Crossing<usize>> {
    let line = Line::of(ray, f64::INFINITY);
    let mut span = Span::everywhere(0);
    for (number, &face) in faces.iter().enumerate() {
        let normal = normal(face);
        let distance = normal.dot(line.origin - face[0]);
        span = span.and(half_space_span(normal.dot(line.direction), distance, number)?)?;
    }
    span.crossing(&line, ray, backfaces)
}

#[inline]
fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

fn box_of(vertices: &[DVec3]) -> Option<Aabb3d> {
    let around = |fold: fn(DVec3, DVec3) -> DVec3| vertices.iter().copied().reduce(fold);
    enclosing_box(around(DVec3::min)?, around(DVec3::max)?)
}

/// The texture of `Triangle3d::mesh` at the point with these weights of the vertices.
#[inline]
pub fn triangle_chart([a, b, c]: [DVec3; 3], weights: DVec3) -> Chart {
    let side = b - a;
    Chart::Triangle {
        weights: Vec2::new(weights.y as f32, weights.z as f32),
        apex: (c - a).dot(side),
        base: side.length_squared(),
    }
}
