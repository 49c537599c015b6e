//! What the buffer hides, case by case.

use bevy::math::{DMat4, Mat4, Quat, UVec2, Vec2, Vec3, Vec3A, bounding::Aabb3d};
use bevy_sightline::raster::{Faces, MaskedDepthBuffer, OccluderMesh, RasterMode, ScreenRect};

const MODES: [RasterMode; 2] = [RasterMode::Strict, RasterMode::Fast];

fn camera() -> Mat4 {
    Mat4::perspective_infinite_reverse_rh(1.0, 2.0, 0.1)
}

/// Looks along -z at 40 by 20 units, 100 deep.
fn orthographic() -> Mat4 {
    Mat4::orthographic_rh(-20.0, 20.0, -10.0, 10.0, 100.0, 0.0)
}

fn cuboid(x: f32, y: f32, z: f32, half: [f32; 3]) -> Aabb3d {
    let (center, half) = (Vec3A::new(x, y, z), Vec3A::from_array(half));
    Aabb3d {
        min: center - half,
        max: center + half,
    }
}

fn wall() -> Aabb3d {
    cuboid(0.0, 0.0, -10.0, [4.0, 3.0, 0.5])
}

fn buffer(mode: RasterMode) -> MaskedDepthBuffer {
    MaskedDepthBuffer::new(UVec2::new(256, 128), mode)
}

fn with_wall(mode: RasterMode, camera: &Mat4) -> MaskedDepthBuffer {
    let mut buffer = buffer(mode);
    buffer.draw_box(&wall(), &camera.as_dmat4());
    buffer
}

/// A sheet of two triangles across the view, as seen from the origin along -z.
fn sheet(half: Vec2, z: f32) -> OccluderMesh {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let positions = corners.map(|(x, y)| Vec3::new(x * half.x, y * half.y, z));
    OccluderMesh::new(&positions, &[[0, 1, 2], [0, 2, 3]])
}

#[test]
fn an_empty_buffer_hides_nothing() {
    for mode in MODES {
        assert!(buffer(mode).is_aabb_visible(&wall(), &camera()));
    }
}

#[test]
fn what_is_behind_a_wall_is_hidden_and_what_is_before_it_or_beside_it_is_not() {
    for (mode, camera) in MODES
        .into_iter()
        .flat_map(|mode| [(mode, camera()), (mode, orthographic())])
    {
        let buffer = with_wall(mode, &camera);
        assert!(!buffer.is_aabb_visible(&cuboid(1.0, 0.5, -20.0, [0.5; 3]), &camera));
        assert!(buffer.is_aabb_visible(&cuboid(1.0, 0.5, -5.0, [0.5; 3]), &camera));
        assert!(buffer.is_aabb_visible(&cuboid(5.0, 0.5, -11.0, [0.5; 3]), &camera));
        assert!(
            buffer.is_aabb_visible(&cuboid(4.0, 0.0, -11.0, [0.5; 3]), &camera),
            "half of it looks out"
        );
    }
}

#[test]
fn a_box_does_not_hide_itself() {
    for (mode, camera) in MODES
        .into_iter()
        .flat_map(|mode| [(mode, camera()), (mode, orthographic())])
    {
        assert!(with_wall(mode, &camera).is_aabb_visible(&wall(), &camera));
    }
}

#[test]
fn what_is_wholly_beside_the_screen_is_not_seen() {
    for mode in MODES {
        let buffer = buffer(mode);
        assert!(!buffer.is_aabb_visible(&cuboid(100.0, 0.0, -10.0, [1.0; 3]), &camera()));
        assert!(!buffer.is_aabb_visible(&cuboid(0.0, -100.0, -10.0, [1.0; 3]), &camera()));
    }
}

#[test]
fn what_reaches_through_the_near_plane_is_seen() {
    for mode in MODES {
        let buffer = with_wall(mode, &camera());
        assert!(buffer.is_aabb_visible(&cuboid(0.0, 0.0, 0.0, [1.0; 3]), &camera()));
        assert!(buffer.is_aabb_visible(&cuboid(0.0, 0.0, -20.0, [1.0, 1.0, 30.0]), &camera()));
    }
}

#[test]
fn what_is_nan_or_infinite_is_seen() {
    for mode in MODES {
        let buffer = with_wall(mode, &camera());
        for bad in [f32::NAN, f32::INFINITY] {
            assert!(buffer.is_aabb_visible(&cuboid(bad, 0.0, -20.0, [1.0; 3]), &camera()));
            assert!(buffer.is_aabb_visible(&cuboid(0.0, 0.0, -20.0, [bad; 3]), &camera()));
            assert!(buffer.is_aabb_visible(&cuboid(0.0, 0.0, -20.0, [1.0; 3]), &(camera() * bad)));
        }
    }
}

#[test]
fn what_is_nan_or_infinite_or_flat_hides_nothing() {
    for mode in MODES {
        let mut buffer = buffer(mode);
        for bad in [f32::NAN, f32::INFINITY] {
            buffer.draw_box(&cuboid(bad, 0.0, -10.0, [1.0; 3]), &camera().as_dmat4());
            buffer.draw_box(&wall(), &(camera() * bad).as_dmat4());
            buffer.draw_mesh(&sheet(Vec2::splat(5.0), bad), &camera().as_dmat4(), Faces::Both);
            buffer.draw_mesh(
                &sheet(Vec2::splat(5.0), -5.0),
                &(camera() * bad).as_dmat4(),
                Faces::Both,
            );
        }
        buffer.draw_box(&cuboid(0.0, 0.0, -10.0, [4.0, 0.0, 1.0]), &camera().as_dmat4());
        buffer.draw_box(&wall(), &DMat4::ZERO);
        buffer.draw_mesh(&OccluderMesh::new(&[], &[]), &camera().as_dmat4(), Faces::Both);
        buffer.draw_mesh(
            &OccluderMesh::new(&[Vec3::ZERO], &[[0, 1, 2], [0, 0, 0]]),
            &camera().as_dmat4(),
            Faces::Both,
        );
        assert!(buffer.is_rect_visible(&ScreenRect {
            min: Vec2::splat(100.0),
            max: Vec2::splat(101.0),
            nearest: 0.0,
        }));
    }
}

#[test]
fn from_within_a_box_nothing_is_hidden() {
    for mode in MODES {
        let mut buffer = buffer(mode);
        buffer.draw_box(&cuboid(0.0, 0.0, 0.0, [5.0; 3]), &camera().as_dmat4());
        assert!(buffer.is_aabb_visible(&cuboid(0.0, 0.0, -20.0, [0.5; 3]), &camera()));
    }
}

#[test]
fn a_wall_beside_the_eye_that_reaches_behind_it_hides_what_is_beyond() {
    for mode in MODES {
        let mut buffer = buffer(mode);
        buffer.draw_box(&cuboid(3.0, 0.0, 0.0, [1.0, 10.0, 100.0]), &camera().as_dmat4());
        assert!(!buffer.is_aabb_visible(&cuboid(8.0, 0.0, -10.0, [0.5; 3]), &camera()));
        assert!(buffer.is_aabb_visible(&cuboid(1.0, 0.0, -10.0, [0.5; 3]), &camera()));
    }
}

#[test]
fn two_boxes_together_hide_what_neither_hides_alone() {
    for mode in MODES {
        let mut buffer = buffer(mode);
        let behind = cuboid(0.0, 0.0, -30.0, [2.0, 0.5, 0.5]);
        // They overlap, so that no pixel is half of each.
        buffer.draw_box(&cuboid(-1.9, 0.0, -10.0, [2.0; 3]), &camera().as_dmat4());
        assert!(buffer.is_aabb_visible(&behind, &camera()));
        buffer.draw_box(&cuboid(1.9, 0.0, -10.0, [2.0; 3]), &camera().as_dmat4());
        assert!(!buffer.is_aabb_visible(&behind, &camera()));
    }
}

#[test]
fn the_triangles_of_a_mesh_hide_together_across_the_edges_that_they_share() {
    for mode in MODES {
        let mut buffer = buffer(mode);
        buffer.draw_mesh(&sheet(Vec2::splat(3.0), -10.0), &camera().as_dmat4(), Faces::Front);
        assert!(!buffer.is_aabb_visible(&cuboid(0.0, 0.0, -20.0, [2.0; 3]), &camera()));
        assert!(buffer.is_aabb_visible(&cuboid(0.0, 0.0, -5.0, [0.1; 3]), &camera()));
        assert!(buffer.is_aabb_visible(&cuboid(6.0, 0.0, -20.0, [0.5; 3]), &camera()));
    }
}

#[test]
fn only_the_faces_that_are_asked_for_hide() {
    let back = DMat4::from_quat(Quat::from_rotation_y(std::f32::consts::PI).as_dquat());
    let behind = cuboid(0.0, 0.0, -20.0, [1.0; 3]);
    for mode in MODES {
        for (faces, front_hides, back_hides) in [
            (Faces::Front, true, false),
            (Faces::Back, false, true),
            (Faces::Both, true, true),
        ] {
            let mut buffer = buffer(mode);
            buffer.draw_mesh(&sheet(Vec2::splat(3.0), -10.0), &camera().as_dmat4(), faces);
            assert_eq!(!buffer.is_aabb_visible(&behind, &camera()), front_hides);
            buffer.clear();
            buffer.draw_mesh(&sheet(Vec2::splat(3.0), 10.0), &(camera().as_dmat4() * back), faces);
            assert_eq!(!buffer.is_aabb_visible(&behind, &camera()), back_hides);
            buffer.clear();
            let mirror = DMat4::from_scale(Vec3::new(-1.0, 1.0, 1.0).as_dvec3());
            buffer.draw_mesh(&sheet(Vec2::splat(3.0), -10.0), &(camera().as_dmat4() * mirror), faces);
            assert_eq!(!buffer.is_aabb_visible(&behind, &camera()), back_hides);
        }
    }
}

#[test]
fn a_mirrored_box_hides_as_any_other() {
    let mirror = DMat4::from_scale(Vec3::new(-1.0, 1.0, 1.0).as_dvec3());
    for mode in MODES {
        let mut buffer = buffer(mode);
        buffer.draw_box(
            &cuboid(-1.0, 0.0, -10.0, [4.0, 3.0, 0.5]),
            &(camera().as_dmat4() * mirror),
        );
        assert!(!buffer.is_aabb_visible(&cuboid(2.0, 0.0, -20.0, [0.5; 3]), &camera()));
        assert!(buffer.is_aabb_visible(&cuboid(2.0, 0.0, -5.0, [0.5; 3]), &camera()));
    }
}

#[test]
fn a_turned_box_is_tested_as_it_lies() {
    for mode in MODES {
        let buffer = with_wall(mode, &camera());
        // Upright it is hidden behind the wall; lying across it looks out at both sides.
        let axes = [Vec3A::X * 0.2, Vec3A::Y * 12.0, Vec3A::Z * 0.2];
        let lying = axes.map(|axis| Quat::from_rotation_z(std::f32::consts::FRAC_PI_2) * axis);
        let short = axes.map(|axis| axis.clamp(Vec3A::splat(-0.5), Vec3A::splat(0.5)));
        let center = Vec3A::new(0.0, 0.0, -20.0);
        assert!(!buffer.is_parallelepiped_visible(center, short, &camera()));
        assert!(buffer.is_parallelepiped_visible(center, lying, &camera()));
    }
}

#[test]
fn drawing_in_any_order_hides_the_same_behind_a_wall() {
    let parts: Vec<Aabb3d> = (0..8)
        .map(|part| cuboid(part as f32 - 3.5, 0.0, -10.0 - part as f32, [0.8, 3.0, 0.5]))
        .collect();
    let behind = cuboid(0.0, 0.0, -40.0, [3.0, 1.0, 1.0]);
    for mode in MODES {
        for start in 0..8 {
            let mut buffer = buffer(mode);
            for part in 0..8 {
                buffer.draw_box(&parts[(start + part * 3) % 8], &camera().as_dmat4());
            }
            assert!(!buffer.is_aabb_visible(&behind, &camera()), "{mode:?} from {start}");
        }
    }
}

#[test]
fn a_pixel_tells_what_is_known_to_cover_it() {
    for mode in MODES {
        let buffer = with_wall(mode, &camera());
        let depth = buffer.depth(128, 64).expect("the wall is in the middle");
        // The front of the wall is 9.5 away.
        assert!(depth <= 0.1 / 9.5 && depth > 0.1 / 9.6, "{depth}");
        assert_eq!(buffer.depth(0, 0), None);
        assert_eq!(buffer.depth(256, 64), None);
    }
}

#[test]
fn a_gap_narrower_than_a_pixel_is_seen_through_strictly() {
    let mut buffer = buffer(RasterMode::Strict);
    for side in [-1.0, 1.0] {
        buffer.draw_box(&cuboid(side * 4.001, 0.0, -10.0, [4.0, 3.0, 0.5]), &camera().as_dmat4());
    }
    assert!(buffer.is_aabb_visible(&cuboid(0.0, 0.0, -20.0, [0.1; 3]), &camera()));
    assert!(!buffer.is_aabb_visible(&cuboid(3.0, 0.0, -20.0, [0.1; 3]), &camera()));
}

#[test]
fn the_picture_has_as_many_pixels_as_the_buffer_and_the_nearest_is_the_brightest() {
    let mut buffer = with_wall(RasterMode::Strict, &camera());
    buffer.draw_box(&cuboid(-1.0, 0.0, -5.0, [0.5; 3]), &camera().as_dmat4());
    let image = buffer.to_image();
    assert_eq!(image.size(), buffer.size());
    let red = |x: u32, y: u32| image.data.as_ref().unwrap()[4 * (y * 256 + x) as usize];
    let (near, far, nothing) = (red(104, 64), red(140, 64), red(1, 1));
    assert!(near > far && far > nothing, "{near} {far} {nothing}");
}

#[test]
fn a_size_is_brought_within_what_a_buffer_can_be() {
    assert_eq!(
        MaskedDepthBuffer::new(UVec2::ZERO, RasterMode::Fast).size(),
        UVec2::splat(8)
    );
    assert_eq!(
        MaskedDepthBuffer::new(UVec2::MAX, RasterMode::Fast).size(),
        UVec2::splat(8192)
    );
}

#[test]
fn many_boxes_are_told_of_as_one_by_one() {
    let mut rng = crate::common::rng(5);
    for mode in MODES {
        let buffer = with_wall(mode, &camera());
        for n in [0, 1, 7, 8, 9, 500] {
            let random = |_| Aabb3d::new(crate::common::random_point(&mut rng, 20.0), Vec3A::splat(0.5));
            let mut boxes: Vec<Aabb3d> = (0..n).map(random).collect();
            if let Some(bad) = boxes.last_mut() {
                bad.max.x = f32::NAN;
            }
            let mut visible = Vec::new();
            buffer.for_each_visible(&boxes, &camera(), |number| visible.push(number));
            let alone = (0..n).filter(|&number| buffer.is_aabb_visible(&boxes[number], &camera()));
            let alone: Vec<usize> = alone.collect();
            // Boxes that only rounding decides may differ: none of these are.
            assert_eq!(visible, alone);
        }
    }
}
