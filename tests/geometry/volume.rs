//! The promise of every kind of volume: what it was made from is in it, and no ray slips past.

use bevy::math::{
    Affine3A, DVec3, Vec3A,
    bounding::{Aabb3d, BoundingSphere},
};
use bevy_sightline::geometry::{
    convex_hull::ConvexHull,
    obb::Obb,
    ray::Ray,
    volume::{UnboundablePoints, Volume},
};
use proptest::prelude::*;

use crate::properties::{affine, cases, direction, point, points};

/// As [`points`], and also so small that products underflow, and so large that they overflow.
pub fn ugly_points() -> impl Strategy<Value = Vec<Vec3A>> {
    let scale = prop_oneof![
        6 => Just(1.0f32),
        1 => Just(1e-43f32),
        1 => Just(1e-36f32),
        1 => Just(1e30f32),
        1 => Just(f32::MAX / 1e8),
    ];
    (points(), scale).prop_map(|(points, scale)| points.into_iter().map(|point| point * scale).collect())
}

/// As [`affine`], and also of extreme scale.
fn ugly_affine() -> impl Strategy<Value = Affine3A> {
    let scale = prop_oneof![6 => Just(1.0f32), 1 => Just(1e-20f32), 1 => Just(1e-40f32), 1 => Just(1e25f32)];
    (affine(), scale, prop::bool::weighted(0.2)).prop_map(|(mut transform, scale, centered)| {
        transform.matrix3 *= scale;
        if centered {
            transform.translation = Vec3A::ZERO;
        }
        transform
    })
}

/// A ray that aims at `target`, or beside it, from near or far, with a direction of any length.
fn rays(target: Vec3A, [away, aside]: [Vec3A; 2], far: f32, length: f32) -> Option<Ray> {
    let origin = target + away * far;
    Ray::new(origin, (target + aside - origin) * length, f32::INFINITY)
}

fn contains_its_points<V: Volume>(points: &[Vec3A]) -> Result<(), TestCaseError> {
    match V::enclosing(points.iter().copied()) {
        Ok(volume) => {
            for &point in points {
                prop_assert!(volume.contains_point(point), "{point:?} is outside");
                prop_assert!(volume.aabb().contains_point(point), "{point:?} is outside of the box");
            }
        }
        Err(refused) => {
            prop_assert_eq!(refused, UnboundablePoints::Overflow);
            prop_assert!(points.iter().any(|point| point.abs().max_element() > f32::MAX / 8.0));
        }
    }
    Ok(())
}

fn merged_contains_both<V: Volume>(a: &[Vec3A], b: &[Vec3A]) -> Result<(), TestCaseError> {
    let [Ok(first), Ok(second)] = [a, b].map(|points| V::enclosing(points.iter().copied())) else {
        return Ok(());
    };
    let merged = first.merged(&second);
    for &point in a.iter().chain(b) {
        prop_assert!(merged.contains_point(point), "{point:?} is outside");
    }
    Ok(())
}

fn grown_contains_what_is_near<V: Volume>(points: &[Vec3A], along: Vec3A, amount: f32) -> Result<(), TestCaseError> {
    let Ok(volume) = V::enclosing(points.iter().copied()) else {
        return Ok(());
    };
    let grown = volume.grown(amount);
    for &point in points {
        let near = point + along * amount;
        if near.as_dvec3().distance(point.as_dvec3()) <= f64::from(amount) {
            prop_assert!(grown.contains_point(near), "{near:?}, near {point:?}, is outside");
        }
    }
    Ok(())
}

fn image_contains_the_images<V: Volume>(points: &[Vec3A], transform: &Affine3A) -> Result<(), TestCaseError> {
    let Ok(volume) = V::enclosing(points.iter().copied()) else {
        return Ok(());
    };
    let image = volume.transformed_by_affine(transform);
    // The points in the volume that were not its corners are images too.
    let inside = points
        .windows(2)
        .map(|pair| pair[0].midpoint(pair[1]))
        .filter(|&point| volume.contains_point(point));
    for point in points.iter().copied().chain(inside) {
        let moved = transform.transform_point3a(point);
        if moved.is_finite() {
            prop_assert!(
                image.contains_point(moved),
                "{moved:?}, the image of {point:?}, is outside"
            );
            prop_assert!(image.aabb().contains_point(moved), "{moved:?} is outside of the box");
        }
    }
    Ok(())
}

/// A point of the content, met by the ray at `t`, is in the exact volume: the ray enters it no later.
fn no_ray_slips_past<V: Volume>(points: &[Vec3A], ray: &Ray, t: f32) -> Result<(), TestCaseError> {
    let Ok(volume) = V::enclosing(points.iter().copied()) else {
        return Ok(());
    };
    let entered = volume.ray_intersection_at(ray);
    prop_assert!(
        entered.is_some_and(|entered| entered <= t),
        "{entered:?} instead of at most {t}"
    );
    Ok(())
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn a_volume_contains_the_points_it_was_built_from(points in ugly_points()) {
        contains_its_points::<BoundingSphere>(&points)?;
        contains_its_points::<Aabb3d>(&points)?;
        contains_its_points::<Obb>(&points)?;
        contains_its_points::<ConvexHull>(&points)?;
    }

    #[test]
    fn a_grown_volume_contains_what_is_near(points in ugly_points(), along in direction(), amount in point()) {
        grown_contains_what_is_near::<BoundingSphere>(&points, along, amount.x.abs())?;
        grown_contains_what_is_near::<Aabb3d>(&points, along, amount.x.abs())?;
        grown_contains_what_is_near::<Obb>(&points, along, amount.x.abs())?;
        grown_contains_what_is_near::<ConvexHull>(&points, along, amount.x.abs())?;
    }

    #[test]
    fn a_merged_volume_contains_the_points_of_both(a in ugly_points(), b in ugly_points()) {
        merged_contains_both::<BoundingSphere>(&a, &b)?;
        merged_contains_both::<Aabb3d>(&a, &b)?;
        merged_contains_both::<Obb>(&a, &b)?;
        merged_contains_both::<ConvexHull>(&a, &b)?;
    }

    #[test]
    fn the_image_of_a_volume_contains_the_images_of_its_points(points in ugly_points(), transform in ugly_affine()) {
        image_contains_the_images::<BoundingSphere>(&points, &transform)?;
        image_contains_the_images::<Aabb3d>(&points, &transform)?;
        image_contains_the_images::<Obb>(&points, &transform)?;
        image_contains_the_images::<ConvexHull>(&points, &transform)?;
    }

    #[test]
    fn a_ray_through_a_point_of_the_content_enters_the_volume_before(
        mut points in points(),
        away in [point(), point()],
        along in [-3i8..=3, -3i8..=3, -3i8..=3],
        t in 0u8..8,
    ) {
        // Whole numbers, so that the ray meets the point exactly: checked below in double precision.
        points.iter_mut().for_each(|point| *point = point.round().clamp(Vec3A::splat(-1e4), Vec3A::splat(1e4)));
        let direction = Vec3A::from_array(along.map(f32::from));
        let target = points[0];
        let origin = target - direction * f32::from(t);
        prop_assume!(direction != Vec3A::ZERO);
        points.push(target + away[0].round());
        let ray = Ray::new(origin, direction, f32::INFINITY).expect("finite");
        prop_assert_eq!(origin.as_dvec3() + direction.as_dvec3() * f64::from(t), target.as_dvec3());
        no_ray_slips_past::<BoundingSphere>(&points, &ray, f32::from(t))?;
        no_ray_slips_past::<Aabb3d>(&points, &ray, f32::from(t))?;
        no_ray_slips_past::<Obb>(&points, &ray, f32::from(t))?;
        no_ray_slips_past::<ConvexHull>(&points, &ray, f32::from(t))?;
    }
}

fn refusals<V: Volume + std::fmt::Debug + PartialEq>() {
    let refused = |points: &[Vec3A]| V::enclosing(points.iter().copied()).expect_err("unboundable");
    assert_eq!(refused(&[]), UnboundablePoints::Empty);
    let spoilt = |bad: f32| [Vec3A::ONE, Vec3A::ZERO, Vec3A::new(0.0, bad, 0.0), Vec3A::NAN];
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert_eq!(refused(&spoilt(bad)), UnboundablePoints::NotFinite { index: 2 });
    }
}

#[test]
fn no_points_and_points_that_are_not_finite_are_refused_with_the_first_index() {
    refusals::<BoundingSphere>();
    refusals::<Aabb3d>();
    refusals::<Obb>();
    refusals::<ConvexHull>();
}

#[test]
fn only_the_sphere_around_the_largest_numbers_overflows() {
    let ends = [Vec3A::splat(f32::MAX), Vec3A::splat(f32::MIN)];
    assert_eq!(BoundingSphere::enclosing(ends), Err(UnboundablePoints::Overflow));
    assert_eq!(
        Aabb3d::enclosing(ends),
        Ok(Aabb3d {
            min: ends[1],
            max: ends[0]
        })
    );
    let obb = Obb::enclosing(ends).expect("finite");
    assert!(ends.iter().all(|&end| obb.contains_point(end)));
}

fn is_endless<V: Volume>(volume: &V) {
    let ray = Ray::new(Vec3A::splat(1e30), Vec3A::new(0.0, 1e-30, -1.0), 5.0)
        .expect("finite")
        .with_interval(2.0, 5.0);
    assert!(volume.contains_point(Vec3A::splat(-3e38)));
    assert_eq!(volume.ray_intersection_at(&ray), Some(2.0));
    assert_eq!(
        volume.aabb(),
        Aabb3d {
            min: Vec3A::NEG_INFINITY,
            max: Vec3A::INFINITY
        }
    );
}

#[test]
fn a_transform_that_overflows_or_is_no_number_makes_a_volume_without_end() {
    fn check<V: Volume>() {
        let volume = V::enclosing([Vec3A::NEG_ONE, Vec3A::ONE, Vec3A::X]).expect("finite");
        for bad in [f32::NAN, f32::INFINITY] {
            let broken = volume.transformed_by_affine(&Affine3A::from_scale(bevy::math::Vec3::splat(bad)));
            is_endless(&broken);
            is_endless(&broken.transformed_by_affine(&Affine3A::IDENTITY));
            is_endless(&broken.merged(&volume));
            is_endless(&volume.merged(&broken));
        }
    }
    check::<BoundingSphere>();
    check::<Aabb3d>();
    check::<Obb>();
    check::<ConvexHull>();
}

#[test]
fn rays_from_far_away_find_the_volume() {
    // A unit set, seen from a million units: in single precision the discriminant cancels to noise.
    let corners: [Vec3A; 8] = std::array::from_fn(|corner| {
        Vec3A::from_array(std::array::from_fn(
            |axis| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 },
        ))
    });
    fn entered<V: Volume>(corners: [Vec3A; 8], ray: &Ray) -> Option<f32> {
        V::enclosing(corners).expect("finite").ray_intersection_at(ray)
    }
    let hit = Ray::new(Vec3A::new(-1e6, 0.5, 0.5), Vec3A::X, f32::INFINITY).expect("finite");
    let miss = Ray::new(Vec3A::new(-1e6, 1.75, 0.5), Vec3A::X, f32::INFINITY).expect("finite");
    let close = |t: Option<f32>| t.is_some_and(|t| (1e6 - 3.0..1e6).contains(&t));
    assert!(close(entered::<BoundingSphere>(corners, &hit)) && close(entered::<Aabb3d>(corners, &hit)));
    assert!(close(entered::<Obb>(corners, &hit)));
    assert_eq!(entered::<BoundingSphere>(corners, &miss), None);
    assert_eq!(entered::<Obb>(corners, &miss), None);
}

/// The points of the exact ray in double precision.
pub fn exactly_at(ray: &Ray, t: f64) -> DVec3 {
    ray.origin().as_dvec3() + ray.direction().as_dvec3() * t
}

/// A ray that starts around `target`, near or far, towards it or close by.
pub fn ray_towards(target: Vec3A) -> impl Strategy<Value = Ray> {
    let far = prop_oneof![3 => Just(1.0f32), 1 => Just(1e4f32), 1 => Just(0.01f32)];
    let length = prop_oneof![2 => Just(1.0f32), 1 => Just(1e-6f32), 1 => Just(1e6f32)];
    let interval = prop_oneof![3 => Just([0.0, f32::INFINITY]), 1 => [0.0f32..1.0, 0.0f32..3.0]];
    let axis = prop_oneof![3 => Just(None), 1 => (0usize..3).prop_map(Some)];
    (point(), point(), far, length, interval, axis).prop_filter_map(
        "a direction",
        move |(away, aside, far, length, [t_min, t_max], axis)| {
            let mut ray = rays(target, [away, aside * 0.02], far, length)?;
            if let Some(axis) = axis {
                let mut direction = Vec3A::ZERO;
                direction[axis] = ray.direction()[axis];
                ray = Ray::new(ray.origin(), direction, f32::INFINITY)?;
            }
            Some(ray.with_interval(t_min / length, t_max / length))
        },
    )
}
