use bevy::math::{Affine3A, Vec3, Vec3A, bounding::Aabb3d};
use bevy_sightline::geometry::{aabb::Aabb3dExt, volume::Volume};
use proptest::prelude::*;

use crate::properties::{affine, cases, points};

#[test]
fn the_box_around_a_point_is_that_point() {
    let point = Vec3A::new(1.0, -2.0, 1e-45);
    assert_eq!(Aabb3d::enclosing([point]), Ok(Aabb3d { min: point, max: point }));
}

#[test]
fn the_size_of_a_box() {
    let aabb = Aabb3d {
        min: Vec3A::ZERO,
        max: Vec3A::new(1.0, 2.0, 3.0),
    };
    assert_eq!(aabb.volume(), 6.0);
    assert_eq!(aabb.surface_area(), 22.0);
}

#[test]
fn a_flat_box_has_no_volume_and_two_sides() {
    let aabb = Aabb3d {
        min: Vec3A::ZERO,
        max: Vec3A::new(1.0, 2.0, 0.0),
    };
    assert_eq!(aabb.volume(), 0.0);
    assert_eq!(aabb.surface_area(), 4.0);
}

#[test]
fn the_image_of_a_tiny_box_does_not_underflow() {
    let aabb = Aabb3d {
        min: Vec3A::splat(1e-45),
        max: Vec3A::splat(1e-45),
    };
    let transform = Affine3A::from_scale(Vec3::splat(1e4));
    assert!(
        aabb.transformed_by_affine(&transform)
            .contains_point(transform.transform_point3a(aabb.min))
    );
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn the_smallest_box_is_touched_on_all_sides(points in points()) {
        let aabb = Aabb3d::enclosing(points.iter().copied()).expect("finite");
        prop_assert!(aabb.is_sound());
        for axis in 0..3 {
            prop_assert!(points.iter().any(|point| point[axis] == aabb.min[axis]));
            prop_assert!(points.iter().any(|point| point[axis] == aabb.max[axis]));
        }
    }

    #[test]
    fn the_image_of_a_box_is_as_tight_as_its_corners(points in points(), transform in affine()) {
        let aabb = Aabb3d::enclosing(points).expect("finite");
        let image = aabb.transformed_by_affine(&transform);
        let corners = (0..8).map(|corner| {
            let corner = Vec3A::from_array(std::array::from_fn(|axis| {
                if corner >> axis & 1 == 0 { aabb.min[axis] } else { aabb.max[axis] }
            }));
            transform.transform_point3a(corner)
        });
        let tight = Aabb3d::enclosing(corners).expect("finite");
        let magnitude = aabb.min.abs().max(aabb.max.abs()).element_sum() * 10.0 + transform.translation.abs().max_element();
        let slack = Vec3A::splat(magnitude * 2e-6 + 1e-30);
        prop_assert!(image.min.cmple(tight.min).all() && image.max.cmpge(tight.max).all());
        prop_assert!(image.min.cmpge(tight.min - slack).all() && image.max.cmple(tight.max + slack).all());
    }
}

#[test]
fn the_image_of_a_box_that_underflows_contains_the_images_of_its_corners() {
    let smallest = f32::from_bits(1);
    let aabb = Aabb3d {
        min: Vec3A::splat(0.5),
        max: Vec3A::splat(1.5),
    };
    let transform = Affine3A::from_scale(Vec3::splat(smallest));
    let image = aabb.transformed_by_affine(&transform);
    for corner in [aabb.min, aabb.max] {
        assert!(image.contains_point(transform.transform_point3a(corner)), "{image:?}");
    }
}
