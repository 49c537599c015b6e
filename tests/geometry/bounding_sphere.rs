use bevy::math::{Affine3A, DMat3, DVec3, Vec3, Vec3A, bounding::BoundingSphere};
use bevy_sightline::geometry::{bounding_sphere::BoundingSphereExt, ray::Ray, volume::Volume};
use proptest::prelude::*;

use super::volume::{exactly_at, ray_towards, ugly_points};
use crate::properties::{affine, cases, point, points};

fn sphere(points: &[Vec3A]) -> BoundingSphere {
    BoundingSphere::enclosing(points.iter().copied()).expect("finite")
}

/// The smallest radius by trying the spheres on all pairs, triples and quadruples: the largest of the smallest spheres
/// around any of these (Helly), each found by solving for its centre among the affine combinations.
fn smallest_radius(points: &[Vec3A]) -> f64 {
    let points: Vec<DVec3> = points.iter().map(|point| point.as_dvec3()).collect();
    let mut best = f64::INFINITY;
    let mut consider = |center: DVec3| {
        if center.is_finite() {
            let radius = points.iter().map(|point| point.distance(center)).fold(0.0, f64::max);
            best = best.min(radius);
        }
    };
    for (i, &a) in points.iter().enumerate() {
        consider(a);
        for (j, &b) in points[..i].iter().enumerate() {
            consider((a + b) / 2.0);
            for (k, &c) in points[..j].iter().enumerate() {
                // The three planes: half way between a and b, half way between a and c, and that of the triangle.
                let (ab, ac) = (b - a, c - a);
                let planes = DMat3::from_cols(ab, ac, ab.cross(ac)).transpose();
                let sides = DVec3::new(ab.length_squared() / 2.0, ac.length_squared() / 2.0, 0.0);
                consider(a + planes.inverse() * sides);
                for &d in &points[..k] {
                    let ad = d - a;
                    let planes = DMat3::from_cols(ab, ac, ad).transpose();
                    consider(a + planes.inverse() * sides.with_z(ad.length_squared() / 2.0));
                }
            }
        }
    }
    best
}

/// The largest singular value by repeated squaring of `matrixᵀ · matrix`.
fn largest_stretch(transform: &Affine3A) -> f64 {
    let matrix = DMat3::from_cols_array(&transform.matrix3.to_cols_array().map(f64::from));
    let mut gram = matrix.transpose() * matrix;
    let norm = |m: &DMat3| m.to_cols_array().map(f64::abs).into_iter().fold(0.0, f64::max);
    let (mut log, mut power) = (0.0, 1.0);
    for _ in 0..40 {
        let size = norm(&gram);
        if size == 0.0 {
            return 0.0;
        }
        log += size.ln() / power;
        gram *= size.recip();
        gram = gram * gram;
        power *= 2.0;
    }
    (0.5 * log).exp()
}

#[test]
fn the_sphere_around_an_octahedron_is_the_unit_sphere() {
    let points = [Vec3A::X, Vec3A::NEG_X, Vec3A::Y, Vec3A::NEG_Y, Vec3A::Z, Vec3A::NEG_Z];
    assert_eq!(sphere(&points), BoundingSphere::new(Vec3A::ZERO, 1.0));
}

#[test]
fn the_sphere_around_coincident_points_is_a_point() {
    assert_eq!(
        sphere(&[Vec3A::splat(0.1); 50]),
        BoundingSphere::new(Vec3A::splat(0.1), 0.0)
    );
}

#[test]
fn the_sphere_around_points_on_a_line_has_its_ends_as_diameter() {
    let points: Vec<_> = (0..=100u8).map(|n| Vec3A::new(f32::from(n), 0.0, 3.0)).collect();
    assert_eq!(sphere(&points), BoundingSphere::new(Vec3A::new(50.0, 0.0, 3.0), 50.0));
}

#[test]
fn the_sphere_around_a_hundred_thousand_points_of_one_sphere_is_that_sphere() {
    // A spiral of Fibonacci.
    let points: Vec<_> = (0..100_000u32)
        .map(|n| {
            let (sin, cos) = (f64::from(n) * 2.399_963_229_728_653).sin_cos();
            let z = 1.0 - 2.0 * (f64::from(n) + 0.5) / 100_000.0;
            let around = (1.0 - z * z).sqrt();
            (DVec3::new(around * cos, around * sin, z) * 7.0 + DVec3::new(1.0, 2.0, 3.0)).as_vec3a()
        })
        .collect();
    let around = sphere(&points);
    assert!((around.radius() - 7.0).abs() < 7e-6, "{around:?}");
    assert!(points.iter().all(|&point| around.contains_point(point)));
}

#[test]
fn a_sphere_merged_with_one_inside_stays_as_it_is() {
    let (outer, inner) = (
        BoundingSphere::new(Vec3A::ONE, 3.0),
        BoundingSphere::new(Vec3A::ZERO, 1.0),
    );
    assert_eq!(outer.merged(&inner), outer);
    assert_eq!(inner.merged(&outer), outer);
    assert_eq!(outer.merged(&outer), outer);
}

#[test]
fn a_sphere_merged_with_one_apart_spans_both() {
    let merged = BoundingSphere::new(Vec3A::ZERO, 1.0).merged(&BoundingSphere::new(Vec3A::X * 10.0, 3.0));
    assert_eq!(merged.center, Vec3A::X * 6.0);
    assert!((7.0..7.000002).contains(&merged.radius()));
}

#[test]
fn the_size_of_the_unit_sphere() {
    let unit = BoundingSphere::new(Vec3A::ZERO, 1.0);
    assert_eq!(unit.volume(), std::f32::consts::PI * 4.0 / 3.0);
    assert_eq!(unit.surface_area(), std::f32::consts::PI * 4.0);
}

#[test]
fn a_mirrored_and_stretched_sphere_grows_by_the_largest_stretch() {
    let image =
        BoundingSphere::new(Vec3A::ZERO, 2.0).transformed_by_affine(&Affine3A::from_scale(Vec3::new(1.0, -3.0, 0.0)));
    assert!((6.0..6.00001).contains(&image.radius()));
}

#[test]
fn a_ray_enters_a_sphere_where_it_touches_it() {
    let unit = BoundingSphere::new(Vec3A::ZERO, 1.0);
    let tangent = Ray::new(Vec3A::new(-5.0, 1.0, 0.0), Vec3A::X, f32::INFINITY).expect("finite");
    assert!(
        tangent
            .sphere_intersection_at(&unit)
            .is_some_and(|t| (4.9999..=5.0).contains(&t))
    );
    let short = Ray::new(Vec3A::new(-5.0, 0.0, 0.0), Vec3A::X * 2.0, 1.9).expect("finite");
    assert_eq!(short.sphere_intersection_at(&unit), None);
    assert!(
        short
            .with_t_max(2.0)
            .sphere_intersection_at(&unit)
            .is_some_and(|t| (1.9999..=2.0).contains(&t))
    );
    let inside = Ray::new(Vec3A::ZERO, Vec3A::X, f32::INFINITY).expect("finite");
    assert_eq!(inside.sphere_intersection_at(&unit), Some(0.0));
    assert_eq!(inside.with_interval(0.5, 9.0).sphere_intersection_at(&unit), Some(0.5));
    assert_eq!(inside.with_interval(1.5, 9.0).sphere_intersection_at(&unit), None);
    assert_eq!(inside.with_interval(0.5, 0.25).sphere_intersection_at(&unit), None);
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn no_sphere_is_smaller(points in points(), kept in 1usize..9) {
        let points = &points[..kept.min(points.len())];
        let (around, smallest) = (sphere(points), smallest_radius(points));
        // The centre is rounded to `f32`.
        let rounding = f64::from(f32::EPSILON) * (smallest + around.center.as_dvec3().length());
        prop_assert!((f64::from(around.radius()) - smallest).abs() <= rounding, "{} {smallest}", around.radius());
    }

    #[test]
    fn ritter_contains_the_points_and_is_no_smaller_than_the_smallest(points in ugly_points()) {
        let Ok(ritter) = BoundingSphere::ritter(points.iter().copied()) else {
            prop_assert!(points.iter().any(|point| point.abs().max_element() > f32::MAX / 4.0));
            return Ok(());
        };
        for &point in &points {
            prop_assert!(ritter.contains_point(point));
        }
        let (smallest, fast) = (sphere(&points), f64::from(ritter.radius()));
        // Of the centres; denormal numbers are rounded by a whole one.
        let rounding = f64::from(f32::EPSILON) * (fast + smallest.center.as_dvec3().length()) + 4.0 * f64::from(f32::from_bits(1));
        prop_assert!(fast >= f64::from(smallest.radius()) - rounding);
        prop_assert!(fast <= f64::from(smallest.radius()) * 1.2 + rounding, "{fast} {}", smallest.radius());
    }

    #[test]
    fn a_merged_sphere_contains_the_ends_of_both_and_is_no_larger_than_they_span(
        [a, b] in [point(), point()],
        [ra, rb] in [0.0f32..100.0, 0.0f32..100.0],
    ) {
        let (first, second) = (BoundingSphere::new(a, ra), BoundingSphere::new(b, rb));
        let merged = first.merged(&second);
        let center = merged.center.as_dvec3();
        let reaches = [first, second].map(|s| center.distance(s.center.as_dvec3()) + f64::from(s.radius()));
        let radius = f64::from(merged.radius());
        prop_assert!(reaches.iter().all(|&reach| reach <= radius * (1.0 + 1e-15)), "{reaches:?} {radius}");
        let span = (a.as_dvec3().distance(b.as_dvec3()) + f64::from(ra) + f64::from(rb)) / 2.0;
        let smallest = span.max(ra.into()).max(rb.into());
        prop_assert!(radius <= smallest + 2e-7 * (smallest + center.length()));
    }

    #[test]
    fn the_radius_of_an_image_is_the_largest_stretch_of_it(center in point(), radius in 0.0f32..100.0, transform in affine()) {
        let image = BoundingSphere::new(center, radius).transformed_by_affine(&transform);
        let exact = largest_stretch(&transform) * f64::from(radius);
        let magnitude = f64::from(center.length() + radius) * 10.0 + f64::from(transform.translation.length());
        prop_assert!(f64::from(image.radius()) >= exact);
        prop_assert!(f64::from(image.radius()) <= exact + magnitude * 1e-6);
    }

    #[test]
    fn a_ray_is_reported_as_in_double_precision(
        (around, ray) in (point(), prop_oneof![0.0f32..50.0, Just(0.0f32)])
            .prop_flat_map(|(center, radius)| (Just(BoundingSphere::new(center, radius)), ray_towards(center))),
    ) {
        let (center, radius) = (around.center.as_dvec3(), f64::from(around.radius()));
        let direction = ray.direction().as_dvec3();
        let (t_min, t_max) = (f64::from(ray.t_min()), f64::from(ray.t_max()));
        let closest = (center - ray.origin().as_dvec3()).dot(direction) / direction.length_squared();
        let t = closest.clamp(t_min, t_max.max(t_min));
        let apart = exactly_at(&ray, t).distance(center);
        let entered = ray.sphere_intersection_at(&around);
        let slack = 1e-13 * (ray.origin().as_dvec3().distance(center) + radius);
        if t_min > t_max || apart > radius + slack {
            prop_assert_eq!(entered, None);
        } else if apart <= radius {
            let entered = f64::from(entered.expect("a hit"));
            prop_assert!(entered >= t_min && entered <= t);
            // By bisection between a point outside and the closest inside.
            let (mut outside, mut inside) = (t_min, t);
            if exactly_at(&ray, outside).distance(center) <= radius {
                inside = outside;
            }
            for _ in 0..200 {
                let middle = (outside + inside) / 2.0;
                if exactly_at(&ray, middle).distance(center) <= radius { inside = middle } else { outside = middle }
            }
            prop_assert!(entered <= inside, "{entered} {inside}");
            let grazing = (2.0 * slack * (radius + slack)).sqrt() / direction.length();
            prop_assert!(entered >= inside * (1.0 - 1e-6) - grazing - slack / direction.length(), "{entered} {inside}");
        }
    }
}

#[test]
fn a_ray_that_touches_a_sphere_in_one_point_meets_it() {
    for step in 0..1000 {
        // The closest point is at n / 25 along the ray, which no double is, and at a distance of exactly 1.
        let n = 15.0 + 25.0 * step as f32;
        let center = Vec3A::new((3.0 * n - 20.0) / 25.0, (4.0 * n + 15.0) / 25.0, 0.0);
        let ray = Ray::new(Vec3A::ZERO, Vec3A::new(3.0, 4.0, 0.0), f32::INFINITY).expect("finite");
        let entered = BoundingSphere::new(center, 1.0).ray_intersection_at(&ray);
        assert!(
            entered.is_some_and(|t| f64::from(t) <= f64::from(n) / 25.0),
            "{center:?} {entered:?}"
        );
    }
}
