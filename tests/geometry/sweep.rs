use bevy::math::{
    DVec3, Quat, Vec3, Vec3A,
    bounding::{Aabb3d, BoundingSphere},
    primitives::{Segment3d, Triangle3d},
};
use bevy_sightline::geometry::{
    intersection::gjk,
    obb::Obb,
    ray::Ray,
    support::Support,
    sweep::{AabbSweep, SphereSweep, SweepIntersection},
};
use proptest::prelude::*;

use super::shapes::{Shape, any_shape, hull};
use crate::properties;

/// A box or a point that is carried along.
struct Carried {
    center: DVec3,
    half_size: DVec3,
}

impl Support for Carried {
    fn support_point(&self, direction: DVec3) -> DVec3 {
        self.center + DVec3::select(direction.cmpge(DVec3::ZERO), self.half_size, -self.half_size)
    }
}

struct Standing<'a>(&'a Shape);

impl Support for Standing<'_> {
    fn support_point(&self, direction: DVec3) -> DVec3 {
        match self.0 {
            // The radius counts with that of the sweep.
            Shape::Sphere(sphere) => sphere.center.as_dvec3(),
            shape => shape.support(direction),
        }
    }
}

fn swept(shape: &Shape, sweep: &impl AnySweep) -> Option<Option<f32>> {
    Some(match shape {
        Shape::Point(a) => sweep.at(a),
        Shape::Segment(a) => sweep.at(a),
        Shape::Sphere(a) => sweep.at(a),
        Shape::Aabb(a) => sweep.at(a),
        Shape::Obb(a) => sweep.at(a),
        Shape::Hull(a) => sweep.at(a),
        Shape::Triangle(a) => sweep.at(a),
        Shape::Ray(_) | Shape::Frustum(_) => return None,
    })
}

trait AnySweep {
    fn at<S>(&self, shape: &S) -> Option<f32>
    where
        SphereSweep: SweepIntersection<S>,
        AabbSweep: SweepIntersection<S>;
}

impl AnySweep for SphereSweep {
    fn at<S>(&self, shape: &S) -> Option<f32>
    where
        SphereSweep: SweepIntersection<S>,
    {
        self.intersection_at(shape)
    }
}

impl AnySweep for AabbSweep {
    fn at<S>(&self, shape: &S) -> Option<f32>
    where
        AabbSweep: SweepIntersection<S>,
    {
        self.intersection_at(shape)
    }
}

/// The distance is a convex function of the parameter: its minimum by golden sections, then the first parameter at which
/// it is at most `radius` by bisection.
fn check(found: Option<f32>, ray: &Ray, half_size: DVec3, radius: f64, shape: &Shape) -> Result<(), TestCaseError> {
    let radius = radius
        + if let Shape::Sphere(sphere) = shape {
            f64::from(sphere.radius())
        } else {
            0.0
        };
    let distance = |t: f64| {
        let center = ray.origin().as_dvec3() + ray.direction().as_dvec3() * t;
        gjk::distance(&Carried { center, half_size }, &Standing(shape)).distance
    };
    let (t_min, t_max) = (f64::from(ray.t_min()), f64::from(ray.t_max()));
    let (mut low, mut high) = (t_min, t_max);
    for _ in 0..80 {
        let (a, b) = (low + (high - low) * 0.382, low + (high - low) * 0.618);
        // Where the two touch for a while, the distance is zero on all of it.
        if distance(a) <= distance(b) { high = b } else { low = a }
    }
    let minimum = distance(low)
        .min(distance(high))
        .min(distance(t_min))
        .min(distance(t_max));
    let slack = 2e-9 * 100.0;
    match found {
        None => prop_assert!(minimum > radius - slack, "missed: {minimum} within {radius}"),
        Some(found) => {
            let t = f64::from(found);
            prop_assert!((t_min..=t_max).contains(&t));
            prop_assert!(minimum <= radius + slack, "never so close: {minimum}, radius {radius}");
            // Rounding of the parameter moves the shape.
            let moved = 1.2e-7 * t * ray.direction().as_dvec3().length();
            prop_assert!(
                distance(t) <= radius + slack + moved,
                "not there yet: {} of {radius}",
                distance(t)
            );
            // Not when it leaves, nor on the way through: the first such parameter, by bisection.
            let lowest = if distance(low) <= distance(high) { low } else { high };
            if distance(lowest) <= radius {
                let (mut before, mut first) = (t_min, if distance(t_min) <= radius { t_min } else { lowest });
                for _ in 0..80 {
                    let middle = (before + first) / 2.0;
                    if distance(middle) <= radius {
                        first = middle;
                    } else {
                        before = middle;
                    }
                }
                prop_assert!(
                    t <= first * (1.0 + 6.0e-8) + 1e-11 * t_max,
                    "too late: {t} after {first}"
                );
            }
            if t > t_min && radius > 0.0 {
                prop_assert!(
                    distance(t) >= radius - slack - moved,
                    "too late: {} of {radius}",
                    distance(t)
                );
            }
        }
    }
    Ok(())
}

fn ray() -> impl Strategy<Value = Ray> {
    (
        properties::point(),
        properties::direction(),
        0.1f32..3.0,
        1.0f32..100.0,
        prop_oneof![Just(0.0f32), 0.0f32..1.0],
    )
        .prop_map(|(target, direction, speed, t_max, t_min)| {
            let origin = target * 0.1 - direction * (0.4 * t_max * speed);
            Ray::new(origin, direction * speed, t_max)
                .expect("sound")
                .with_interval(t_min, t_max)
        })
}

fn near_shape() -> impl Strategy<Value = Shape> {
    any_shape().prop_filter("swept", |shape| !matches!(shape, Shape::Ray(_) | Shape::Frustum(_)))
}

proptest! {
    #![proptest_config(crate::properties::cases())]

    #[test]
    fn a_sphere_stops_where_it_touches(ray in ray(), radius in prop_oneof![Just(0.0f32), 0.0f32..5.0], shape in near_shape()) {
        let sweep = SphereSweep::new(ray, radius).expect("sound");
        let found = swept(&shape, &sweep).expect("swept");
        check(found, &ray, DVec3::ZERO, radius.into(), &shape)?;
    }

    #[test]
    fn an_aabb_stops_where_it_touches(
        ray in ray(), half in (prop_oneof![Just(0.0f32), 0.0f32..5.0], 0.0f32..5.0, 0.0f32..5.0), shape in near_shape()
    ) {
        let half = Vec3A::new(half.0, half.1, half.2);
        let sweep = AabbSweep::new(ray, half).expect("sound");
        let found = swept(&shape, &sweep).expect("swept");
        check(found, &ray, half.as_dvec3(), 0.0, &shape)?;
    }

    #[test]
    fn a_box_is_swept_alike_as_aabb_obb_and_hull(ray in ray(), half in [0.0f32..3.0, 0.0f32..3.0, 0.0f32..3.0], radius in 0.0f32..3.0) {
        // Representable corners, so that the three are the same set.
        let half = Vec3A::from_array(half.map(|h| (h * 64.0).round() / 64.0));
        let aabb = Shape::Aabb(Aabb3d::new(Vec3A::ZERO, half));
        let obb = Shape::Obb(Obb::new(Vec3A::ZERO, half, Quat::IDENTITY).expect("a sound box"));
        let as_hull = Shape::Hull(hull(Obb::new(Vec3A::ZERO, half, Quat::IDENTITY).expect("a sound box").corners()));
        let sphere = SphereSweep::new(ray, radius).expect("sound");
        let moving = AabbSweep::new(ray, Vec3A::splat(radius)).expect("sound");
        for other in [obb, as_hull] {
            for (a, b) in [
                (swept(&aabb, &sphere).unwrap(), swept(&other, &sphere).unwrap()),
                (swept(&aabb, &moving).unwrap(), swept(&other, &moving).unwrap()),
            ] {
                if let (Some(a), Some(b)) = (a, b) {
                    prop_assert!((a - b).abs() <= 1e-4, "{a} {b}");
                }
            }
        }
    }

    #[test]
    fn the_parameter_scales_with_the_direction(ray in ray(), radius in 0.0f32..5.0, shape in near_shape(), exponent in -10i32..10) {
        let scale = f32::powi(2.0, exponent);
        let faster = Ray::new(ray.origin(), ray.direction() * scale, ray.t_max() / scale)
            .expect("sound")
            .with_interval(ray.t_min() / scale, ray.t_max() / scale);
        let at = |ray| swept(&shape, &SphereSweep::new(ray, radius).expect("sound")).expect("swept");
        prop_assert_eq!(at(ray).map(|t| t / scale), at(faster));
    }
}

fn along_x(t_max: f32) -> Ray {
    Ray::new(Vec3::ZERO, Vec3::X, t_max).unwrap()
}

#[test]
fn a_sphere_meets_a_wall_by_its_radius() {
    let wall = Triangle3d::new(
        Vec3::new(5.0, -9.0, -9.0),
        Vec3::new(5.0, 9.0, -9.0),
        Vec3::new(5.0, 0.0, 9.0),
    );
    let sweep = SphereSweep::new(along_x(10.0), 1.0).unwrap();
    let t = sweep.intersection_at(&wall).unwrap();
    assert!((t - 4.0).abs() < 1e-6, "{t}");
}

#[test]
fn a_sphere_that_starts_in_contact_stops_at_the_start() {
    let ray = along_x(10.0).with_interval(2.0, 10.0);
    let sweep = SphereSweep::new(ray, 1.0).unwrap();
    assert_eq!(sweep.intersection_at(&Vec3A::new(2.0, 1.0, 0.0)), Some(2.0));
    assert_eq!(
        sweep.intersection_at(&BoundingSphere::new(Vec3::new(3.0, 0.0, 0.0), 9.0)),
        Some(2.0)
    );
}

#[test]
fn a_box_that_slides_along_a_wall_touches_it() {
    let floor = Triangle3d::new(
        Vec3::new(5.0, -1.0, -9.0),
        Vec3::new(15.0, -1.0, 0.0),
        Vec3::new(5.0, -1.0, 9.0),
    );
    let sweep = AabbSweep::new(along_x(10.0), Vec3::ONE).unwrap();
    let t = sweep.intersection_at(&floor).unwrap();
    assert!((t - 4.0).abs() < 1e-6, "{t}");
}

#[test]
fn what_ends_short_of_a_shape_does_not_touch_it() {
    let sweep = SphereSweep::new(along_x(3.5), 1.0).unwrap();
    assert_eq!(
        sweep.intersection_at(&Segment3d::new(Vec3::new(5.0, -1.0, 0.0), Vec3::new(5.0, 1.0, 0.0))),
        None
    );
    let sweep = AabbSweep::new(along_x(3.5), Vec3::ONE).unwrap();
    assert_eq!(sweep.intersection_at(&Aabb3d::new(Vec3::X * 6.0, Vec3::ONE)), None);
}

#[test]
fn what_ends_in_contact_touches() {
    let sweep = AabbSweep::new(along_x(4.0), Vec3::ONE).unwrap();
    assert_eq!(sweep.intersection_at(&Aabb3d::new(Vec3::X * 6.0, Vec3::ONE)), Some(4.0));
    let sweep = SphereSweep::new(along_x(4.0), 1.0).unwrap();
    assert_eq!(sweep.intersection_at(&Aabb3d::new(Vec3::X * 6.0, Vec3::ONE)), Some(4.0));
}

#[test]
fn endless_sweeps_end() {
    let sweep = SphereSweep::new(along_x(f32::INFINITY), 1.0).unwrap();
    assert_eq!(sweep.intersection_at(&Vec3A::new(-5.0, 0.0, 0.0)), None);
    assert_eq!(sweep.intersection_at(&Vec3A::new(5.0, 2.0, 0.0)), None);
    let t = sweep.intersection_at(&Vec3A::new(5.0, 1.0, 0.0)).expect("tangential");
    assert!((t - 5.0).abs() < 1e-4, "{t}");
}

#[test]
fn bad_sizes_are_refused() {
    for bad in [-1.0, f32::NAN, f32::INFINITY] {
        assert!(SphereSweep::new(along_x(1.0), bad).is_none());
        assert!(AabbSweep::new(along_x(1.0), Vec3::new(1.0, bad, 1.0)).is_none());
    }
}
