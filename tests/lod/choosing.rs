//! Which level is enough: by size on the screen, by error in pixels, by distance.

use bevy::camera::{
    CameraUpdateSystems, OrthographicProjection, PerspectiveProjection, Projection, SubCameraView, primitives::Aabb,
};

use super::*;

/// The height of a unit at distance one, as a fraction of a viewport with the default field of view of 45 degrees.
const HEIGHT: f32 = 1.2071068;

/// The diameter of the sphere around a unit cube.
const DIAMETER: f32 = 1.7320508;

fn perspective(fov: f32) -> Projection {
    PerspectiveProjection { fov, ..default() }.into()
}

/// An orthographic view that is so many metres high.
fn orthographic(height: f32) -> Projection {
    let half = height / 2.0;
    OrthographicProjection {
        area: Rect::new(-2.0 * half, -half, 2.0 * half, half),
        ..OrthographicProjection::default_3d()
    }
    .into()
}

/// From where on a view shows the second level, by halving: without hysteresis.
fn switching_distance(app: &mut App, camera: Entity, statue: &Statue) -> f32 {
    settings(app).hysteresis = 0.0;
    let (mut near, mut far) = (0.0, 1e4);
    while far - near > 1e-4 * far {
        let middle = (near + far) / 2.0;
        match look_from(app, camera, middle, statue) {
            0 => near = middle,
            _ => far = middle,
        }
    }
    far
}

#[track_caller]
fn assert_near(found: f32, expected: f32) {
    assert!((found / expected - 1.0).abs() < 1e-3, "{found} is not {expected}");
}

#[test]
fn by_distance_a_level_is_shown_from_its_threshold_on() {
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 5.0), spawn_statue_by_distance(&mut app));
    settings(&mut app).hysteresis = 0.0;
    for (distance, level) in [
        (9.99, 0),
        (10.0, 1),
        (19.99, 1),
        (20.0, 2),
        (500.0, 2),
        (10.0, 1),
        (0.1, 0),
    ] {
        assert_eq!(look_from(&mut app, camera, distance, &statue), level, "at {distance} m");
    }
}

#[test]
fn height_is_that_of_the_bounding_sphere_as_a_fraction_of_the_viewport() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 5.0);
    let statue = spawn_statue(&mut app, 2, |levels| lod(LodMetric::Height, levels, &[0.2]));
    let found = switching_distance(&mut app, camera, &statue);
    assert_near(found, DIAMETER * HEIGHT / 0.2);
}

#[test]
fn an_error_may_be_so_many_pixels_of_the_viewport() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 5.0);
    set_viewport_height(&mut app, camera, 720);
    let statue = spawn_statue(&mut app, 2, |levels| lod(LodMetric::PixelError(2.0), levels, &[0.05]));
    let found = switching_distance(&mut app, camera, &statue);
    assert_near(found, 0.05 * HEIGHT * 720.0 / 2.0);
}

#[test]
fn by_default_the_error_is_one_pixel() {
    assert_eq!(LodMetric::ONE_PIXEL, LodMetric::PixelError(1.0));
}

#[test]
fn of_errors_the_coarsest_level_that_is_good_enough_is_shown_whatever_their_order() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 5.0);
    set_viewport_height(&mut app, camera, 1000);
    // The third is better than the second, which so is never needed.
    let statue = spawn_statue(&mut app, 3, |levels| lod(LodMetric::ONE_PIXEL, levels, &[0.1, 0.05]));
    let begin = 0.05 * HEIGHT * 1000.0;
    assert_eq!(look_from(&mut app, camera, begin * 0.99, &statue), 0);
    assert_eq!(look_from(&mut app, camera, begin * 1.11, &statue), 2);
    assert_eq!(look_from(&mut app, camera, begin * 5.0, &statue), 2);
}

#[test]
fn where_no_viewport_is_known_the_settings_tell_its_height() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 5.0);
    let statue = spawn_statue(&mut app, 2, |levels| lod(LodMetric::ONE_PIXEL, levels, &[0.05]));
    settings(&mut app).viewport_height = 200.0;
    let found = switching_distance(&mut app, camera, &statue);
    assert_near(found, 0.05 * HEIGHT * 200.0);
}

#[test]
fn a_viewport_that_is_a_part_of_the_window_counts_by_its_own_height() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 5.0);
    set_viewport_height(&mut app, camera, 1000);
    app.world_mut().get_mut::<Camera>(camera).unwrap().viewport = Some(bevy::camera::Viewport {
        physical_size: UVec2::new(2000, 250),
        ..default()
    });
    let statue = spawn_statue(&mut app, 2, |levels| lod(LodMetric::ONE_PIXEL, levels, &[0.05]));
    let found = switching_distance(&mut app, camera, &statue);
    assert_near(found, 0.05 * HEIGHT * 250.0);
}

#[test]
fn zooming_and_moving_to_the_same_size_give_the_same_level() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 5.0);
    let statue = spawn_statue(&mut app, 2, |levels| lod(LodMetric::Height, levels, &[0.2]));
    for fov in [0.05f32, 0.3, 0.8, 1.5, 2.5] {
        insert(&mut app, camera, perspective(fov));
        let found = switching_distance(&mut app, camera, &statue);
        assert_near(found * (fov / 2.0).tan(), DIAMETER / 2.0 / 0.2);
    }
}

#[test]
fn plain_distance_knows_no_field_of_view() {
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 15.0), spawn_statue_by_distance(&mut app));
    for projection in [
        perspective(0.1),
        perspective(2.0),
        orthographic(3.0),
        orthographic(300.0),
    ] {
        insert(&mut app, camera, projection);
        assert_eq!(look(&mut app, camera, &statue), 1);
    }
}

#[test]
fn orthographic_views_show_the_same_from_everywhere_and_less_if_they_are_larger() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 5.0);
    let statue = spawn_statue(&mut app, 2, |levels| lod(LodMetric::Height, levels, &[0.1]));
    let begin = DIAMETER / 0.1;
    for (height, level) in [
        (0.99 * begin, 0),
        (1.11 * begin, 1),
        (1.01 * begin, 1),
        (0.99 * begin, 0),
    ] {
        insert(&mut app, camera, orthographic(height));
        for distance in [0.1, 3.0, 900.0] {
            assert_eq!(look_from(&mut app, camera, distance, &statue), level, "{height} m high");
        }
    }
}

#[test]
fn orthographic_views_count_pixels_too() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 5.0);
    set_viewport_height(&mut app, camera, 500);
    let statue = spawn_statue(&mut app, 2, |levels| lod(LodMetric::ONE_PIXEL, levels, &[0.02]));
    for (height, level) in [(9.9, 0), (11.1, 1)] {
        insert(&mut app, camera, orthographic(height));
        assert_eq!(look(&mut app, camera, &statue), level, "{height} m high");
    }
}

#[test]
fn a_camera_may_change_between_perspective_and_orthographic() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 15.0);
    let statue = spawn_statue(&mut app, 2, |levels| lod(LodMetric::Height, levels, &[0.2]));
    assert_eq!(look(&mut app, camera, &statue), 1);
    insert(&mut app, camera, orthographic(2.0));
    assert_eq!(look(&mut app, camera, &statue), 0);
    insert(&mut app, camera, perspective(0.8));
    assert_eq!(look(&mut app, camera, &statue), 1);
}

#[test]
fn a_part_of_a_view_shows_things_as_large_as_they_are_in_it() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 15.0);
    let statue = spawn_statue(&mut app, 2, |levels| lod(LodMetric::Height, levels, &[0.2]));
    assert_eq!(look(&mut app, camera, &statue), 1);
    app.world_mut().get_mut::<Camera>(camera).unwrap().sub_camera_view = Some(SubCameraView {
        full_size: UVec2::new(1000, 1000),
        size: UVec2::new(200, 200),
        offset: Vec2::new(400.0, 400.0),
    });
    assert_eq!(look(&mut app, camera, &statue), 0);
}

#[test]
fn the_projection_of_this_frame_counts() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 15.0);
    let statue = spawn_statue(&mut app, 2, |levels| lod(LodMetric::Height, levels, &[0.2]));
    assert_eq!(look(&mut app, camera, &statue), 1);
    // As Bevy does it with the areas of orthographic views.
    let zoom = move |mut projections: Query<&mut Projection>| {
        *projections.get_mut(camera).expect("a camera") = perspective(0.1);
    };
    app.add_systems(PostUpdate, zoom.in_set(CameraUpdateSystems));
    assert_eq!(look(&mut app, camera, &statue), 0);
}

#[test]
fn what_is_scaled_is_as_large_as_it_looks() {
    for metric in [LodMetric::Height, LodMetric::ONE_PIXEL] {
        let mut app = app();
        let camera = spawn_camera(&mut app, 5.0);
        let statue = spawn_statue(&mut app, 2, |levels| {
            lod(metric, levels, &[0.1]).measured_to(LodReference::Center)
        });
        let begin = |app: &mut App, scale: Vec3| {
            insert(app, statue.root, Transform::from_scale(scale));
            switching_distance(app, camera, &statue) + 0.5
        };
        let usual = begin(&mut app, Vec3::ONE);
        assert_near(begin(&mut app, Vec3::splat(3.0)), 3.0 * usual);
        assert_near(begin(&mut app, Vec3::splat(0.25)), 0.25 * usual);
        assert_near(begin(&mut app, Vec3::new(-1.0, 1.0, 1.0)), usual);
        assert_near(begin(&mut app, Vec3::splat(-2.0)), 2.0 * usual);
    }
}

#[test]
fn errors_are_as_large_as_their_group_is_stretched_most() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 5.0);
    let statue = spawn_statue(&mut app, 2, |levels| {
        lod(LodMetric::ONE_PIXEL, levels, &[0.05]).measured_to(LodReference::Center)
    });
    let usual = switching_distance(&mut app, camera, &statue) + 0.5;
    for scale in [
        Vec3::new(3.0, 1.0, 1.0),
        Vec3::new(1.0, 0.5, 3.0),
        Vec3::new(0.1, -3.0, 2.0),
    ] {
        let turned = Transform::from_rotation(Quat::from_euler(EulerRot::XYZ, 0.3, 1.0, -2.0)).with_scale(scale);
        insert(&mut app, statue.root, turned);
        assert_near(switching_distance(&mut app, camera, &statue) + 0.5, 3.0 * usual);
    }
}

#[test]
fn however_it_is_turned_a_group_is_as_large() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 5.0);
    let statue = spawn_statue(&mut app, 2, |levels| {
        lod(LodMetric::Height, levels, &[0.2]).measured_to(LodReference::Center)
    });
    let usual = switching_distance(&mut app, camera, &statue);
    let mut rng = rng(7);
    for _ in 0..5 {
        insert(
            &mut app,
            statue.root,
            Transform::from_rotation(random_rotation(&mut rng)),
        );
        assert_near(switching_distance(&mut app, camera, &statue), usual);
    }
}

#[test]
fn distances_are_measured_to_the_nearest_point_or_to_the_centre() {
    let long = Aabb::from_min_max(Vec3::new(-1.0, -1.0, -30.0), Vec3::new(1.0, 1.0, 10.0));
    for (reference, nearest) in [(LodReference::NearestPoint, 10.0), (LodReference::Center, -10.0)] {
        let mut app = app();
        let camera = spawn_camera(&mut app, 5.0);
        let statue = spawn_statue(&mut app, 2, |levels| {
            lod(LodMetric::Distance, levels, &[50.0])
                .with_bounds(long)
                .measured_to(reference)
        });
        assert_near(switching_distance(&mut app, camera, &statue), 50.0 + nearest - 0.5);
    }
}

#[test]
fn within_its_bounds_a_group_is_shown_in_full() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 50.0);
    for metric in [LodMetric::Height, LodMetric::ONE_PIXEL, LodMetric::Distance] {
        let around = Aabb::from_min_max(Vec3::splat(-30.0), Vec3::splat(30.0));
        let statue = spawn_statue(&mut app, 2, |levels| lod(metric, levels, &[1.0]).with_bounds(around));
        assert_eq!(look_from(&mut app, camera, 29.0, &statue), 0);
        despawn(&mut app, statue.root);
    }
}

#[test]
fn bounds_are_those_of_all_that_the_first_level_shows_and_of_nothing_else() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 5.0);
    let statue = spawn_statue(&mut app, 2, |levels| {
        let mut lod = lod(LodMetric::Height, levels, &[0.2]);
        lod.reference = LodReference::Center;
        lod
    });
    let usual = switching_distance(&mut app, camera, &statue) + 0.5;
    insert(&mut app, statue.levels[1], Transform::from_scale(Vec3::splat(50.0)));
    assert_near(switching_distance(&mut app, camera, &statue) + 0.5, usual);
    insert(&mut app, statue.levels[0], Transform::from_scale(Vec3::splat(2.0)));
    assert_near(switching_distance(&mut app, camera, &statue) + 0.5, 2.0 * usual);
    let mesh = app.world().get::<Mesh3d>(statue.levels[0]).unwrap().clone();
    // Below the first level: from -1 to 5 along x.
    spawn(
        &mut app,
        (mesh, Transform::from_xyz(2.0, 0.0, 0.0), ChildOf(statue.levels[0])),
    );
    let diameter = Vec3::new(6.0, 2.0, 2.0).length();
    let found = switching_distance(&mut app, camera, &statue) + 0.5;
    assert_near(Vec2::new(found, 2.0).length(), diameter * HEIGHT / 0.2);
}

#[test]
fn biases_of_all_of_a_camera_and_of_a_group_multiply() {
    for metric in [LodMetric::Height, LodMetric::ONE_PIXEL, LodMetric::Distance] {
        let mut app = app();
        let camera = spawn_camera(&mut app, 5.0);
        let threshold = if metric == LodMetric::Distance { 10.0 } else { 0.1 };
        let statue = spawn_statue(&mut app, 2, |levels| lod(metric, levels, &[threshold]));
        let usual = switching_distance(&mut app, camera, &statue);
        settings(&mut app).bias = 3.0;
        assert_near(switching_distance(&mut app, camera, &statue), 3.0 * usual);
        insert(&mut app, camera, LodBias(0.5));
        assert_near(switching_distance(&mut app, camera, &statue), 1.5 * usual);
        app.world_mut().get_mut::<ProxyLod>(statue.root).unwrap().bias = 4.0;
        assert_near(switching_distance(&mut app, camera, &statue), 6.0 * usual);
    }
}

#[test]
fn what_is_too_small_to_matter_is_not_shown() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 5.0);
    let statue = spawn_statue(&mut app, 2, |levels| {
        lod(LodMetric::Distance, levels, &[10.0]).then_nothing(20.0)
    });
    assert_eq!(look_from(&mut app, camera, 15.0, &statue), 1);
    insert(&mut app, camera, at_distance(30.0));
    app.update();
    assert_eq!(listed(&app, camera), []);
    assert_eq!(choices(&app).level(statue.root, camera), Some(2));
    assert_eq!(look_from(&mut app, camera, 5.0, &statue), 0);
}

#[test]
fn a_group_that_moves_is_chosen_for_by_where_it_is_in_the_same_frame() {
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 5.0), spawn_statue_by_distance(&mut app));
    for (away, level) in [(0.0, 0), (10.0, 1), (50.0, 2), (0.0, 0)] {
        insert(&mut app, statue.root, Transform::from_xyz(0.0, 0.0, -away));
        assert_eq!(look(&mut app, camera, &statue), level);
    }
}

#[test]
fn a_root_that_has_no_bounds_and_moves_alone_is_followed() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 5.0);
    let far = Transform::from_xyz(0.0, 0.0, -100.0);
    let root = spawn(&mut app, Transform::default());
    // Neither is below the root.
    let levels = [spawn_cube(&mut app, Vec3::ZERO), spawn_cube(&mut app, Vec3::ZERO)];
    let around = Aabb::from_min_max(Vec3::NEG_ONE, Vec3::ONE);
    insert(
        &mut app,
        root,
        lod(LodMetric::Distance, &levels, &[20.0]).with_bounds(around),
    );
    let statue = Statue {
        root,
        levels: levels.into(),
    };
    assert_eq!(look(&mut app, camera, &statue), 0);
    insert(&mut app, root, far);
    assert_eq!(look(&mut app, camera, &statue), 1);
    insert(&mut app, root, Transform::default());
    assert_eq!(look(&mut app, camera, &statue), 0);
}

#[test]
fn a_group_that_grows_from_nothing_is_chosen_for_as_large_as_it_is() {
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 15.0), spawn_statue_by_distance(&mut app));
    insert(&mut app, statue.root, Transform::from_scale(Vec3::ZERO));
    app.update();
    for scale in [1e-3, 0.5, 1.0] {
        insert(&mut app, statue.root, Transform::from_scale(Vec3::splat(scale)));
        assert_eq!(look(&mut app, camera, &statue), 1);
    }
}

#[test]
fn a_viewport_without_a_height_is_as_one_of_which_nothing_is_known() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 15.0);
    let statue = spawn_statue(&mut app, 2, |levels| lod(LodMetric::Height, levels, &[0.2]));
    assert_eq!(look(&mut app, camera, &statue), 1);
    // As of a window that is minimised.
    set_viewport_height(&mut app, camera, 0);
    assert_eq!(look(&mut app, camera, &statue), 1);
}

#[test]
fn everything_is_finest_while_levels_are_switched_off() {
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 50.0), spawn_statue_by_distance(&mut app));
    assert_eq!(look(&mut app, camera, &statue), 2);
    settings(&mut app).enabled = false;
    assert_eq!(look(&mut app, camera, &statue), 0);
    assert_eq!(look_from(&mut app, camera, 100.0, &statue), 0);
    settings(&mut app).enabled = true;
    assert_eq!(look(&mut app, camera, &statue), 2);
}

#[test]
fn a_group_of_lamps_alone_is_followed_where_it_goes() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 5.0);
    let root = spawn(&mut app, (Transform::from_xyz(0.0, 0.0, -100.0), Visibility::default()));
    let lamp = spawn(&mut app, (PointLight::default(), ChildOf(root)));
    let bounds = Aabb::from_min_max(Vec3::splat(-0.5), Vec3::splat(0.5));
    let lod = ProxyLod::new(LodMetric::Distance, lamp)
        .then_nothing(20.0)
        .with_bounds(bounds);
    insert(&mut app, root, lod);
    for _ in 0..3 {
        app.update();
    }
    assert_eq!(choices(&app).level(root, camera), Some(1));
    insert(&mut app, root, Transform::default());
    app.update();
    assert_eq!(choices(&app).level(root, camera), Some(0));
}
