//! What a ray cast visits and tests, told step by step.

use bevy::prelude::*;
use bevy_sightline::{
    geometry::ray::{Ray, triangle::Backfaces},
    index::EntityTest,
    mesh::{MeshBuildSettings, MeshBvh, TriangleMesh},
    prelude::*,
    spatial::TracedLeaf,
};
use rand::Rng;

use crate::common::*;

fn trace(app: &mut App, ray: Ray3d, settings: &SceneQuerySettings) -> RayTrace {
    query(app, |scene| {
        let trace = scene.trace_ray(ray, settings);
        assert_eq!(
            trace.hit,
            scene.cast_ray(ray, settings),
            "the answer is that of the cast"
        );
        trace
    })
}

/// Spheres of 320 triangles here and there, some with shapes of their own.
fn scattered(count: usize) -> App {
    let mut rng = rng(count as u64);
    let mut app = headless_app();
    let ball = add_mesh(&mut app, Sphere::new(1.0).mesh().ico(4).expect("not too fine"));
    for number in 0..count {
        let place = Transform::from_translation(random_point(&mut rng, 10.0))
            .with_rotation(random_rotation(&mut rng))
            .with_scale(Vec3::splat(rng.random_range(0.2..2.0)));
        let mut entity = app.world_mut().spawn((Mesh3d(ball.clone()), place));
        match number % 4 {
            0 => entity.insert(BoundedBy(BoundingKind::Sphere)),
            1 => entity.insert(HitSurface::Volume(BoundingKind::Obb)),
            _ => &mut entity,
        };
    }
    settle(&mut app);
    app
}

#[test]
fn a_trace_finds_what_the_cast_finds() {
    let mut rng = rng(1);
    for count in [0, 1, 200] {
        let mut app = scattered(count);
        let mut hits = 0;
        for _ in 0..300 {
            let ray = ray_towards(*random_dir(&mut rng) * 20.0, random_point(&mut rng, 10.0));
            let trace = trace(&mut app, ray, &SceneQuerySettings::default());
            hits += usize::from(trace.hit.is_some());
            assert_eq!(trace.hits().last(), trace.hit.as_ref());
            assert!(trace.hits().map(|hit| hit.distance).is_sorted_by(|a, b| a >= b));
            let visited = trace.tree.leaves().map(|leaf| (leaf.key, leaf.at));
            let told = trace.entities.iter().map(|entity| (entity.entity, entity.entered_at));
            assert!(visited.eq(told), "an account of every box that is entered");
        }
        assert!(count < 200 || hits > 100);
    }
}

#[test]
fn among_many_entities_few_boxes_and_triangles_are_tested() {
    let mut app = scattered(1000);
    let ray = ray_towards(Vec3::X * 30.0, Vec3::ZERO);
    let trace = trace(&mut app, ray, &SceneQuerySettings::default());
    assert!(trace.tree.boxes_tested() < 500);
    assert!((1..100).contains(&trace.entities_tested()));
    assert!(trace.triangles_tested() < 2000);
}

#[test]
fn what_is_tested_of_an_entity_is_told() {
    let mut app = headless_app();
    let ball = || Sphere::new(1.0).mesh().ico(4).expect("not too fine");
    let mesh = spawn_mesh(&mut app, ball(), Transform::IDENTITY);
    let bounded = spawn_mesh(&mut app, ball(), Transform::from_xyz(0.0, 0.0, -10.0));
    let volume = spawn_mesh(&mut app, ball(), Transform::from_xyz(0.0, 0.0, -20.0));
    let flat = spawn_mesh(
        &mut app,
        ball(),
        Transform::from_xyz(0.0, 0.0, -30.0).with_scale(Vec3::new(1.0, 1.0, 0.0)),
    );
    app.world_mut()
        .entity_mut(bounded)
        .insert(BoundedBy(BoundingKind::Sphere));
    let surface = HitSurface::Volume(BoundingKind::Sphere);
    app.world_mut().entity_mut(volume).insert(surface);
    settle(&mut app);

    // Through the corners of all boxes, past all that is inside.
    let ray = Ray3d::new(Vec3::new(0.9, 0.9, 50.0), Dir3::NEG_Z);
    let trace = trace(&mut app, ray, &SceneQuerySettings::default());
    let tests: Vec<(Entity, &EntityTest)> = (trace.entities.iter())
        .map(|entity| (entity.entity, &entity.test))
        .collect();
    assert_eq!(
        tests.iter().map(|(entity, _)| *entity).collect::<Vec<_>>(),
        [mesh, bounded, volume, flat]
    );
    assert!(matches!(tests[0].1, EntityTest::Hierarchy { .. }));
    assert!(matches!(tests[1].1, EntityTest::BoundingVolume));
    assert!(matches!(tests[2].1, EntityTest::Shape));
    assert!(matches!(tests[3].1, EntityTest::Triangles(_)));
    assert!(trace.entities.iter().all(|entity| entity.hit.is_none()));
}

#[test]
fn what_the_settings_refuse_is_not_tested() {
    let mut app = headless_app();
    let near = spawn_cube(&mut app, Vec3::ZERO);
    let far = spawn_cube(&mut app, Vec3::NEG_Z * 5.0);
    settle(&mut app);
    let ray = Ray3d::new(Vec3::new(0.1, 0.2, 10.0), Dir3::NEG_Z);
    let excluded = [near];
    let settings = SceneQuerySettings {
        excluded: &excluded,
        ..default()
    };
    let trace = trace(&mut app, ray, &settings);
    assert!(matches!(trace.entities[0].test, EntityTest::None));
    assert_eq!(trace.entities_tested(), 1);
    assert_eq!(trace.hit.map(|hit| hit.entity), Some(far));
}

#[test]
fn a_predicate_that_refuses_a_hit_leaves_it_in_the_trace() {
    let mut app = headless_app();
    let near = spawn_cube(&mut app, Vec3::ZERO);
    let far = spawn_cube(&mut app, Vec3::NEG_Z * 5.0);
    settle(&mut app);
    let not_near = |entity| entity != near;
    let settings = SceneQuerySettings {
        predicate: Some(&not_near),
        ..default()
    };
    let ray = Ray3d::new(Vec3::new(0.1, 0.2, 10.0), Dir3::NEG_Z);
    let trace = trace(&mut app, ray, &settings);
    let told: Vec<_> = (trace.entities.iter())
        .map(|entity| (entity.entity, entity.hit.is_some(), entity.is_nearest))
        .collect();
    assert_eq!(told, [(near, true, false), (far, true, true)]);
}

#[test]
fn a_ray_from_nowhere_has_no_way() {
    let mut app = scattered(20);
    let ray = Ray3d::new(Vec3::NAN, Dir3::X);
    let trace = trace(&mut app, ray, &SceneQuerySettings::default());
    assert!(trace.tree.steps.is_empty() && trace.entities.is_empty());
}

#[test]
fn a_trace_of_a_mesh_is_what_its_query_does() {
    let mut rng = rng(2);
    let meshes: [Mesh; 3] = [
        Torus::new(0.5, 1.0).into(),
        Sphere::new(1.0).mesh().ico(10).expect("not too fine"),
        Triangle3d::new(Vec3::X, Vec3::Y, Vec3::Z).into(),
    ];
    for mesh in meshes {
        let triangles = TriangleMesh::from_mesh(&mesh).expect("a usable mesh");
        let count = triangles.len();
        for compact in [false, true] {
            let settings = MeshBuildSettings { compact, ..default() };
            let bvh = MeshBvh::build_with(&triangles, &settings, None).expect("nothing calls it off");
            for _ in 0..200 {
                let ray = ray_towards(*random_dir(&mut rng) * 4.0, random_point(&mut rng, 1.0));
                let ray = Ray::from_ray3d(ray, f32::INFINITY).expect("a ray");
                let (hit, trace) = bvh.trace_closest_hit(&ray, Backfaces::Include);
                assert_eq!(hit, bvh.closest_hit(&ray, Backfaces::Include));
                let tested = trace.leaves().map(|leaf| leaf.key.len()).sum::<usize>();
                assert!(tested <= count);
                if let Some(hit) = hit {
                    let holds_it = |leaf: &TracedLeaf<Vec<u32>>| leaf.key.contains(&hit.triangle);
                    assert_eq!(trace.leaves().filter(|leaf| holds_it(leaf)).count(), 1);
                }
            }
        }
    }
}
