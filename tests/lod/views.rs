//! Each view chooses for itself.

use bevy::math::Vec3A;

use super::*;

#[test]
fn cameras_show_different_levels_at_the_same_time() {
    let mut app = app();
    let statue = spawn_statue_by_distance(&mut app);
    let cameras = [5.0, 15.0, 50.0].map(|distance| spawn_camera(&mut app, distance));
    app.update();
    for (level, camera) in cameras.into_iter().enumerate() {
        assert_eq!(shown(&app, camera, &statue), level);
    }
}

#[test]
fn what_any_camera_shows_is_marked_as_visible() {
    let mut app = app();
    let statue = spawn_statue_by_distance(&mut app);
    let (near, far) = (spawn_camera(&mut app, 5.0), spawn_camera(&mut app, 50.0));
    app.update();
    let marks = |app: &App| -> Vec<bool> {
        let mark = |&level: &Entity| app.world().get::<ViewVisibility>(level).unwrap().get();
        statue.levels.iter().map(mark).collect()
    };
    assert_eq!(marks(&app), [true, false, true]);
    insert(&mut app, near, at_distance(15.0));
    app.update();
    assert_eq!(marks(&app), [false, true, true]);
    despawn(&mut app, far);
    app.update();
    assert_eq!(marks(&app), [false, true, false]);
}

#[test]
fn the_reason_not_to_see_a_level_is_that_another_is_shown() {
    use bevy::ecs::system::RunSystemOnce;
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 15.0), spawn_statue_by_distance(&mut app));
    app.update();
    let levels = statue.levels.clone();
    let ask = move |reasons: VisibilityReasons| {
        let of = levels.iter().map(|&level| reasons.of(level, camera));
        of.collect::<Vec<_>>()
    };
    let reasons = app.world_mut().run_system_once(ask).expect("a system that runs");
    let other = Some(VisibilityReason::OtherLevel);
    assert_eq!(reasons, [other, Some(VisibilityReason::Visible), other]);
}

#[test]
fn to_switch_is_to_enter_and_to_leave_the_view() {
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 5.0), spawn_statue_by_distance(&mut app));
    app.update();
    insert(&mut app, camera, at_distance(15.0));
    app.update();
    let set = app.world().get::<VisibleSet>(camera).unwrap();
    assert_eq!(set.entered(), [statue.levels[1]]);
    assert_eq!(set.left(), [statue.levels[0]]);
}

#[test]
fn without_a_camera_nothing_is_chosen_and_nothing_goes_wrong() {
    let mut app = app();
    let statue = spawn_statue_by_distance(&mut app);
    for _ in 0..3 {
        app.update();
    }
    assert_eq!(choices(&app).len(), 1);
    assert_eq!(choices(&app).main_camera(), None);
    let camera = spawn_camera(&mut app, 15.0);
    assert_eq!(look(&mut app, camera, &statue), 1);
}

#[test]
fn a_camera_that_is_not_active_has_no_levels() {
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 15.0), spawn_statue_by_distance(&mut app));
    assert_eq!(look(&mut app, camera, &statue), 1);
    for (is_active, level) in [(false, None), (true, Some(1))] {
        app.world_mut().get_mut::<Camera>(camera).unwrap().is_active = is_active;
        app.update();
        assert_eq!(choices(&app).level(statue.root, camera), level);
    }
    assert_eq!(shown(&app, camera, &statue), 1);
}

#[test]
fn a_camera_that_comes_back_does_not_know_what_it_showed() {
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 15.0), spawn_statue_by_distance(&mut app));
    app.update();
    assert_eq!(look_from(&mut app, camera, 10.5, &statue), 1);
    app.world_mut().get_mut::<Camera>(camera).unwrap().is_active = false;
    app.update();
    app.world_mut().get_mut::<Camera>(camera).unwrap().is_active = true;
    assert_eq!(look(&mut app, camera, &statue), 0);
}

#[test]
fn a_place_that_is_not_finite_shows_all_in_full_and_then_goes_on() {
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 50.0), spawn_statue_by_distance(&mut app));
    assert_eq!(look(&mut app, camera, &statue), 2);
    for bias in [f32::NAN, f32::INFINITY, -1.0, 0.0] {
        insert(&mut app, camera, LodBias(bias));
        app.update();
        assert_eq!(choices(&app).level(statue.root, camera), None);
        assert_eq!(listed(&app, camera), [statue.levels[0]]);
        insert(&mut app, camera, LodBias(1.0));
        assert_eq!(look(&mut app, camera, &statue), 2);
    }
}

#[test]
fn from_the_end_of_the_world_and_back_the_choice_is_right() {
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 5.0), spawn_statue_by_distance(&mut app));
    assert_eq!(look(&mut app, camera, &statue), 0);
    for far in [1e7, 1e12, 1e18, 1e25, 1e38] {
        // Out of the frustum, so that nothing is listed; its level is known all the same.
        insert(&mut app, camera, Transform::from_xyz(0.0, 0.0, far));
        app.update();
        assert_eq!(choices(&app).level(statue.root, camera), Some(2), "from {far}");
        for (distance, level) in [(5.0, 0), (9.0, 0), (10.5, 0), (11.5, 1), (15.0, 1), (25.0, 2), (1.0, 0)] {
            assert_eq!(
                look_from(&mut app, camera, distance, &statue),
                level,
                "after {far}, at {distance}"
            );
        }
        // In steps that are too small to count beside the way so far.
        for i in 0..60 {
            look_from(&mut app, camera, 5.0 + 0.3 * i as f32, &statue);
        }
        assert_eq!(shown(&app, camera, &statue), 2, "after {far}");
    }
}

#[test]
fn the_index_may_be_paused() {
    #[derive(Resource)]
    struct IsOn(bool);
    let mut app = app();
    app.insert_resource(IsOn(true))
        .configure_sets(PostUpdate, SpatialIndexSystems::Sync.run_if(|is_on: Res<IsOn>| is_on.0));
    let (camera, statue) = (spawn_camera(&mut app, 5.0), spawn_statue_by_distance(&mut app));
    assert_eq!(look(&mut app, camera, &statue), 0);
    app.insert_resource(IsOn(false));
    let other = spawn_statue_by_distance(&mut app);
    for (away, level) in [(10.0, 1), (50.0, 2), (0.0, 0), (50.0, 2)] {
        insert(&mut app, statue.root, Transform::from_xyz(0.0, 0.0, -away));
        assert_eq!(look(&mut app, camera, &statue), level);
        assert_eq!(shown(&app, camera, &other), 0);
    }
    app.insert_resource(IsOn(true));
    assert_eq!(look(&mut app, camera, &statue), 2);
    assert_eq!(shown(&app, camera, &other), 0);
}

#[test]
fn levels_do_not_depend_on_the_order_in_which_they_were_spawned_or_listed() {
    let mut app = app();
    let mesh = add_mesh(&mut app, Cuboid::default());
    let mut members: Vec<Entity> = (0..6).map(|_| spawn(&mut app, Mesh3d(mesh.clone()))).collect();
    let camera = spawn_camera(&mut app, 15.0);
    for turn in 0..6 {
        members.rotate_left(1);
        let root = spawn(&mut app, Transform::default());
        let lod = ProxyLod::new(LodMetric::Distance, vec![members[4], members[1]])
            .then(10.0, vec![members[0], members[5]])
            .then(20.0, vec![members[3], members[2]]);
        insert(&mut app, root, lod);
        for (distance, expected) in [(5.0, [4, 1]), (15.0, [0, 5]), (50.0, [3, 2])] {
            insert(&mut app, camera, at_distance(distance));
            app.update();
            let mut expected = expected.map(|i| members[i]);
            expected.sort_by_key(|entity| entity.index());
            assert_eq!(listed(&app, camera), expected, "turn {turn}");
        }
        despawn(&mut app, root);
    }
}

#[test]
fn the_distances_are_those_from_which_on_levels_are_shown() {
    let mut app = app();
    let statue = spawn_statue(&mut app, 3, |levels| {
        lod(LodMetric::Height, levels, &[0.2, 0.05]).with_bias(1.5)
    });
    let camera = spawn_camera(&mut app, 5.0);
    settings(&mut app).hysteresis = 0.0;
    app.update();
    let distances: Vec<f32> = choices(&app)
        .distances(statue.root, camera)
        .expect("an active camera")
        .collect();
    assert_eq!((distances.len(), distances[0]), (3, 0.0));
    for (level, distance) in distances.iter().enumerate().skip(1) {
        assert_eq!(look_from(&mut app, camera, distance * 0.999, &statue), level - 1);
        assert_eq!(look_from(&mut app, camera, distance * 1.001, &statue), level);
    }
}

#[test]
fn where_distances_decide_nothing_there_are_none() {
    let mut app = app();
    let by_height = spawn_statue(&mut app, 2, |levels| lod(LodMetric::Height, levels, &[0.2]));
    let by_distance = spawn_statue_by_distance(&mut app);
    let orthographic = Projection::from(OrthographicProjection::default_3d());
    let camera = spawn(&mut app, (Camera3d::default(), orthographic, at_distance(10.0)));
    app.update();
    let has_some = |group, view| choices(&app).distances(group, view).is_some();
    assert!(!has_some(by_height.root, camera));
    assert!(has_some(by_distance.root, camera));
    assert!(!has_some(camera, camera), "it is no group");
    assert!(!has_some(by_distance.root, by_distance.root), "it is no camera");
}

#[test]
fn the_bounds_of_groups_are_known_by_their_roots() {
    let mut app = app();
    let statue = spawn_statue_by_distance(&mut app);
    insert(&mut app, statue.root, Transform::from_xyz(3.0, 0.0, 0.0));
    app.update();
    assert_eq!(choices(&app).roots().collect::<Vec<_>>(), [statue.root]);
    let bounds = choices(&app).bounds(statue.root).expect("a group");
    assert_eq!(bounds.center, Vec3A::ZERO, "in the space of the root");
    assert!(bounds.half_extents.abs_diff_eq(Vec3A::splat(0.5), 1e-5));
    assert_eq!(choices(&app).bounds(statue.levels[0]), None, "it is no root");
    despawn(&mut app, statue.root);
    app.update();
    assert_eq!(choices(&app).bounds(statue.root), None);
    assert_eq!(choices(&app).roots().count(), 0);
}
