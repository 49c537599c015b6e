//! What cameras do not see.

use bevy::{
    camera::{
        OrthographicProjection, PerspectiveProjection,
        visibility::{NoCpuCulling, NoFrustumCulling, RenderLayers, VisibilityRange},
    },
    prelude::*,
};
use bevy_sightline::prelude::*;

use super::*;

#[test]
fn what_is_behind_an_occluder_is_not_seen() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    let (wall, behind, before) = (
        spawn_wall(&mut app),
        spawn_ahead(&mut app, 20.0),
        spawn_ahead(&mut app, 5.0),
    );
    let beside = spawn_cube(&mut app, Vec3::new(0.0, 4.4, -12.0));
    let seen = look(&mut app, camera);
    assert!(!seen.contains(&behind));
    assert!(seen.contains(&wall) && seen.contains(&before) && seen.contains(&beside));
}

#[test]
fn what_no_camera_sees_is_not_visible() {
    let mut app = headless_app();
    spawn_camera(&mut app);
    let (wall, behind) = (spawn_wall(&mut app), spawn_ahead(&mut app, 20.0));
    app.update();
    let is_visible = |entity| app.world().get::<ViewVisibility>(entity).unwrap().get();
    assert!(is_visible(wall) && !is_visible(behind));
}

#[test]
fn a_camera_without_occlusion_sees_all() {
    let mut app = headless_app();
    let (camera, other) = (spawn_camera(&mut app), spawn(&mut app, Camera3d::default()));
    spawn_wall(&mut app);
    let behind = spawn_ahead(&mut app, 20.0);
    assert!(!sees(&mut app, camera, behind));
    assert!(listed(&app, other).contains(&behind));
    remove::<SoftwareOcclusion>(&mut app, camera);
    assert!(sees(&mut app, camera, behind));
    insert(&mut app, camera, SoftwareOcclusion::default());
    assert!(!sees(&mut app, camera, behind));
}

#[test]
fn culling_that_is_left_to_bevy_hides_nothing() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    spawn_wall(&mut app);
    let behind = spawn_ahead(&mut app, 20.0);
    assert!(!sees(&mut app, camera, behind));
    app.world_mut().resource_mut::<ViewCullingSettings>().enabled = false;
    assert!(sees(&mut app, camera, behind));
    app.world_mut().resource_mut::<ViewCullingSettings>().enabled = true;
    assert!(!sees(&mut app, camera, behind));
}

#[test]
fn a_camera_that_leaves_culling_to_the_gpu_sees_all() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    insert(&mut app, camera, NoCpuCulling);
    spawn_wall(&mut app);
    let behind = spawn_ahead(&mut app, 20.0);
    assert!(sees(&mut app, camera, behind));
}

#[test]
fn perspective_and_orthographic_cameras_see_no_more_than_there_is() {
    for projection in [
        Projection::Perspective(PerspectiveProjection::default()),
        Projection::Orthographic(OrthographicProjection {
            scale: 0.02,
            ..OrthographicProjection::default_3d()
        }),
    ] {
        let mut app = headless_app();
        let camera = spawn_camera(&mut app);
        insert(&mut app, camera, projection);
        spawn_wall(&mut app);
        let (behind, before) = (spawn_ahead(&mut app, 20.0), spawn_ahead(&mut app, 5.0));
        let seen = look(&mut app, camera);
        assert!(!seen.contains(&behind) && seen.contains(&before));
    }
}

/// Depth that grows with distance.
#[derive(Clone, Debug)]
struct NotReversed;

impl bevy::camera::CameraProjection for NotReversed {
    fn get_clip_from_view(&self) -> Mat4 {
        Mat4::perspective_rh(1.0, 1.0, 0.1, 100.0)
    }

    fn get_clip_from_view_for_sub(&self, _: &bevy::camera::SubCameraView) -> Mat4 {
        self.get_clip_from_view()
    }

    fn update(&mut self, _: f32, _: f32) {}

    fn far(&self) -> f32 {
        100.0
    }

    fn get_frustum_corners(&self, _: f32, _: f32) -> [bevy::math::Vec3A; 8] {
        [bevy::math::Vec3A::ZERO; 8]
    }
}

#[test]
fn with_depth_that_is_not_reversed_nothing_is_hidden() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    insert(&mut app, camera, Projection::custom(NotReversed));
    spawn_wall(&mut app);
    let behind = spawn_ahead(&mut app, 20.0);
    assert!(sees(&mut app, camera, behind));
}

#[test]
fn a_camera_at_a_place_that_is_nan_does_no_harm() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    spawn_wall(&mut app);
    let behind = spawn_ahead(&mut app, 20.0);
    insert(&mut app, camera, Transform::from_xyz(f32::NAN, 0.0, 0.0));
    app.update();
    insert(&mut app, camera, Transform::IDENTITY);
    assert!(!sees(&mut app, camera, behind));
}

#[test]
fn every_kind_of_occluder_hides() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    let wall = spawn_wall(&mut app);
    let behind = spawn_ahead(&mut app, 20.0);
    let core = add_mesh(&mut app, Cuboid::new(6.0, 5.0, 0.5));
    for kind in [Occluder::Box, Occluder::Auto, Occluder::Mesh, Occluder::Proxy(core)] {
        insert(&mut app, wall, kind.clone());
        app.update();
        while app.world().resource::<Occluders>().making() > 0 {
            app.update();
        }
        assert!(!sees(&mut app, camera, behind), "{kind:?}");
    }
}

#[test]
fn an_occluder_on_other_layers_than_a_camera_hides_nothing_from_it() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    let (wall, behind) = (spawn_wall(&mut app), spawn_ahead(&mut app, 20.0));
    insert(&mut app, wall, RenderLayers::layer(1));
    assert!(sees(&mut app, camera, behind));
    insert(&mut app, camera, RenderLayers::from_layers(&[0, 1]));
    assert!(!sees(&mut app, camera, behind));
}

#[test]
fn an_occluder_that_is_shown_at_some_distances_hides_nothing() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    let (wall, behind) = (spawn_wall(&mut app), spawn_ahead(&mut app, 20.0));
    insert(&mut app, wall, VisibilityRange::abrupt(50.0, 100.0));
    assert!(sees(&mut app, camera, behind));
}

#[test]
fn from_within_an_occluder_all_is_seen() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    let (wall, behind) = (spawn_wall(&mut app), spawn_ahead(&mut app, 20.0));
    // The near plane is 0.1 m ahead: just within the wall.
    insert(&mut app, wall, Transform::from_xyz(0.0, 0.0, -0.55));
    assert!(sees(&mut app, camera, behind));
    insert(&mut app, wall, Transform::from_xyz(0.0, 0.0, -0.65));
    assert!(!sees(&mut app, camera, behind));
}

#[test]
fn what_a_mirror_turns_inside_out_hides_nothing() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    let (wall, behind) = (spawn_wall(&mut app), spawn_ahead(&mut app, 20.0));
    insert(
        &mut app,
        wall,
        Transform::from_xyz(0.0, 0.0, -10.0).with_scale(Vec3::new(-1.0, 1.0, 1.0)),
    );
    assert!(sees(&mut app, camera, behind));
}

#[test]
fn what_is_not_to_be_left_out_is_seen_behind_all() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    spawn_wall(&mut app);
    let behind = spawn_ahead(&mut app, 20.0);
    insert(&mut app, behind, NoOcclusionCulling);
    assert!(sees(&mut app, camera, behind));
    remove::<NoOcclusionCulling>(&mut app, behind);
    assert!(!sees(&mut app, camera, behind));
    insert(&mut app, behind, NoFrustumCulling);
    assert!(sees(&mut app, camera, behind));
}

#[test]
fn what_is_not_to_be_left_out_is_still_out_of_sight_beside_the_view() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    let beside = spawn_cube(&mut app, Vec3::new(500.0, 0.0, -10.0));
    insert(&mut app, beside, NoOcclusionCulling);
    assert!(!sees(&mut app, camera, beside));
}

#[test]
fn what_is_indexed_by_nothing_is_seen() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    spawn_wall(&mut app);
    let behind = spawn_ahead(&mut app, 20.0);
    insert(&mut app, behind, NoSpatialIndex);
    assert!(sees(&mut app, camera, behind));
}

#[test]
fn a_budget_of_nothing_hides_nothing() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    spawn_wall(&mut app);
    let behind = spawn_ahead(&mut app, 20.0);
    let budget = OcclusionBudget::default();
    for budget in [
        OcclusionBudget { occluders: 0, ..budget },
        OcclusionBudget {
            triangles: 11,
            ..budget
        },
        OcclusionBudget {
            least_area: 0.99,
            ..budget
        },
    ] {
        let occlusion = SoftwareOcclusion { budget, ..default() };
        insert(&mut app, camera, occlusion);
        assert!(sees(&mut app, camera, behind), "{budget:?}");
    }
    insert(&mut app, camera, SoftwareOcclusion::default());
    assert!(!sees(&mut app, camera, behind));
}

#[test]
fn the_nearest_occluders_are_drawn_and_those_that_are_hidden_are_not() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    spawn_wall(&mut app);
    let hidden = spawn_ahead(&mut app, 20.0);
    insert(&mut app, hidden, Occluder::Box);
    app.update();
    let stats = *app.world().get::<OcclusionBuffer>(camera).unwrap().stats();
    assert_eq!((stats.occluders, stats.triangles, stats.hidden), (1, 12, 1));
}

#[test]
fn what_was_drawn_can_be_read() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    spawn_wall(&mut app);
    app.update();
    // Also in a frame in which nothing has changed.
    for _ in 0..2 {
        let buffer = app.world().get::<OcclusionBuffer>(camera).expect("with the occlusion");
        let depth = buffer.depth().depth(512, 256).expect("the wall");
        assert!((depth - 0.1 / 9.5).abs() < 1e-3, "{depth}");
        app.update();
    }
}
