//! Single tests between a ray or a triangle and one shape, against parry3d, in the local space of the shape.
//!
//! A ray cast gives the parameter and the normal on both sides, from outside, where half of the rays miss. Ours rejects
//! by its own means; nothing is prepared in advance. The convex hull is a bounding volume here and a solid there, so that
//! only the parameter is asked for.

use bevy::math::{DVec3, Vec3, Vec3A, primitives::*};
use bevy_sightline::geometry::{
    convex_hull::ConvexHull,
    ray::{Ray, triangle::Backfaces},
    surface::Surface,
    triangle_triangle,
    volume::Volume,
};
use parry3d::{
    math::{Pose, Vector},
    query::{self, RayCast},
    shape,
};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{
    Effort,
    compare::{compare, time},
    mesh_mesh,
};

const PEER: &str = "parry3d 0.31.1";
/// Tests in a turn.
const TURN: usize = 1000;
/// The largest relative difference of two parameters that are one answer. Parry computes in single precision.
const SAME: f32 = 1e-3;

pub(crate) fn run(effort: Effort) {
    let rounds = match effort {
        Effort::Quick => 50,
        Effort::Full => 500,
    };
    surface("ray-ball", rounds, &Sphere::new(1.0), &shape::Ball::new(1.0));
    let half_size = Vec3::new(0.9, 0.6, 0.7);
    let cuboid = shape::Cuboid::new(to_parry(half_size));
    surface("ray-cuboid", rounds, &Cuboid::from_size(half_size * 2.0), &cuboid);
    surface(
        "ray-cylinder",
        rounds,
        &Cylinder::new(0.7, 1.6),
        &shape::Cylinder::new(0.8, 0.7),
    );
    surface(
        "ray-capsule",
        rounds,
        &Capsule3d::new(0.5, 1.2),
        &shape::Capsule::new_y(0.6, 0.5),
    );
    surface("ray-cone", rounds, &Cone::new(0.9, 1.8), &shape::Cone::new(0.9, 0.9));
    let corners = [
        Vec3::new(-1.0, -0.8, 0.1),
        Vec3::new(1.1, -0.5, -0.2),
        Vec3::new(0.1, 1.0, 0.3),
    ];
    let [a, b, c] = corners.map(to_parry);
    let triangle = Triangle3d::new(corners[0], corners[1], corners[2]);
    surface("ray-triangle", rounds, &triangle, &shape::Triangle::new(a, b, c));
    for corners in [8, 32, 128] {
        hull(corners, rounds);
    }
    triangle_pairs("triangle-triangle", rounds, 1.3);
    triangle_pairs("triangle-triangle-apart", rounds, 6.0);
    mesh_mesh::run(effort);
}

fn to_parry(v: Vec3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

fn vector(rng: &mut ChaCha8Rng) -> Vec3 {
    loop {
        let v = Vec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
        if (0.01..1.0).contains(&v.length_squared()) {
            return v;
        }
    }
}

/// Rays from around a shape of about unit size, most of them towards it.
fn rays() -> Vec<(Ray, query::Ray)> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut ray = || {
        let origin = vector(&mut rng).normalize() * 4.0;
        let direction = (vector(&mut rng) * 1.3 - origin).normalize();
        let ours = Ray::new(origin, direction, f32::INFINITY).expect("a sound ray");
        (ours, query::Ray::new(to_parry(origin), to_parry(direction)))
    };
    (0..16 * TURN).map(|_| ray()).collect()
}

/// How many answers differ.
fn differences(ours: &[Option<f32>], peers: &[Option<f32>]) -> (usize, usize) {
    let same = |pair: (&Option<f32>, &Option<f32>)| match pair {
        (Some(a), Some(b)) => (a - b).abs() <= SAME * a.abs().max(b.abs()),
        (a, b) => a.is_none() && b.is_none(),
    };
    (ours.iter().zip(peers).filter(|pair| !same(*pair)).count(), ours.len())
}

/// Asks both sides about a turn of rays.
fn ray_case(case: &str, rounds: usize, ours: impl Fn(&Ray) -> Option<f32>, peer: impl Fn(&query::Ray) -> Option<f32>) {
    let turn = |rays: &[(Ray, query::Ray)], round: usize| round * TURN % rays.len()..round * TURN % rays.len() + TURN;
    compare(
        &format!("geometry/{case}"),
        PEER,
        rounds,
        &mut rays(),
        |rays, round| {
            let rays = &rays[turn(rays, round)];
            time(|| rays.iter().map(|(ray, _)| ours(ray)).collect::<Vec<_>>())
        },
        |rays, round| {
            let rays = &rays[turn(rays, round)];
            time(|| rays.iter().map(|(_, ray)| peer(ray)).collect::<Vec<_>>())
        },
        |ours, peers| differences(ours, peers),
    );
}

fn surface(case: &str, rounds: usize, ours: &impl Surface, peer: &impl RayCast) {
    // A triangle has two sides there.
    let hit = |ray: &Ray| std::hint::black_box(ours).closest_hit(ray, Backfaces::Include);
    let peer_hit = |ray: &query::Ray| std::hint::black_box(peer).cast_local_ray_and_get_normal(ray, f32::MAX, false);
    ray_case(
        case,
        rounds,
        |ray| hit(ray).map(|hit| std::hint::black_box(hit).t),
        |ray| peer_hit(ray).map(|hit| std::hint::black_box(hit).time_of_impact),
    );
}

fn hull(corners: u16, rounds: usize) {
    // A spiral over a sphere (Vogel 1979).
    let points: Vec<Vec3> = (0..corners)
        .map(|i| {
            let z = 1.0 - (2.0 * f32::from(i) + 1.0) / f32::from(corners);
            let angle = f32::from(i) * 2.399_963_2;
            let radius = (1.0 - z * z).sqrt();
            Vec3::new(radius * angle.cos(), radius * angle.sin(), z)
        })
        .collect();
    let ours = ConvexHull::enclosing(points.iter().copied().map(Vec3A::from)).expect("finite points");
    let points: Vec<Vector> = points.into_iter().map(to_parry).collect();
    let peer = shape::ConvexPolyhedron::from_convex_hull(&points).expect("a solid hull");
    ray_case(
        &format!("ray-hull-{corners}"),
        rounds,
        |ray| std::hint::black_box(&ours).ray_intersection_at(ray),
        |ray| std::hint::black_box(&peer).cast_local_ray(ray, f32::MAX, true),
    );
}

/// Pairs of random triangles of unit size whose middles are up to `spread` apart.
fn triangle_pairs(case: &str, rounds: usize, spread: f32) {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let mut pairs: Vec<[[Vec3; 3]; 2]> = (0..16 * TURN)
        .map(|_| {
            let offset = vector(&mut rng) * spread;
            let mut triangle = |middle: Vec3| [(); 3].map(|()| middle + vector(&mut rng));
            [triangle(Vec3::ZERO), triangle(offset)]
        })
        .collect();
    let turn = |round: usize| round * TURN % (16 * TURN)..round * TURN % (16 * TURN) + TURN;
    compare(
        &format!("geometry/{case}"),
        PEER,
        rounds,
        &mut pairs,
        |pairs, round| {
            let pairs = &pairs[turn(round)];
            time(|| {
                let touch = |[a, b]: &[[Vec3; 3]; 2]| {
                    let exact = |triangle: &[Vec3; 3]| triangle.map(|corner| -> DVec3 { corner.as_dvec3() });
                    triangle_triangle::intersect_by_intervals(exact(a), exact(b))
                };
                pairs.iter().map(touch).collect::<Vec<bool>>()
            })
        },
        |pairs, round| {
            let pairs = &pairs[turn(round)];
            time(|| {
                let touch = |pair: &[[Vec3; 3]; 2]| {
                    let [a, b] = pair.map(|triangle| {
                        let [a, b, c] = triangle.map(to_parry);
                        shape::Triangle::new(a, b, c)
                    });
                    query::intersection_test(&Pose::IDENTITY, &a, &Pose::IDENTITY, &b).expect("triangles are supported")
                };
                pairs
                    .iter()
                    .map(touch)
                    .map(|found| found.intersecting)
                    .collect::<Vec<bool>>()
            })
        },
        |ours, peers| (ours.iter().zip(peers).filter(|(a, b)| a != b).count(), ours.len()),
    );
}
