//! The table of pairs. Each has one implementation, and its mirror image asks that.

use bevy::math::{
    Vec3, Vec3A,
    bounding::{Aabb3d, BoundingSphere},
    primitives::{Segment3d, Triangle3d, ViewFrustum},
};

use super::{
    Intersects,
    exact::{Stretch, point_in_triangle, point_on_ray, point_on_segment},
    frustum::Frustum,
    gjk,
    polyhedron::{Line, ObbFrame, Polyhedron},
    sat::{self, Polytope as _},
    sphere,
};
use crate::geometry::{closest_point::ClosestPoint, convex_hull::ConvexHull, obb::Obb, ray::Ray, volume::Volume};

macro_rules! pairs {
    ($($a:ty, $b:ty: |$x:ident, $y:ident| $touch:expr;)*) => { $(
        impl Intersects<$b> for $a {
            fn intersects(&self, other: &$b) -> bool {
                let ($x, $y) = (self, other);
                $touch
            }
        }

        impl Intersects<$a> for $b {
            fn intersects(&self, other: &$a) -> bool {
                other.intersects(self)
            }
        }
    )* };
}

macro_rules! same_kind {
    ($($a:ty: |$x:ident, $y:ident| $touch:expr;)*) => { $(
        impl Intersects<$a> for $a {
            fn intersects(&self, other: &$a) -> bool {
                let ($x, $y) = (self, other);
                $touch
            }
        }
    )* };
}

same_kind! {
    Vec3A: |a, b| a == b;
    Ray: |a, b| Stretch::of_ray(a).zip(Stretch::of_ray(b)).is_some_and(|(a, b)| a.touches(&b));
    Segment3d: |a, b| Stretch::of_segment(a).touches(&Stretch::of_segment(b));
    BoundingSphere: |a, b| sphere::touches_sphere(a, b);
    Aabb3d: |a, b| a.min.cmple(b.max).all() && b.min.cmple(a.max).all();
    Obb: |a, b| sat::touch(&ObbFrame::from(a), &ObbFrame::from(b));
    ConvexHull: |a, b| gjk::intersects(a, b);
    Frustum: |a, b| a.touches_frustum(b);
}

pairs! {
    Vec3A, Ray: |point, ray| point_on_ray(point.as_dvec3(), ray);
    Vec3A, Segment3d: |point, segment| point_on_segment(point.as_dvec3(), segment);
    Vec3A, BoundingSphere: |point, sphere| sphere::touches_point(sphere, point.as_dvec3());
    Vec3A, Aabb3d: |point, aabb| aabb.min.cmple(*point).all() && point.cmple(aabb.max).all();
    Vec3A, Obb: |point, obb| ObbFrame::from(obb).planes().all(|plane| plane.admits(point.as_dvec3()));
    Vec3A, ConvexHull: |point, hull| hull.contains_point(*point);
    Vec3A, Frustum: |point, frustum| frustum.planes().all(|plane| plane.admits_exactly(point.as_dvec3()));
    Vec3A, Triangle3d: |point, triangle| point_in_triangle(point.as_dvec3(), triangle.vertices.map(Vec3::as_dvec3));

    Ray, Segment3d: |ray, segment| Stretch::of_ray(ray).is_some_and(|ray| ray.touches(&Stretch::of_segment(segment)));
    Ray, BoundingSphere: |ray, sphere| ray.t_min() <= ray.t_max()
        && Line::from(ray).touches_sphere(sphere);
    Ray, Aabb3d: |ray, aabb| Line::from(ray).clipped(aabb.planes()).is_some();
    Ray, Obb: |ray, obb| Line::from(ray).clipped(ObbFrame::from(obb).planes()).is_some();
    Ray, ConvexHull: |ray, hull| Line::from(ray).clipped(Polyhedron::planes(hull)).is_some();
    Ray, Frustum: |ray, frustum| Line::from(ray).clipped(frustum.planes()).is_some();
    Ray, Triangle3d: |ray, triangle| Stretch::of_ray(ray).is_some_and(|ray| ray.touches_triangle(triangle));

    Segment3d, BoundingSphere: |segment, sphere| {
        let magnitude = segment.magnitude().max_element();
        sphere::reaches(sphere, segment.closest_point_f64(sphere.center.as_dvec3()), magnitude, 1.0)
    };
    Segment3d, Aabb3d: |segment, aabb| Line::from(segment).clipped(aabb.planes()).is_some();
    Segment3d, Obb: |segment, obb| Line::from(segment).clipped(ObbFrame::from(obb).planes()).is_some();
    Segment3d, ConvexHull: |segment, hull| Line::from(segment).clipped(Polyhedron::planes(hull)).is_some();
    Segment3d, Frustum: |segment, frustum| Line::from(segment).clipped(frustum.planes()).is_some();
    Segment3d, Triangle3d: |segment, triangle| Stretch::of_segment(segment).touches_triangle(triangle);

    BoundingSphere, Aabb3d: |sphere, aabb| sphere::touches_aabb(sphere, aabb);
    BoundingSphere, Obb: |sphere, obb| {
        let frame = ObbFrame::from(obb);
        let (closest, magnitude) = (frame.closest_point(sphere.center.as_dvec3()), frame.magnitude().max_element());
        sphere::reaches(sphere, closest, magnitude, frame.stretch_squared())
    };
    BoundingSphere, ConvexHull: |sphere, hull| {
        gjk::distance(&sphere.center, hull).bound <= sphere::reach(sphere, hull.magnitude().max_element())
    };
    BoundingSphere, Frustum: |sphere, frustum| frustum.touches_sphere(sphere);
    BoundingSphere, Triangle3d: |sphere, triangle| {
        let magnitude = triangle.magnitude().max_element();
        sphere::reaches(sphere, triangle.closest_point_f64(sphere.center.as_dvec3()), magnitude, 1.0)
    };

    Aabb3d, Obb: |aabb, obb| sat::touch(aabb, &ObbFrame::from(obb));
    Aabb3d, ConvexHull: |aabb, hull| gjk::intersects(aabb, hull);
    Aabb3d, Frustum: |aabb, frustum| frustum.touches(aabb);
    Aabb3d, Triangle3d: |aabb, triangle| sat::touch(aabb, triangle);

    Obb, ConvexHull: |obb, hull| gjk::intersects(&ObbFrame::from(obb), hull);
    Obb, Frustum: |obb, frustum| frustum.touches(&ObbFrame::from(obb));
    Obb, Triangle3d: |obb, triangle| sat::touch(&ObbFrame::from(obb), triangle);

    ConvexHull, Frustum: |hull, frustum| match hull.margin() {
        0.0 => frustum.touches(hull),
        // The edges of the hull do not include its margin, as its planes do.
        margin => frustum.with_planes_moved_out(margin.into()).touches(hull),
    };
    ConvexHull, Triangle3d: |hull, triangle| gjk::intersects(hull, triangle);

    Frustum, Triangle3d: |frustum, triangle| frustum.touches(triangle);
}

/// A frustum as Bevy has it must be prepared first.
macro_rules! pairs_of_view_frustum {
    ($($other:ty),*) => { pairs! { $(
        ViewFrustum, $other: |frustum, other| Frustum::from(frustum).intersects(other);
    )* } };
}

pairs_of_view_frustum!(
    Vec3A,
    Ray,
    Segment3d,
    BoundingSphere,
    Aabb3d,
    Obb,
    ConvexHull,
    Frustum,
    Triangle3d
);

same_kind! {
    ViewFrustum: |a, b| Frustum::from(a).intersects(&Frustum::from(b));
}
