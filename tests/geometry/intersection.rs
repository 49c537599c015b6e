use bevy::math::{
    DVec3, Quat, Vec3, Vec3A,
    bounding::{Aabb3d, BoundingSphere},
    primitives::{Segment3d, Triangle3d, ViewFrustum},
};
use bevy_sightline::geometry::{
    intersection::{Contains, Frustum, Intersects, gjk},
    obb::Obb,
    ray::Ray,
    support::Support,
};
use proptest::prelude::*;

use super::shapes::{Shape, aabb_frustum, any_shape, around, frustum, hull, inactive, lattice_point};
use crate::properties;

/// Whether the origin is in the convex hull of the points, by Carathéodory's theorem in whole numbers: in one of all
/// tetrahedra, triangles and segments between them.
fn hull_has_origin(points: &[[i64; 3]]) -> bool {
    let sub = |a: [i64; 3], b: [i64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let cross = |a: [i64; 3], b: [i64; 3]| {
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    };
    let dot = |a: [i64; 3], b: [i64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let det = |a, b, c| dot(a, cross(b, c));
    let zero = [0; 3];
    let n = points.len();
    for i in 0..n {
        let a = points[i];
        if a == zero {
            return true;
        }
        for j in 0..i {
            let b = points[j];
            if cross(a, b) == zero && dot(a, b) < 0 {
                return true;
            }
            for k in 0..j {
                let c = points[k];
                let normal = cross(sub(b, a), sub(c, a));
                if normal != zero && dot(normal, a) == 0 {
                    let sides = [
                        dot(normal, cross(a, b)),
                        dot(normal, cross(b, c)),
                        dot(normal, cross(c, a)),
                    ];
                    if sides.iter().all(|&side| side >= 0) {
                        return true;
                    }
                }
                for &d in &points[..k] {
                    let volume = det(sub(b, a), sub(c, a), sub(d, a)).signum();
                    if volume == 0 {
                        continue;
                    }
                    let parts = [det(b, c, d), -det(a, c, d), det(a, b, d), -det(a, b, c)];
                    if parts.iter().all(|&part| part * volume >= 0) {
                        return true;
                    }
                }
            }
        }
    }
    false
}

/// Whether two lattice polytopes touch, exactly.
fn lattice_polytopes_touch(a: &[Vec3A], b: &[Vec3A]) -> bool {
    let mut differences: Vec<[i64; 3]> = a
        .iter()
        .flat_map(|a| b.iter().map(move |b| (*a - *b).to_array().map(|x| x as i64)))
        .collect();
    differences.sort_unstable();
    differences.dedup();
    hull_has_origin(&differences)
}

/// A lattice polytope of few vertices, and those.
fn lattice_polytope() -> impl Strategy<Value = (Shape, Vec<Vec3A>)> {
    let p = lattice_point;
    prop_oneof![
        p().prop_map(|a| (Shape::Point(a), vec![a])),
        (p(), p()).prop_map(|(a, b)| (Shape::Segment(Segment3d::new(a.into(), b.into())), vec![a, b])),
        (p(), p()).prop_filter_map("a direction", |(a, b)| {
            let ray = Ray::segment(a.into(), b.into())?;
            Some((Shape::Ray(ray), vec![a, b]))
        }),
        (p(), p()).prop_filter_map("a direction", |(a, b)| {
            // Long enough to leave the lattice.
            let ray = Ray::new(a, b, f32::INFINITY)?;
            Some((Shape::Ray(ray), vec![a, a + b * 16.0]))
        }),
        (p(), p(), p()).prop_map(|(a, b, c)| {
            let triangle = Triangle3d::new(a.into(), b.into(), c.into());
            (Shape::Triangle(triangle), vec![a, b, c])
        }),
        prop::collection::vec(p(), 1..6).prop_map(|points| (Shape::Hull(hull(points.clone())), points)),
    ]
}

/// A lattice box as each kind of shape that can be one.
fn lattice_box() -> impl Strategy<Value = (Shape, Vec<Vec3A>)> {
    (lattice_point(), lattice_point(), 0u8..4).prop_map(|(a, b, kind)| {
        let (min, max) = (a.min(b), a.max(b));
        let corners = box_corners(min, max);
        let shape = match kind {
            0 => Shape::Aabb(Aabb3d { min, max }),
            1 => Shape::Obb(Obb::new((min + max) * 0.5, (max - min) * 0.5, Quat::IDENTITY).expect("a sound box")),
            2 => Shape::Hull(hull(corners.clone())),
            _ => Shape::Frustum(aabb_frustum(min, max)),
        };
        (shape, corners)
    })
}

fn box_corners(min: Vec3A, max: Vec3A) -> Vec<Vec3A> {
    let bounds = [min, max];
    (0..8)
        .map(|corner: usize| Vec3A::from_array(std::array::from_fn(|axis| bounds[corner >> axis & 1][axis])))
        .collect()
}

proptest! {
    #![proptest_config(crate::properties::cases())]

    #[test]
    fn shapes_with_a_point_in_common_touch(
        (a, b) in lattice_point().prop_flat_map(|point| (around(point), around(point)))
    ) {
        prop_assert!(a.touches(&b));
    }

    #[test]
    fn every_pair_is_symmetric(a in any_shape(), b in any_shape()) {
        prop_assert_eq!(a.touches(&b), b.touches(&a));
    }

    #[test]
    fn shapes_apart_along_a_direction_do_not_touch(
        a in any_shape(), b in any_shape(), direction in properties::direction(), gap in 1e-3f32..1.0
    ) {
        let normal = direction.as_dvec3();
        let overlap = a.support(normal).dot(normal) - b.support(-normal).dot(normal);
        let b = b.translated((normal * (overlap + f64::from(gap))).as_vec3a());
        let apart = b.support(-normal).dot(normal) - a.support(normal).dot(normal);
        prop_assume!(apart > 5e-4);
        prop_assert!(!a.touches(&b));
    }

    #[test]
    fn lattice_polytopes_touch_exactly_when_they_do((a, of_a) in lattice_polytope(), (b, of_b) in lattice_polytope()) {
        prop_assert_eq!(a.touches(&b), lattice_polytopes_touch(&of_a, &of_b));
    }

    #[test]
    fn lattice_polytopes_touch_lattice_boxes_exactly_when_they_do(
        (a, of_a) in lattice_polytope(), (b, of_b) in lattice_box()
    ) {
        prop_assert_eq!(a.touches(&b), lattice_polytopes_touch(&of_a, &of_b));
    }

    #[test]
    fn lattice_boxes_touch_exactly_when_their_bounds_do((a, of_a) in lattice_box(), (b, of_b) in lattice_box()) {
        let bounds = |corners: &[Vec3A]| (corners[0], corners[7]);
        let ((a_min, a_max), (b_min, b_max)) = (bounds(&of_a), bounds(&of_b));
        let touch = a_min.cmple(b_max).all() && b_min.cmple(a_max).all();
        prop_assert_eq!(a.touches(&b), touch);
    }

    #[test]
    fn lattice_spheres_touch_exactly_when_they_do(
        center in lattice_point(), radius in 0i8..6, (b, corners) in lattice_box()
    ) {
        let sphere = Shape::Sphere(BoundingSphere::new(center, radius.into()));
        let closest = center.clamp(corners[0], corners[7]);
        let touch = center.distance_squared(closest) <= f32::from(radius) * f32::from(radius);
        prop_assert_eq!(sphere.touches(&b), touch);
    }

    #[test]
    fn the_answer_keeps_under_powers_of_two(
        (a, b) in (lattice_polytope(), lattice_box()), exponent in -60i32..60
    ) {
        let scale = f32::powi(2.0, exponent);
        let scaled = |points: &[Vec3A]| hull(points.iter().map(|&p| p * scale));
        let expected = lattice_polytopes_touch(&a.1, &b.1);
        prop_assert_eq!(scaled(&a.1).intersects(&scaled(&b.1)), expected);
        let aabb = Aabb3d { min: b.1[0] * scale, max: b.1[7] * scale };
        prop_assert_eq!(scaled(&a.1).intersects(&aabb), expected);
        let obb = Obb::new((aabb.min + aabb.max) * 0.5, (aabb.max - aabb.min) * 0.5, Quat::IDENTITY).expect("a sound box");
        prop_assert_eq!(scaled(&a.1).intersects(&obb), expected);
    }

    #[test]
    fn the_answer_keeps_far_from_the_origin((a, b) in (lattice_polytope(), lattice_box()), by in lattice_point()) {
        let by = by * 65536.0;
        let (before, after) = (a.0.touches(&b.0), a.0.translated(by).touches(&b.0.translated(by)));
        prop_assert!(after || !before);
        // The offsets of the planes of a hull are rounded outward, to what `f32` has there.
        let has_planes = |shape: &Shape| matches!(shape, Shape::Hull(_));
        let asks_planes = |shape: &Shape| {
            matches!(shape, Shape::Point(_) | Shape::Ray(_) | Shape::Segment(_) | Shape::Frustum(_))
        };
        if !(has_planes(&a.0) && asks_planes(&b.0) || has_planes(&b.0) && asks_planes(&a.0)) {
            prop_assert_eq!(before, after);
        }
    }

    #[test]
    fn a_box_touches_what_its_triangles_or_its_inside_touch((a, _) in lattice_polytope(), (b, corners) in lattice_box()) {
        let faces = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
        let triangles = faces.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).map(|corner| {
            Shape::Triangle(Triangle3d { vertices: corner.map(|index: usize| Vec3::from(corners[index])) })
        });
        let by_surface = triangles.into_iter().any(|triangle| triangle.touches(&a));
        let aabb = Shape::Aabb(Aabb3d { min: corners[0], max: corners[7] });
        let inside = aabb.holds(&a) == Some(true);
        if !matches!(a, Shape::Ray(_)) {
            prop_assert_eq!(b.touches(&a), by_surface || inside);
        }
    }

    #[test]
    fn boxes_agree_with_their_hulls(
        a in any_shape(), center in properties::point(), half in [0.1f32..5.0, 0.1f32..5.0, 0.1f32..5.0],
        rotation in properties::rotation()
    ) {
        let obb = Obb::new(center * 0.1, Vec3A::from_array(half), rotation).expect("a sound box");
        let around = |growth: f32| hull(
            Obb::new(center * 0.1, Vec3A::from_array(half) * growth, rotation).expect("a sound box").corners()
        );
        // Unless the rounding of the corners decides.
        let (smaller, larger) = (Shape::Hull(around(0.9999)), Shape::Hull(around(1.0001)));
        let by_obb = Shape::Obb(obb).touches(&a);
        prop_assert!(by_obb || !smaller.touches(&a));
        prop_assert!(!by_obb || larger.touches(&a));
    }

    #[test]
    fn a_frustum_agrees_with_the_hull_of_its_corners(frustum in frustum(), a in any_shape()) {
        let corners = frustum.corners().expect("corners").map(Vec3A::from);
        let middle = corners.iter().sum::<Vec3A>() / 8.0;
        let grown = |growth: f32| Shape::Hull(hull(corners.map(|corner| middle + (corner - middle) * growth)));
        let by_frustum = Shape::Frustum(frustum).touches(&a);
        prop_assert!(by_frustum || !grown(0.999).touches(&a));
        prop_assert!(!by_frustum || grown(1.001).touches(&a));
    }

    #[test]
    fn an_endless_frustum_is_one_with_its_end_far_off(frustum in frustum(), a in any_shape()) {
        let (mut endless, mut long) = (frustum, frustum);
        endless.half_spaces[ViewFrustum::FAR_PLANE_IDX] = inactive();
        let near = frustum.half_spaces[ViewFrustum::NEAR_PLANE_IDX];
        let far = -near.normal();
        long.half_spaces[ViewFrustum::FAR_PLANE_IDX] =
            bevy::math::primitives::HalfSpace::new(Vec3::from(far).extend(1000.0 - near.d()));
        prop_assert_eq!(Shape::Frustum(endless).touches(&a), Shape::Frustum(long).touches(&a));
    }

    #[test]
    fn what_is_contained_touches_and_has_its_points_inside(a in any_shape(), b in any_shape(), seed in properties::direction()) {
        if a.holds(&b) == Some(true) {
            prop_assert!(a.touches(&b));
            // Of the frustum, `f32` corners are no proof.
            if !matches!(b, Shape::Frustum(_)) && !matches!(a, Shape::Frustum(_)) {
                let (of_a, of_b) = (a.support(seed.as_dvec3()), b.support(seed.as_dvec3()));
                let slack = 1e-5 * of_a.abs().max_element();
                prop_assert!(of_b.dot(seed.as_dvec3()) <= of_a.dot(seed.as_dvec3()) + slack);
            }
        }
    }

    #[test]
    fn containment_is_that_of_the_vertices_on_the_lattice((a, of_a) in lattice_box(), (b, of_b) in lattice_polytope()) {
        let (min, max) = (of_a[0], of_a[7]);
        let inside = of_b.iter().all(|p| min.cmple(*p).all() && p.cmple(max).all());
        match (&a, a.holds(&b)) {
            // Inward by rounding: what reaches the boundary need not be contained.
            (Shape::Obb(_), Some(held)) => prop_assert!(!held || inside),
            (_, Some(held)) => prop_assert_eq!(held, inside),
            (_, None) => {}
        }
    }

    #[test]
    fn shrunk_shapes_are_contained(a in any_shape(), growth in 0.1f32..0.9) {
        let inner = match &a {
            Shape::Sphere(s) => Shape::Sphere(BoundingSphere::new(s.center, s.radius() * growth)),
            Shape::Aabb(b) => {
                let (center, half) = ((b.min + b.max) * 0.5, (b.max - b.min) * 0.5);
                prop_assume!(half.min_element() > 1e-2);
                Shape::Aabb(Aabb3d::new(center, half * growth))
            }
            Shape::Obb(b) => {
                prop_assume!(b.half_size().min_element() > 1e-2);
                Shape::Obb(Obb::new(b.center(), b.half_size() * growth, Quat::from_mat3a(&b.axes())).expect("a sound box"))
            }
            Shape::Hull(h) => Shape::Point(h.vertices()[0]),
            _ => return Ok(()),
        };
        if let Shape::Sphere(s) = &a {
            prop_assume!(s.radius() > 1e-2);
        }
        prop_assert_eq!(a.holds(&inner), Some(true));
    }

    #[test]
    fn gjk_distance_is_the_smallest_between_features(
        a in prop::collection::vec(properties::point(), 1..9), b in prop::collection::vec(properties::point(), 1..9)
    ) {
        let (a_hull, b_hull) = (hull(a.clone()), hull(b.clone()));
        let separation = gjk::distance(&a_hull, &b_hull);
        prop_assert_eq!(separation.distance == 0.0, gjk::intersects(&a_hull, &b_hull));
        prop_assert!((separation.points[0].distance(separation.points[1]) - separation.distance).abs() < 1e-9);
        let expected = feature_distance(&a, &b);
        if separation.distance > 0.0 {
            prop_assert!((separation.distance - expected).abs() <= 1e-9 * (1.0 + expected));
            prop_assert!(separation.bound <= separation.distance);
            let (of_a, of_b) = (a_hull.support_point(-separation.normal), b_hull.support_point(separation.normal));
            prop_assert!((of_a - of_b).dot(separation.normal) >= separation.bound - 1e-12);
        }
    }

    #[test]
    fn gjk_tells_apart_round_shapes(
        center in properties::point(), direction in properties::direction(), radii in [0.1f32..10.0, 0.1f32..10.0], gap in 1e-4f32..1.0
    ) {
        let a = BoundingSphere::new(center, radii[0]);
        let b = BoundingSphere::new(center + direction * (radii[0] + radii[1] + gap), radii[1]);
        let exact = a.center.as_dvec3().distance(b.center.as_dvec3()) - f64::from(radii[0]) - f64::from(radii[1]);
        prop_assume!(exact > 2e-5);
        prop_assert!(!gjk::intersects(&a, &b));
        let separation = gjk::distance(&a, &b);
        prop_assert!((separation.distance - exact).abs() < 1e-6 * (radii[0] + radii[1]) as f64, "{} {}", separation.distance, exact);
    }

    #[test]
    fn gjk_resolves_tiny_gaps_between_polytopes(
        a in prop::collection::vec(lattice_point(), 4..8), b in prop::collection::vec(lattice_point(), 4..8), exponent in 5i32..17
    ) {
        // Two hulls on either side of a plane, a gap apart: along z, where both have a face or vertex.
        let gap = f32::powi(2.0, -exponent);
        let below = hull(a.iter().map(|&p| p - Vec3A::Z * 3.0));
        let above = hull(b.iter().map(|&p| p + Vec3A::Z * 3.0));
        let top = below.vertices().iter().map(|p| p.z).fold(f32::MIN, f32::max);
        let bottom = above.vertices().iter().map(|p| p.z).fold(f32::MAX, f32::min);
        let above = hull(above.vertices().iter().map(|&p| p + Vec3A::Z * (top - bottom + gap)));
        prop_assert!(!gjk::intersects(&below, &above));
    }
}

/// The distance of two sets of points' hulls, if those are apart: the smallest between a point of one and a triangle of
/// the other, or two segments.
fn feature_distance(a: &[Vec3A], b: &[Vec3A]) -> f64 {
    let wide = |points: &[Vec3A]| points.iter().map(|p| p.as_dvec3()).collect::<Vec<_>>();
    let (a, b) = (wide(a), wide(b));
    let mut best = f64::INFINITY;
    for (points, others) in [(&a, &b), (&b, &a)] {
        for &p in points {
            for i in 0..others.len() {
                for j in 0..=i {
                    for k in 0..=j {
                        best = best.min(point_triangle_distance(p, [others[i], others[j], others[k]]));
                    }
                }
            }
        }
    }
    for i in 0..a.len() {
        for j in 0..i {
            for k in 0..b.len() {
                for l in 0..k {
                    best = best.min(segment_segment_distance([a[i], a[j]], [b[k], b[l]]));
                }
            }
        }
    }
    best
}

pub fn point_segment_distance(p: DVec3, [a, b]: [DVec3; 2]) -> f64 {
    let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
    if t.is_nan() {
        p.distance(a)
    } else {
        p.distance(a + (b - a) * t)
    }
}

pub fn point_triangle_distance(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let edges = [[a, b], [b, c], [c, a]].map(|edge| point_segment_distance(p, edge));
    let of_edges = edges.into_iter().fold(f64::INFINITY, f64::min);
    let normal = (b - a).cross(c - a).normalize_or_zero();
    if normal == DVec3::ZERO {
        return of_edges;
    }
    let sides = [(b - a, a), (c - b, b), (a - c, c)].map(|(edge, from)| normal.cross(edge).dot(p - from));
    if sides.iter().all(|&side| side >= 0.0) {
        normal.dot(p - a).abs()
    } else {
        of_edges
    }
}

fn segment_segment_distance([a, b]: [DVec3; 2], [c, d]: [DVec3; 2]) -> f64 {
    let ends = [
        point_segment_distance(a, [c, d]),
        point_segment_distance(b, [c, d]),
        point_segment_distance(c, [a, b]),
        point_segment_distance(d, [a, b]),
    ];
    let of_ends = ends.into_iter().fold(f64::INFINITY, f64::min);
    let (u, v, w) = (b - a, d - c, a - c);
    let normal = u.cross(v);
    let n2 = normal.length_squared();
    if n2 <= 1e-20 * u.length_squared() * v.length_squared() {
        return of_ends;
    }
    let (s, t) = (v.cross(w).dot(normal) / n2, u.cross(w).dot(normal) / n2);
    let inside = (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t);
    if inside {
        of_ends.min((a + u * s).distance(c + v * t))
    } else {
        of_ends
    }
}

#[test]
fn an_empty_ray_touches_nothing() {
    let ray = Ray::new(Vec3::ZERO, Vec3::X, 2.0).unwrap().with_interval(1.5, 1.0);
    let everything = aabb_frustum(Vec3A::splat(-9.0), Vec3A::splat(9.0));
    assert!(!ray.intersects(&Vec3A::new(1.25, 0.0, 0.0)));
    assert!(!ray.intersects(&BoundingSphere::new(Vec3::ZERO, 9.0)));
    assert!(!ray.intersects(&Aabb3d::new(Vec3::ZERO, Vec3::splat(9.0))));
    assert!(!ray.intersects(&everything));
    assert!(!ray.intersects(&Triangle3d::new(Vec3::ZERO, Vec3::X * 3.0, Vec3::Y)));
    assert!(!ray.intersects(&Segment3d::new(Vec3::ZERO, Vec3::X * 3.0)));
    assert!(!ray.intersects(&ray));
}

#[test]
fn parallel_endless_rays_touch_only_on_one_line() {
    let ray = |y: f32, x: f32, forward: f32| Ray::new(Vec3::new(x, y, 0.0), Vec3::X * forward, f32::INFINITY).unwrap();
    assert!(!ray(0.0, 0.0, 1.0).intersects(&ray(1.0, 5.0, 1.0)));
    assert!(!ray(0.0, 0.0, 1.0).intersects(&ray(1.0, 5.0, -1.0)));
    assert!(ray(0.0, 0.0, 1.0).intersects(&ray(0.0, 5.0, 1.0)));
    assert!(ray(0.0, 5.0, 1.0).intersects(&ray(0.0, 5.0, -1.0)));
    assert!(!ray(0.0, 5.0, 1.0).intersects(&ray(0.0, 4.0, -1.0)));
}

#[test]
fn a_ray_without_end_and_one_to_the_largest_number_are_exact() {
    for t_max in [f32::INFINITY, f32::MAX] {
        let ray = Ray::new(Vec3::new(0.25, 0.5, 0.75), Vec3::new(1.0, 2.0, 3.0), t_max).unwrap();
        assert!(ray.intersects(&Vec3A::new(8.25, 16.5, 24.75)));
        assert!(!ray.intersects(&Vec3A::new(8.25, 16.5, 24.750002)));
        assert!(!ray.intersects(&Vec3A::new(-0.75, -1.5, -2.25)));
        assert!(ray.intersects(&Segment3d::new(
            Vec3::new(8.25, 16.5, 20.0),
            Vec3::new(8.25, 16.5, 24.75)
        )));
    }
}

#[test]
fn a_frustum_without_planes_is_all_of_space() {
    let everything = ViewFrustum::default();
    assert!(everything.intersects(&Vec3A::splat(1e30)));
    assert!(everything.intersects(&BoundingSphere::new(Vec3::splat(7.0), 0.0)));
    assert!(everything.intersects(&Triangle3d::default()));
    assert!(everything.intersects(&everything));
    assert!(everything.contains(&Aabb3d::new(Vec3::ZERO, Vec3::ONE)));
    assert!(!Aabb3d::new(Vec3::ZERO, Vec3::ONE).contains(&everything));
}

#[test]
fn a_frustum_behind_its_own_planes_is_empty() {
    let empty = aabb_frustum(Vec3A::ONE, Vec3A::NEG_ONE);
    for shape in [
        Shape::Point(Vec3A::ZERO),
        Shape::Sphere(BoundingSphere::new(Vec3::ZERO, 0.5)),
        Shape::Aabb(Aabb3d::new(Vec3::ZERO, Vec3::splat(5.0))),
        Shape::Frustum(aabb_frustum(Vec3A::splat(-5.0), Vec3A::splat(5.0))),
    ] {
        assert!(!Shape::Frustum(empty).touches(&shape), "{shape:?}");
    }
}

#[test]
fn a_large_sphere_beside_a_corner_of_a_frustum_is_outside() {
    // Inside all planes grown by the radius, which is what half-spaces alone would ask.
    let frustum = Frustum::from(&aabb_frustum(Vec3A::NEG_ONE, Vec3A::ONE));
    assert!(!frustum.intersects(&BoundingSphere::new(Vec3::splat(1.9), 1.5)));
    assert!(frustum.intersects(&BoundingSphere::new(Vec3::splat(1.9), 1.6)));
}

#[test]
fn a_large_box_across_a_corner_of_a_frustum_is_outside() {
    let frustum = Frustum::from(&aabb_frustum(Vec3A::NEG_ONE, Vec3A::ONE));
    let rotation = Quat::from_rotation_arc(Vec3::X, Vec3::ONE.normalize());
    let beside = |distance: f32| {
        Obb::new(Vec3A::ONE.normalize() * distance, Vec3A::new(0.1, 50.0, 50.0), rotation).expect("a sound box")
    };
    assert!(frustum.intersects(&beside(1.8)));
    assert!(!frustum.intersects(&beside(1.85)));
}

#[test]
fn denormals_and_huge_coordinates_are_told_apart() {
    for scale in [f32::from_bits(1), 1e-38, 1e-20, 1e18] {
        let at = |x: f32| {
            Shape::Aabb(Aabb3d {
                min: Vec3A::splat(x * scale),
                max: Vec3A::splat((x + 1.0) * scale),
            })
        };
        let hull_at = |x: f32| {
            Shape::Hull(hull(box_corners(
                Vec3A::splat(x * scale),
                Vec3A::splat((x + 1.0) * scale),
            )))
        };
        for (a, b) in [
            (at(0.0), hull_at(1.0)),
            (hull_at(0.0), hull_at(1.0)),
            (hull_at(1.0), at(2.0)),
        ] {
            assert!(a.touches(&b), "{scale}");
        }
        for (a, b) in [
            (at(0.0), hull_at(2.0)),
            (hull_at(0.0), hull_at(2.0)),
            (hull_at(1.0), at(3.0)),
        ] {
            assert!(!a.touches(&b), "{scale}");
        }
    }
}

#[test]
fn the_bound_of_gjk_does_not_exceed_its_distance() {
    let a = Segment3d::new(Vec3::new(-1.0, -4.3638687, -1.0), Vec3::new(-38.632557, 0.0, -2.0));
    let b = Segment3d::new(Vec3::new(-31.229637, -1.0, 2.0), Vec3::new(10.847669, -3.0, -74.51257));
    let separation = gjk::distance(&a, &b);
    assert!(separation.bound <= separation.distance);
}

#[test]
fn a_sphere_without_a_radius_touches_the_turned_box_that_it_is_in() {
    let sphere = BoundingSphere::new(Vec3A::ZERO, 0.0);
    for step in 0..64 {
        let rotation = Quat::from_euler(bevy::math::EulerRot::XYZ, 0.1 * step as f32, 0.7, 0.03 * step as f32);
        let center = rotation * Vec3A::new(0.0, 0.0, 0.75);
        let obb = Obb::new(center, Vec3A::new(0.001, 0.001, 1.001), rotation).expect("a sound box");
        assert!(sphere.intersects(&obb) && obb.intersects(&sphere), "{obb:?}");
    }
}

#[test]
fn a_sphere_that_sticks_out_is_not_contained() {
    let (min, max) = (Vec3A::splat(-2.0), Vec3A::splat(2.0));
    let inside = BoundingSphere::new(Vec3A::ONE, 0.75);
    let sticks_out = BoundingSphere::new(Vec3A::ONE, 1.25);
    let boxes = [
        Shape::Aabb(Aabb3d { min, max }),
        Shape::Obb(Obb::new(Vec3A::ZERO, max, Quat::IDENTITY).expect("a sound box")),
        Shape::Hull(hull(box_corners(min, max))),
        Shape::Frustum(aabb_frustum(min, max)),
    ];
    for container in boxes {
        assert_eq!(container.holds(&Shape::Sphere(inside)), Some(true), "{container:?}");
        assert_eq!(
            container.holds(&Shape::Sphere(sticks_out)),
            Some(false),
            "{container:?}"
        );
    }
}

#[test]
fn a_point_just_beyond_a_sphere_does_not_touch() {
    let sphere = BoundingSphere::new(Vec3A::ZERO, 1.0);
    assert!(sphere.intersects(&Vec3A::X));
    // The square of its distance is 1 in double precision.
    assert!(!sphere.intersects(&Vec3A::new(1.0, 2f32.powi(-60), 0.0)));
}

#[test]
fn a_frustum_touches_the_margin_of_a_hull() {
    use bevy_sightline::geometry::volume::Volume;
    let frustum = Frustum::from(&aabb_frustum(Vec3A::ZERO, Vec3A::splat(10.0)));
    let above = [
        Vec3A::new(5.0, 5.0, 10.5),
        Vec3A::new(5.5, 5.0, 11.0),
        Vec3A::new(5.0, 5.5, 11.0),
    ];
    assert!(!frustum.intersects(&hull(above)));
    assert!(frustum.intersects(&hull(above).grown(1.0)));
}

proptest! {
    #![proptest_config(crate::properties::cases())]

    #[test]
    fn a_point_touches_the_turned_box_that_was_built_around_it(
        points in properties::points(), transform in properties::affine()
    ) {
        use bevy_sightline::geometry::volume::Volume;
        let obb = Obb::enclosing(points.iter().copied()).expect("finite");
        let image = obb.transformed_by_affine(&transform);
        for point in points {
            prop_assert!(point.intersects(&obb));
            prop_assert!(transform.transform_point3a(point).intersects(&image));
        }
    }
}
