use bevy::math::{
    Affine3A, DMat3, DVec3, Mat3A, Quat, Vec3, Vec3A,
    bounding::{Aabb3d, BoundingVolume},
};
use bevy_sightline::geometry::{obb::Obb, ray::Ray, volume::Volume};
use proptest::prelude::*;

use super::volume::{exactly_at, ray_towards};
use crate::properties::{affine, cases, direction, point, points, rotation};

fn enclosing(points: &[Vec3A]) -> Obb {
    Obb::enclosing(points.iter().copied()).expect("finite")
}

/// Extents from a thousandth to a hundred, of which some are zero.
fn extent() -> impl Strategy<Value = f32> {
    prop_oneof![4 => 0.5f32..100.0, 1 => 0.001f32..0.5, 1 => Just(1.0f32), 1 => Just(0.0f32)]
}

fn half_sizes() -> impl Strategy<Value = Vec3A> {
    [extent(), extent(), extent()].prop_map(Vec3A::from_array)
}

fn obbs() -> impl Strategy<Value = Obb> {
    (point(), half_sizes(), rotation())
        .prop_map(|(center, half_size, rotation)| Obb::new(center, half_size, rotation).expect("sound"))
}

fn sorted(half_size: Vec3A) -> Vec3A {
    let mut sizes = half_size.to_array();
    sizes.sort_by(f32::total_cmp);
    Vec3A::from_array(sizes)
}

fn is_right_handed_and_orthonormal(axes: Mat3A) -> bool {
    (axes.transpose() * axes).abs_diff_eq(Mat3A::IDENTITY, 4e-7) && axes.determinant() > 0.0
}

/// The half sizes are these, in any order, up to 1e-5 of the largest and what rounding makes of a coordinate.
fn has_size(obb: &Obb, half_size: Vec3A, magnitude: f32) -> Result<(), TestCaseError> {
    let off = sorted(obb.half_size()) - sorted(half_size);
    let slack = 1e-5 * half_size.max_element() + 8.0 * f32::EPSILON * magnitude;
    prop_assert!(
        off.abs().max_element() <= slack,
        "{:?} instead of {half_size:?}",
        obb.half_size()
    );
    Ok(())
}

#[test]
fn an_unsound_box_is_refused() {
    let (one, turn) = (Vec3A::ONE, Quat::IDENTITY);
    assert!(Obb::new(one, one, turn).is_some());
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert_eq!(Obb::new(one.with_z(bad), one, turn), None);
        assert_eq!(Obb::new(one, one.with_y(bad), turn), None);
        assert_eq!(Obb::new(one, one, Quat::from_xyzw(0.0, bad, 0.0, 1.0)), None);
    }
    assert_eq!(Obb::new(one, one.with_y(-1e-30), turn), None);
    assert_eq!(Obb::new(one, one, Quat::from_xyzw(0.0, 0.0, 0.0, 0.0)), None);
}

#[test]
fn a_rotation_of_another_length_is_normalized() {
    let turn = Quat::from_xyzw(0.0, 0.0, 3.0, 3.0);
    let obb = Obb::new(Vec3A::ZERO, Vec3A::ONE, turn).expect("sound");
    assert!(is_right_handed_and_orthonormal(obb.axes()));
}

#[test]
fn the_size_of_a_box() {
    let obb = Obb::new(Vec3A::ONE, Vec3A::new(1.0, 2.0, 3.0), Quat::from_rotation_x(0.3)).expect("sound");
    assert_eq!(obb.volume(), 48.0);
    assert_eq!(obb.surface_area(), 88.0);
    assert_eq!(BoundingVolume::visible_area(&obb), 44.0);
}

#[test]
fn the_box_around_a_point_is_that_point() {
    let obb = enclosing(&[Vec3A::splat(0.1)]);
    assert_eq!((obb.center(), obb.half_size()), (Vec3A::splat(0.1), Vec3A::ZERO));
}

#[test]
fn the_box_around_a_slanted_rectangle_in_a_plane_of_the_space_stays_flat() {
    let turn = Quat::from_rotation_z(0.3);
    let corners = [[-2.0, -1.0], [2.0, -1.0], [2.0, 1.0], [-2.0, 1.0]]
        .map(|[x, y]| turn * Vec3A::new(x, y, 0.0) + Vec3A::Z * 0.1);
    let obb = enclosing(&corners);
    assert_eq!(obb.volume(), 0.0);
    assert!((obb.surface_area() - 16.0).abs() < 1e-4);
}

#[test]
fn a_box_that_contains_the_other_is_what_they_merge_to() {
    let outer = Obb::new(Vec3A::ONE, Vec3A::splat(3.0), Quat::from_rotation_x(0.5)).expect("sound");
    let inner = Obb::new(Vec3A::ONE, Vec3A::splat(1.0), Quat::from_rotation_y(0.5)).expect("sound");
    assert_eq!(outer.merged(&inner), outer);
    assert_eq!(inner.merged(&outer), outer);
    assert_eq!(inner.merged(&inner), inner);
}

#[test]
fn two_halves_of_a_box_merge_to_it() {
    let turn = Quat::from_euler(bevy::math::EulerRot::XYZ, 0.3, 0.7, -1.1);
    let half = |side: f32| Obb::new(turn * Vec3A::X * side, Vec3A::new(1.0, 2.0, 3.0), turn).expect("sound");
    let merged = half(-1.0).merged(&half(1.0));
    assert!((merged.volume() - 96.0).abs() < 1e-3, "{merged:?}");
}

#[test]
fn shrinking_a_box_beyond_its_size_leaves_its_centre() {
    let obb = Obb::new(Vec3A::ONE, Vec3A::new(1.0, 2.0, 3.0), Quat::IDENTITY).expect("sound");
    assert_eq!(obb.shrink(Vec3A::splat(1.5)).half_size(), Vec3A::new(0.0, 0.5, 1.5));
    assert_eq!(obb.grow(Vec3A::splat(1.5)).half_size(), Vec3A::new(2.5, 3.5, 4.5));
    assert_eq!(
        obb.scale_around_center(Vec3A::new(0.0, 2.0, -1.0)).half_size(),
        Vec3A::new(0.0, 4.0, 3.0)
    );
    assert!(obb.grow(Vec3A::ONE).contains(&obb));
    assert!(!obb.contains(&obb.grow(Vec3A::ONE)));
}

#[test]
fn a_ray_in_the_plane_of_a_face_touches_the_box() {
    let obb = Obb::new(Vec3A::ZERO, Vec3A::ONE, Quat::IDENTITY).expect("sound");
    let grazing = Ray::new(Vec3A::new(-5.0, 1.0, 1.0), Vec3A::X, f32::INFINITY).expect("finite");
    assert!(
        grazing
            .obb_intersection_at(&obb)
            .is_some_and(|t| (3.9999..=4.0).contains(&t))
    );
    let beside = Ray::new(Vec3A::new(-5.0, 1.000001, 1.0), Vec3A::X, f32::INFINITY).expect("finite");
    assert_eq!(beside.obb_intersection_at(&obb), None);
    let away = Ray::new(Vec3A::new(-5.0, 0.0, 0.0), Vec3A::NEG_X, f32::INFINITY).expect("finite");
    assert_eq!(away.obb_intersection_at(&obb), None);
}

#[test]
fn a_ray_along_a_flat_box_from_its_very_centre_starts_inside() {
    let obb = Obb::new(Vec3A::ZERO, Vec3A::new(1.0, 1.0, 0.0), Quat::IDENTITY).expect("sound");
    let ray = Ray::new(Vec3A::ZERO, Vec3A::X, f32::INFINITY).expect("finite");
    assert_eq!(ray.obb_intersection_at(&obb), Some(0.0));
    let point = Obb::new(Vec3A::ZERO, Vec3A::ZERO, Quat::IDENTITY).expect("sound");
    assert_eq!(ray.obb_intersection_at(&point), Some(0.0));
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn no_box_is_larger_than_the_upright_one(points in points()) {
        let (obb, upright) = (enclosing(&points), Aabb3d::enclosing(points.iter().copied()).expect("finite"));
        prop_assert!(is_right_handed_and_orthonormal(obb.axes()));
        // As large as an oriented box must be that is upright: its centre is rounded.
        let magnitude = points.iter().map(|point| point.abs().max_element()).fold(0.0, f32::max);
        let rounding = upright.center().abs() * f32::EPSILON + Vec3A::splat(1e-44);
        let largest = upright.half_size().as_dvec3() * (1.0 + 1e-6) + rounding.as_dvec3();
        let half_size = obb.half_size().as_dvec3();
        // What is thinner than the rounding of the coordinates has no volume to compare, but an area.
        let noise = DVec3::splat((magnitude * f32::EPSILON * 4.0).into());
        prop_assert!(half_size.max(noise).element_product() <= largest.max(noise).element_product(), "{obb:?} {upright:?}");
    }

    #[test]
    fn the_box_around_the_corners_of_a_box_is_that_box(obb in obbs()) {
        has_size(&enclosing(&obb.corners()), obb.half_size(), obb.center().abs().max_element())?;
    }

    #[test]
    fn the_box_around_the_surface_of_a_box_is_that_box(obb in obbs(), steps in 1u8..5) {
        let steps = i8::try_from(steps).expect("small");
        let line = || (-steps..=steps).map(|step| f32::from(step) / f32::from(steps));
        let grid = line().flat_map(|x| line().flat_map(move |y| line().map(move |z| Vec3A::new(x, y, z))));
        let surface: Vec<_> = grid
            .filter(|point| point.abs().max_element() == 1.0)
            .map(|point| obb.center() + obb.axes() * (point * obb.half_size()))
            .collect();
        has_size(&enclosing(&surface), obb.half_size(), obb.center().abs().max_element())?;
    }

    #[test]
    fn merged_boxes_contain_the_corners_of_both(a in obbs(), b in obbs()) {
        let merged = a.merged(&b);
        prop_assert!(is_right_handed_and_orthonormal(merged.axes()));
        for (obb, corner) in [&a, &b].into_iter().flat_map(|obb| obb.corners().map(|corner| (obb, corner))) {
            if obb.contains_point(corner) {
                prop_assert!(merged.contains_point(corner));
            }
        }
    }

    #[test]
    fn the_image_under_what_keeps_right_angles_is_a_box_of_the_same_proportions(
        obb in obbs(),
        turn in rotation(),
        scale in [-3.0f32..3.0, -3.0f32..3.0, -3.0f32..3.0].prop_map(Vec3A::from_array),
        offset in point(),
    ) {
        // Along the axes of the box, then turned.
        let scaling = obb.axes() * Mat3A::from_diagonal(scale.into()) * obb.axes().transpose();
        let transform = Affine3A { matrix3: Mat3A::from_quat(turn) * scaling, translation: offset };
        let image = obb.transformed_by_affine(&transform);
        let magnitude = 10.0 * (obb.center().abs().element_sum() + obb.half_size().element_sum()) + offset.abs().max_element();
        has_size(&image, (obb.half_size() * scale).abs(), magnitude)?;
    }

    #[test]
    fn the_image_of_a_box_contains_the_images_of_the_points_in_it(
        obb in obbs(),
        transform in affine(),
        inside in [-1.0f32..=1.0, -1.0f32..=1.0, -1.0f32..=1.0].prop_map(Vec3A::from_array),
    ) {
        let image = obb.transformed_by_affine(&transform);
        prop_assert!(is_right_handed_and_orthonormal(image.axes()));
        let inside = obb.center() + obb.axes() * (inside * obb.half_size());
        for point in obb.corners().into_iter().chain([inside]).filter(|&point| obb.contains_point(point)) {
            prop_assert!(image.contains_point(transform.transform_point3a(point)));
            prop_assert!(obb.aabb().contains_point(point));
        }
    }

    #[test]
    fn the_upright_box_around_a_box_is_touched_by_its_corners(obb in obbs()) {
        let aabb = obb.aabb();
        let tight = Aabb3d::enclosing(obb.corners()).expect("finite");
        let slack = Vec3A::splat(1e-6 * (obb.center().abs().max_element() + obb.half_size().element_sum()));
        prop_assert!(aabb.min.cmpge(tight.min - slack).all() && aabb.max.cmple(tight.max + slack).all());
    }

    #[test]
    fn a_ray_is_reported_as_in_double_precision(
        (obb, ray) in obbs().prop_flat_map(|obb| (Just(obb), ray_towards(obb.center()))),
    ) {
        let axes = [obb.axes().x_axis, obb.axes().y_axis, obb.axes().z_axis].map(Vec3A::as_dvec3);
        // How far a point is outside, along the axis where it is most so.
        let outside = |t: f64| {
            let local = exactly_at(&ray, t) - obb.center().as_dvec3();
            (0..3).map(|axis| axes[axis].dot(local).abs() - f64::from(obb.half_size()[axis])).fold(f64::NEG_INFINITY, f64::max)
        };
        // It is convex along the ray: a ternary search finds the least.
        let reach = (ray.origin().as_dvec3().distance(obb.center().as_dvec3()) + obb.half_size().as_dvec3().length()) * 1.1;
        let t_min = f64::from(ray.t_min());
        let end = f64::from(ray.t_max()).min(reach / ray.direction().as_dvec3().length());
        let (mut low, mut high) = (t_min, end.max(t_min));
        for _ in 0..300 {
            let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if outside(a) <= outside(b) { high = b } else { low = a }
        }
        let entered = ray.obb_intersection_at(&obb);
        let slack = 1e-13 * reach;
        if ray.t_min() > ray.t_max() || outside(low) > slack {
            prop_assert_eq!(entered, None);
        } else if outside(low) <= 0.0 {
            let entered = f64::from(entered.expect("a hit"));
            prop_assert!(entered >= t_min);
            let (mut before, mut inside) = (t_min, low);
            if outside(before) <= 0.0 {
                inside = before;
            }
            for _ in 0..200 {
                let middle = (before + inside) / 2.0;
                if outside(middle) <= 0.0 { inside = middle } else { before = middle }
            }
            prop_assert!(entered <= inside, "{entered} {inside}");
            prop_assert!(outside(entered * (1.0 + 1e-6)).min(outside(inside)) <= slack);
        }
    }

    #[test]
    fn a_box_around_points_in_a_plane_is_flat(points in points(), normal in direction()) {
        let turn = Quat::from_rotation_arc(Vec3::Z, normal.into());
        let flat: Vec<_> = points.iter().map(|point| turn * point.with_z(0.0)).collect();
        // What the rotation rounded them out of the plane by, what counts as flat, and, up to as much again, what the
        // rounding of the axes to `f32` tilts the box by and pads it for.
        let across = turn.as_dquat().normalize() * DVec3::Z;
        let heights = || flat.iter().map(|point| point.as_dvec3().dot(across));
        let rounding = heights().fold(f64::NEG_INFINITY, f64::max) - heights().fold(f64::INFINITY, f64::min);
        let size = flat.iter().map(|point| point.abs().max_element()).fold(0.0, f32::max);
        let noise = f64::from(size * 16.0 * f32::EPSILON);
        let thickness = 2.0 * f64::from(enclosing(&flat).half_size().min_element());
        prop_assert!(thickness <= rounding + noise, "{thickness} {rounding} {noise}");
    }
}

/// The best of many random orientations, each improved by small random turns as long as that helps.
fn best_volume(points: &[DVec3], random: &mut impl rand::Rng) -> f64 {
    let volume = |axes: &DMat3| {
        let local: Vec<_> = points.iter().map(|&point| axes.transpose() * point).collect();
        let max = local.iter().fold(DVec3::NEG_INFINITY, |max, &point| max.max(point));
        let min = local.iter().fold(DVec3::INFINITY, |min, &point| min.min(point));
        (max - min).element_product()
    };
    let mut best = f64::INFINITY;
    for _ in 0..60 {
        let mut turn = |angle: f64| {
            let axis = DVec3::new(
                random.random_range(-1.0..1.0),
                random.random_range(-1.0..1.0),
                random.random_range(-1.0..1.0),
            );
            DMat3::from_axis_angle(axis.normalize_or(DVec3::X), angle)
        };
        let mut axes = turn(3.0) * turn(2.0);
        let (mut size, mut angle) = (volume(&axes), 0.5);
        while angle > 1e-3 {
            let next = turn(angle) * axes;
            let next_size = volume(&next);
            if next_size < size {
                (axes, size) = (next, next_size);
            } else {
                angle *= 0.93;
            }
        }
        best = best.min(size);
    }
    best
}

#[test]
fn boxes_around_random_points_are_within_a_few_percent_of_the_best_found() {
    use rand::{Rng, SeedableRng};
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(7);
    let mut ratios = Vec::new();
    for set in 0..24 {
        let count = [4, 8, 20, 60][set % 4];
        let stretch = Vec3A::new(1.0, random.random_range(0.2..1.0), random.random_range(0.05..1.0));
        let turn = Quat::from_euler(
            bevy::math::EulerRot::XYZ,
            random.random_range(-3.0..3.0),
            random.random_range(-1.5..1.5),
            random.random_range(-3.0..3.0),
        );
        let points: Vec<_> = (0..count)
            .map(|_| turn * (Vec3A::from_array(std::array::from_fn(|_| random.random_range(-1.0..1.0))) * stretch))
            .collect();
        let exact: Vec<_> = points.iter().map(|point| point.as_dvec3()).collect();
        ratios.push(f64::from(enclosing(&points).volume()) / best_volume(&exact, &mut random));
    }
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    let worst = ratios.iter().copied().fold(0.0, f64::max);
    assert!(mean < 1.02 && worst < 1.08, "mean {mean}, worst {worst}");
}

#[test]
fn a_skinny_flat_set_whose_ends_hide_its_middle_is_boxed_flat() {
    // Two of the four are extremal along every direction of the first sample: the box was tilted out of the plane.
    let turn = Quat::from_rotation_arc(Vec3::Z, Vec3::new(0.0, 0.9899942, 0.14110804));
    let corners = [
        [18.353363, -6.45145],
        [0.20436847, 2.8185759],
        [-25.318138, 9.636371],
        [-0.13624561, -1.8790506],
    ];
    let obb = enclosing(&corners.map(|[x, y]| turn * Vec3A::new(x, y, 0.0)));
    assert!(obb.half_size().min_element() < 2e-5, "{obb:?}");
}

#[test]
fn a_grown_box_contains_what_is_as_far_along_its_axes() {
    for step in 0..2000 {
        let rotation = Quat::from_euler(bevy::math::EulerRot::XYZ, 0.37 * step as f32, 0.11 * step as f32, 0.7);
        let obb = Obb::new(Vec3A::ZERO, Vec3A::ZERO, rotation).expect("a sound box");
        for axis in [obb.axes().x_axis, obb.axes().y_axis, obb.axes().z_axis] {
            let point = axis.as_dvec3().normalize().as_vec3a();
            if point.as_dvec3().length() <= 1.0 {
                assert!(obb.grown(1.0).contains_point(point), "{point:?}");
            }
        }
    }
}
