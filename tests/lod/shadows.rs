//! What casts shadows: the levels that are chosen from one place for all lights.

use bevy::{
    camera::{
        ShadowLodOrigin,
        visibility::{CascadesVisibleEntities, CubemapVisibleEntities, VisibleMeshEntities},
    },
    light::CascadeShadowConfigBuilder,
};

use super::*;

/// A lamp, a spot and a sun that all shine at the origin, and cast shadows.
struct Lights {
    lamp: Entity,
    spot: Entity,
    sun: Entity,
}

fn spawn_lights(app: &mut App) -> Lights {
    let place = Transform::from_xyz(0.0, 0.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y);
    let lamp = PointLight {
        shadow_maps_enabled: true,
        range: 1000.0,
        ..default()
    };
    let spot = SpotLight {
        shadow_maps_enabled: true,
        range: 1000.0,
        ..default()
    };
    let sun = DirectionalLight {
        shadow_maps_enabled: true,
        ..default()
    };
    let cascades = CascadeShadowConfigBuilder {
        num_cascades: 1,
        maximum_distance: 1000.0,
        ..default()
    };
    Lights {
        lamp: spawn(app, (lamp, place)),
        spot: spawn(app, (spot, place)),
        sun: spawn(app, (sun, cascades.build(), place)),
    }
}

/// All that casts a shadow in some map of a lamp.
fn of_lamp(app: &App, lamp: Entity) -> Vec<Entity> {
    let faces = app.world().get::<CubemapVisibleEntities>(lamp).expect("a lamp");
    let mut all: Vec<Entity> = (0..6).flat_map(|face| faces.get(face).entities.clone()).collect();
    all.sort_unstable();
    all.dedup();
    all
}

fn of_spot(app: &App, spot: Entity) -> Vec<Entity> {
    app.world()
        .get::<VisibleMeshEntities>(spot)
        .expect("a spot")
        .entities
        .clone()
}

fn of_sun(app: &App, sun: Entity, camera: Entity) -> Vec<Entity> {
    let views = app.world().get::<CascadesVisibleEntities>(sun).expect("a sun");
    let cascades = views.entities.get(&camera).into_iter().flatten();
    cascades.flat_map(|list| list.entities.clone()).collect()
}

/// The level that casts shadows for a camera, after a frame: exactly one, the same for all lights.
#[track_caller]
fn cast_for(app: &App, lights: &Lights, camera: Entity, statue: &Statue) -> usize {
    let listed = of_sun(app, lights.sun, camera);
    let cast: Vec<usize> = (0..statue.levels.len())
        .filter(|&level| listed.contains(&statue.levels[level]))
        .collect();
    assert_eq!(cast.len(), 1, "exactly one level casts shadows, and not {cast:?}");
    cast[0]
}

/// The level that casts shadows for lamps and spots.
#[track_caller]
fn cast_by_lamps(app: &App, lights: &Lights, statue: &Statue) -> usize {
    let listed = of_lamp(app, lights.lamp);
    assert_eq!(of_spot(app, lights.spot), listed);
    let cast: Vec<usize> = (0..statue.levels.len())
        .filter(|&level| listed.contains(&statue.levels[level]))
        .collect();
    assert_eq!(cast.len(), 1, "exactly one level casts shadows, and not {cast:?}");
    cast[0]
}

#[test]
fn shadows_are_of_what_the_camera_shows() {
    let mut app = app();
    let lights = spawn_lights(&mut app);
    let (camera, statue) = (spawn_camera(&mut app, 5.0), spawn_statue_by_distance(&mut app));
    for (distance, level) in [(5.0, 0), (15.0, 1), (50.0, 2), (20.5, 2), (10.5, 1), (5.0, 0)] {
        assert_eq!(look_from(&mut app, camera, distance, &statue), level);
        assert_eq!(cast_for(&app, &lights, camera, &statue), level);
        assert_eq!(cast_by_lamps(&app, &lights, &statue), level);
    }
}

#[test]
fn a_bias_takes_coarser_levels_for_shadows_alone() {
    let mut app = app();
    let lights = spawn_lights(&mut app);
    let (camera, statue) = (spawn_camera(&mut app, 5.0), spawn_statue_by_distance(&mut app));
    settings(&mut app).shadow_bias = 0.4;
    for (distance, level, shadow) in [
        (3.0, 0, 0),
        (5.0, 0, 1),
        (9.0, 0, 2),
        (15.0, 1, 2),
        (50.0, 2, 2),
        (6.0, 0, 1),
    ] {
        assert_eq!(look_from(&mut app, camera, distance, &statue), level);
        assert_eq!(cast_for(&app, &lights, camera, &statue), shadow, "from {distance} m");
        assert_eq!(cast_by_lamps(&app, &lights, &statue), shadow);
    }
    settings(&mut app).shadow_bias = 1.0;
    assert_eq!(look_from(&mut app, camera, 9.0, &statue), 0);
    assert_eq!(cast_for(&app, &lights, camera, &statue), 0);
    assert_eq!(cast_by_lamps(&app, &lights, &statue), 0);
}

#[test]
fn suns_cast_for_each_camera_what_it_shows_and_lamps_from_one_origin() {
    let mut app = app();
    let lights = spawn_lights(&mut app);
    let statue = spawn_statue_by_distance(&mut app);
    let (near, far) = (spawn_camera(&mut app, 5.0), spawn_camera(&mut app, 50.0));
    app.update();
    assert_eq!(cast_for(&app, &lights, near, &statue), 0);
    assert_eq!(cast_for(&app, &lights, far, &statue), 2);
    let first = near.min(far);
    assert_eq!(cast_by_lamps(&app, &lights, &statue), shown(&app, first, &statue));
    insert(&mut app, far, ShadowLodOrigin);
    app.update();
    assert_eq!(cast_by_lamps(&app, &lights, &statue), 2);
    remove::<ShadowLodOrigin>(&mut app, far);
    insert(&mut app, near, ShadowLodOrigin);
    app.update();
    assert_eq!(cast_by_lamps(&app, &lights, &statue), 0);
}

#[test]
fn the_origin_of_shadows_need_not_be_a_camera() {
    let mut app = app();
    let lights = spawn_lights(&mut app);
    let (camera, statue) = (spawn_camera(&mut app, 5.0), spawn_statue_by_distance(&mut app));
    let origin = spawn(&mut app, (ShadowLodOrigin, at_distance(15.0)));
    assert_eq!(look(&mut app, camera, &statue), 0);
    assert_eq!(cast_by_lamps(&app, &lights, &statue), 1);
    insert(&mut app, origin, at_distance(50.0));
    assert_eq!(look(&mut app, camera, &statue), 0);
    assert_eq!(cast_by_lamps(&app, &lights, &statue), 2);
    assert_eq!(cast_for(&app, &lights, camera, &statue), 0);
    despawn(&mut app, origin);
    app.update();
    assert_eq!(cast_by_lamps(&app, &lights, &statue), 0);
}

#[test]
fn what_is_not_shown_casts_no_shadow() {
    let mut app = app();
    let lights = spawn_lights(&mut app);
    let camera = spawn_camera(&mut app, 5.0);
    let statue = spawn_statue(&mut app, 1, |levels| {
        ProxyLod::new(LodMetric::Distance, levels[0]).then_nothing(10.0)
    });
    assert_eq!(look(&mut app, camera, &statue), 0);
    assert_eq!(cast_by_lamps(&app, &lights, &statue), 0);
    insert(&mut app, camera, at_distance(50.0));
    app.update();
    assert_eq!(of_lamp(&app, lights.lamp), []);
    assert_eq!(of_spot(&app, lights.spot), []);
    assert_eq!(of_sun(&app, lights.sun, camera), []);
    let mark = app.world().get::<ViewVisibility>(statue.levels[0]).unwrap();
    assert!(!mark.get());
}

#[test]
fn swapped_meshes_cast_no_shadow_when_nothing_is_shown() {
    let mut app = app();
    let lights = spawn_lights(&mut app);
    let camera = spawn_camera(&mut app, 5.0);
    let mesh = add_mesh(&mut app, Cuboid::default());
    let lod = ProxyLod::new(LodMetric::Distance, mesh.clone()).then_nothing(10.0);
    let root = spawn(&mut app, (Mesh3d(mesh), lod));
    // Lamps look from where no levels are chosen.
    let idle = spawn_camera(&mut app, 5.0);
    insert(&mut app, idle, ShadowLodOrigin);
    app.world_mut().get_mut::<Camera>(idle).unwrap().is_active = false;
    for (distance, expected) in [(5.0, vec![root]), (50.0, vec![]), (5.0, vec![root]), (50.0, vec![])] {
        insert(&mut app, camera, at_distance(distance));
        app.update();
        assert_eq!(of_sun(&app, lights.sun, camera), expected);
        assert_eq!(of_lamp(&app, lights.lamp), expected);
        assert_eq!(of_spot(&app, lights.spot), expected);
    }
}

#[test]
fn blocks_cast_the_shadow_of_what_stands_for_them() {
    let mut app = app();
    let lights = spawn_lights(&mut app);
    let camera = spawn_camera(&mut app, 5.0);
    let inner = spawn_statue_by_distance(&mut app);
    let proxy = spawn_cube(&mut app, Vec3::ZERO);
    let root = spawn(&mut app, (Transform::default(), Visibility::default()));
    insert(&mut app, root, lod(LodMetric::Distance, &[inner.root, proxy], &[30.0]));
    settings(&mut app).shadow_bias = 0.5;
    for (distance, expected) in [
        (4.0, inner.levels[0]),
        (8.0, inner.levels[1]),
        (14.0, inner.levels[2]),
        (25.0, proxy),
    ] {
        insert(&mut app, camera, at_distance(distance));
        app.update();
        assert_eq!(of_sun(&app, lights.sun, camera), [expected]);
        assert_eq!(of_lamp(&app, lights.lamp), [expected]);
        assert_eq!(of_spot(&app, lights.spot), [expected]);
    }
}
