//! The wide path draws and tells the same as the plain one, to the last bit.

use bevy::math::{DMat4, Mat4, Quat, UVec2, Vec3, Vec3A, bounding::Aabb3d};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{
    Faces, MaskedDepthBuffer, OccluderMesh, RasterMode, cuboid::DrawBox, query::TestBoxes, triangles::DrawMesh,
};
use crate::spatial::simd::{Portable, Task, dispatch};

fn random_vec(rng: &mut ChaCha8Rng, size: f32) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| rng.random_range(-size..size)))
}

/// Triangles of which some share vertices, in front of the camera and about it.
fn random_mesh(rng: &mut ChaCha8Rng) -> OccluderMesh {
    let positions: Vec<Vec3> = (0..30).map(|_| random_vec(rng, 8.0)).collect();
    let corner = |rng: &mut ChaCha8Rng| rng.random_range(0..30);
    let triangles: Vec<[u32; 3]> = (0..27).map(|_| [corner(rng), corner(rng), corner(rng)]).collect();
    OccluderMesh::new(&positions, &triangles)
}

fn random_box(rng: &mut ChaCha8Rng) -> Aabb3d {
    let half = Vec3A::from(random_vec(rng, 3.0).abs());
    Aabb3d::new(random_vec(rng, 10.0), half)
}

#[test]
fn both_paths_draw_and_tell_the_same() {
    let clip_from_view = Mat4::perspective_infinite_reverse_rh(1.2, 1.6, 0.1);
    for seed in 0..150 {
        let rng = &mut ChaCha8Rng::seed_from_u64(seed);
        let mode = [RasterMode::Strict, RasterMode::Fast][seed as usize % 2];
        let mut wide = MaskedDepthBuffer::new(UVec2::new(200, 100), mode);
        let mut plain = wide.clone();
        for _ in 0..4 {
            let rotation = Quat::from_euler(bevy::math::EulerRot::XYZ, rng.random(), rng.random(), rng.random());
            let world_from_model = Mat4::from_rotation_translation(rotation, Vec3::NEG_Z * rng.random_range(0.0..20.0));
            let clip_from_model: DMat4 = clip_from_view.as_dmat4() * world_from_model.as_dmat4();
            let aabb = random_box(rng);
            let draw_box = |buffer| DrawBox {
                buffer,
                aabb: &aabb,
                clip_from_model: &clip_from_model,
            };
            dispatch(draw_box(&mut wide));
            draw_box(&mut plain).run(Portable);
            let mesh = random_mesh(rng);
            let faces = [Faces::Front, Faces::Back, Faces::Both][rng.random_range(0..3)];
            let draw_mesh = |buffer| DrawMesh {
                buffer,
                mesh: &mesh,
                clip_from_model: &clip_from_model,
                faces,
                bands: 1,
            };
            dispatch(draw_mesh(&mut wide));
            draw_mesh(&mut plain).run(Portable);
        }
        assert_eq!(wide.tiles, plain.tiles, "{mode:?}, seed {seed}");

        let boxes: Vec<Aabb3d> = (0..100).map(|_| random_box(rng)).collect();
        let (mut seen_wide, mut seen_plain) = (Vec::new(), Vec::new());
        dispatch(TestBoxes {
            buffer: &wide,
            aabbs: &boxes,
            clip_from_world: &clip_from_view,
            visit: |number| seen_wide.push(number),
        });
        TestBoxes {
            buffer: &plain,
            aabbs: &boxes,
            clip_from_world: &clip_from_view,
            visit: |number| seen_plain.push(number),
        }
        .run(Portable);
        assert_eq!(seen_wide, seen_plain, "{mode:?}, seed {seed}");
    }
}

#[test]
fn bands_drawn_side_by_side_make_what_is_drawn_alone() {
    let clip_from_view = Mat4::perspective_infinite_reverse_rh(1.2, 1.6, 0.1);
    for seed in 0..150 {
        let rng = &mut ChaCha8Rng::seed_from_u64(seed);
        let mode = [RasterMode::Strict, RasterMode::Fast][seed as usize % 2];
        let mut alone = MaskedDepthBuffer::new(UVec2::new(200, rng.random_range(8..150)), mode);
        let mut together = alone.clone();
        for _ in 0..4 {
            let mesh = random_mesh(rng);
            let clip_from_model = clip_from_view.as_dmat4() * DMat4::from_translation(random_vec(rng, 8.0).as_dvec3());
            let faces = [Faces::Front, Faces::Back, Faces::Both][rng.random_range(0..3)];
            for (buffer, bands) in [(&mut alone, 1), (&mut together, rng.random_range(2..9))] {
                dispatch(DrawMesh {
                    buffer,
                    mesh: &mesh,
                    clip_from_model: &clip_from_model,
                    faces,
                    bands,
                });
            }
        }
        assert!(alone.tiles == together.tiles, "{mode:?}, seed {seed}");
    }
}
