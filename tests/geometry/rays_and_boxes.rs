//! Boxes, rays and triangles.

use bevy::math::{
    Affine3A, DAffine3, DVec3, Mat3A, Vec3, Vec3A,
    bounding::{Aabb3d, BoundingVolume},
};
use bevy_sightline::geometry::{
    aabb::Aabb3dExt,
    ray::{
        Ray,
        triangle::{Backfaces, TriangleRay},
    },
    volume::Volume,
};
use rand::Rng;

use crate::common::{random_dir, random_point, random_rotation, rng};

fn unit_box() -> Aabb3d {
    Aabb3d::new(Vec3A::ZERO, Vec3A::ONE)
}

fn ray(origin: [f32; 3], direction: [f32; 3]) -> Ray {
    Ray::new(Vec3A::from(origin), Vec3A::from(direction), f32::INFINITY).expect("a sound ray")
}

/// Rotation, scale of any sign, and shear.
fn random_affine(rng: &mut rand_chacha::ChaCha8Rng, size: f32) -> Affine3A {
    let mut columns = || Vec3A::from(random_point(rng, size));
    let matrix = Mat3A::from_cols(columns(), columns(), columns());
    let translation = columns() * 10.0;
    Affine3A {
        matrix3: matrix,
        translation,
    }
}

#[test]
fn a_transformed_box_contains_the_image_of_every_corner_and_inner_point() {
    let mut rng = rng(1);
    for size in [1e-20, 1e-3, 1.0, 1e7] {
        for _ in 0..1000 {
            let affine = random_affine(&mut rng, size);
            let aabb = Aabb3d::new(random_point(&mut rng, 100.0), random_point(&mut rng, 5.0).abs());
            let image = aabb.transformed_by_affine(&affine);
            for _ in 0..16 {
                let weights: [f32; 3] =
                    std::array::from_fn(|_| [0.0, 1.0, rng.random_range(0.0..1.0)][rng.random_range(0..3)]);
                let point = (aabb.min + (aabb.max - aabb.min) * Vec3A::from(weights)).clamp(aabb.min, aabb.max);
                let exact = affine.as_daffine3().transform_point3(Vec3::from(point).as_dvec3());
                let (min, max) = (Vec3::from(image.min).as_dvec3(), Vec3::from(image.max).as_dvec3());
                assert!(
                    min.cmple(exact).all() && exact.cmple(max).all(),
                    "{exact} is not in {image:?}"
                );
            }
        }
    }
}

#[test]
fn a_transformed_box_is_tight() {
    let mut rng = rng(2);
    for _ in 0..1000 {
        let affine = random_affine(&mut rng, 1.0);
        let image = unit_box().transformed_by_affine(&affine);
        let corners = (0..8).map(|i| Vec3A::new((i & 1) as f32, ((i >> 1) & 1) as f32, (i >> 2) as f32) * 2.0 - 1.0);
        let tight = Aabb3d::enclosing(corners.map(|corner| affine.transform_point3a(corner))).expect("eight corners");
        assert!(
            (image.half_size() - tight.half_size()).abs().max_element()
                < 1e-4 * (1.0 + tight.half_size().max_element())
        );
    }
}

#[test]
fn boxes_with_nan_infinity_or_inverted_bounds_are_not_sound() {
    let sound = unit_box();
    assert!(sound.is_sound());
    assert!(
        Aabb3d {
            min: Vec3A::ONE,
            max: Vec3A::ONE
        }
        .is_sound(),
        "a point is a box"
    );
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 2.0] {
        assert!(
            !Aabb3d {
                min: Vec3A::new(0.0, bad, 0.0),
                ..sound
            }
            .is_sound(),
            "{bad}"
        );
    }
}

#[test]
fn a_ray_needs_finite_numbers_and_a_direction() {
    assert_eq!(Ray::new(Vec3A::ZERO, Vec3A::ZERO, 1.0), None);
    assert_eq!(Ray::new(Vec3A::NAN, Vec3A::X, 1.0), None);
    assert_eq!(Ray::new(Vec3A::ZERO, Vec3A::splat(f32::INFINITY), 1.0), None);
    assert_eq!(Ray::new(Vec3A::ZERO, Vec3A::X, -1.0), None);
    assert_eq!(Ray::new(Vec3A::ZERO, Vec3A::X, f32::NAN), None);
    assert!(Ray::new(Vec3A::ZERO, Vec3A::X, 0.0).is_some());
}

#[test]
fn a_ray_that_starts_inside_a_box_enters_at_zero() {
    assert_eq!(
        ray([0.5, 0.0, 0.0], [1.0, 2.0, 3.0]).aabb_intersection_at(&unit_box()),
        Some(0.0)
    );
}

#[test]
fn a_ray_enters_a_box_where_it_meets_the_nearest_face() {
    let t = ray([-3.0, 0.5, 0.5], [0.5, 0.0, 0.0])
        .aabb_intersection_at(&unit_box())
        .expect("a hit");
    assert!((t - 4.0).abs() < 1e-5 && t <= 4.0);
}

#[test]
fn a_ray_misses_a_box_behind_it() {
    assert_eq!(
        ray([2.0, 0.0, 0.0], [1.0, 0.0, 0.0]).aabb_intersection_at(&unit_box()),
        None
    );
}

#[test]
fn a_ray_does_not_reach_a_box_beyond_its_end() {
    let ray = ray([-3.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
    assert_eq!(ray.with_t_max(1.9).aabb_intersection_at(&unit_box()), None);
    assert!(ray.with_t_max(2.0).aabb_intersection_at(&unit_box()).is_some());
}

#[test]
fn axis_parallel_rays_hit_and_miss_boxes_on_all_sides() {
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let mut direction = [0.0; 3];
            direction[axis] = sign;
            for (offset, hits) in [(0.0, true), (1.0, true), (-1.0, true), (1.001, false), (-1.001, false)] {
                let mut origin = [offset; 3];
                origin[axis] = -5.0 * sign;
                let ray = ray(origin, direction);
                assert_eq!(ray.aabb_intersection_at(&unit_box()).is_some(), hits, "{ray:?}");
            }
        }
    }
}

#[test]
fn rays_in_the_plane_of_a_flat_box_hit_it() {
    let floor = Aabb3d {
        min: Vec3A::new(-1.0, 0.0, -1.0),
        max: Vec3A::new(1.0, 0.0, 1.0),
    };
    assert!(
        ray([-5.0, 0.0, 0.0], [1.0, 0.0, 0.0])
            .aabb_intersection_at(&floor)
            .is_some()
    );
    assert!(
        ray([0.0, 3.0, 0.0], [0.0, -1.0, 0.0])
            .aabb_intersection_at(&floor)
            .is_some()
    );
}

#[test]
fn the_slab_test_misses_no_box_that_holds_a_point_of_the_ray() {
    let mut rng = rng(3);
    for _ in 0..100_000 {
        let scale = 10.0_f32.powi(rng.random_range(-6..7));
        let origin = Vec3A::from(random_point(&mut rng, 10.0 * scale));
        let direction = *random_dir(&mut rng) * rng.random_range(0.001..1000.0);
        let ray = Ray::new(origin, direction, f32::INFINITY).expect("a sound ray");
        let t = rng.random_range(0.0..20.0) * scale / direction.length();
        // A point box on the ray: exact in double precision, then grown by the rounding of the point itself.
        let exact = Vec3::from(origin).as_dvec3() + direction.as_dvec3() * f64::from(t);
        let point = exact.as_vec3();
        let ulp = (point.abs().max(Vec3::from(origin).abs()) * f32::EPSILON).max(Vec3::splat(f32::MIN_POSITIVE));
        let aabb = Aabb3d::from_min_max(point - ulp, point + ulp);
        assert!(ray.aabb_intersection_at(&aabb).is_some(), "{ray:?} misses {aabb:?}");
    }
}

const TRIANGLE: [Vec3A; 3] = [
    Vec3A::new(0.0, 0.0, 0.0),
    Vec3A::new(1.0, 0.0, 0.0),
    Vec3A::new(0.0, 1.0, 0.0),
];

#[test]
fn a_triangle_is_hit_from_the_front_and_culled_from_behind() {
    let front = TriangleRay::new(&ray([0.25, 0.5, 3.0], [0.0, 0.0, -1.0]));
    let behind = TriangleRay::new(&ray([0.25, 0.5, -3.0], [0.0, 0.0, 1.0]));
    for (name, ray, culled) in [("front", front, true), ("behind", behind, false)] {
        let hit = ray
            .triangle_intersection(TRIANGLE, f32::INFINITY, Backfaces::Include)
            .expect(name);
        assert_eq!(hit.t, 3.0, "{name}");
        assert_eq!(hit.barycentrics, Vec3::new(0.25, 0.25, 0.5), "{name}");
        let with_culling = ray.triangle_intersection(TRIANGLE, f32::INFINITY, Backfaces::Cull);
        assert_eq!(with_culling.is_some(), culled, "{name}");
    }
}

#[test]
fn the_direction_in_which_a_ray_runs_does_not_change_what_is_the_front() {
    let mut rng = rng(4);
    for _ in 0..10_000 {
        let rotation = random_rotation(&mut rng);
        let corners = TRIANGLE.map(|corner| rotation * corner);
        let target = rotation * Vec3::new(0.25, 0.25, 0.0);
        let side = rng.random_range(0.1..5.0) * if rng.random() { 1.0 } else { -1.0 };
        let origin = rotation * Vec3::new(rng.random_range(-3.0..3.0), rng.random_range(-3.0..3.0), side);
        let ray = TriangleRay::new(&Ray::segment(origin, target + (target - origin)).expect("two points"));
        let culled = ray.triangle_intersection(corners, 1.0, Backfaces::Cull);
        assert_eq!(culled.is_some(), side > 0.0);
        let hit = ray
            .triangle_intersection(corners, 1.0, Backfaces::Include)
            .expect("aimed at the inside");
        assert!((hit.t - 0.5).abs() < 1e-3);
    }
}

#[test]
fn a_triangle_outside_the_interval_of_the_ray_is_missed() {
    let ahead = ray([0.25, 0.25, 3.0], [0.0, 0.0, -1.0]);
    let past = ray([0.25, 0.25, -3.0], [0.0, 0.0, -1.0]);
    assert!(
        TriangleRay::new(&ahead)
            .triangle_intersection(TRIANGLE, 3.0, Backfaces::Include)
            .is_some()
    );
    assert_eq!(
        TriangleRay::new(&ahead).triangle_intersection(TRIANGLE, 2.9, Backfaces::Include),
        None
    );
    assert_eq!(
        TriangleRay::new(&past).triangle_intersection(TRIANGLE, 100.0, Backfaces::Include),
        None
    );
}

#[test]
fn degenerate_and_edge_on_triangles_are_missed() {
    let down = TriangleRay::new(&ray([0.0, 0.0, 3.0], [0.0, 0.0, -1.0]));
    for corners in [
        [Vec3A::ZERO; 3],
        [Vec3A::ZERO, Vec3A::X, Vec3A::X * 2.0],
        [Vec3A::ZERO, Vec3A::Z, Vec3A::X],
    ] {
        assert_eq!(
            down.triangle_intersection(corners, f32::INFINITY, Backfaces::Include),
            None,
            "{corners:?}"
        );
    }
}

#[test]
fn the_size_of_a_triangle_does_not_matter() {
    for exponent in [-18, -12, -6, 0, 6, 12] {
        let scale = 10.0_f32.powi(exponent);
        let ray = TriangleRay::new(&ray([0.25 * scale, 0.25 * scale, scale], [0.0, 0.0, -1.0]));
        let corners = TRIANGLE.map(|corner| corner * scale);
        let hit = ray
            .triangle_intersection(corners, f32::INFINITY, Backfaces::Cull)
            .expect("a hit at any scale");
        assert!((hit.t / scale - 1.0).abs() < 1e-6);
        assert!(hit.barycentrics.abs_diff_eq(Vec3::new(0.5, 0.25, 0.25), 1e-6));
    }
}

/// An octahedron: closed, and every vertex and edge shared by triangles that face different ways.
fn octahedron(center: Vec3A, transform: Mat3A) -> Vec<[Vec3A; 3]> {
    let signs = [-1.0, 1.0];
    let place = |v: Vec3A| transform * v + center;
    let mut triangles = Vec::new();
    for x in signs {
        for y in signs {
            for z in signs {
                let (a, b, c) = (place(Vec3A::X * x), place(Vec3A::Y * y), place(Vec3A::Z * z));
                triangles.push(if x * y * z > 0.0 { [a, b, c] } else { [b, a, c] });
            }
        }
    }
    triangles
}

#[test]
fn no_ray_slips_through_an_edge_or_vertex_of_a_closed_mesh() {
    let mut rng = rng(5);
    let mut hit_nothing = 0;
    for i in 0..100_000 {
        let scale = 10.0_f32.powi(rng.random_range(-6..7));
        let rotation = Mat3A::from_quat(random_rotation(&mut rng));
        let stretch = Vec3::new(
            rng.random_range(0.2..3.0),
            rng.random_range(0.2..3.0),
            rng.random_range(-3.0..-0.2),
        );
        let center = Vec3A::from(random_point(&mut rng, 10.0 * scale));
        let triangles = octahedron(center, rotation * Mat3A::from_diagonal(stretch) * scale);
        // From inside, every ray must hit something: aim at vertices and at points on edges.
        let [a, b, _] = triangles[i % 8];
        let along = [0.0, 1.0, 0.5, rng.random_range(0.0..1.0)][i % 4];
        let target = a + (b - a) * along;
        let ray = TriangleRay::new(&Ray::new(center, target - center, f32::INFINITY).expect("not the center"));
        let hits = triangles
            .iter()
            .filter_map(|t| ray.triangle_intersection(*t, f32::INFINITY, Backfaces::Include));
        hit_nothing += usize::from(hits.count() == 0);
    }
    assert_eq!(hit_nothing, 0);
}

#[test]
fn a_ray_keeps_its_parameter_under_every_transform() {
    let mut rng = rng(6);
    for _ in 0..1000 {
        let affine = Affine3A::from_scale_rotation_translation(
            Vec3::new(
                rng.random_range(0.1..3.0),
                rng.random_range(-3.0..-0.1),
                rng.random_range(0.1..3.0),
            ),
            random_rotation(&mut rng),
            random_point(&mut rng, 10.0),
        );
        let ray = Ray::new(random_point(&mut rng, 10.0), *random_dir(&mut rng), 5.0).expect("a sound ray");
        let moved = ray.transformed_by(&affine.as_daffine3()).expect("a sound ray");
        assert!(moved.at(2.0).abs_diff_eq(affine.transform_point3a(ray.at(2.0)), 1e-4));
        assert_eq!(moved.t_max(), 5.0);
    }
}

#[test]
fn a_transform_that_flattens_the_direction_leaves_no_ray() {
    let flat = DAffine3::from_scale(DVec3::new(0.0, 1.0, 1.0));
    assert_eq!(ray([1.0; 3], [1.0, 0.0, 0.0]).transformed_by(&flat), None);
    assert!(ray([1.0; 3], [1.0, 1.0, 0.0]).transformed_by(&flat).is_some());
}
