use bevy::math::{
    DVec3, Vec3, Vec3A,
    bounding::{Aabb3d, BoundingSphere},
    primitives::{Segment3d, Triangle3d},
};
use bevy_sightline::geometry::{closest_point::ClosestPoint, obb::Obb};
use num_rational::BigRational;
use num_traits::{ToPrimitive, Zero};
use proptest::prelude::*;

use super::{intersection::point_segment_distance, shapes::hull};
use crate::properties;

fn half_size() -> impl Strategy<Value = Vec3A> {
    [0.0f32..5.0, 0.0f32..5.0, 0.0f32..5.0].prop_map(Vec3A::from_array)
}

/// Weights of a convex combination.
fn weights(count: usize) -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(0.0f64..1.0, count).prop_map(|w| {
        let sum: f64 = w.iter().sum::<f64>().max(1e-9);
        w.into_iter().map(|x| x / sum).collect()
    })
}

/// The distance from a triangle by rational numbers: of a sliver, double precision does not even know the plane.
fn exact_distance(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    type Vector = [BigRational; 3];
    let exact = |v: DVec3| v.to_array().map(|x| BigRational::from_float(x).expect("finite"));
    let sub = |a: &Vector, b: &Vector| -> Vector { std::array::from_fn(|i| &a[i] - &b[i]) };
    let dot = |a: &Vector, b: &Vector| &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2];
    let cross = |a: &Vector, b: &Vector| -> Vector {
        std::array::from_fn(|i| &a[(i + 1) % 3] * &b[(i + 2) % 3] - &a[(i + 2) % 3] * &b[(i + 1) % 3])
    };
    let of_edges = [[a, b], [b, c], [c, a]].map(|edge| point_segment_distance(p, edge));
    let of_edges = of_edges.into_iter().fold(f64::INFINITY, f64::min);
    let [p, a, b, c] = [p, a, b, c].map(exact);
    let normal = cross(&sub(&b, &a), &sub(&c, &a));
    let zero = BigRational::zero();
    let inside = |from: &Vector, to: &Vector| dot(&cross(&normal, &sub(to, from)), &sub(&p, from)) >= zero;
    let area_squared = dot(&normal, &normal);
    if area_squared == zero || !(inside(&a, &b) && inside(&b, &c) && inside(&c, &a)) {
        return of_edges;
    }
    let height = dot(&normal, &sub(&p, &a));
    (&height * &height / area_squared).to_f64().expect("finite").sqrt()
}

proptest! {
    #![proptest_config(crate::properties::cases())]

    #[test]
    fn of_a_segment_is_at_the_distance(a in properties::point(), b in properties::point(), p in properties::point()) {
        let segment = Segment3d::new(a.into(), b.into());
        let expected = point_segment_distance(p.as_dvec3(), [a.as_dvec3(), b.as_dvec3()]);
        let found = segment.closest_point_f64(p.as_dvec3());
        prop_assert!((found.distance(p.as_dvec3()) - expected).abs() <= 1e-12 * 200.0);
        prop_assert!(point_segment_distance(found, [a.as_dvec3(), b.as_dvec3()]) <= 1e-12 * 200.0);
    }

    #[test]
    fn of_a_triangle_is_at_the_distance(
        corners in [properties::point(), properties::point(), properties::point()], p in properties::point(),
        degenerate in 0u8..4
    ) {
        let [a, b, mut c] = corners;
        match degenerate {
            1 => c = a,
            2 => c = (a + b) * 0.5,
            _ => {}
        }
        let corners = [a, b, c].map(Vec3A::as_dvec3);
        let triangle = Triangle3d::new(a.into(), b.into(), c.into());
        let found = triangle.closest_point_f64(p.as_dvec3());
        prop_assert!((found.distance(p.as_dvec3()) - exact_distance(p.as_dvec3(), corners)).abs() <= 1e-10);
        prop_assert!(exact_distance(found, corners) <= 1e-10);
        prop_assert!((triangle.distance_to_point(p) as f64 - found.distance(p.as_dvec3())).abs() <= 1e-7 * 400.0);
    }

    #[test]
    fn of_a_box_and_a_sphere_is_not_beaten(
        center in properties::point(), half in half_size(), p in properties::point(), sample in [-1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0]
    ) {
        let aabb = Aabb3d::new(center, half);
        let sampled = (center + half * Vec3A::from_array(sample)).clamp(aabb.min, aabb.max);
        let found = ClosestPoint::closest_point(&aabb, p);
        prop_assert!(found.cmpge(aabb.min).all() && found.cmple(aabb.max).all());
        prop_assert!(p.as_dvec3().distance(found.as_dvec3()) <= p.as_dvec3().distance(sampled.as_dvec3()));

        let sphere = BoundingSphere::new(center, half.x);
        let of_sphere = sphere.closest_point_f64(p.as_dvec3());
        let expected = (p.as_dvec3().distance(center.as_dvec3()) - f64::from(half.x)).max(0.0);
        prop_assert!((of_sphere.distance(p.as_dvec3()) - expected).abs() <= 1e-10);
    }

    #[test]
    fn of_an_obb_is_in_it_and_not_beaten(
        center in properties::point(), half in half_size(), rotation in properties::rotation(), p in properties::point(),
        sample in [-1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0]
    ) {
        let obb = Obb::new(center, half, rotation).expect("a sound box");
        let found = obb.closest_point_f64(p.as_dvec3());
        let axes = obb.axes();
        let local = |axis: usize| (found - center.as_dvec3()).dot(axes.col(axis).as_dvec3());
        for axis in 0..3 {
            prop_assert!(local(axis).abs() <= f64::from(half[axis]) + 1e-5);
        }
        let sampled = (0..3).map(|axis| axes.col(axis).as_dvec3() * f64::from(half[axis] * sample[axis])).sum::<DVec3>()
            + center.as_dvec3();
        prop_assert!(found.distance(p.as_dvec3()) <= sampled.distance(p.as_dvec3()) * (1.0 + 1e-6));
    }

    #[test]
    fn of_a_hull_is_not_beaten(
        points in prop::collection::vec(properties::point(), 1..9), p in properties::point(), weights in weights(8)
    ) {
        let shape = hull(points.clone());
        let found = shape.closest_point_f64(p.as_dvec3());
        let total: f64 = weights[..points.len().min(8)].iter().sum();
        prop_assume!(total > 1e-6);
        let sampled: DVec3 = points.iter().zip(&weights).map(|(p, w)| p.as_dvec3() * (w / total)).sum();
        prop_assert!(found.distance(p.as_dvec3()) <= sampled.distance(p.as_dvec3()) + 1e-9);
        for vertex in &points {
            // Everything is behind the plane through the closest point.
            let gap = p.as_dvec3() - found;
            prop_assert!(gap.dot(vertex.as_dvec3() - found) <= 1e-7 * (1.0 + gap.length()) );
        }
    }
}

#[test]
fn inside_a_solid_is_the_point_itself() {
    let p = Vec3A::new(0.25, -0.5, 0.125);
    assert_eq!(ClosestPoint::closest_point(&Aabb3d::new(Vec3::ZERO, Vec3::ONE), p), p);
    assert_eq!(ClosestPoint::closest_point(&BoundingSphere::new(Vec3::ZERO, 1.0), p), p);
    let shape = hull([Vec3A::splat(-4.0), Vec3A::X * 9.0, Vec3A::Y * 9.0, Vec3A::Z * 9.0]);
    assert_eq!(shape.closest_point(p), p);
    assert_eq!(shape.distance_to_point(p), 0.0);
}

#[test]
fn of_a_tiny_triangle_far_away_is_in_it() {
    let triangle = Triangle3d::new(Vec3::ZERO, Vec3::X * 1e-3, Vec3::Y * 1e-3);
    let found = triangle.closest_point(Vec3A::new(2.5e-4, 2.5e-4, 1e6));
    assert!((found - Vec3A::new(2.5e-4, 2.5e-4, 0.0)).length() < 1e-9, "{found}");
}

#[test]
fn of_a_sliver_is_in_its_plane() {
    // In double precision the cross product of its edges leans over, and misses its far end by 5e-8.
    let (a, b) = (
        Vec3::new(-4.6205955, -64.958824, 0.0),
        Vec3::new(45.342743, 3.4199975, 56.56496),
    );
    let triangle = Triangle3d::new(a, b, (a + b) * 0.5);
    let found = triangle.closest_point_f64(DVec3::ZERO);
    assert!(exact_distance(found, triangle.vertices.map(Vec3::as_dvec3)) < 1e-12);
}
