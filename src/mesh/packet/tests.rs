//! What a packet says of its lanes, against the test of one triangle.

use bevy::math::{Vec3, Vec3A, Vec3Swizzles as _};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{TrianglePacket, triangle_box};
use crate::{
    geometry::{
        aabb::{EMPTY, union},
        ray::{
            Ray,
            triangle::{Backfaces, TriangleRay},
        },
    },
    spatial::simd::{LANES, Portable, Simd, Task, dispatch},
};

const EITHER: [Backfaces; 2] = [Backfaces::Cull, Backfaces::Include];

#[derive(Clone, Copy)]
struct Candidates<'a>(&'a TrianglePacket, &'a TriangleRay, Backfaces);

impl Task for Candidates<'_> {
    type Output = u32;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> u32 {
        let Self(packet, ray, backfaces) = self;
        packet.candidates(simd, ray, backfaces) & 0xff
    }
}

#[derive(Clone, Copy)]
struct Bounds<'a>(&'a TrianglePacket);

impl Task for Bounds<'_> {
    type Output = [Vec3A; 2];

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> [Vec3A; 2] {
        let bounds = self.0.bounds(simd);
        [bounds.min, bounds.max]
    }
}

/// One to eight triangles, with corners on a coarse lattice half of the time: rays through their edges and vertices, and
/// degenerate ones, are common then.
fn random_triangles(rng: &mut ChaCha8Rng, scale: f32) -> Vec<[Vec3A; 3]> {
    let on_lattice = rng.random();
    let corner = |rng: &mut ChaCha8Rng| {
        let at = Vec3A::from_array(std::array::from_fn(|_| rng.random_range(-2.0_f32..=2.0)));
        (if on_lattice { at.round() } else { at }) * scale
    };
    let count = rng.random_range(1..=LANES);
    (0..count).map(|_| std::array::from_fn(|_| corner(rng))).collect()
}

fn random_ray(rng: &mut ChaCha8Rng, triangles: &[[Vec3A; 3]], scale: f32) -> Ray {
    let [a, b, c] = triangles[rng.random_range(0..triangles.len())];
    let target = [a, (a + b) / 2.0, (a + b + c) / 3.0, a + b - c][rng.random_range(0..4)];
    let origin = Vec3A::from_array(std::array::from_fn(|_| rng.random_range(-4.0_f32..=4.0).round())) * scale;
    // A length that no scale makes vanish.
    let direction = (target - origin) / scale;
    Ray::new(origin, direction, f32::INFINITY).unwrap_or_else(|| random_ray(rng, triangles, scale))
}

fn packet(triangles: &[[Vec3A; 3]]) -> TrianglePacket {
    TrianglePacket::new(triangles.iter().copied().zip(10..))
}

fn for_random_packets(mut check: impl FnMut(&[[Vec3A; 3]], &TrianglePacket, &Ray)) {
    let mut rng = ChaCha8Rng::seed_from_u64(70);
    for scale in [1.0, 1e-6, 1e6, 1e-20, 1e20, 1e-38] {
        for _ in 0..400 {
            let triangles = random_triangles(&mut rng, scale);
            let packet = packet(&triangles);
            for _ in 0..8 {
                check(&triangles, &packet, &random_ray(&mut rng, &triangles, scale));
            }
        }
    }
}

#[test]
fn a_packet_gives_back_its_triangles_and_numbers() {
    for_random_packets(|triangles, packet, _| {
        assert_eq!(packet.len(), triangles.len());
        for (lane, triangle) in triangles.iter().enumerate() {
            assert_eq!(packet.corners(lane), *triangle);
            assert_eq!(packet.number(lane), 10 + lane as u32);
        }
    });
}

#[test]
fn every_triangle_that_a_ray_hits_is_a_candidate_with_the_same_hit() {
    let (mut hits, mut candidates) = (0, 0);
    for_random_packets(|triangles, packet, ray| {
        let ray = TriangleRay::new(ray);
        for backfaces in EITHER {
            let lanes = dispatch(Candidates(packet, &ray, backfaces));
            candidates += (lanes & ((1 << triangles.len()) - 1)).count_ones();
            for (lane, &triangle) in triangles.iter().enumerate() {
                let expected = ray.triangle_intersection(triangle, f32::INFINITY, backfaces);
                assert_eq!(packet.intersection(lane, &ray, f32::INFINITY, backfaces), expected);
                assert!(expected.is_none() || lanes >> lane & 1 != 0, "{triangle:?} {ray:?}");
                hits += u32::from(expected.is_some());
            }
        }
    });
    assert!(hits > 10_000, "only {hits} hits");
    assert!(candidates < hits * 4, "{candidates} candidates for {hits} hits");
}

#[test]
fn the_candidates_are_the_same_with_and_without_vector_instructions() {
    for_random_packets(|_, packet, ray| {
        for backfaces in EITHER {
            let task = Candidates(packet, &TriangleRay::new(ray), backfaces);
            assert_eq!(dispatch(task), task.run(Portable));
        }
    });
}

#[test]
fn the_bounds_are_those_of_the_triangles_at_every_occupancy() {
    for_random_packets(|triangles, packet, _| {
        let expected = triangles
            .iter()
            .fold(EMPTY, |bounds, &triangle| union(&bounds, &triangle_box(triangle)));
        assert_eq!(dispatch(Bounds(packet)), [expected.min, expected.max]);
        assert_eq!(Bounds(packet).run(Portable), [expected.min, expected.max]);
    });
}

#[test]
fn a_packet_whose_corners_move_is_that_of_the_moved_triangles() {
    for_random_packets(|triangles, packet, _| {
        let moved: Vec<[Vec3A; 3]> = triangles
            .iter()
            .map(|corners| corners.map(|corner| corner.yzx() * 2.0))
            .collect();
        let mut packet = packet.clone();
        packet.move_corners(|number| moved[number as usize - 10].map(Vec3::from));
        let anew = super::tests::packet(&moved);
        assert_eq!(format!("{packet:?}"), format!("{anew:?}"));
    });
}
