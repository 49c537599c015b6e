//! Data that makes no sense: nothing panics, one level is shown, and it goes on when the data is good again.

use bevy::camera::{OrthographicProjection, PerspectiveProjection, primitives::Aabb};

use super::*;

const BAD: [f32; 4] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0];

#[test]
fn without_levels_nothing_is_shown_or_hidden() {
    let mut app = app();
    let (camera, cube) = (spawn_camera(&mut app, 5.0), spawn_cube(&mut app, Vec3::ZERO));
    let mut none = ProxyLod::new(LodMetric::Height, cube);
    none.levels.clear();
    insert(&mut app, cube, none);
    for distance in [5.0, 500.0] {
        insert(&mut app, camera, at_distance(distance));
        app.update();
        assert_eq!(listed(&app, camera), [cube]);
    }
}

#[test]
fn one_level_is_always_shown() {
    for metric in [LodMetric::Height, LodMetric::ONE_PIXEL, LodMetric::Distance] {
        let mut app = app();
        let camera = spawn_camera(&mut app, 5.0);
        let statue = spawn_statue(&mut app, 1, |levels| ProxyLod::new(metric, levels[0]));
        for distance in [0.0, 5.0, 900.0] {
            assert_eq!(look_from(&mut app, camera, distance, &statue), 0);
        }
    }
}

#[test]
fn nothing_alone_shows_nothing() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 5.0);
    let cube = spawn_cube(&mut app, Vec3::ZERO);
    insert(&mut app, cube, ProxyLod::new(LodMetric::Height, LodContent::Nothing));
    app.update();
    assert_eq!(choices(&app).level(cube, camera), Some(0));
}

#[test]
fn of_more_than_eight_levels_the_first_eight_are_shown() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 5.0);
    let thresholds: Vec<f32> = (1..12).map(|level| 10.0 * level as f32).collect();
    let statue = spawn_statue(&mut app, 12, |levels| lod(LodMetric::Distance, levels, &thresholds));
    for (distance, level) in [(5.0, 0), (45.0, 4), (75.0, 6), (78.0, 7), (119.0, 7), (900.0, 7)] {
        insert(&mut app, camera, at_distance(distance));
        app.update();
        assert_eq!(
            choices(&app).level(statue.root, camera),
            Some(level),
            "from {distance} m"
        );
        let of_first: Vec<Entity> = listed(&app, camera)
            .into_iter()
            .filter(|e| statue.levels[..8].contains(e))
            .collect();
        assert_eq!(of_first, [statue.levels[level]]);
    }
}

#[test]
fn of_mixed_contents_those_like_the_first_are_shown() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 15.0);
    let mesh = add_mesh(&mut app, Cuboid::default());
    let statue = spawn_statue(&mut app, 2, |levels| {
        ProxyLod::new(LodMetric::Distance, levels[0])
            .then(5.0, mesh)
            .then(10.0, levels[1])
    });
    assert_eq!(look(&mut app, camera, &statue), 1);
    assert_eq!(look_from(&mut app, camera, 8.0, &statue), 0);
    assert!(!app.world().entity(statue.root).contains::<Mesh3d>());
}

#[test]
fn nothing_before_others_is_the_last() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 50.0);
    let statue = spawn_statue(&mut app, 2, |levels| {
        ProxyLod::new(LodMetric::Distance, levels[0])
            .then_nothing(10.0)
            .then(20.0, levels[1])
    });
    app.update();
    assert!(!sees(&app, camera, statue.levels[0]));
    assert_eq!(choices(&app).level(statue.root, camera), Some(1));
}

#[test]
fn a_level_with_a_threshold_that_makes_no_sense_is_never_shown() {
    for (metric, bad) in [
        (LodMetric::Distance, f32::NAN),
        (LodMetric::Distance, f32::INFINITY),
        (LodMetric::Height, f32::NAN),
        (LodMetric::Height, 0.0),
        (LodMetric::Height, -1.0),
        (LodMetric::ONE_PIXEL, f32::NAN),
        (LodMetric::ONE_PIXEL, f32::INFINITY),
        (LodMetric::PixelError(f32::NAN), 1e-3),
        (LodMetric::PixelError(0.0), 1e-3),
        (LodMetric::PixelError(-1.0), 1e-3),
    ] {
        let mut app = app();
        let camera = spawn_camera(&mut app, 5.0);
        let statue = spawn_statue(&mut app, 2, |levels| lod(metric, levels, &[bad]));
        for distance in [0.0, 5.0, 900.0] {
            assert_eq!(look_from(&mut app, camera, distance, &statue), 0, "{metric:?} {bad}");
        }
        insert(&mut app, camera, Transform::from_xyz(0.0, 0.0, 1e25));
        app.update();
        assert_eq!(choices(&app).level(statue.root, camera), Some(0), "{metric:?} {bad}");
    }
}

#[test]
fn a_bias_of_a_group_that_makes_no_sense_counts_as_one() {
    for bias in [f32::NAN, f32::INFINITY, -1.0, 0.0] {
        let mut app = app();
        let camera = spawn_camera(&mut app, 15.0);
        let statue = spawn_statue(&mut app, 3, |levels| by_distance(levels).with_bias(bias));
        assert_eq!(look(&mut app, camera, &statue), 1);
    }
}

#[test]
fn settings_that_make_no_sense_show_some_level() {
    for bad in BAD {
        let changes: [fn(&mut LodSettings, f32); 4] = [
            |settings, bad| settings.bias = bad,
            |settings, bad| settings.shadow_bias = bad,
            |settings, bad| settings.hysteresis = bad,
            |settings, bad| settings.viewport_height = bad,
        ];
        for change in changes {
            let mut app = app();
            let (camera, statue) = (spawn_camera(&mut app, 15.0), spawn_statue_by_distance(&mut app));
            assert_eq!(look(&mut app, camera, &statue), 1);
            change(&mut settings(&mut app), bad);
            app.update();
            assert_eq!(listed(&app, camera).len(), 1);
            *settings(&mut app) = LodSettings::default();
            assert_eq!(look(&mut app, camera, &statue), 1);
        }
    }
}

#[test]
fn projections_that_make_no_sense_show_some_level() {
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 15.0), spawn_statue_by_distance(&mut app));
    insert(
        &mut app,
        statue.root,
        lod(LodMetric::Height, &statue.levels, &[0.5, 0.3]),
    );
    let flat = OrthographicProjection {
        area: Rect::default(),
        ..OrthographicProjection::default_3d()
    };
    let projections: [Projection; 4] = [
        PerspectiveProjection {
            fov: f32::NAN,
            ..default()
        }
        .into(),
        PerspectiveProjection { fov: 0.0, ..default() }.into(),
        flat.clone().into(),
        OrthographicProjection {
            area: Rect::new(f32::NAN, 0.0, 1.0, 1.0),
            ..flat
        }
        .into(),
    ];
    for projection in projections {
        insert(&mut app, camera, projection);
        app.update();
        let shown = (0..3)
            .filter(|&level| choices(&app).shows(camera, statue.levels[level]))
            .count();
        assert_eq!(shown, 1);
    }
    insert(&mut app, camera, Projection::default());
    assert_eq!(look(&mut app, camera, &statue), 2);
}

#[test]
fn transforms_that_make_no_sense_show_the_finest_level_until_they_are_good() {
    for bad in [
        Transform::from_xyz(f32::NAN, 0.0, 0.0),
        Transform::from_xyz(f32::INFINITY, 0.0, 0.0),
        Transform::from_scale(Vec3::splat(f32::NAN)),
        Transform::from_scale(Vec3::splat(1e38)),
        Transform::from_xyz(3e38, 3e38, 3e38),
    ] {
        let mut app = app();
        let (camera, statue) = (spawn_camera(&mut app, 15.0), spawn_statue_by_distance(&mut app));
        assert_eq!(look(&mut app, camera, &statue), 1);
        insert(&mut app, statue.root, bad);
        app.update();
        app.update();
        assert!(choices(&app).level(statue.root, camera).is_some());
        insert(&mut app, statue.root, Transform::default());
        assert_eq!(look(&mut app, camera, &statue), 1, "after {bad:?}");
        insert(&mut app, statue.levels[0], bad);
        app.update();
        insert(&mut app, statue.levels[0], Transform::default());
        assert_eq!(look(&mut app, camera, &statue), 1, "after {bad:?}");
    }
}

#[test]
fn what_is_flat_or_without_size_is_somewhere_all_the_same() {
    for scale in [
        Vec3::ZERO,
        Vec3::new(1.0, 0.0, 1.0),
        Vec3::new(0.0, 0.0, 1.0),
        Vec3::splat(1e-30),
    ] {
        let mut app = app();
        let camera = spawn_camera(&mut app, 15.0);
        let around = Aabb::from_min_max(Vec3::splat(-0.5), Vec3::splat(0.5));
        let statue = spawn_statue(&mut app, 3, |levels| by_distance(levels).with_bounds(around));
        insert(&mut app, statue.root, Transform::from_scale(scale));
        app.update();
        assert_eq!(choices(&app).level(statue.root, camera), Some(1), "{scale}");
    }
}

#[test]
fn bounds_that_make_no_sense_show_the_finest_level() {
    for bad in [f32::NAN, f32::INFINITY] {
        let mut app = app();
        let camera = spawn_camera(&mut app, 15.0);
        let around = Aabb {
            center: Vec3A::splat(bad),
            half_extents: Vec3A::ONE,
        };
        let statue = spawn_statue(&mut app, 3, |levels| by_distance(levels).with_bounds(around));
        assert_eq!(look(&mut app, camera, &statue), 0);
        app.world_mut().get_mut::<ProxyLod>(statue.root).unwrap().bounds = None;
        assert_eq!(look(&mut app, camera, &statue), 1);
    }
}

#[test]
fn far_from_the_origin_distances_are_right_as_far_as_there_are_such() {
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 5.0), spawn_statue_by_distance(&mut app));
    let far = Vec3::new(1e7, -1e7, 1e7);
    insert(&mut app, statue.root, Transform::from_translation(far));
    for (distance, level) in [(8.0, 0), (9.0, 0), (13.0, 1), (14.0, 1), (30.0, 2), (16.0, 1), (4.0, 0)] {
        insert(&mut app, camera, Transform::from_translation(far + Vec3::Z * distance));
        app.update();
        assert_eq!(
            choices(&app).level(statue.root, camera),
            Some(level),
            "from {distance} m"
        );
    }
}

#[test]
fn listed_entities_that_do_not_exist_are_passed_over() {
    let mut app = app();
    let gone = spawn(&mut app, ());
    despawn(&mut app, gone);
    let camera = spawn_camera(&mut app, 15.0);
    let statue = spawn_statue(&mut app, 2, |levels| {
        ProxyLod::new(LodMetric::Distance, vec![gone, levels[0], Entity::PLACEHOLDER])
            .then(8.0, vec![gone, Entity::PLACEHOLDER])
            .then(30.0, levels[1])
    });
    // The second has nothing to show.
    for (distance, level) in [(5.0, 0), (15.0, 0), (50.0, 2)] {
        insert(&mut app, camera, at_distance(distance));
        app.update();
        assert_eq!(
            choices(&app).level(statue.root, camera),
            Some(level),
            "from {distance} m"
        );
        assert_eq!(listed(&app, camera), [statue.levels[level / 2]]);
    }
}

#[test]
fn groups_in_a_cycle_are_shown_as_far_as_that_goes() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 5.0);
    let roots: Vec<Entity> = (0..3).map(|_| spawn_cube(&mut app, Vec3::ZERO)).collect();
    let proxies: Vec<Entity> = (0..3).map(|_| spawn_cube(&mut app, Vec3::ZERO)).collect();
    for i in 0..3 {
        let levels = [roots[(i + 1) % 3], proxies[i]];
        insert(&mut app, roots[i], lod(LodMetric::Distance, &levels, &[10.0]));
    }
    for distance in [5.0, 15.0, 5.0] {
        insert(&mut app, camera, at_distance(distance));
        app.update();
        assert!(!listed(&app, camera).is_empty());
    }
    for root in roots {
        despawn(&mut app, root);
        app.update();
    }
    assert_eq!(listed(&app, camera), proxies);
}

#[test]
fn a_group_below_its_own_level_is_one() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 5.0);
    let mesh = add_mesh(&mut app, Cuboid::default());
    let fine = spawn(&mut app, Mesh3d(mesh.clone()));
    let root = spawn(&mut app, (Transform::default(), Visibility::default(), ChildOf(fine)));
    let coarse = spawn(&mut app, (Mesh3d(mesh), ChildOf(root)));
    insert(&mut app, root, lod(LodMetric::Distance, &[fine, coarse], &[10.0]));
    for (distance, expected) in [(5.0, fine), (15.0, coarse), (5.0, fine)] {
        insert(&mut app, camera, at_distance(distance));
        app.update();
        assert_eq!(listed(&app, camera), [expected]);
    }
}

#[test]
fn a_root_without_a_place_shows_its_finest_level() {
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 50.0), spawn_statue_by_distance(&mut app));
    assert_eq!(look(&mut app, camera, &statue), 2);
    let root = spawn(&mut app, ());
    remove::<ProxyLod>(&mut app, statue.root);
    insert(&mut app, root, by_distance(&statue.levels));
    let statue = Statue {
        root,
        levels: statue.levels,
    };
    assert_eq!(look(&mut app, camera, &statue), 0);
    insert(&mut app, root, Transform::default());
    assert_eq!(look(&mut app, camera, &statue), 2);
}
