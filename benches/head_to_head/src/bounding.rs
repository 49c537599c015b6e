//! What a bounding volume before the triangles of a mesh saves or costs, against the triangle hierarchy alone, whose
//! root is an axis-aligned box: rays that enter that box, as those from an entity tree do.

use std::hint::black_box;

use bevy::{math::Vec3A, prelude::*};
use bevy_sightline::{
    geometry::{
        ray::{Ray, triangle::Backfaces},
        volume::BoundingKind,
    },
    mesh::{MeshBvh, TriangleMesh},
};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{
    Effort,
    compare::{compare, time},
};

const PEER: &str = "the hierarchy alone";
/// Rays in a turn.
const TURN: usize = 1000;

pub(crate) fn run(effort: Effort) {
    let rounds = match effort {
        Effort::Quick => 30,
        Effort::Full => 300,
    };
    let tilt = Quat::from_euler(EulerRot::XYZ, 0.6, 0.0, 0.7);
    let meshes: [(&str, Mesh); 4] = [
        ("ball", Sphere::new(1.0).mesh().ico(20).expect("few enough triangles")),
        ("tilted-rod", Mesh::from(Cylinder::new(0.1, 3.0)).rotated_by(tilt)),
        ("tilted-box", Mesh::from(Cuboid::new(2.0, 1.0, 0.3)).rotated_by(tilt)),
        ("ring", Mesh::from(Torus::new(0.7, 1.0)).rotated_by(tilt)),
    ];
    for (name, mesh) in meshes {
        let bvh = MeshBvh::build(&TriangleMesh::from_mesh(&mesh).expect("a mesh with triangles"));
        let mut rays = rays(&bvh);
        for kind in [BoundingKind::Sphere, BoundingKind::Obb, BoundingKind::Hull] {
            let volume = bvh.mesh().bounding_volume(kind).expect("a small mesh");
            let case = format!("bounding/{name}-{kind:?}").to_lowercase();
            compare(
                &case,
                PEER,
                rounds,
                &mut rays,
                |rays, round| {
                    let rays = turn(rays, round);
                    time(|| {
                        let hit = |ray: &Ray| {
                            black_box(&volume).ray_intersection_at(ray)?;
                            Some(bvh.closest_hit(ray, Backfaces::Cull)?.t)
                        };
                        rays.iter().map(hit).collect::<Vec<_>>()
                    })
                },
                |rays, round| {
                    let rays = turn(rays, round);
                    time(|| {
                        let hit = |ray: &Ray| Some(bvh.closest_hit(ray, Backfaces::Cull)?.t);
                        rays.iter().map(hit).collect::<Vec<_>>()
                    })
                },
                |a, b| (a.iter().zip(b).filter(|(a, b)| a != b).count(), a.len()),
            );
        }
    }
}

fn turn(rays: &[Ray], round: usize) -> &[Ray] {
    let start = round * TURN % rays.len();
    &rays[start..start + TURN]
}

/// Random rays through the box of a mesh.
fn rays(bvh: &MeshBvh) -> Vec<Ray> {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let aabb = bvh.mesh().aabb();
    let mut ray = || {
        let mut vector = || Vec3A::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
        let from = vector().normalize_or(Vec3A::X) * 5.0;
        let middle = (aabb.min + aabb.max) / 2.0;
        let ray = Ray::new(from, middle + vector() * (aabb.max - middle) - from, f32::INFINITY)?;
        ray.aabb_intersection_at(&aabb).map(|_| ray)
    };
    std::iter::repeat_with(&mut ray).flatten().take(16 * TURN).collect()
}
