//! Batches of rays, of which some go through the hierarchy together: whatever they are, each gets the answer that it gets
//! alone.

use bevy::{
    asset::RenderAssetUsages,
    math::{
        Vec3, Vec3A,
        primitives::{Sphere, Torus},
    },
    mesh::{Indices, Mesh, MeshBuilder, Meshable, PrimitiveTopology},
};
use bevy_sightline::{
    geometry::ray::{Ray, triangle::Backfaces},
    mesh::{MeshBuildSettings, MeshBvh, TriangleHit, TriangleMesh},
};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use crate::common::{random_dir, random_point, rng};

const EITHER: [Backfaces; 2] = [Backfaces::Cull, Backfaces::Include];

fn list(positions: Vec<Vec3>) -> Mesh {
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
}

/// Both kinds of hierarchy.
fn hierarchies(mesh: &Mesh) -> [MeshBvh; 2] {
    let mesh = TriangleMesh::from_mesh(mesh).expect("a usable mesh");
    [false, true].map(|compact| {
        let settings = MeshBuildSettings {
            compact,
            ..MeshBuildSettings::default()
        };
        MeshBvh::build_with(&mesh, &settings, None).expect("nothing calls it off")
    })
}

/// Triangles of one size here and there.
fn soup(rng: &mut ChaCha8Rng, n: usize, extent: f32, size: f32) -> Vec<Vec3> {
    let triangle = |_| {
        let center = random_point(rng, extent);
        std::array::from_fn::<_, 3, _>(|_| center + random_point(rng, size))
    };
    (0..n).flat_map(triangle).collect()
}

/// Squares on a lattice in the plane y = 0, two triangles each.
fn lattice(n: u32) -> Mesh {
    let point =
        |i: u32| Vec3::new((i % (n + 1)) as f32, 0.0, (i / (n + 1)) as f32) - n as f32 / 2.0 * (Vec3::X + Vec3::Z);
    let positions: Vec<Vec3> = (0..(n + 1) * (n + 1)).map(point).collect();
    let squares = (0..n * n).map(|square| square / n * (n + 1) + square % n);
    let triangles = squares.flat_map(|a| [a, a + n + 1, a + 1, a + 1, a + n + 1, a + n + 2]);
    list(positions).with_inserted_indices(Indices::U32(triangles.collect()))
}

/// The rays of a picture of `size`×`size` pixels from `eye`, row by row.
fn camera(eye: Vec3, target: Vec3, degrees: f32, size: usize) -> Vec<Ray> {
    let ahead = (target - eye).normalize();
    let (right, up) = ahead.any_orthonormal_pair();
    let at = |k: usize| ((k as f32 + 0.5) / size as f32 - 0.5) * degrees.to_radians();
    let pixels = (0..size * size).map(|pixel| ahead + at(pixel % size) * right + at(pixel / size) * up);
    pixels
        .filter_map(|towards| Ray::new(eye, towards, f32::INFINITY))
        .collect()
}

type Bits = (u32, u32, [u32; 3]);

fn bits(hit: Option<TriangleHit>) -> Option<Bits> {
    hit.map(|hit| {
        (
            hit.t.to_bits(),
            hit.triangle,
            hit.barycentrics.to_array().map(f32::to_bits),
        )
    })
}

/// Asserts that the answers to a batch are those to its rays, and returns how many hit.
fn assert_answered_alike(bvh: &MeshBvh, rays: &[Ray]) -> usize {
    let (mut hits, mut any, mut count) = (Vec::new(), Vec::new(), 0);
    for backfaces in EITHER {
        bvh.closest_hits(rays, backfaces, None, &mut hits);
        bvh.any_hits(rays, backfaces, None, &mut any);
        assert_eq!((hits.len(), any.len()), (rays.len(), rays.len()));
        for (ray, (&hit, &any)) in rays.iter().zip(hits.iter().zip(&any)) {
            assert_eq!(bits(hit), bits(bvh.closest_hit(ray, backfaces)), "{ray:?}");
            assert_eq!(any, bvh.any_hit(ray, backfaces), "{ray:?}");
            count += usize::from(hit.is_some());
        }
    }
    count
}

#[test]
fn the_rays_of_a_picture_are_answered_as_one_by_one() {
    let rng = &mut rng(1);
    for mesh in [
        Sphere::new(1.0).mesh().ico(20).expect("not too fine"),
        Torus::new(0.4, 1.0).mesh().build(),
        list(soup(rng, 3_000, 1.0, 0.1)),
        list(soup(rng, 300, 1.0, 1.0)),
        list(soup(rng, 1, 1.0, 1.0)),
    ] {
        for bvh in hierarchies(&mesh) {
            for degrees in [0.5, 5.0, 30.0, 120.0] {
                let eye = *random_dir(rng) * 2.5;
                let rays = camera(eye, random_point(rng, 0.5), degrees, 33);
                assert_answered_alike(&bvh, &rays);
            }
        }
    }
}

#[test]
fn a_batch_may_have_any_number_of_rays() {
    let [bvh, _] = hierarchies(&Sphere::new(1.0).mesh().ico(10).expect("not too fine"));
    let rays = camera(Vec3::new(0.3, 0.2, 3.0), Vec3::ZERO, 20.0, 8);
    for count in 0..rays.len() {
        assert_answered_alike(&bvh, &rays[..count]);
    }
}

#[test]
fn rays_to_one_light_are_answered_as_one_by_one() {
    let rng = &mut rng(2);
    for bvh in hierarchies(&list(soup(rng, 2_000, 1.0, 0.1))) {
        let light = Vec3::new(2.0, 3.0, 1.5);
        let from = camera(Vec3::new(0.0, 4.0, 0.0), Vec3::ZERO, 30.0, 24);
        let shadows: Vec<Ray> = (from.iter())
            .filter_map(|ray| Ray::segment(Vec3::from(ray.at(4.0)), light))
            .collect();
        let blocked = assert_answered_alike(&bvh, &shadows);
        assert!(blocked > 100, "only {blocked}");
    }
}

#[test]
fn rays_that_have_nothing_in_common_are_answered_as_one_by_one() {
    let rng = &mut rng(3);
    for bvh in hierarchies(&list(soup(rng, 1_000, 1.0, 0.3))) {
        let ray = |rng: &mut ChaCha8Rng, octant: bool| {
            let direction = *random_dir(rng);
            let direction = if octant { direction.abs() } else { direction };
            Ray::new(random_point(rng, 1.5), direction, f32::INFINITY).expect("a direction")
        };
        for octant in [false, true] {
            let rays: Vec<Ray> = (0..1_000).map(|_| ray(rng, octant)).collect();
            assert_answered_alike(&bvh, &rays);
        }
    }
}

#[test]
fn rays_along_axes_through_edges_and_vertices_are_answered_as_one_by_one() {
    for bvh in hierarchies(&lattice(24)) {
        let down = |i: usize| {
            let at = Vec3::new((i % 52) as f32 / 2.0 - 12.5, 3.0, (i / 52) as f32 / 2.0 - 12.5);
            Ray::new(at, Vec3::NEG_Y, f32::INFINITY).expect("a direction")
        };
        let rays: Vec<Ray> = (0..52 * 51).map(down).collect();
        assert_answered_alike(&bvh, &rays);
        // In the very plane of all triangles and boxes.
        let along = |i: usize| {
            let at = Vec3::new(-20.0, 0.0, i as f32 / 4.0 - 13.0);
            Ray::new(at, Vec3::new(1.0, 0.0, (i % 3) as f32 * 0.1), f32::INFINITY).expect("a direction")
        };
        assert_answered_alike(&bvh, &(0..104).map(along).collect::<Vec<_>>());
    }
}

#[test]
fn no_ray_of_a_batch_slips_between_triangles() {
    let n = 24;
    for bvh in hierarchies(&lattice(n)) {
        let eye = Vec3::new(0.7, 9.0, -3.1);
        let corners = (1..n * 2).flat_map(|i| (1..n * 2).map(move |j| Vec3::new(i as f32, 0.0, j as f32) / 2.0));
        let towards = corners.map(|corner| corner - n as f32 / 2.0 * (Vec3::X + Vec3::Z) - eye);
        let rays: Vec<Ray> = towards.filter_map(|to| Ray::new(eye, to, f32::INFINITY)).collect();
        let mut hits = Vec::new();
        bvh.closest_hits(&rays, Backfaces::Include, None, &mut hits);
        assert!(hits.iter().all(Option::is_some));
        assert_answered_alike(&bvh, &rays);
    }
}

#[test]
fn of_triangles_in_one_place_a_batch_finds_the_first() {
    let rng = &mut rng(4);
    let positions = soup(rng, 60, 1.0, 0.6).repeat(7);
    for bvh in hierarchies(&list(positions)) {
        let rays = camera(Vec3::new(0.1, 0.2, 4.0), Vec3::ZERO, 30.0, 40);
        assert!(assert_answered_alike(&bvh, &rays) > 100);
        let mut hits = Vec::new();
        bvh.closest_hits(&rays, Backfaces::Include, None, &mut hits);
        assert!(hits.iter().flatten().all(|hit| hit.triangle < 60));
    }
}

#[test]
fn rays_with_ends_are_answered_as_one_by_one() {
    let rng = &mut rng(5);
    for bvh in hierarchies(&list(soup(rng, 1_000, 1.0, 0.2))) {
        let rays = camera(Vec3::new(0.4, 0.3, 3.0), Vec3::ZERO, 30.0, 32);
        let mut cut = |ray: &Ray| match rng.random_range(0..4) {
            0 => *ray,
            1 => ray.with_t_max(rng.random_range(0.0..4.0)),
            2 => ray.with_interval(rng.random_range(0.0..4.0), f32::INFINITY),
            _ => ray.with_interval(rng.random_range(0.0..4.0), rng.random_range(0.0..4.0)),
        };
        let rays: Vec<Ray> = rays.iter().map(&mut cut).collect();
        assert_answered_alike(&bvh, &rays);
        // Ends on a surface.
        let to_hit = |ray: &Ray| {
            bvh.closest_hit(ray, Backfaces::Include)
                .map(|hit| ray.with_t_max(hit.t))
        };
        let rays: Vec<Ray> = rays.iter().filter_map(to_hit).collect();
        assert_answered_alike(&bvh, &rays);
    }
}

#[test]
fn rays_at_meshes_of_any_size_and_at_any_distance_are_answered_as_one_by_one() {
    let rng = &mut rng(6);
    for scale in [1e-36, 1e-20, 1e-6, 1e6, 1e18, 1e30] {
        let positions: Vec<Vec3> = soup(rng, 400, 1.0, 0.2).into_iter().map(|at| at * scale).collect();
        for bvh in hierarchies(&list(positions)) {
            let of_unit = camera(Vec3::new(0.4, -0.3, 3.0), Vec3::ZERO, 30.0, 24);
            let scaled = |ray: &Ray| Ray::new(ray.origin() * scale, ray.direction(), f32::INFINITY);
            assert_answered_alike(&bvh, &of_unit.iter().filter_map(scaled).collect::<Vec<_>>());
        }
    }
}

#[test]
fn rays_from_so_far_that_triangles_are_lost_in_rounding_are_answered_as_one_by_one() {
    let rng = &mut rng(7);
    let mut count = 0;
    for (extent, size) in [(1.0, 0.1), (10.0, 1.0), (100.0, 1.0), (3.0, 1.0)] {
        for bvh in hierarchies(&list(soup(rng, 1_000, extent, size))) {
            for distance in [1e3, 1e5, 1e6, 1e7, 1e8] {
                // Nearly along an axis: there a ray enters a box late, and what it hits may come before.
                let back = Vec3::Z + random_point(rng, 1.0) * 10_f32.powi(rng.random_range(-4..=0));
                let eye = back.normalize() * distance * extent;
                let towards = (0..2_000).map(|_| random_point(rng, extent) - eye);
                let rays: Vec<Ray> = towards.filter_map(|to| Ray::new(eye, to, f32::INFINITY)).collect();
                count += assert_answered_alike(&bvh, &rays);
            }
        }
    }
    assert!(count > 10_000, "only {count}");
}

#[test]
fn rays_at_needles_and_degenerate_triangles_are_answered_as_one_by_one() {
    let rng = &mut rng(8);
    let needle = |rng: &mut ChaCha8Rng| {
        let (from, along) = (random_point(rng, 1.0), *random_dir(rng));
        let width = 10_f32.powi(rng.random_range(-7..0));
        let aside = match rng.random_range(0..3) {
            0 => Vec3::ZERO,
            _ => *random_dir(rng) * width,
        };
        [from, from + along, from + along * 0.5 + aside]
    };
    let mut positions: Vec<Vec3> = (0..800).flat_map(|_| needle(rng)).collect();
    positions.extend([Vec3::ONE; 3]);
    for bvh in hierarchies(&list(positions.clone())) {
        let rays = camera(Vec3::new(0.4, -0.3, 3.0), Vec3::ZERO, 40.0, 40);
        assert_answered_alike(&bvh, &rays);
        // At their corners, edge-on.
        let eye = Vec3A::new(2.0, 2.5, 3.0);
        let towards = positions.iter().map(|&corner| Vec3A::from(corner) - eye);
        let rays: Vec<Ray> = towards.filter_map(|to| Ray::new(eye, to, f32::INFINITY)).collect();
        assert_answered_alike(&bvh, &rays);
    }
}
