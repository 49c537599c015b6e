//! All pairs of triangles of two meshes that touch, against the pairs of leaves of parry3d's two trees and its triangle
//! test. Its meshes are placed in advance; ours are placed in the descent. An answer is one for each pair that it tests;
//! it reports some pairs that only come close.

use std::{hint::black_box, ops::ControlFlow};

use bevy::{math::Affine3A, mesh::VertexAttributeValues, prelude::*};
use bevy_sightline::mesh::{MeshBvh, PlacedMesh, TriangleMesh};
use parry3d::{
    math::{Pose, Vector},
    partitioning::BvhNode,
    query,
    shape::TriMesh,
};

use crate::{
    Effort,
    compare::{compare, time},
};

const PEER: &str = "parry3d 0.31.1";

pub(crate) fn run(effort: Effort) {
    let rounds = match effort {
        Effort::Quick => 10,
        Effort::Full => 60,
    };
    let ring: Mesh = Torus::new(0.9, 1.6)
        .mesh()
        .major_resolution(128)
        .minor_resolution(48)
        .build();
    let ball: Mesh = Sphere::new(1.0).mesh().ico(30).expect("few enough triangles");
    // As far through the hole, beside it, and well apart.
    for (case, offset) in [("crossing", 0.7), ("deep", 1.3), ("apart", 6.0)] {
        pair(&format!("geometry/meshes-{case}"), rounds, &ring, &ball, offset);
    }
}

fn pair(case: &str, rounds: usize, ring: &Mesh, ball: &Mesh, offset: f32) {
    let places: Vec<[Affine3A; 2]> = (0u8..16)
        .map(|round| {
            let turn = f32::from(round) * 0.37;
            let ring = Quat::from_euler(EulerRot::XYZ, turn, 0.5 * turn, 0.3);
            let ball = Quat::from_euler(EulerRot::XYZ, 0.2, turn, turn);
            [
                Affine3A::from_quat(ring),
                Affine3A::from_rotation_translation(ball, Vec3::new(offset, 0.1 * turn, 0.05)),
            ]
        })
        .collect();
    let bvhs = [ring, ball].map(|mesh| MeshBvh::build(&TriangleMesh::from_mesh(mesh).expect("triangles")));
    let peers: Vec<[TriMesh; 2]> = (places.iter())
        .map(|&[at_a, at_b]| [placed(ring, at_a), placed(ball, at_b)])
        .collect();
    compare(
        case,
        PEER,
        rounds,
        &mut (),
        |(), round| {
            let [at_a, at_b] = places[round % places.len()];
            let (a, b) = (PlacedMesh::new(&bvhs[0], at_a), PlacedMesh::new(&bvhs[1], at_b));
            time(|| {
                let mut touching = 0;
                a.visit_touching(&b, |pair| {
                    black_box(pair);
                    touching += 1;
                    ControlFlow::Continue(())
                });
                (touching, 0)
            })
        },
        |(), round| {
            let [a, b] = &peers[round % peers.len()];
            time(|| {
                let pairs = a.bvh().leaf_pairs(b.bvh(), BvhNode::intersects);
                let mut tested = 0;
                let touch = |&(i, j): &(u32, u32)| {
                    let (a, b) = (a.triangle(i), b.triangle(j));
                    query::intersection_test(&Pose::IDENTITY, &a, &Pose::IDENTITY, &b)
                        .expect("triangles are supported")
                        .intersecting
                };
                (pairs.inspect(|_| tested += 1).filter(touch).count(), tested)
            })
        },
        |ours, peers| (ours.0.abs_diff(peers.0), peers.1),
    );
}

fn placed(mesh: &Mesh, place: Affine3A) -> TriMesh {
    let Some(VertexAttributeValues::Float32x3(positions)) = mesh.attribute(Mesh::ATTRIBUTE_POSITION) else {
        panic!("a mesh without positions");
    };
    let vertices = positions.iter().map(|&position| {
        let position = place.transform_point3(position.into());
        Vector::new(position.x, position.y, position.z)
    });
    let indices: Vec<u32> = mesh
        .indices()
        .expect("indices")
        .iter()
        .map(|index| index as u32)
        .collect();
    let triangles = indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]);
    TriMesh::new(vertices.collect(), triangles.collect()).expect("a mesh with triangles")
}
