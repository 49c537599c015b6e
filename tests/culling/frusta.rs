//! Who is in front of a camera.

use bevy::{
    camera::{
        CameraProjection, SubCameraView,
        primitives::{Aabb, Frustum, Sphere},
        visibility::{DynamicSkinnedMeshBounds, NoAutoAabb, NoFrustumCulling},
    },
    math::{
        Vec3A,
        primitives::{HalfSpace, ViewFrustum},
    },
    mesh::skinning::SkinnedMesh,
    prelude::*,
};
use bevy_sightline::prelude::*;

use super::{
    differential::{
        cast::{Meshes, Skin},
        things::Tree,
    },
    *,
};

#[test]
fn what_is_beside_above_below_or_behind_a_camera_is_not_seen() {
    of_both(|app| {
        let (camera, cube) = (spawn_camera(app), spawn_cube(app));
        for (x, y, z) in [
            (-20.0, 0.0, 0.0),
            (20.0, 0.0, 0.0),
            (0.0, 20.0, 0.0),
            (0.0, -20.0, 0.0),
            (0.0, 0.0, 20.0),
        ] {
            insert(app, cube, Transform::from_xyz(x, y, z));
            assert_eq!(look(app, camera), [], "at {x}, {y}, {z}");
            assert!(!is_seen(app, cube));
        }
        insert(app, cube, Transform::default());
        assert_eq!(look(app, camera), [cube]);
    });
}

#[test]
fn what_a_plane_of_the_frustum_cuts_is_seen() {
    of_both(|app| {
        // At a distance of 10, half the height in view is 4.14.
        let (camera, _) = (spawn_camera(app), spawn_cube_at(app, 0.0, 4.9, 0.0));
        let cut = spawn_cube_at(app, 0.0, 4.6, 0.0);
        assert_eq!(look(app, camera), [cut]);
    });
}

#[test]
fn nothing_is_too_far_away_for_a_camera() {
    of_both(|app| {
        let (camera, far) = (spawn_camera(app), spawn_cube_at(app, 0.0, 0.0, -5000.0));
        assert_eq!(look(app, camera), [far]);
    });
}

#[test]
fn looking_away_from_everything_empties_the_list() {
    of_both(|app| {
        let camera = spawn_camera(app);
        let cubes = [-1.0, 0.0, 1.0].map(|x| spawn_cube_at(app, x, 0.0, 0.0));
        assert_eq!(look(app, camera), sorted(cubes));
        insert(
            app,
            camera,
            Transform::from_xyz(0.0, 0.0, 10.0).looking_to(Vec3::Z, Vec3::Y),
        );
        assert_eq!(look(app, camera), []);
        assert!(cubes.iter().all(|&cube| !is_seen(app, cube)));
        insert(app, camera, Transform::from_xyz(0.0, 0.0, 10.0));
        assert_eq!(look(app, camera), sorted(cubes));
    });
}

#[test]
fn what_two_cameras_see_is_in_both_lists() {
    of_both(|app| {
        let (first, second) = (spawn_camera(app), spawn_camera(app));
        let cube = spawn_cube(app);
        assert_eq!(look(app, first), [cube]);
        assert_eq!(listed::<Mesh3d>(app, second), [cube]);
    });
}

#[test]
fn what_one_of_two_cameras_loses_stays_visible() {
    of_both(|app| {
        let (first, second) = (spawn_camera(app), spawn_camera(app));
        let cube = spawn_cube(app);
        app.update();
        insert(app, first, Transform::from_xyz(0.0, 0.0, -50.0));
        assert_eq!(look(app, first), []);
        assert_eq!(listed::<Mesh3d>(app, second), [cube]);
        assert!(is_seen(app, cube));
    });
}

#[test]
fn an_orthographic_camera_sees_a_box() {
    of_both(|app| {
        let projection = OrthographicProjection {
            area: Rect::from_center_half_size(Vec2::ZERO, Vec2::splat(3.0)),
            ..OrthographicProjection::default_3d()
        };
        let camera = spawn_camera(app);
        insert(app, camera, Projection::from(projection));
        let seen = spawn_cube_at(app, 3.4, 0.0, -500.0);
        spawn_cube_at(app, 3.6, 0.0, -500.0);
        assert_eq!(look(app, camera), [seen]);
    });
}

/// The right half of what a perspective would show.
#[derive(Clone, Debug)]
struct RightHalf(PerspectiveProjection);

impl CameraProjection for RightHalf {
    fn get_clip_from_view(&self) -> Mat4 {
        let full_size = UVec2::new(200, 200);
        let right_half = SubCameraView {
            full_size,
            offset: Vec2::new(100.0, 0.0),
            size: UVec2::new(100, 200),
        };
        self.0.get_clip_from_view_for_sub(&right_half)
    }

    fn get_clip_from_view_for_sub(&self, sub_view: &SubCameraView) -> Mat4 {
        self.0.get_clip_from_view_for_sub(sub_view)
    }

    fn update(&mut self, _: f32, _: f32) {}

    fn far(&self) -> f32 {
        f32::INFINITY
    }

    fn get_frustum_corners(&self, z_near: f32, z_far: f32) -> [Vec3A; 8] {
        self.0.get_frustum_corners(z_near, z_far)
    }
}

#[test]
fn a_projection_of_its_own_may_be_off_centre_and_endless() {
    of_both(|app| {
        let camera = spawn_camera(app);
        insert(
            app,
            camera,
            Projection::custom(RightHalf(PerspectiveProjection::default())),
        );
        spawn_cube_at(app, -2.0, 0.0, 0.0);
        let right = spawn_cube_at(app, 2.0, 0.0, 0.0);
        assert_eq!(look(app, camera), [right]);
    });
}

#[test]
fn a_changed_projection_counts_in_the_same_frame() {
    of_both(|app| {
        let (camera, cube) = (spawn_camera(app), spawn_cube_at(app, 8.0, 0.0, 0.0));
        assert_eq!(look(app, camera), []);
        let wide = PerspectiveProjection { fov: 2.0, ..default() };
        insert(app, camera, Projection::from(wide));
        assert_eq!(look(app, camera), [cube]);
    });
}

#[test]
fn planes_that_are_no_numbers_cull_nothing() {
    of_both(|app| {
        let camera = spawn(app, Camera::default());
        let cubes = [-100.0, 0.0, 100.0].map(|x| spawn_cube_at(app, x, 0.0, 0.0));
        let half_spaces = [HalfSpace::new(Vec4::NAN); 6];
        let frustum = Frustum(ViewFrustum { half_spaces });
        insert(app, camera, frustum);
        assert_eq!(look(app, camera), sorted(cubes));
    });
}

#[test]
fn planes_without_a_direction_cull_all_boxes() {
    of_both(|app| {
        let camera = spawn(app, (Camera::default(), Frustum::default()));
        let (_, unbounded) = (spawn_cube(app), spawn_cube(app));
        insert(app, unbounded, NoAutoAabb);
        assert_eq!(look(app, camera), [unbounded]);
    });
}

#[test]
fn an_entity_whose_place_is_no_number_is_always_seen_until_it_has_one() {
    of_both(|app| {
        let (camera, cube) = (spawn_camera(app), spawn_cube_at(app, 100.0, 0.0, 0.0));
        assert_eq!(look(app, camera), []);
        insert(app, cube, Transform::from_xyz(f32::NAN, 0.0, 0.0));
        assert_eq!(look(app, camera), [cube]);
        insert(app, cube, Transform::from_xyz(100.0, 0.0, 0.0));
        assert_eq!(look(app, camera), []);
    });
}

#[test]
fn a_mirrored_and_a_sheared_box_are_seen_where_they_are() {
    of_both(|app| {
        let camera = spawn_camera(app);
        let aabb = Aabb::from_min_max(Vec3::new(4.0, -0.5, -0.5), Vec3::new(6.0, 0.5, 0.5));
        let mirrored = spawn(app, (Tree, aabb, Transform::from_xyz(10.0, 0.0, 0.0)));
        assert_eq!(look_for::<Tree>(app, camera), []);
        insert(
            app,
            mirrored,
            Transform::from_xyz(6.0, 0.0, 0.0).with_scale(Vec3::new(-1.0, 1.0, 1.0)),
        );
        assert_eq!(look_for::<Tree>(app, camera), [mirrored]);
        let stretched = spawn(
            app,
            (Transform::from_scale(Vec3::new(4.0, 1.0, 1.0)), Visibility::default()),
        );
        let turned = Transform::from_rotation(Quat::from_rotation_z(1.0));
        insert(app, mirrored, (ChildOf(stretched), turned));
        assert_eq!(look_for::<Tree>(app, camera), []);
        insert(
            app,
            stretched,
            Transform::from_xyz(-10.8, -4.2, 0.0).with_scale(Vec3::new(4.0, 1.0, 1.0)),
        );
        assert_eq!(look_for::<Tree>(app, camera), [mirrored]);
    });
}

#[test]
fn what_moves_with_its_parent_is_followed() {
    of_both(|app| {
        let (camera, child) = (spawn_camera(app), spawn_cube(app));
        let parent = spawn(app, (Transform::from_xyz(50.0, 0.0, 0.0), Visibility::default()));
        insert(app, child, ChildOf(parent));
        assert_eq!(look(app, camera), []);
        insert(app, parent, Transform::default());
        assert_eq!(look(app, camera), [child]);
    });
}

#[test]
fn a_global_transform_that_is_written_by_hand_counts() {
    of_both(|app| {
        let (camera, cube) = (spawn_camera(app), spawn_cube(app));
        app.update();
        remove::<Transform>(app, cube);
        insert(app, cube, GlobalTransform::from_xyz(50.0, 0.0, 0.0));
        assert_eq!(look(app, camera), []);
        insert(app, cube, GlobalTransform::IDENTITY);
        assert_eq!(look(app, camera), [cube]);
    });
}

#[test]
fn a_sphere_is_where_it_says_whatever_the_transform() {
    of_both(|app| {
        let camera = spawn_camera(app);
        let sphere = |x| Sphere {
            center: Vec3A::X * x,
            radius: 1.0,
        };
        let far = Transform::from_xyz(500.0, 0.0, 0.0);
        let entity = spawn(app, (Tree, sphere(0.0), far));
        assert_eq!(look_for::<Tree>(app, camera), [entity]);
        insert(app, entity, (sphere(20.0), Transform::default()));
        assert_eq!(look_for::<Tree>(app, camera), []);
    });
}

#[test]
fn a_box_comes_before_a_sphere() {
    of_both(|app| {
        let camera = spawn_camera(app);
        let sphere = Sphere {
            center: Vec3A::ZERO,
            radius: 1.0,
        };
        let aabb = Aabb::from_min_max(Vec3::splat(99.0), Vec3::splat(100.0));
        let entity = spawn(app, (Tree, sphere, aabb));
        assert_eq!(look_for::<Tree>(app, camera), []);
        remove::<Aabb>(app, entity);
        assert_eq!(look_for::<Tree>(app, camera), [entity]);
    });
}

#[test]
fn what_has_no_bounds_is_always_seen() {
    of_both(|app| {
        let (camera, entity) = (
            spawn_camera(app),
            spawn(app, (Tree, Transform::from_xyz(500.0, 0.0, 0.0))),
        );
        assert_eq!(look_for::<Tree>(app, camera), [entity]);
        insert(app, entity, Aabb::from_min_max(Vec3::NEG_ONE, Vec3::ONE));
        assert_eq!(look_for::<Tree>(app, camera), []);
        remove::<Aabb>(app, entity);
        assert_eq!(look_for::<Tree>(app, camera), [entity]);
    });
}

#[test]
fn without_frustum_culling_an_entity_is_seen_wherever_it_is() {
    of_both(|app| {
        let (camera, cube) = (spawn_camera(app), spawn_cube_at(app, 100.0, 0.0, 0.0));
        assert_eq!(look(app, camera), []);
        insert(app, cube, NoFrustumCulling);
        assert_eq!(look(app, camera), [cube]);
        remove::<NoFrustumCulling>(app, cube);
        assert_eq!(look(app, camera), []);
    });
}

#[test]
fn an_entity_that_is_not_indexed_is_culled_all_the_same() {
    let mut app = ours();
    let (camera, cube) = (spawn_camera(&mut app), spawn_cube(&mut app));
    assert_eq!(look(&mut app, camera), [cube]);
    insert(&mut app, cube, NoSpatialIndex);
    assert_eq!(look(&mut app, camera), [cube]);
    insert(&mut app, cube, Transform::from_xyz(100.0, 0.0, 0.0));
    assert_eq!(look(&mut app, camera), []);
    remove::<NoSpatialIndex>(&mut app, cube);
    assert_eq!(look(&mut app, camera), []);
    insert(&mut app, cube, Transform::default());
    assert_eq!(look(&mut app, camera), [cube]);
}

#[test]
fn a_box_that_is_changed_by_hand_counts() {
    of_both(|app| {
        let (camera, cube) = (spawn_camera(app), spawn_cube(app));
        app.update();
        let mut aabb = app.world_mut().get_mut::<Aabb>(cube).expect("Bevy has computed it");
        aabb.center = Vec3A::X * 50.0;
        assert_eq!(look(app, camera), []);
    });
}

#[test]
fn a_mesh_that_is_swapped_has_another_box() {
    of_both(|app| {
        let camera = spawn_camera(app);
        let entity = spawn_cube_at(app, 0.0, 7.0, 0.0);
        assert_eq!(look(app, camera), []);
        let tall = Mesh3d(app.world().resource::<Meshes>().0[1].clone());
        insert(app, entity, tall);
        assert_eq!(look(app, camera), [entity]);
    });
}

#[test]
fn a_mesh_that_gets_no_box_is_always_seen() {
    of_both(|app| {
        let (camera, cube) = (spawn_camera(app), cube(app));
        let entity = spawn(app, (cube, NoAutoAabb, Transform::from_xyz(500.0, 0.0, 0.0)));
        assert_eq!(look(app, camera), [entity]);
    });
}

#[test]
fn a_skinned_mesh_is_seen_where_its_joints_put_its_bounds() {
    of_both(|app| {
        let camera = spawn_camera(app);
        let mesh = Mesh3d(
            app.world()
                .resource::<Meshes>()
                .0
                .last()
                .expect("the skinned mesh")
                .clone(),
        );
        let inverse_bindposes = app.world().resource::<Skin>().0.clone();
        let joints: Vec<Entity> = (0..Skin::JOINTS).map(|_| spawn(app, Transform::default())).collect();
        let skin = SkinnedMesh {
            inverse_bindposes,
            joints: joints.clone(),
        };
        let own_place = Transform::from_xyz(300.0, 0.0, 0.0);
        let rig = spawn(app, (mesh, skin, own_place, DynamicSkinnedMeshBounds));
        app.update();
        assert_eq!(look(app, camera), [rig]);
        for &joint in &joints {
            insert(app, joint, Transform::from_xyz(0.0, 60.0, 0.0));
        }
        assert_eq!(look(app, camera), []);
    });
}
