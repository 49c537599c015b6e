use std::collections::HashMap;

use bevy::math::{Affine3A, DVec3, Vec3, Vec3A};
use bevy_sightline::geometry::{
    convex_hull::{ConvexHull, HullRank},
    ray::Ray,
    volume::{UnboundablePoints, Volume},
};
use proptest::prelude::*;

use crate::properties;

fn hull(points: &[Vec3A]) -> ConvexHull {
    ConvexHull::enclosing(points.iter().copied()).unwrap()
}

fn cube_corners() -> Vec<Vec3A> {
    let side = |corner: usize, axis: usize| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
    (0..8)
        .map(|corner| Vec3A::new(side(corner, 0), side(corner, 1), side(corner, 2)))
        .collect()
}

/// Points all over a sphere, on a spiral (Vogel's).
fn spiral(count: usize) -> Vec<Vec3A> {
    (0..count)
        .map(|i| {
            let z = 1.0 - 2.0 * (i as f64 + 0.5) / count as f64;
            let angle = i as f64 * 2.399_963_229_728_653;
            let r = (1.0 - z * z).sqrt();
            DVec3::new(r * angle.cos(), r * angle.sin(), z).as_vec3a()
        })
        .collect()
}

/// A regular prism with `sides` sides, along z.
fn prism(sides: usize) -> Vec<Vec3A> {
    (0..sides)
        .flat_map(|i| {
            let angle = i as f32 * std::f32::consts::TAU / sides as f32;
            [-1.0, 1.0].map(|z| Vec3A::new(angle.cos(), angle.sin(), z))
        })
        .collect()
}

/// The sum of the largest coordinates: what rounding is relative to.
fn magnitude(points: &[Vec3A]) -> f64 {
    let largest = points
        .iter()
        .fold(Vec3A::ZERO, |largest, point| largest.max(point.abs()));
    largest.as_dvec3().element_sum()
}

/// Sets that are harder than scattered points: thin ones, round ones, needles, denormals, and duplicates.
fn ugly_points() -> impl Strategy<Value = Vec<Vec3A>> {
    let scaled = (
        prop::collection::vec(properties::point(), 1..40),
        properties::rotation(),
    );
    let squeezed = (
        scaled,
        prop_oneof![Just(1e-7f32), Just(1e-4), Just(1e-12)],
        any::<bool>(),
    )
        .prop_map(|((points, rotation), thickness, needle)| {
            let scale = if needle {
                Vec3A::new(1.0, thickness, thickness)
            } else {
                Vec3A::new(1.0, 1.0, thickness)
            };
            points
                .into_iter()
                .map(|point| rotation * (point * scale))
                .collect::<Vec<_>>()
        });
    let axis_aligned = (prop::collection::vec(properties::point(), 1..40), 0usize..3).prop_map(|(points, axis)| {
        let mut scale = Vec3A::ONE;
        scale[axis] = 1e-7;
        points.into_iter().map(|point| point * scale).collect()
    });
    let round = (
        prop::collection::vec(properties::direction(), 1..60),
        prop_oneof![Just(1e-20f32), Just(1e7), Just(1.0)],
    )
        .prop_map(|(points, radius)| points.into_iter().map(|point| point * radius).collect());
    let denormal = prop::collection::vec([-4i8..=4, -4i8..=4, -4i8..=4], 1..30).prop_map(|points| {
        points
            .into_iter()
            .map(|p| Vec3A::from_array(p.map(|c| f32::from(c) * f32::from_bits(1))))
            .collect()
    });
    let mixed = prop::collection::vec((properties::point(), -30i32..30), 1..30).prop_map(|points| {
        points
            .into_iter()
            .map(|(p, exponent)| p * 2f32.powi(exponent))
            .collect()
    });
    let doubled =
        properties::points().prop_map(|points| points.iter().chain(&points).map(|&p| -(-p - Vec3A::ZERO)).collect());
    prop_oneof![
        4 => properties::points(),
        2 => squeezed,
        1 => axis_aligned,
        2 => round,
        1 => denormal,
        1 => mixed,
        1 => doubled,
    ]
}

/// A point of what `points` span, in `f64`: their mean by weights.
fn mixture(points: &[Vec3A], weights: &[f64]) -> DVec3 {
    let weights = || weights.iter().cycle().take(points.len());
    let total: f64 = weights().sum();
    points
        .iter()
        .zip(weights())
        .map(|(point, weight)| point.as_dvec3() * *weight)
        .sum::<DVec3>()
        / total
}

/// The parameters at which a ray enters and leaves the planes of the hull, in `f64`, with each plane moved out.
fn clipped(hull: &ConvexHull, ray: &Ray, out: f64) -> Option<(f64, f64)> {
    let (origin, direction) = (ray.origin().as_dvec3(), ray.direction().as_dvec3());
    let (mut enter, mut leave) = (f64::from(ray.t_min()), f64::from(ray.t_max()));
    for plane in hull.planes() {
        let normal = plane.normal.as_dvec3();
        let height = f64::from(plane.offset) + out - normal.dot(origin);
        let speed = normal.dot(direction);
        if speed < 0.0 {
            enter = enter.max(height / speed);
        } else if speed > 0.0 {
            leave = leave.min(height / speed);
        } else if height < 0.0 {
            return None;
        }
    }
    (enter <= leave).then_some((enter, leave))
}

/// Whether the first of the two parameters is an `f32`.
fn in_range(&(enter, _): &(f64, f64)) -> bool {
    enter < f64::from(f32::MAX)
}

#[test]
fn a_cube_has_eight_vertices_twelve_edges_and_six_faces() {
    let cube = hull(&cube_corners());
    assert_eq!(cube.rank(), HullRank::Solid);
    assert_eq!(
        (cube.vertices().len(), cube.edges().len(), cube.faces().len()),
        (8, 12, 6)
    );
    assert_eq!(cube.planes().len(), 6);
    assert!(
        cube.planes()
            .iter()
            .all(|plane| plane.normal.abs().element_sum() == 1.0 && plane.offset <= 1.0f32.next_up())
    );
    assert_eq!((cube.volume(), cube.surface_area()), (8.0, 24.0));
}

#[test]
fn points_inside_of_faces_and_edges_are_no_vertices() {
    let lattice: Vec<Vec3A> = (0..125)
        .map(|i| Vec3A::new((i % 5) as f32, (i / 5 % 5) as f32, (i / 25) as f32))
        .collect();
    let cube = hull(&lattice);
    assert_eq!(
        (cube.vertices().len(), cube.edges().len(), cube.faces().len()),
        (8, 12, 6)
    );
}

#[test]
fn coplanar_points_have_a_polygon_with_two_faces() {
    let square = hull(&[
        Vec3A::ZERO,
        Vec3A::X,
        Vec3A::Y,
        Vec3A::new(1.0, 1.0, 0.0),
        Vec3A::new(0.5, 0.5, 0.0),
    ]);
    assert_eq!(square.rank(), HullRank::Polygon);
    assert_eq!(
        (square.vertices().len(), square.edges().len(), square.faces().len()),
        (4, 4, 2)
    );
    assert_eq!(square.planes().len(), 6);
    assert_eq!((square.volume(), square.surface_area()), (0.0, 2.0));
    assert!(square.contains_point(Vec3A::new(0.25, 0.75, 0.0)));
    assert!(!square.contains_point(Vec3A::new(0.25, 0.75, 1e-6)));
    assert!(!square.contains_point(Vec3A::new(1.000_001, 0.75, 0.0)));
}

#[test]
fn collinear_points_have_a_segment() {
    let segment = hull(&[Vec3A::ONE, Vec3A::ZERO, Vec3A::splat(3.0), Vec3A::splat(2.0)]);
    assert_eq!(segment.rank(), HullRank::Segment);
    assert_eq!(
        (segment.vertices().len(), segment.edges(), segment.faces().len()),
        (2, &[[0, 1]][..], 0)
    );
    assert_eq!((segment.volume(), segment.surface_area()), (0.0, 0.0));
    assert!(segment.contains_point(Vec3A::splat(0.1)));
    assert!(!segment.contains_point(Vec3A::splat(3.000_001)));
    assert!(!segment.contains_point(Vec3A::new(1.0, 1.0, 1.000_001)));
}

#[test]
fn coincident_points_have_a_point_whatever_the_signs_of_their_zeros() {
    let point = hull(&[Vec3A::new(0.0, -0.0, 1.0), Vec3A::new(-0.0, 0.0, 1.0)]);
    assert_eq!(point.rank(), HullRank::Point);
    assert_eq!(point.vertices(), [Vec3A::Z]);
    assert!(point.contains_point(Vec3A::Z));
    assert!(!point.contains_point(Vec3A::new(0.0, 0.0, 1.0f32.next_up())));
}

#[test]
fn a_nearly_flat_set_is_a_solid_of_its_thickness() {
    let mut points = cube_corners();
    for point in &mut points {
        point.z *= 1e-7;
    }
    let sheet = hull(&points);
    assert_eq!((sheet.rank(), sheet.faces().len()), (HullRank::Solid, 6));
    assert!((sheet.volume() - 8e-7).abs() < 1e-12);
}

#[test]
fn the_planes_of_a_needle_do_not_reach_far_beyond_its_point() {
    let needle = hull(&[
        Vec3A::new(1.0, 0.0, 0.0),
        Vec3A::new(-1.0, 1e-6, 0.0),
        Vec3A::new(-1.0, -1e-6, 1e-6),
        Vec3A::new(-1.0, -1e-6, -1e-6),
    ]);
    let past_its_point = Ray::new(Vec3A::new(1.00001, 0.0, -1.0), Vec3A::Z, f32::INFINITY).unwrap();
    assert_eq!(needle.ray_intersection_at(&past_its_point), None);
    let through_its_point = Ray::new(Vec3A::new(1.0, 0.0, -1.0), Vec3A::Z, f32::INFINITY).unwrap();
    assert!(needle.ray_intersection_at(&through_its_point).is_some());
}

#[test]
fn no_points_have_no_hull() {
    assert_eq!(ConvexHull::enclosing([]), Err(UnboundablePoints::Empty));
}

#[test]
fn the_first_point_that_is_not_finite_is_named() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let points = [Vec3A::ZERO, Vec3A::new(0.0, bad, 0.0), Vec3A::NAN];
        assert_eq!(
            ConvexHull::enclosing(points),
            Err(UnboundablePoints::NotFinite { index: 1 })
        );
        assert_eq!(
            ConvexHull::with_vertex_budget(points, 8),
            Err(UnboundablePoints::NotFinite { index: 1 })
        );
    }
}

#[test]
fn points_too_far_out_overflow() {
    assert_eq!(
        ConvexHull::enclosing([Vec3A::ZERO, Vec3A::MAX]),
        Err(UnboundablePoints::Overflow)
    );
}

#[test]
fn a_transform_that_overflows_contains_everything() {
    let everything = hull(&cube_corners()).transformed_by_affine(&Affine3A::from_scale(Vec3::splat(f32::MAX)));
    assert!(everything.contains_point(Vec3A::MAX));
    assert_eq!(everything.aabb().max, Vec3A::INFINITY);
    let ray = Ray::new(Vec3A::splat(1e30), Vec3A::X, f32::INFINITY).unwrap();
    assert_eq!(everything.ray_intersection_at(&ray), Some(0.0));
    let again = everything
        .transformed_by_affine(&Affine3A::from_scale(Vec3::ZERO))
        .merged(&everything);
    assert!(again.contains_point(Vec3A::MIN));
}

#[test]
fn a_mirrored_hull_keeps_its_faces_turned_outward() {
    let mirrored = hull(&cube_corners()).transformed_by_affine(&Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0)));
    assert_eq!((mirrored.volume(), mirrored.faces().len()), (8.0, 6));
    assert!(mirrored.planes().iter().all(|plane| plane.offset >= 1.0));
}

#[test]
fn a_flattened_hull_is_flat() {
    let solid = hull(&cube_corners());
    for (scale, rank) in [
        (Vec3::new(1.0, 1.0, 0.0), HullRank::Polygon),
        (Vec3::new(0.0, 1.0, 0.0), HullRank::Segment),
        (Vec3::ZERO, HullRank::Point),
    ] {
        assert_eq!(solid.transformed_by_affine(&Affine3A::from_scale(scale)).rank(), rank);
    }
}

#[test]
fn a_rotated_cylinder_has_no_more_planes() {
    let cylinder = hull(&prism(64));
    let rotation = Affine3A::from_rotation_translation(
        bevy::math::Quat::from_euler(bevy::math::EulerRot::XYZ, 0.3, 1.1, -2.0),
        Vec3::new(3.0, -2.0, 5.0),
    );
    let rotated = cylinder.transformed_by_affine(&rotation);
    assert_eq!(cylinder.planes().len(), 66);
    assert_eq!(rotated.planes().len(), 66);

    assert_eq!(rotated.vertices().len(), 128);
}

#[test]
fn all_points_of_a_sphere_are_vertices() {
    let points = spiral(2000);
    let sphere = hull(&points);
    assert_eq!(sphere.vertices().len(), 2000);
    assert_eq!(sphere.faces().len(), 2 * 2000 - 4);
    assert!((sphere.volume() - 4.0 / 3.0 * std::f32::consts::PI).abs() < 0.02);
}

#[test]
fn rays_of_any_length_meet_the_cube_where_they_should() {
    let cube = hull(&cube_corners());
    for length in [1e-37, 1e-30, 1e-3, 1.0, 1e3, 1e30] {
        let ray = Ray::new(Vec3A::new(-3.0, 0.5, 0.5), Vec3A::X * length, f32::INFINITY).unwrap();
        let t = cube
            .ray_intersection_at(&ray)
            .map(|t| f64::from(t) * f64::from(ray.direction().x));
        assert!(t.is_some_and(|t| (t - 2.0).abs() < 1e-5), "{length}: {t:?}");
    }
}

#[test]
fn a_ray_in_the_plane_of_a_face_touches_it() {
    let cube = hull(&cube_corners());
    for z in [-1.0, 1.0] {
        let along_face = Ray::new(Vec3A::new(-3.0, 0.0, z), Vec3A::X, f32::INFINITY).unwrap();
        let along_edge = Ray::new(Vec3A::new(-3.0, 1.0, z), Vec3A::X, f32::INFINITY).unwrap();
        let beside = Ray::new(Vec3A::new(-3.0, 0.0, z * 1.0001), Vec3A::X, f32::INFINITY).unwrap();
        assert!(cube.ray_intersection_at(&along_face).is_some_and(|t| t <= 2.0));
        assert!(cube.ray_intersection_at(&along_edge).is_some_and(|t| t <= 2.0));
        assert_eq!(cube.ray_intersection_at(&beside), None);
    }
}

#[test]
fn only_the_interval_of_the_ray_counts() {
    let cube = hull(&cube_corners());
    let ray = Ray::new(Vec3A::new(-3.0, 0.0, 0.0), Vec3A::X, f32::INFINITY).unwrap();
    assert_eq!(cube.ray_intersection_at(&ray.with_interval(0.0, 1.9)), None);
    assert_eq!(cube.ray_intersection_at(&ray.with_interval(4.1, 9.0)), None);
    assert_eq!(cube.ray_intersection_at(&ray.with_interval(3.0, 9.0)), Some(3.0));
    assert_eq!(cube.ray_intersection_at(&ray.with_interval(3.5, 3.0)), None);
}

#[test]
fn a_budget_that_suffices_changes_nothing() {
    assert_eq!(
        ConvexHull::with_vertex_budget(cube_corners(), 8).unwrap(),
        hull(&cube_corners())
    );
}

#[test]
fn a_sphere_of_32_vertices_is_much_smaller_than_its_box() {
    let points = spiral(1000);
    let simple = ConvexHull::with_vertex_budget(points.iter().copied(), 32).unwrap();
    assert!(simple.vertices().len() <= 32);
    assert!(simple.volume() < 5.5, "{}", simple.volume());
}

#[test]
fn a_tiny_polygon_far_out_has_a_hull_within_the_budget() {
    let points = [
        Vec3A::new(-3.09275e-19, 5.839661e-19, 85571.25),
        Vec3A::new(5.037996e-19, 0.0, 85571.25),
        Vec3A::new(-4.5458517e-19, 0.0, 85571.25),
        Vec3A::new(0.0, 8.5707135e-19, 85571.25),
        Vec3A::new(0.0, -7.6679167e-19, 85571.25),
    ];
    let simple = ConvexHull::with_vertex_budget(points, 0).unwrap();
    assert!(simple.vertices().len() <= 4);
    assert!(points.iter().all(|&point| simple.contains_point(point)));
}

#[test]
fn a_ray_enters_a_denormal_hull_no_later_than_it_should() {
    let unit = f32::from_bits(1);
    let hull = hull(&[
        Vec3A::new(-4.0 * unit, 0.0, unit),
        Vec3A::new(0.0, 3.0 * unit, 0.0),
        Vec3A::ZERO,
    ]);
    let size = magnitude(hull.vertices()) as f32;
    let ray = Ray::new(
        Vec3A::new(0.0, 0.0, 53.93495) * size * 0.02,
        Vec3A::NEG_Z * f32::MIN_POSITIVE,
        f32::INFINITY,
    )
    .unwrap();
    let (enter, _) = clipped(&hull, &ray, 0.0).unwrap();
    assert!(hull.ray_intersection_at(&ray).is_some_and(|t| f64::from(t) <= enter));
}

proptest! {
    #![proptest_config(properties::cases())]

    #[test]
    fn a_hull_contains_its_points(points in ugly_points()) {
        let hull = hull(&points);
        for &point in &points {
            prop_assert!(hull.contains_point(point), "{point}");
            for plane in hull.planes() {
                prop_assert!(plane.normal.as_dvec3().dot(point.as_dvec3()) <= f64::from(plane.offset));
            }
        }
    }

    #[test]
    fn a_hull_contains_what_its_points_span(points in ugly_points(), weights in prop::collection::vec(0.0f64..1.0, 3..40)) {
        let hull = hull(&points);
        let mixture = mixture(&points, &weights).as_vec3a();
        // The mixture rounds to `f32`, where it may lie outside.
        let slack = 1e-6 * magnitude(&points) + 1e-44;
        for plane in hull.planes() {
            prop_assert!(plane.normal.as_dvec3().dot(mixture.as_dvec3()) <= f64::from(plane.offset) + slack);
        }
    }

    #[test]
    fn planes_are_unit_and_touch_the_hull_up_to_rounding(points in ugly_points()) {
        let hull = hull(&points);
        let slack = 3e-7 * magnitude(&points) + 1e-44;
        for plane in hull.planes() {
            let normal = plane.normal.as_dvec3();
            prop_assert!((normal.length() - 1.0).abs() < 1e-6);
            let support = hull.vertices().iter().map(|v| normal.dot(v.as_dvec3())).fold(f64::MIN, f64::max);
            prop_assert!(f64::from(plane.offset) - support <= slack, "{plane:?} {support}");
        }
    }

    #[test]
    fn the_vertices_of_a_face_lie_in_its_plane(points in ugly_points()) {
        let hull = hull(&points);
        let slack = 1e-6 * magnitude(&points) + 1e-44;
        for face in hull.faces() {
            for &vertex in face.vertices {
                let vertex = hull.vertices()[vertex as usize].as_dvec3();
                let depth = f64::from(face.plane.offset) - face.plane.normal.as_dvec3().dot(vertex);
                prop_assert!((0.0..=slack).contains(&depth), "{depth} {slack}");
            }
        }
    }

    #[test]
    fn faces_close_the_hull(points in ugly_points()) {
        let hull = hull(&points);
        let mut directed = HashMap::new();
        for face in hull.faces() {
            let next = face.vertices.iter().cycle().skip(1);
            for edge in face.vertices.iter().zip(next) {
                *directed.entry((*edge.0, *edge.1)).or_insert(0) += 1;
            }
        }
        for (&(a, b), &count) in &directed {
            prop_assert_eq!(count, 1);
            prop_assert!(directed.contains_key(&(b, a)));
        }
        match hull.rank() {
            HullRank::Point => prop_assert_eq!(hull.edges().len(), 0),
            HullRank::Segment => prop_assert_eq!(hull.edges(), [[0, 1]]),
            _ => {
                prop_assert_eq!(hull.edges().len() * 2, directed.len());
                prop_assert!(hull.edges().iter().all(|&[a, b]| directed.contains_key(&(a, b))));
                prop_assert_eq!(hull.vertices().len() + hull.faces().len(), hull.edges().len() + 2);
            }
        }
    }

    #[test]
    fn vertices_are_points_and_all_are_needed(points in ugly_points()) {
        let whole = hull(&points);
        prop_assert!(whole.vertices().iter().all(|vertex| points.contains(vertex)));
        let again = hull(whole.vertices());
        prop_assert_eq!((again.vertices(), again.rank()), (whole.vertices(), whole.rank()));
        for left_out in 0..whole.vertices().len() {
            let mut rest = whole.vertices().to_vec();
            rest.remove(left_out);
            prop_assert!(rest.is_empty() || hull(&rest) != whole);
        }
    }

    #[test]
    fn the_order_of_points_does_not_matter(points in ugly_points(), turn in 0usize..40) {
        let mut turned = points.clone();
        turned.rotate_left(turn % points.len());
        turned.reverse();
        let (one, other) = (hull(&points), hull(&turned));
        prop_assert_eq!(one.rank(), other.rank());
        prop_assert_eq!(one.faces().len(), other.faces().len());
        prop_assert_eq!(one.vertices().len(), other.vertices().len());
        prop_assert!(one.vertices().iter().all(|vertex| other.vertices().contains(vertex)));
    }

    #[test]
    fn the_box_is_that_of_the_points(points in ugly_points()) {
        let aabb = hull(&points).aabb();
        prop_assert_eq!(aabb.min, points.iter().copied().reduce(Vec3A::min).unwrap());
        prop_assert_eq!(aabb.max, points.iter().copied().reduce(Vec3A::max).unwrap());
    }

    #[test]
    fn the_volume_is_the_sum_of_tetrahedra_and_the_area_that_of_triangles(points in ugly_points()) {
        let hull = hull(&points);
        let corner = |i: u32| hull.vertices()[i as usize].as_dvec3();
        let center = hull.vertices().iter().map(|v| v.as_dvec3()).sum::<DVec3>() / hull.vertices().len() as f64;
        let (mut volume, mut area) = (0.0, 0.0);
        for face in hull.faces() {
            let middle = face.vertices.iter().map(|&v| corner(v)).sum::<DVec3>() / face.vertices.len() as f64;
            for (&a, &b) in face.vertices.iter().zip(face.vertices.iter().cycle().skip(1)) {
                let normal = (corner(a) - middle).cross(corner(b) - middle);
                area += 0.5 * normal.length();
                volume += normal.dot(middle - center) / 6.0;
            }
        }
        let size = magnitude(&points);
        prop_assert!((f64::from(hull.volume()) - volume).abs() <= 1e-6 * volume.abs() + 1e-14 * size.powi(3) + 1e-44);
        prop_assert!((f64::from(hull.surface_area()) - area).abs() <= 1e-6 * area + 1e-14 * size.powi(2) + 1e-44);
    }

    #[test]
    fn images_of_contained_points_are_contained(
        points in ugly_points(),
        transform in properties::affine(),
        weights in prop::collection::vec(0.0f64..1.0, 3..40),
    ) {
        let source = hull(&points);
        let image = source.transformed_by_affine(&transform);
        let again = image.transformed_by_affine(&transform);
        let probes = points.iter().copied().chain([mixture(&points, &weights).as_vec3a()]);
        for point in probes.filter(|&point| source.contains_point(point)) {
            let once = transform.transform_point3a(point);
            prop_assert!(image.contains_point(once), "{once}");
            prop_assert!(again.contains_point(transform.transform_point3a(once)));
        }
    }

    #[test]
    fn images_of_points_that_only_rounding_contains_are_contained(
        points in ugly_points(),
        (first, second) in (properties::affine(), properties::affine()),
        direction in properties::direction(),
    ) {
        let source = hull(&points).transformed_by_affine(&first);
        let image = source.transformed_by_affine(&second);
        for &vertex in source.vertices() {
            let beyond = vertex + direction * source.margin() * 0.999;
            if source.contains_point(beyond) {
                prop_assert!(image.contains_point(second.transform_point3a(beyond)));
            }
        }
    }

    #[test]
    fn a_transform_leaves_a_small_margin(points in properties::points(), transform in properties::affine()) {
        let image = hull(&points).transformed_by_affine(&transform);
        let added_up = transform.matrix3.x_axis.abs() + transform.matrix3.y_axis.abs() + transform.matrix3.z_axis.abs();
        let size = added_up.as_dvec3().length() * magnitude(&points) + transform.translation.as_dvec3().length();
        prop_assert!(f64::from(image.margin()) <= 1e-6 * size + 1e-43);
    }

    #[test]
    fn a_merged_hull_contains_both(
        a in ugly_points(),
        b in ugly_points(),
        transform in properties::affine(),
        weights in prop::collection::vec(0.0f64..1.0, 3..40),
    ) {
        let (one, other) = (hull(&a), hull(&b).transformed_by_affine(&transform));
        let merged = one.merged(&other);
        let probes = a.iter().copied().chain([mixture(&a, &weights).as_vec3a()]);
        for point in probes.filter(|&point| one.contains_point(point)) {
            prop_assert!(merged.contains_point(point));
        }
        for &point in &b {
            prop_assert!(merged.contains_point(transform.transform_point3a(point)));
        }
    }

    #[test]
    fn merging_does_not_add_up_rounding(a in ugly_points(), b in ugly_points()) {
        let (one, other) = (hull(&a), hull(&b));
        let merged = (0..20).fold(one.merged(&other), |merged, _| merged.merged(&other).merged(&one));
        let size = magnitude(&a).max(magnitude(&b));
        prop_assert!(f64::from(merged.margin()) <= 1e-11 * size + 1e-44);
    }

    #[test]
    fn points_clearly_outside_are_not_contained(points in ugly_points(), direction in properties::direction()) {
        let hull = hull(&points);
        let direction = direction.as_dvec3();
        let support = points.iter().map(|p| direction.dot(p.as_dvec3())).fold(f64::MIN, f64::max);
        for point in &points {
            let height = support - direction.dot(point.as_dvec3());
            let beyond = (point.as_dvec3() + direction * (height + 1e-6 * magnitude(&points) + 1e-43)).as_vec3a();
            prop_assert!(!hull.contains_point(beyond));
        }
    }

    #[test]
    fn a_budget_is_kept_and_contains_all_points(points in ugly_points(), budget in 0usize..24) {
        let simple = ConvexHull::with_vertex_budget(points.iter().copied(), budget).unwrap();
        prop_assert!(simple.vertices().len() <= budget.max(4));
        for &point in &points {
            prop_assert!(simple.contains_point(point));
        }
    }

    #[test]
    fn eight_vertices_are_no_worse_than_the_box(points in ugly_points(), budget in 8usize..24) {
        let simple = ConvexHull::with_vertex_budget(points.iter().copied(), budget).unwrap();
        let size = (hull(&points).aabb().max - hull(&points).aabb().min).as_dvec3();
        let rounding = 1e-6 * magnitude(&points) * size.max_element().powi(2);
        prop_assert!(f64::from(simple.volume()) <= size.x * size.y * size.z * 1.000_001 + rounding + 1e-44);
    }

    #[test]
    fn rays_to_points_of_the_hull_hit_no_later(
        points in ugly_points(),
        weights in prop::collection::vec(0.0f64..1.0, 3..40),
        direction in properties::direction(),
        away in prop_oneof![Just(0.0f32), Just(1.0), Just(1e3), Just(1e-3)],
        length in prop_oneof![Just(1e-30f32), Just(1e-3), Just(1.0), Just(1e20)],
    ) {
        let hull = hull(&points);
        // Rays along an axis from where the rounding is exact, and rays in between.
        for target in hull.vertices().iter().copied().chain([mixture(&points, &weights).as_vec3a()]) {
            let size = magnitude(&points) as f32;
            let Some(ray) = Ray::new(target - direction * away * size, direction * length, f32::INFINITY) else { continue };
            let (origin, along) = (ray.origin().as_dvec3(), ray.direction().as_dvec3());
            if let Some((enter, _)) = clipped(&hull, &ray, 0.0).filter(in_range) {
                let t = hull.ray_intersection_at(&ray);
                prop_assert!(t.is_some_and(|t| f64::from(t) <= enter), "{t:?} {enter}");
            }
            // The exact ray, where it meets the exact target.
            let t = (target.as_dvec3() - origin).dot(along) / along.length_squared();
            if origin + along * t == target.as_dvec3() && t >= 0.0 && in_range(&(t, t)) && hull.contains_point(target) {
                prop_assert!(hull.ray_intersection_at(&ray).is_some_and(|hit| f64::from(hit) <= t));
            }
        }
    }

    #[test]
    fn rays_hit_what_an_exact_ray_comes_near(
        points in ugly_points(),
        origin in properties::point(),
        direction in properties::direction(),
        t_max in prop_oneof![Just(f32::INFINITY), Just(1.0f32)],
    ) {
        let hull = hull(&points);
        let size = magnitude(&points);
        let ray = Ray::new(origin * size as f32 * 0.02, direction * size as f32, t_max);
        if let Some(ray) = ray {
            let exact = clipped(&hull, &ray, 0.0);
            let hit = hull.ray_intersection_at(&ray);
            if let Some((enter, _)) = exact.filter(in_range) {
                prop_assert!(hit.is_some_and(|t| f64::from(t) <= enter), "{hit:?} {enter}");
            }
            if let Some(t) = hit {
                let at = ray.origin().as_dvec3().abs().element_sum() + f64::from(t) * ray.direction().as_dvec3().length();
                let widened = clipped(&hull, &ray.with_t_max(f32::INFINITY), 2e-6 * (at + size) + 1e-43);
                prop_assert!(widened.is_some_and(|(enter, _)| enter <= f64::from(t) * 1.000_001), "{t} {widened:?}");
            }
        }
    }

    #[test]
    fn a_ray_that_starts_inside_enters_at_its_start(points in ugly_points(), direction in properties::direction(), t_min in 0.0f32..2.0) {
        let hull = hull(&points);
        for &vertex in hull.vertices() {
            let ray = Ray::new(vertex, direction, f32::INFINITY).unwrap();
            prop_assert_eq!(hull.ray_intersection_at(&ray), Some(0.0));
            let later = ray.with_interval(t_min, f32::INFINITY);
            if clipped(&hull, &later, 0.0).is_some_and(|(enter, _)| enter == f64::from(t_min)) {
                prop_assert_eq!(hull.ray_intersection_at(&later), Some(t_min));
            }
        }
    }
}

#[test]
fn a_needle_whose_coordinates_are_far_apart_contains_its_corners() {
    // The normals of two of its faces are lost in double precision.
    let corners = [
        Vec3A::new(91113.16, -1.0, -2.0),
        Vec3A::new(91114.16, -2.0, -2.0),
        Vec3A::new(0.0, -2e24, 1e24),
        Vec3A::new(1e24, -1e24, 0.0),
    ];
    let hull = ConvexHull::enclosing(corners).expect("bounded");
    for corner in corners {
        assert!(hull.contains_point(corner), "{corner:?}");
    }
}

#[test]
fn the_corners_of_a_flat_hull_are_extreme() {
    let points = (0..25).map(|i| Vec3A::new((i % 5) as f32, (i / 5) as f32, 1.0));
    let hull = ConvexHull::enclosing(points).expect("bounded");
    assert_eq!((hull.rank(), hull.vertices().len()), (HullRank::Polygon, 4));
}

proptest! {
    #![proptest_config(properties::cases())]

    #[test]
    fn the_planes_contain_the_margin(points in properties::points(), amount in 0.0f32..100.0) {
        let hull = ConvexHull::enclosing(points).expect("bounded").grown(amount);
        for plane in hull.planes() {
            let normal = plane.normal.as_dvec3();
            for vertex in hull.vertices() {
                let farthest = normal.dot(vertex.as_dvec3()) + normal.length() * f64::from(amount);
                prop_assert!(farthest <= f64::from(plane.offset), "{:?} {:?}", plane, vertex);
            }
        }
    }
}
