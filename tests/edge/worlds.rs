//! More than one world, and worlds without an app around the query.

use bevy::{
    app::{AppLabel, Main, MainSchedulePlugin, SubApp},
    ecs::{
        schedule::ScheduleLabel,
        system::{RunSystemOnce, SystemState},
    },
    math::bounding::Aabb3d,
    prelude::*,
};
use bevy_sightline::prelude::*;

use crate::common::*;

#[test]
fn two_apps_do_not_know_of_each_other() {
    let mut apps = [headless_app(), headless_app()];
    let cubes = [0, 1].map(|number| {
        let app = &mut apps[number];
        app.world_mut()
            .spawn((Camera3d::default(), Transform::from_xyz(0.0, 0.0, 10.0)));
        spawn_cube(app, Vec3::X * number as f32 * 5.0)
    });
    for _ in 0..3 {
        apps.iter_mut().for_each(settle);
    }
    let at = |app: &mut App, x: f32| hit_at(app, Vec3::X * x).map(|hit| hit.entity);
    let [one, other] = &mut apps;
    assert_eq!((at(one, 0.0), at(one, 5.0)), (Some(cubes[0]), None));
    assert_eq!((at(other, 0.0), at(other, 5.0)), (None, Some(cubes[1])));

    one.world_mut().despawn(cubes[0]);
    apps.iter_mut().for_each(App::update);
    let [one, other] = &mut apps;
    assert_eq!((at(one, 0.0), at(other, 5.0)), (None, Some(cubes[1])));
}

#[test]
fn a_sub_app_has_an_index_of_its_own() {
    #[derive(AppLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
    struct Simulation;

    let mut app = headless_app();
    let mut simulation = SubApp::new();
    simulation.update_schedule = Some(Main.intern());
    // As every App has it, and a SubApp has not.
    simulation.init_resource::<AppTypeRegistry>();
    simulation.add_plugins((MainSchedulePlugin, TransformPlugin, SightlinePlugins));
    simulation.finish();
    simulation.cleanup();
    let ball = PickShape::new(Sphere::new(1.0));
    let entity = simulation.world_mut().spawn(ball).id();
    app.insert_sub_app(Simulation, simulation);
    app.update();
    let cast = |scene: SceneQuery| {
        let ray = Ray3d::new(Vec3::Z * 10.0, Dir3::NEG_Z);
        scene
            .cast_ray(ray, &SceneQuerySettings::default())
            .map(|hit| hit.entity)
    };
    let of_simulation = app.sub_app_mut(Simulation).world_mut().run_system_once(cast);
    assert_eq!(of_simulation.expect("the plugins are there"), Some(entity));
    assert_eq!(
        app.world_mut().run_system_once(cast).expect("the plugins are there"),
        None
    );
}

#[test]
fn a_world_is_asked_without_a_system() {
    let mut app = headless_app();
    let cube = spawn_cube(&mut app, Vec3::ZERO);
    settle(&mut app);
    let mut state = SystemState::<SceneQuery>::new(app.world_mut());
    let scene = state.get(app.world()).expect("the plugin is there");
    let nearest = scene.nearest(Vec3::X * 3.0, &SceneQuerySettings::default());
    assert_eq!(nearest.map(|nearest| nearest.key), Some(cube));
}

#[test]
fn a_fresh_index_has_no_answers() {
    let mut app = headless_app();
    spawn_cube(&mut app, Vec3::ZERO);
    let everywhere = Aabb3d::new(Vec3::ZERO, Vec3::splat(1e6));
    query(&mut app, |scene| {
        let settings = SceneQuerySettings::default();
        let mut found = Vec::new();
        scene.overlap(&everywhere, &settings, &mut found);
        assert_eq!(found, []);
        assert_eq!(scene.nearest(Vec3::ZERO, &settings), None);
        assert!(scene.line_of_sight(Vec3::Z, Vec3::NEG_Z, &settings));
    });
    assert_eq!(hit_at(&mut app, Vec3::ZERO), None);
    assert!(index(&app).is_empty() && index(&app).bounds().is_none());
}
