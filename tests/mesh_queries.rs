//! What is asked of the triangles of a mesh besides the nearest hit: the hierarchy gives the very answers of a loop over
//! all triangles, and those are right.

use std::ops::ControlFlow;

use bevy::{
    asset::RenderAssetUsages,
    math::{
        Affine3A, Dir3, Quat, Vec3, Vec3A,
        bounding::{Aabb3d, BoundingSphere},
        primitives::{Sphere, Triangle3d, ViewFrustum},
    },
    mesh::{Mesh, Meshable, PrimitiveTopology},
    tasks::TaskPoolBuilder,
};
use bevy_sightline::{
    geometry::{
        closest_point::ClosestPoint,
        convex_hull::ConvexHull,
        intersection::Frustum,
        obb::Obb,
        ray::{
            Ray,
            triangle::{Backfaces, TriangleRay},
        },
        sweep::{SphereSweep, SweepIntersection},
        volume::Volume,
    },
    mesh::{MeshBvh, SphereContact, SurfacePoint, TriangleHit, TriangleMesh, TriangleRegion},
    spatial::Visit,
};
use proptest::prelude::*;
use rand::Rng;

use crate::{
    common::{random_dir, random_point, rng},
    properties::{cases, points, rotation},
};

fn list(positions: Vec<Vec3>) -> TriangleMesh {
    let mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
    let mesh = mesh.with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions);
    TriangleMesh::from_mesh(&mesh).expect("a usable mesh")
}

fn sphere() -> TriangleMesh {
    let mesh = Sphere::new(1.0).mesh().ico(12).expect("not too fine");
    TriangleMesh::from_mesh(&mesh).expect("a usable mesh")
}

/// One to a hundred triangles between points of any kind: many share vertices, coincide, or have no area.
fn meshes() -> impl Strategy<Value = TriangleMesh> {
    let corners = prop::collection::vec(any::<[u8; 3]>(), 1..100);
    (points(), corners).prop_map(|(points, corners)| {
        let corner = |index: u8| Vec3::from(points[usize::from(index) % points.len()]);
        list(corners.into_iter().flatten().map(corner).collect())
    })
}

fn in_box(mesh: &TriangleMesh, fraction: [f32; 3]) -> Vec3A {
    let Aabb3d { min, max } = mesh.aabb();
    min + (max - min) * Vec3A::from_array(fraction)
}

fn fractions(reach: f32) -> impl Strategy<Value = [f32; 3]> {
    let fraction = prop_oneof![
        3 => -reach..1.0 + reach,
        1 => prop::sample::select(vec![0.0_f32, 0.5, 1.0]),
    ];
    [fraction.clone(), fraction.clone(), fraction]
}

/// A mesh and a ray from around it to a place in its box, at times to an end or from a later start.
fn meshes_with_rays() -> impl Strategy<Value = (TriangleMesh, Ray)> {
    let t_max = prop_oneof![Just(f32::INFINITY), 0.0f32..2.0, Just(1.0f32)];
    let t_min = prop_oneof![3 => Just(0.0f32), 1 => 0.0f32..1.0];
    (meshes(), fractions(1.5), fractions(0.0), t_min, t_max).prop_filter_map(
        "two different points",
        |(mesh, from, to, t_min, t_max)| {
            let (origin, target) = (in_box(&mesh, from), in_box(&mesh, to));
            let ray = Ray::new(origin, target - origin, f32::INFINITY)?;
            Some((mesh, ray.with_interval(t_min, t_max)))
        },
    )
}

fn backfaces() -> impl Strategy<Value = Backfaces> {
    prop_oneof![Just(Backfaces::Cull), Just(Backfaces::Include)]
}

/// The triangles of a mesh that was copied whole, by number.
fn numbered(mesh: &TriangleMesh) -> impl Iterator<Item = (u32, [Vec3; 3])> {
    (0..).zip(mesh.corners_of_all())
}

/// Everything that a hit says of itself, bit for bit.
fn bits(hit: &TriangleHit) -> (u32, u32, [u32; 3]) {
    (
        hit.t.to_bits(),
        hit.triangle,
        hit.barycentrics.to_array().map(f32::to_bits),
    )
}

fn point_bits(point: Option<SurfacePoint>) -> Option<impl PartialEq + std::fmt::Debug> {
    point.map(|found| {
        (
            found.point.to_array(),
            found.distance,
            found.normal.to_array(),
            bits(&found.hit),
        )
    })
}

fn contact_bits(contact: Option<SphereContact>) -> Option<impl PartialEq + std::fmt::Debug> {
    contact.map(|found| (found.point.to_array(), found.normal.to_array(), bits(&found.hit)))
}

fn random_rays(seed: u64, n: usize) -> Vec<Ray> {
    let mut rng = rng(seed);
    let ray = |_| Ray::new(random_point(&mut rng, 2.0), *random_dir(&mut rng), f32::INFINITY).expect("a direction");
    (0..n).map(ray).collect()
}

// --- All hits ---

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn all_hits_are_those_of_every_triangle_in_order((mesh, ray) in meshes_with_rays(), backfaces in backfaces()) {
        let test = TriangleRay::new(&ray);
        let hit = |(number, corners): (u32, [Vec3; 3])| {
            let hit = test.triangle_intersection(corners.map(Vec3A::from), ray.t_max(), backfaces)?;
            Some((hit.t.to_bits(), number, hit.barycentrics.to_array().map(f32::to_bits)))
        };
        let mut expected: Vec<_> = numbered(&mesh).filter_map(hit).collect();
        expected.sort_by(|a, b| f32::from_bits(a.0).partial_cmp(&f32::from_bits(b.0)).expect("numbers").then(a.1.cmp(&b.1)));

        let bvh = MeshBvh::build(&mesh);
        let (mut of_mesh, mut of_bvh) = (Vec::new(), Vec::new());
        mesh.all_hits(&ray, backfaces, &mut of_mesh);
        bvh.all_hits(&ray, backfaces, &mut of_bvh);
        prop_assert_eq!(of_mesh.iter().map(bits).collect::<Vec<_>>(), expected.clone());
        prop_assert_eq!(of_bvh.iter().map(bits).collect::<Vec<_>>(), expected);
        prop_assert_eq!(
            bvh.closest_hit(&ray, backfaces).as_ref().map(bits),
            of_bvh.first().map(bits)
        );
    }

    #[test]
    fn a_visit_that_shortens_the_ray_sees_nothing_beyond((mesh, ray) in meshes_with_rays()) {
        let mut hits = Vec::new();
        let bvh = MeshBvh::build(&mesh);
        bvh.all_hits(&ray, Backfaces::Include, &mut hits);
        let nearest = hits.first().map(|hit| hit.t);
        let ties = hits.iter().filter(|hit| Some(hit.t) == nearest).count();

        let (mut limit, mut at_nearest) = (f32::INFINITY, 0);
        bvh.visit_hits(&ray, Backfaces::Include, |hit| {
            assert!(hit.t <= limit);
            limit = hit.t;
            at_nearest += usize::from(Some(hit.t) == nearest);
            Visit::Shorten(hit.t)
        });
        prop_assert_eq!(at_nearest, ties);
    }
}

#[test]
fn a_visit_of_hits_stops_when_told() {
    let mesh = sphere();
    let bvh = MeshBvh::build(&mesh);
    for ray in random_rays(1, 200) {
        let mut seen = 0;
        bvh.visit_hits(&ray, Backfaces::Include, |_| {
            seen += 1;
            Visit::Stop
        });
        assert_eq!(seen > 0, bvh.any_hit(&ray, Backfaces::Include));
        assert!(seen <= 1);
    }
}

#[test]
fn a_line_through_a_closed_surface_hits_it_an_even_number_of_times() {
    let bvh = MeshBvh::build(&sphere());
    let mut rng = rng(2);
    let (mut hits, mut pierced) = (Vec::new(), 0);
    for _ in 0..1_000 {
        let direction = *random_dir(&mut rng);
        let ray = Ray::new(random_point(&mut rng, 1.0) - direction * 5.0, direction, f32::INFINITY).expect("a ray");
        bvh.all_hits(&ray, Backfaces::Include, &mut hits);
        assert_eq!(hits.len() % 2, 0);
        pierced += usize::from(!hits.is_empty());
    }
    assert!(pierced > 500, "only {pierced}");
}

// --- Batches ---

#[test]
fn a_batch_has_the_answers_of_the_rays_one_by_one() {
    let bvh = MeshBvh::build(&sphere());
    let pool = TaskPoolBuilder::new().num_threads(3).build();
    let (mut hits, mut any) = (vec![None; 7], vec![true; 7]);
    for n in [0, 1, 511, 512, 5_003] {
        let rays = random_rays(n as u64, n);
        for pool in [None, Some(&pool)] {
            bvh.closest_hits(&rays, Backfaces::Cull, pool, &mut hits);
            bvh.any_hits(&rays, Backfaces::Cull, pool, &mut any);
            let expected: Vec<_> = rays.iter().map(|ray| bvh.closest_hit(ray, Backfaces::Cull)).collect();
            assert_eq!(any, expected.iter().map(Option::is_some).collect::<Vec<_>>());
            assert_eq!(hits, expected);
        }
    }
}

// --- The closest point ---

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn the_closest_point_is_that_of_every_triangle(
        mesh in meshes(),
        at in fractions(1.5),
        reach in prop_oneof![Just(f32::INFINITY), 0.0f32..2.0],
    ) {
        let bvh = MeshBvh::build(&mesh);
        let point = in_box(&mesh, at);
        let max_distance = reach * (mesh.aabb().max - mesh.aabb().min).length();
        let max_distance = if max_distance.is_nan() { f32::INFINITY } else { max_distance };
        let (of_mesh, of_bvh) = (mesh.closest_point(point, max_distance), bvh.closest_point(point, max_distance));
        prop_assert_eq!(point_bits(of_bvh), point_bits(of_mesh));

        let distance_to = |corners: [Vec3; 3]| Triangle3d::new(corners[0], corners[1], corners[2])
            .closest_point_f64(point.as_dvec3()).distance(point.as_dvec3());
        let expected = numbered(&mesh).map(|(_, corners)| distance_to(corners)).fold(f64::INFINITY, f64::min);
        let largest = point.abs().max(mesh.aabb().min.abs()).max(mesh.aabb().max.abs()).max_element();
        let rounding = f64::from(f32::EPSILON) * expected + 1e-14 * f64::from(largest);
        match of_bvh {
            Some(found) => {
                prop_assert!((f64::from(found.distance) - expected).abs() <= rounding, "{found:?} {expected}");
                prop_assert!(found.distance <= max_distance);
                let corners = bvh.mesh().triangle(&found.hit);
                prop_assert_eq!(mesh.corners_of_all().nth(found.hit.triangle as usize), Some(corners));
                let weights = found.hit.barycentrics;
                let by_weights = corners[0] * weights.x + corners[1] * weights.y + corners[2] * weights.z;
                prop_assert!((by_weights - found.point).length() <= 8.0 * f32::EPSILON * largest);
                prop_assert!(weights.min_element() >= 0.0);
            }
            None => prop_assert!(expected + rounding > f64::from(max_distance)),
        }
    }

    #[test]
    fn the_closest_point_is_found_within_its_own_distance_and_not_within_less(mesh in meshes(), at in fractions(1.5)) {
        let bvh = MeshBvh::build(&mesh);
        let point = in_box(&mesh, at);
        let found = bvh.closest_point(point, f32::INFINITY).expect("there are triangles");
        let again = bvh.closest_point(point, found.distance.next_up());
        prop_assert_eq!(point_bits(again), point_bits(Some(found)));
        if found.distance > 0.0 {
            prop_assert_eq!(bvh.closest_point(point, found.distance.next_down()), None);
        }
    }
}

#[test]
fn a_point_in_front_of_a_triangle_is_closest_to_its_inside_an_edge_or_a_vertex() {
    let bvh = MeshBvh::build(&list(vec![Vec3::ZERO, Vec3::X * 4.0, Vec3::Y * 4.0]));
    let closest = |x, y, z| bvh.closest_point(Vec3::new(x, y, z), 10.0).expect("not far");

    let inside = closest(1.0, 1.0, 3.0);
    assert_eq!(
        (inside.point, inside.distance, inside.normal),
        (Vec3::new(1.0, 1.0, 0.0), 3.0, Vec3::Z)
    );
    assert_eq!(inside.hit.barycentrics, Vec3::new(0.5, 0.25, 0.25));

    let edge = closest(1.0, -3.0, -4.0);
    assert_eq!((edge.point, edge.distance), (Vec3::X, 5.0));
    assert_eq!(edge.hit.barycentrics, Vec3::new(0.75, 0.25, 0.0));

    let vertex = closest(-1.0, -2.0, 2.0);
    assert_eq!((vertex.point, vertex.distance), (Vec3::ZERO, 3.0));
    assert_eq!(vertex.hit.barycentrics, Vec3::X);
}

#[test]
fn of_triangles_at_one_distance_the_first_is_closest() {
    let bvh = MeshBvh::build(&list([[Vec3::ZERO, Vec3::X, Vec3::Y]; 40].concat()));
    let found = bvh.closest_point(Vec3::new(0.3, 0.3, 2.0), f32::INFINITY);
    assert_eq!(found.map(|found| found.hit.triangle), Some(0));
}

#[test]
fn nothing_is_close_to_a_point_that_is_not_finite_nor_within_less_than_nothing() {
    let mesh = sphere();
    let bvh = MeshBvh::build(&mesh);
    for bad in [Vec3::NAN, Vec3::INFINITY, Vec3::new(0.0, f32::NEG_INFINITY, 0.0)] {
        assert_eq!(
            (
                bvh.closest_point(bad, f32::INFINITY),
                mesh.closest_point(bad, f32::INFINITY)
            ),
            (None, None)
        );
    }
    for bad in [-1.0, f32::NAN, f32::NEG_INFINITY] {
        assert_eq!(bvh.closest_point(Vec3::X, bad), None);
    }
    let vertex = mesh.corners_of_all().next().expect("a triangle")[0];
    assert_eq!(bvh.closest_point(vertex, 0.0).map(|found| found.point), Some(vertex));
}

#[test]
fn distances_whose_squares_overflow_or_underflow_single_precision_are_told_apart() {
    for size in [1e-30_f32, 1e-20, 1.0, 1e15, 1e25] {
        let mut rng = rng(3);
        let mesh = list((0..300).map(|_| random_point(&mut rng, 1.0) * size).collect());
        let bvh = MeshBvh::build(&mesh);
        for _ in 0..50 {
            let point = random_point(&mut rng, 3.0) * size;
            let (of_mesh, of_bvh) = (
                mesh.closest_point(point, f32::INFINITY),
                bvh.closest_point(point, f32::INFINITY),
            );
            assert_eq!(point_bits(of_bvh), point_bits(of_mesh), "{size}");
            assert!(of_mesh.is_some());
        }
    }
}

// --- What touches a region ---

/// Asserts that those triangles are found that touch by the plain test, each once.
fn assert_finds_what_touches(mesh: &TriangleMesh, region: &impl TriangleRegion) -> Result<usize, TestCaseError> {
    let touches = |&(_, [a, b, c]): &(u32, [Vec3; 3])| region.intersects(&Triangle3d::new(a, b, c));
    let expected: Vec<u32> = numbered(mesh).filter(touches).map(|(number, _)| number).collect();

    let mut of_mesh = Vec::new();
    mesh.visit_touching(region, |triangle| {
        of_mesh.push(triangle);
        ControlFlow::Continue(())
    });
    let bvh = MeshBvh::build(mesh);
    let mut of_bvh = vec![99];
    bvh.find_touching(region, &mut of_bvh);
    of_bvh.sort_unstable();
    prop_assert_eq!(&of_mesh, &expected);
    prop_assert_eq!(&of_bvh, &expected);
    prop_assert_eq!(bvh.touches(region), !expected.is_empty());
    Ok(expected.len())
}

fn half_sizes() -> impl Strategy<Value = [f32; 3]> {
    let half = prop_oneof![3 => 0.0f32..1.0, 1 => Just(0.0f32), 1 => Just(0.5f32)];
    [half.clone(), half.clone(), half]
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn the_triangles_that_touch_a_box_are_found(mesh in meshes(), at in fractions(0.3), half in half_sizes()) {
        let half = in_box(&mesh, half) - mesh.aabb().min;
        let center = in_box(&mesh, at);
        assert_finds_what_touches(&mesh, &Aabb3d { min: center - half, max: center + half })?;
    }

    #[test]
    fn the_triangles_that_touch_a_sphere_are_found(mesh in meshes(), at in fractions(0.5), radius in 0.0f32..1.0) {
        let size = (mesh.aabb().max - mesh.aabb().min).length();
        let center = in_box(&mesh, at);
        assert_finds_what_touches(&mesh, &BoundingSphere::new(center, radius * size))?;
        // Just so that a vertex is on it.
        let vertex = Vec3A::from(mesh.corners_of_all().next().expect("a triangle")[0]);
        assert_finds_what_touches(&mesh, &BoundingSphere::new(center, center.distance(vertex)))?;
    }

    #[test]
    fn the_triangles_that_touch_an_oriented_box_are_found(
        mesh in meshes(), at in fractions(0.3), half in half_sizes(), rotation in rotation(),
    ) {
        let half = in_box(&mesh, half) - mesh.aabb().min;
        let obb = Obb::new(in_box(&mesh, at), half, rotation).expect("finite");
        assert_finds_what_touches(&mesh, &obb)?;
    }

    #[test]
    fn the_triangles_that_touch_a_hull_are_found(
        mesh in meshes(), corners in prop::collection::vec(fractions(0.2), 1..12),
    ) {
        let hull = ConvexHull::enclosing(corners.into_iter().map(|corner| in_box(&mesh, corner)));
        assert_finds_what_touches(&mesh, &hull.expect("finite"))?;
    }

    #[test]
    fn the_triangles_that_touch_a_frustum_are_found(
        mesh in meshes(), from in fractions(1.0), rotation in rotation(), fov in 0.1f32..2.5, far in 0.5f32..3.0,
    ) {
        let size = (mesh.aabb().max - mesh.aabb().min).length().max(f32::MIN_POSITIVE);
        let frustum = frustum(in_box(&mesh, from), rotation, fov, size * 0.05, size * far);
        assert_finds_what_touches(&mesh, &frustum)?;
    }
}

fn frustum(eye: Vec3A, rotation: Quat, fov: f32, near: f32, far: f32) -> Frustum {
    let world_from_view = Affine3A::from_rotation_translation(rotation, eye.into());
    let clip_from_view = bevy::math::Mat4::perspective_infinite_reverse_rh(fov, 1.3, near);
    let clip_from_world = clip_from_view * bevy::math::Mat4::from(world_from_view.inverse());
    let backward = world_from_view.transform_vector3(Vec3::Z);
    let frustum = ViewFrustum::from_clip_from_world_custom_far(&clip_from_world, &eye.into(), &backward, far);
    Frustum::from(&frustum)
}

#[test]
fn regions_of_all_sizes_find_their_part_of_a_fine_mesh() {
    let mesh = sphere();
    let mut rng = rng(4);
    let mut found = [0; 5];
    for _ in 0..30 {
        let center = Vec3A::from(random_point(&mut rng, 1.0));
        let size = 10_f32.powf(rng.random_range(-2.0..0.5));
        let half = Vec3A::from_array(std::array::from_fn(|_| size * rng.random_range(0.3..1.0)));
        let rotation = Quat::from_rotation_arc(Vec3::Z, *random_dir(&mut rng));
        let corners = (0..20).map(|_| center + Vec3A::from(random_point(&mut rng, size)));
        let hull = ConvexHull::enclosing(corners.collect::<Vec<_>>()).expect("finite");
        let check = |region: Result<usize, TestCaseError>| region.expect("the same triangles");
        found[0] += check(assert_finds_what_touches(
            &mesh,
            &Aabb3d {
                min: center - half,
                max: center + half,
            },
        ));
        found[1] += check(assert_finds_what_touches(&mesh, &BoundingSphere::new(center, size)));
        found[2] += check(assert_finds_what_touches(
            &mesh,
            &Obb::new(center, half, rotation).expect("finite"),
        ));
        found[3] += check(assert_finds_what_touches(&mesh, &hull));
        found[4] += check(assert_finds_what_touches(
            &mesh,
            &frustum(center, rotation, 1.0, 0.01, 3.0),
        ));
    }
    assert!(found.iter().all(|&found| found > 1_000), "{found:?}");
}

#[test]
fn a_region_inside_of_a_closed_mesh_touches_nothing_and_one_around_it_touches_all() {
    let mesh = sphere();
    let bvh = MeshBvh::build(&mesh);
    assert!(!bvh.touches(&BoundingSphere::new(Vec3::ZERO, 0.9)));
    let mut found = Vec::new();
    bvh.find_touching(&BoundingSphere::new(Vec3::ZERO, 1.1), &mut found);
    found.sort_unstable();
    assert_eq!(found, (0..mesh.len() as u32).collect::<Vec<_>>());
}

// --- Moving spheres ---

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn a_moving_sphere_touches_the_triangle_that_it_reaches_first(
        (mesh, ray) in meshes_with_rays(),
        radius in prop_oneof![4 => 0.0f32..0.5, 1 => Just(0.0f32)],
    ) {
        let size = (mesh.aabb().max - mesh.aabb().min).length();
        let sweep = SphereSweep::new(ray, radius * size).expect("a radius");
        let bvh = MeshBvh::build(&mesh);
        let (of_mesh, of_bvh) = (mesh.sweep_sphere(&sweep), bvh.sweep_sphere(&sweep));
        prop_assert_eq!(contact_bits(of_bvh), contact_bits(of_mesh));

        let touched = |(number, [a, b, c]): (u32, [Vec3; 3])| Some((sweep.intersection_at(&Triangle3d::new(a, b, c))?, number));
        let expected = numbered(&mesh).filter_map(touched).min_by(|a, b| a.partial_cmp(b).expect("numbers"));
        match expected {
            Some((t, _)) if t == ray.t_min() => {
                let closest = bvh.closest_point(ray.at(t), f32::INFINITY).expect("there are triangles");
                let hit = of_bvh.expect("in touch").hit;
                prop_assert_eq!((hit.t, hit.triangle), (t, closest.hit.triangle));
            }
            _ => prop_assert_eq!(of_bvh.map(|contact| (contact.hit.t, contact.hit.triangle)), expected),
        }

        if let Some(SphereContact { point, normal, hit }) = of_bvh {
            let path = sweep.ray();
            let center = path.origin().as_dvec3() + path.direction().as_dvec3() * f64::from(hit.t);
            let apart = center.distance(point.as_dvec3());
            let largest = center.abs().max(point.as_dvec3().abs()).max(path.origin().as_dvec3().abs()).max_element();
            let rounding = 4.0 * f64::from(f32::EPSILON) * largest;
            if hit.t > path.t_min() {
                prop_assert!((apart - f64::from(sweep.radius())).abs() <= rounding, "{apart}");
            } else {
                prop_assert!(apart <= f64::from(sweep.radius()) + rounding, "{apart}");
            }
            let length = normal.length();
            prop_assert!((length - 1.0).abs() < 1e-5 || length == 0.0);
            if apart > 1e3 * rounding {
                let outward = (center - point.as_dvec3()) / apart;
                prop_assert!(outward.distance(normal.as_dvec3()) < 1e-2);
            }
        }
    }
}

/// A sphere of radius 1/2 that comes down at a triangle in the plane z = 0.
fn come_down(x: f32, y: f32) -> Option<SphereContact> {
    let bvh = MeshBvh::build(&list(vec![Vec3::ZERO, Vec3::X * 4.0, Vec3::Y * 4.0]));
    let ray = Ray::new(Vec3::new(x, y, 8.0), Vec3::NEG_Z * 2.0, f32::INFINITY).expect("a ray");
    bvh.sweep_sphere(&SphereSweep::new(ray, 0.5).expect("a radius"))
}

#[test]
fn a_moving_sphere_touches_faces_edges_and_vertices() {
    let face = come_down(1.0, 1.0).expect("over the face");
    assert_eq!((face.point, face.normal), (Vec3::new(1.0, 1.0, 0.0), Vec3::Z));
    assert_eq!((face.hit.t, face.hit.barycentrics), (3.75, Vec3::new(0.5, 0.25, 0.25)));

    // With 3, 4, 5 tenths for the sides of the triangle between the centre, the contact, and above the contact.
    let edge = come_down(1.0, -0.3).expect("beside an edge");
    assert!(
        (edge.hit.t - 3.8).abs() < 1e-6 && edge.point.distance(Vec3::X) < 1e-6,
        "{edge:?}"
    );
    assert!(edge.normal.distance(Vec3::new(0.0, -0.6, 0.8)) < 1e-6, "{edge:?}");
    assert_eq!(edge.hit.barycentrics.z, 0.0);

    let vertex = come_down(-0.18, -0.24).expect("beside a vertex");
    assert!(
        (vertex.hit.t - 3.8).abs() < 1e-6 && vertex.point == Vec3::ZERO,
        "{vertex:?}"
    );
    assert!(
        vertex.normal.distance(Vec3::new(-0.36, -0.48, 0.8)) < 1e-6,
        "{vertex:?}"
    );
    assert_eq!(vertex.hit.barycentrics, Vec3::X);

    assert_eq!(come_down(1.0, -0.51), None);
    assert_eq!(come_down(-0.4, -0.4), None);
}

#[test]
fn a_sphere_that_touches_at_its_start_does_so_at_the_first_parameter() {
    let bvh = MeshBvh::build(&sphere());
    let ray = Ray::new(Vec3::X * 1.2, Vec3::X, f32::INFINITY)
        .expect("a ray")
        .with_interval(0.1, 5.0);
    let contact = bvh
        .sweep_sphere(&SphereSweep::new(ray, 0.5).expect("a radius"))
        .expect("in touch");
    assert_eq!(contact.hit.t, 0.1);
    assert!(contact.normal.distance(Vec3::X) < 0.1);
}

#[test]
fn a_sphere_without_a_radius_touches_what_a_ray_hits_and_is_turned_back() {
    let bvh = MeshBvh::build(&sphere());
    let mut rng = rng(5);
    let mut touched = 0;
    for _ in 0..500 {
        let (from, through) = (random_point(&mut rng, 3.0), random_point(&mut rng, 1.0));
        let ray = Ray::new(from, through - from, f32::INFINITY).expect("two different points");
        let hit = bvh.closest_hit(&ray, Backfaces::Include);
        let contact = bvh.sweep_sphere(&SphereSweep::new(ray, 0.0).expect("a radius"));
        // The ray may pass beside an edge by rounding.
        let (Some(hit), Some(contact)) = (hit, contact) else {
            assert_eq!(hit.is_some(), contact.is_some(), "{ray:?}");
            continue;
        };
        touched += 1;
        assert!((hit.t - contact.hit.t).abs() < 1e-5, "{hit:?} {contact:?}");
        assert!(contact.normal.dot(ray.direction().into()) <= 0.0, "{contact:?}");
    }
    assert!(touched > 100, "only {touched}");
}

#[test]
fn a_moving_sphere_touches_triangles_without_area_as_segments_and_points() {
    let needle = [Vec3::NEG_X, Vec3::ZERO, Vec3::X];
    let speck = [Vec3::Y * 5.0; 3];
    let bvh = MeshBvh::build(&list([needle, speck].concat()));
    let drop = |x: f32, y: f32| {
        let ray = Ray::new(Vec3::new(x, y, 4.0), Vec3::NEG_Z, f32::INFINITY).expect("a ray");
        let contact = bvh.sweep_sphere(&SphereSweep::new(ray, 1.0).expect("a radius"))?;
        Some((contact.hit.t, contact.hit.triangle, contact.normal))
    };
    assert_eq!(drop(0.5, 0.0), Some((3.0, 0, Vec3::Z)));
    assert_eq!(drop(0.0, 5.0), Some((3.0, 1, Vec3::Z)));
    assert_eq!(drop(0.0, 2.5), None);
}

#[test]
fn a_sphere_rolls_against_a_fine_mesh_as_against_each_of_its_triangles() {
    let mesh = sphere();
    let bvh = MeshBvh::build(&mesh);
    let mut touched = 0;
    for ray in random_rays(6, 60) {
        let sweep = SphereSweep::new(ray, 0.1).expect("a radius");
        let (of_mesh, of_bvh) = (mesh.sweep_sphere(&sweep), bvh.sweep_sphere(&sweep));
        assert_eq!(contact_bits(of_bvh), contact_bits(of_mesh));
        touched += usize::from(of_bvh.is_some());
    }
    assert!(touched > 10, "only {touched}");
    let away = Ray::new(Vec3::X * 3.0, Dir3::X.as_vec3(), f32::INFINITY).expect("a ray");
    assert_eq!(bvh.sweep_sphere(&SphereSweep::new(away, 0.1).expect("a radius")), None);
}
