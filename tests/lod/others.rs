//! Levels of detail beside what else decides what is seen and hit.

use bevy::camera::{
    primitives::Aabb,
    visibility::{NoCpuCulling, NoFrustumCulling, RenderLayers, VisibilityRange},
};

use super::*;

#[test]
fn visibility_ranges_in_the_same_scene_go_on_working() {
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 5.0), spawn_statue_by_distance(&mut app));
    let [near, far] = [
        VisibilityRange::abrupt(0.0, 12.0),
        VisibilityRange::abrupt(12.0, 1000.0),
    ]
    .map(|range| {
        let cube = spawn_cube(&mut app, Vec3::ZERO);
        insert(&mut app, cube, range);
        cube
    });
    for (distance, level, is_near) in [
        (5.0, 0, true),
        (11.2, 1, true),
        (15.0, 1, false),
        (50.0, 2, false),
        (5.0, 0, true),
    ] {
        assert_eq!(look_from(&mut app, camera, distance, &statue), level);
        assert_eq!(
            (sees(&app, camera, near), sees(&app, camera, far)),
            (is_near, !is_near),
            "from {distance} m"
        );
    }
}

#[test]
fn a_level_with_a_range_is_seen_where_both_allow_it() {
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 5.0), spawn_statue_by_distance(&mut app));
    insert(&mut app, statue.levels[1], VisibilityRange::abrupt(0.0, 15.5));
    for (distance, expected) in [
        (5.0, vec![0]),
        (12.0, vec![1]),
        (17.0, vec![]),
        (12.0, vec![1]),
        (50.0, vec![2]),
    ] {
        insert(&mut app, camera, at_distance(distance));
        app.update();
        let expected: Vec<Entity> = expected.into_iter().map(|level: usize| statue.levels[level]).collect();
        assert_eq!(listed(&app, camera), expected, "from {distance} m");
    }
}

#[test]
fn what_is_left_out_of_the_index_or_of_culling_has_levels_too() {
    for decorate in [
        |app: &mut App, level: Entity| insert(app, level, NoSpatialIndex),
        |app: &mut App, level: Entity| insert(app, level, NoFrustumCulling),
        |app: &mut App, level: Entity| insert(app, level, NoOcclusionCulling),
        |app: &mut App, level: Entity| insert(app, level, RenderLayers::from_layers(&[0, 5])),
        |app: &mut App, level: Entity| insert(app, level, RenderLayers::from_layers(&[0, 50])),
    ] {
        let mut app = app();
        let (camera, statue) = (spawn_camera(&mut app, 5.0), spawn_statue_by_distance(&mut app));
        app.update();
        for &level in &statue.levels {
            decorate(&mut app, level);
        }
        for (distance, level) in [(5.0, 0), (15.0, 1), (50.0, 2), (5.0, 0)] {
            assert_eq!(look_from(&mut app, camera, distance, &statue), level);
        }
        insert(&mut app, statue.root, Transform::from_xyz(0.0, 0.0, -10.0));
        assert_eq!(look(&mut app, camera, &statue), 1);
    }
}

#[test]
fn layers_hide_what_is_on_none_of_those_of_the_camera() {
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 15.0), spawn_statue_by_distance(&mut app));
    insert(&mut app, statue.levels[1], RenderLayers::layer(3));
    app.update();
    assert_eq!(listed(&app, camera), []);
    insert(&mut app, camera, RenderLayers::from_layers(&[0, 3]));
    assert_eq!(look(&mut app, camera, &statue), 1);
}

#[test]
fn a_camera_that_sees_everywhere_shows_one_level() {
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 5.0), spawn_statue_by_distance(&mut app));
    insert(&mut app, camera, NoCpuCulling);
    for (distance, level) in [(5.0, 0), (15.0, 1), (50.0, 2)] {
        assert_eq!(look_from(&mut app, camera, distance, &statue), level);
    }
}

#[test]
fn where_bevy_culls_exactly_one_level_is_shown_as_well() {
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 15.0), spawn_statue_by_distance(&mut app));
    for is_enabled in [false, true, false, true] {
        app.world_mut().resource_mut::<ViewCullingSettings>().enabled = is_enabled;
        for (distance, level) in [(5.0, 0), (15.0, 1), (50.0, 2)] {
            insert(&mut app, camera, at_distance(distance));
            app.update();
            let lists = app.world().get::<VisibleEntities>(camera).unwrap();
            assert_eq!(
                lists.get(TypeId::of::<Mesh3d>()),
                [statue.levels[level]],
                "culled by us: {is_enabled}"
            );
        }
    }
}

/// A camera that does not see what is hidden, 10 m before a wall of three levels, of which each hides more than the
/// last, and a cube behind it.
fn before_a_wall(app: &mut App, occluding: usize) -> (Entity, Statue, Entity) {
    let camera = spawn_camera(app, 5.0);
    insert(app, camera, SoftwareOcclusion::default());
    let wall = spawn_statue_by_distance(app);
    let mesh = add_mesh(app, Cuboid::new(20.0, 20.0, 1.0));
    insert(app, wall.levels[occluding], (Mesh3d(mesh), Occluder::Box));
    (camera, wall, spawn_cube(app, Vec3::new(0.0, 0.0, -5.0)))
}

#[test]
fn an_occluder_of_a_level_that_is_not_shown_hides_nothing() {
    for occluding in 0..3 {
        let mut app = app();
        let (camera, wall, behind) = before_a_wall(&mut app, occluding);
        for (distance, level) in [(5.0, 0), (15.0, 1), (50.0, 2), (15.0, 1), (5.0, 0), (50.0, 2)] {
            assert_eq!(look_from(&mut app, camera, distance, &wall), level);
            assert_eq!(sees(&app, camera, behind), level != occluding, "{occluding} of {level}");
        }
        // Without anything that moves but the settings.
        settings(&mut app).bias = 20.0;
        assert_eq!(look(&mut app, camera, &wall), 0);
        assert_eq!(sees(&app, camera, behind), occluding != 0);
        settings(&mut app).bias = 1.0;
        assert_eq!(look(&mut app, camera, &wall), 2);
        assert_eq!(sees(&app, camera, behind), occluding != 2);
    }
}

#[test]
fn a_level_that_is_hidden_is_not_replaced_by_another() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 5.0);
    insert(&mut app, camera, SoftwareOcclusion::default());
    let wall = spawn_mesh(&mut app, Cuboid::new(30.0, 30.0, 1.0), Transform::default());
    insert(&mut app, wall, Occluder::Box);
    let statue = spawn_statue_by_distance(&mut app);
    insert(&mut app, statue.root, Transform::from_xyz(0.0, 0.0, -5.0));
    for distance in [1.0, 8.0, 30.0] {
        insert(&mut app, camera, at_distance(distance));
        app.update();
        assert_eq!(listed(&app, camera), [wall]);
    }
}

/// The entities that a ray hits, near to far, that comes from far away along -z.
fn hits(app: &mut App, settings: SceneQuerySettings<'static>) -> Vec<Entity> {
    finish_meshes(app);
    query(app, move |scene| {
        let mut hits = Vec::new();
        scene.cast_ray_all(Ray3d::new(Vec3::Z * 100.0, Dir3::NEG_Z), &settings, &mut hits);
        hits.into_iter().map(|hit| hit.entity).collect()
    })
}

#[test]
fn rays_hit_the_finest_level_whichever_is_shown() {
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 5.0), spawn_statue_by_distance(&mut app));
    for distance in [5.0, 15.0, 50.0] {
        look_from(&mut app, camera, distance, &statue);
        for visibility in [
            QueryVisibility::Any,
            QueryVisibility::Visible,
            QueryVisibility::VisibleInView,
        ] {
            let settings = SceneQuerySettings::default().with_visibility(visibility);
            assert_eq!(
                hits(&mut app, settings),
                [statue.levels[0]],
                "{visibility:?} from {distance} m"
            );
        }
    }
}

#[test]
fn boxes_find_the_finest_level_alone() {
    let mut app = app();
    let (camera, statue) = (spawn_camera(&mut app, 50.0), spawn_statue_by_distance(&mut app));
    look(&mut app, camera, &statue);
    let found = query(&mut app, |scene| {
        let settings = SceneQuerySettings::default();
        let (mut found, mut near) = (Vec::new(), Vec::new());
        scene.overlap(
            &bevy::math::bounding::BoundingSphere::new(Vec3::ZERO, 3.0),
            &settings,
            &mut found,
        );
        scene.k_nearest(Vec3::ONE, 5, &settings, &mut near);
        found.extend(near.into_iter().map(|neighbour| neighbour.key));
        found.extend(scene.nearest(Vec3::ONE, &settings).map(|neighbour| neighbour.key));
        found
    });
    assert_eq!(found, [statue.levels[0]; 3]);
}

#[test]
fn on_request_rays_hit_what_is_shown() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 5.0);
    let statue = spawn_statue(&mut app, 3, |levels| by_distance(levels).hit_as(LodHits::Shown));
    for (distance, level) in [(5.0, 0), (15.0, 1), (50.0, 2)] {
        look_from(&mut app, camera, distance, &statue);
        let settings = SceneQuerySettings::default().with_visibility(QueryVisibility::VisibleInView);
        assert_eq!(hits(&mut app, settings), [statue.levels[level]]);
    }
    app.world_mut().get_mut::<ProxyLod>(statue.root).unwrap().hits = LodHits::Finest;
    app.update();
    assert_eq!(hits(&mut app, SceneQuerySettings::default()), [statue.levels[0]]);
}

#[test]
fn swapped_meshes_are_hit_as_the_finest() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 50.0);
    let (fine, coarse) = (
        add_mesh(&mut app, Cuboid::default()),
        add_mesh(&mut app, Cuboid::new(1.0, 1.0, 9.0)),
    );
    let lod = ProxyLod::new(LodMetric::Distance, fine.clone()).then(10.0, coarse);
    let root = spawn(&mut app, (Mesh3d(fine), lod.clone()));
    app.update();
    app.update();
    let depth = |app: &mut App| {
        finish_meshes(app);
        cast(app, Ray3d::new(Vec3::Z * 100.0, Dir3::NEG_Z))
            .expect("a hit")
            .position
            .z
    };
    assert_eq!(choices(&app).level(root, camera), Some(1));
    assert_eq!(depth(&mut app), 0.5);
    insert(&mut app, root, lod.hit_as(LodHits::Shown));
    app.update();
    app.update();
    assert_eq!(depth(&mut app), 4.5);
}

#[test]
fn a_group_is_found_by_what_belongs_to_it() {
    let mut app = app();
    let (_, statue) = (spawn_camera(&mut app, 5.0), spawn_statue_by_distance(&mut app));
    let stone = spawn_cube(&mut app, Vec3::X);
    app.update();
    for (level, &entity) in statue.levels.iter().enumerate() {
        let (root, levels) = choices(&app).group_of(entity).expect("it is listed");
        assert_eq!((root, levels.collect::<Vec<_>>()), (statue.root, vec![level]));
    }
    assert!(choices(&app).group_of(stone).is_none() && choices(&app).group_of(statue.root).is_none());
    let camera = spawn_camera(&mut app, 500.0);
    app.update();
    assert!(choices(&app).shows(camera, stone));
}

#[test]
fn bounds_of_what_has_none_are_asked_for_when_it_has() {
    let mut app = app();
    let camera = spawn_camera(&mut app, 15.0);
    let [fine, coarse] = [(); 2].map(|()| spawn(&mut app, (Transform::default(), Visibility::default())));
    let root = spawn(&mut app, Transform::default());
    insert(&mut app, root, lod(LodMetric::Distance, &[fine, coarse], &[10.0]));
    app.update();
    assert_eq!(choices(&app).level(root, camera), Some(0));
    insert(&mut app, fine, Aabb::from_min_max(Vec3::splat(-0.5), Vec3::splat(0.5)));
    app.update();
    assert_eq!(choices(&app).level(root, camera), Some(1));
}
