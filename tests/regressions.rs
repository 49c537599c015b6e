//! Bugs that were, each as the shortest test that failed for it.

use bevy::{
    asset::RenderAssetUsages,
    math::{
        Affine3A, DVec3, Vec3A,
        bounding::{Aabb3d, BoundingSphere},
    },
    mesh::{PrimitiveTopology, morph::MeshMorphWeights, skinning::SkinnedMesh},
    prelude::*,
};
use bevy_sightline::{
    geometry::{
        convex_hull::ConvexHull,
        intersection::{Contains, Intersects},
        obb::Obb,
        ray::{
            Ray,
            triangle::{Backfaces, TriangleRay},
        },
        support::Support,
        volume::Volume,
    },
    index::{MeshBvhs, PosedMeshes, SyncStats},
    mesh::{MeshBvh, PlacedMesh, TriangleMesh},
    prelude::*,
    spatial::{AabbTree, SpatialUpdates},
};
use rand::Rng;

use crate::{
    common::{add_mesh, cast, headless_app, query, random_dir, random_point, random_rotation, rng, settle},
    skinned_picking::rig::{move_joint, spawn_rig, square, with_one_joint},
};

#[test]
fn a_ray_in_the_plane_of_the_upper_face_of_a_box_hits_it() {
    let unit = Aabb3d::new(Vec3A::ZERO, Vec3A::ONE);
    let ray = Ray::new(Vec3A::new(5.0, 1.0, 1.0), Vec3A::NEG_X, f32::INFINITY).expect("a sound ray");
    assert!(ray.aabb_intersection_at(&unit).is_some());
}

#[test]
fn a_ray_that_starts_a_centimetre_before_a_wall_far_from_the_origin_gets_the_exact_distance() {
    let mut app = headless_app();
    let wall = add_mesh(&mut app, Cuboid::new(9.0, 9.0, 9.0));
    let turned = Quat::from_rotation_y(0.7);
    let center = Vec3::new(457.0, 2.0, 235.0);
    app.world_mut()
        .spawn((Mesh3d(wall), Transform::from_translation(center).with_rotation(turned)));
    app.update();

    let normal = turned * Vec3::X;
    let origin = center + normal * 4.51;
    let exact = (origin.as_dvec3() - center.as_dvec3()).dot(normal.as_dvec3()) - 4.5;
    let ray = Ray3d::new(origin, Dir3::new(-normal).expect("a unit vector"));
    let hit = query(&mut app, |scene| scene.cast_ray(ray, &SceneQuerySettings::default())).expect("a wall");
    assert!(
        (f64::from(hit.distance) / exact - 1.0).abs() < 1e-4,
        "{} is not {exact}",
        hit.distance
    );
}

#[test]
fn a_ray_along_a_triangle_hits_it_within_its_extent() {
    let mut rng = rng(30);
    let mut hits = 0;
    for _ in 0..200 {
        let mut app = headless_app();
        let plane = add_mesh(&mut app, Plane3d::default().mesh().size(2.0, 2.0));
        let place = Transform::from_translation(random_point(&mut rng, 100.0)).with_rotation(random_rotation(&mut rng));
        app.world_mut().spawn((Mesh3d(plane), place));
        app.update();
        for _ in 0..50 {
            let target = place * Vec3::new(rng.random_range(-1.0..1.0), 0.0, rng.random_range(-1.0..1.0));
            let along = place.rotation * Vec3::new(1.0, rng.random_range(-1e-6..1e-6), 0.3).normalize();
            let ray = Ray3d::new(target - along * 20.0, Dir3::new(along).expect("a unit vector"));
            let settings = SceneQuerySettings::default().with_backfaces(Backfaces::Include);
            if let Some(hit) = query(&mut app, |scene| scene.cast_ray(ray, &settings)) {
                hits += 1;
                let from_center = hit.position.distance(place.translation);
                assert!(from_center < 1.5, "{from_center} m from the centre of a plane of 2 m");
            }
        }
    }
    assert!(hits > 100, "only {hits} hits");
}

#[test]
fn of_twins_in_one_place_the_smaller_entity_is_hit_and_both_are_listed() {
    let mut rng = rng(31);
    for _ in 0..50 {
        let mut app = headless_app();
        let ball = add_mesh(&mut app, Sphere::default().mesh().ico(2).expect("few triangles"));
        let place = Transform::from_translation(random_point(&mut rng, 50.0)).with_rotation(random_rotation(&mut rng));
        let twins = [0; 3].map(|_| app.world_mut().spawn((Mesh3d(ball.clone()), place)).id());
        let smallest = twins.into_iter().min().expect("three");
        app.update();
        for _ in 0..50 {
            let direction = random_dir(&mut rng);
            let ray = Ray3d::new(
                place.translation - direction * 7.0 + random_point(&mut rng, 0.2),
                direction,
            );
            let mut all = Vec::new();
            let (nearest, any_blocks) = query(&mut app, |scene| {
                let settings = SceneQuerySettings::default();
                scene.cast_ray_until(ray, &settings, |_| true, &mut all);
                (scene.cast_ray(ray, &settings), scene.any_hit(ray, &settings))
            });
            assert_eq!(nearest.map(|hit| hit.entity), Some(smallest));
            assert_eq!(all.first().copied(), nearest);
            assert_eq!(all.len(), 3, "all three are hit at one distance");
            assert!(any_blocks);
        }
    }
}

#[test]
fn coordinates_at_the_end_of_the_range_of_floats_are_built_into_trees() {
    let far = Vec3A::X * 2e38;
    let boxes = (0..20_u32).map(|key| {
        let center = if key % 3 == 0 { far } else { Vec3A::splat(key as f32) };
        (key, Aabb3d::new(center, Vec3A::ONE))
    });
    let mut tree = AabbTree::default();
    assert!(tree.insert_many(boxes).iter().all(Result::is_ok));
    assert_eq!(tree.validate(), Ok(()));

    let mut mesh = Mesh::from(Sphere::default());
    if let Some(bevy::mesh::VertexAttributeValues::Float32x3(positions)) = mesh.attribute_mut(Mesh::ATTRIBUTE_POSITION)
    {
        positions[0] = [2e38, 0.0, 0.0];
        positions[7] = [-3e38, 3e38, 0.0];
    }
    let triangles = TriangleMesh::from_mesh(&mesh).expect("finite positions");
    assert_eq!(MeshBvh::build(&triangles).mesh().len(), triangles.len());
}

#[test]
fn a_mesh_that_is_scaled_almost_flat_is_hit_as_a_flat_one_is() {
    for scale in [0.0, 1e-45, 1e-40, 1e-38, 1e-37, 1e-30, 1e-20, 1e-10] {
        let mut app = headless_app();
        let ball = add_mesh(&mut app, Sphere::default());
        app.world_mut()
            .spawn((Mesh3d(ball), Transform::from_scale(Vec3::new(1.0, 1.0, scale))));
        app.update();
        let ray = Ray3d::new(Vec3::new(0.1, 0.1, 100.0), Dir3::NEG_Z);
        let hit = query(&mut app, |scene| scene.cast_ray(ray, &SceneQuerySettings::default()));
        assert!(
            hit.is_some_and(|hit| (hit.distance - 100.0).abs() < 1e-3),
            "scale {scale}: {hit:?}"
        );
    }
}

#[test]
fn mesh_assets_without_their_messages_do_no_harm() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, SightlinePlugins))
        .init_resource::<Assets<Mesh>>();
    app.update();
    assert!(app.world().resource::<SpatialIndex>().is_empty());
}

#[cfg(feature = "sprite")]
#[test]
fn image_assets_without_their_messages_do_no_harm() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, SightlinePlugins))
        .init_resource::<Assets<Image>>()
        .init_resource::<Assets<TextureAtlasLayout>>();
    app.update();
    assert!(app.world().resource::<SpatialIndex>().is_empty());
}

#[test]
fn a_ray_too_slow_to_arrive_hits_no_triangle_at_infinity() {
    let ray = Ray::new(Vec3A::ZERO, Vec3A::Z * 2e-38, f32::INFINITY).expect("a sound ray");
    let triangle = [
        Vec3A::new(-1.0, -1.0, 100.0),
        Vec3A::new(1.0, -1.0, 100.0),
        Vec3A::new(0.0, 1.0, 100.0),
    ];
    let hit = TriangleRay::new(&ray).triangle_intersection(triangle, f32::INFINITY, Backfaces::Include);
    assert_eq!(hit, None);
}

#[test]
fn a_ray_that_begins_inside_a_box_after_its_origin_enters_it_there() {
    let unit = Aabb3d::new(Vec3A::ZERO, Vec3A::ONE);
    let ray = Ray::new(Vec3A::ZERO, Vec3A::X, f32::INFINITY).expect("a sound ray");
    assert_eq!(ray.with_interval(0.3, 9.0).aabb_intersection_at(&unit), Some(0.3));
}

#[test]
fn a_grown_hull_is_not_contained_in_what_contains_its_corners() {
    let corners = [Vec3A::ZERO, Vec3A::X, Vec3A::Y, Vec3A::Z];
    let hull = ConvexHull::enclosing(corners).expect("finite");
    let grown = hull.grown(1.0);
    let around_corners = Aabb3d::new(Vec3A::splat(0.5), Vec3A::splat(0.6));
    assert!(around_corners.contains(&hull));
    assert!(!around_corners.contains(&grown) && !hull.contains(&grown));
    assert!(Aabb3d::new(Vec3A::splat(0.5), Vec3A::splat(1.6)).contains(&grown));
}

#[test]
fn an_empty_member_does_not_make_a_group_endless() {
    let mut group = SurfaceGroup::new();
    group.push(SurfaceGroup::new());
    assert!(group.is_empty() && group.aabb().is_none());
    group.push(bevy::math::primitives::Sphere::new(1.0));
    group.push(SurfaceGroup::new());
    assert_eq!(group.aabb(), Some(Aabb3d::new(Vec3A::ZERO, Vec3A::ONE)));
}

#[test]
fn a_volume_without_end_touches_everything() {
    let corners = [Vec3A::NEG_ONE, Vec3A::ONE, Vec3A::X];
    let overflow = Affine3A::from_scale(Vec3::splat(f32::INFINITY));
    let sphere = BoundingSphere::enclosing(corners)
        .expect("finite")
        .transformed_by_affine(&overflow);
    let aabb = Aabb3d::enclosing(corners)
        .expect("finite")
        .transformed_by_affine(&overflow);
    let obb = Obb::enclosing(corners)
        .expect("finite")
        .transformed_by_affine(&overflow);
    let hull = ConvexHull::enclosing(corners)
        .expect("finite")
        .transformed_by_affine(&overflow);
    let triangle = Triangle3d::new(Vec3::splat(5.0), Vec3::new(6.0, 5.0, 5.0), Vec3::new(5.0, 6.0, 5.0));
    let small = Aabb3d::new(Vec3A::splat(9.0), Vec3A::ONE);
    let turned = Obb::new(Vec3A::splat(9.0), Vec3A::ONE, Quat::from_rotation_y(0.3)).expect("a sound box");
    assert!(sphere.intersects(&Vec3A::ONE) && sphere.intersects(&small) && sphere.intersects(&turned));
    assert!(aabb.intersects(&small) && aabb.intersects(&turned) && aabb.intersects(&triangle));
    assert!(obb.intersects(&small) && obb.intersects(&turned) && obb.intersects(&triangle));
    assert!(hull.intersects(&small) && hull.intersects(&turned) && hull.intersects(&triangle));
}

#[test]
fn a_direction_that_has_no_reciprocal_is_refused() {
    assert_eq!(Ray::new(Vec3A::ZERO, Vec3A::X * 1e-40, f32::INFINITY), None);
    assert_eq!(Ray::segment(Vec3::ZERO, Vec3::new(1e-40, 1e-41, 0.0)), None);
    let ray = Ray::new(Vec3A::ZERO, Vec3A::new(1.0, 1e-40, 0.0), f32::INFINITY).expect("a sound ray");
    assert_eq!(ray.direction(), Vec3A::X);
}

#[test]
fn a_sphere_has_a_farthest_point_along_directions_of_any_length() {
    let sphere = BoundingSphere::new(Vec3A::X, 2.0);
    for length in [1e-300, 1e-170, 1.0, 1e200] {
        assert_eq!(sphere.support_point(DVec3::X * length), DVec3::X * 3.0);
    }
}

#[test]
fn a_tiny_mesh_touches_a_huge_one_whichever_is_asked() {
    let triangle = |corners: [[f32; 3]; 3]| {
        let mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
        let mesh = mesh.with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners.to_vec());
        MeshBvh::build(&TriangleMesh::from_mesh(&mesh).expect("one triangle"))
    };
    let upright = triangle([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]]);
    let lying = triangle([[-1e3, 0.0, -1e3], [1e3, 0.0, -1e3], [0.0, 0.0, 1e3]]);
    let big = PlacedMesh::new(&lying, Affine3A::IDENTITY);
    for scale in [1e-20, 1e-30, 1e-33, 1e-36, 1e-38] {
        let small = PlacedMesh::new(&upright, Affine3A::from_scale(Vec3::splat(scale)));
        assert!(small.intersects(&big) && big.intersects(&small), "{scale:e}");
    }
}

/// What a ray from high above hits.
fn from_above(app: &mut App, x: f32) -> Option<Entity> {
    let ray = Ray3d::new(Vec3::new(x, 100.0, 0.1), Dir3::NEG_Y);
    cast(app, ray).map(|hit| hit.entity)
}

/// The entity is at x = 30, and its joint at the origin.
#[test]
fn a_shape_that_replaces_a_skin_while_a_joint_moves_is_where_the_entity_is() {
    let mut app = headless_app();
    let rig = spawn_rig(&mut app, with_one_joint(square()), &[Transform::default()]);
    settle(&mut app);
    move_joint(&mut app, rig.joints[0], Transform::from_xyz(5.0, 0.0, 0.0));
    app.world_mut()
        .entity_mut(rig.entity)
        .insert(PickShape::new(Cuboid::default()));
    app.update();
    assert_eq!(
        (from_above(&mut app, 30.1), from_above(&mut app, 5.1)),
        (Some(rig.entity), None)
    );
}

#[test]
fn a_skin_that_is_given_to_an_entity_that_moves_is_where_its_joints_are() {
    let mut app = headless_app();
    let rig = spawn_rig(&mut app, with_one_joint(square()), &[Transform::default()]);
    let skin = app.world().get::<SkinnedMesh>(rig.entity).expect("a skin").clone();
    app.world_mut().entity_mut(rig.entity).remove::<SkinnedMesh>();
    settle(&mut app);
    app.world_mut()
        .entity_mut(rig.entity)
        .insert((skin, Transform::from_xyz(31.0, 0.0, 0.0)));
    app.update();
    assert_eq!(
        (from_above(&mut app, 0.1), from_above(&mut app, 31.1)),
        (Some(rig.entity), None)
    );
}

#[test]
fn what_poses_and_meshes_are_is_not_marked_as_changed_by_moves_and_idle_frames() {
    let mut app = headless_app();
    let mesh = add_mesh(&mut app, Cuboid::default());
    let cube = app.world_mut().spawn((Mesh3d(mesh), Transform::default())).id();
    settle(&mut app);
    let mut last = app.world_mut().change_tick();
    for step in 0..3 {
        app.world_mut()
            .entity_mut(cube)
            .insert(Transform::from_xyz(step as f32, 0.0, 0.0));
        app.update();
        let world = app.world();
        let this = world.read_change_tick();
        let changed = |ticks: Option<bevy::ecs::change_detection::ComponentTicks>| {
            ticks.expect("a resource").is_changed(last, this)
        };
        assert!(!changed(world.get_resource_change_ticks::<MeshBvhs>()));
        assert!(!changed(world.get_resource_change_ticks::<PosedMeshes>()));
        last = this;
    }
}

#[test]
fn a_morph_weight_that_stays_nan_is_no_news_in_an_idle_frame() {
    let mut app = headless_app();
    let mut rng = rng(7);
    let mesh = add_mesh(
        &mut app,
        crate::skinned_picking::rig::with_random_targets(square(), &mut rng, 2),
    );
    let weights = vec![f32::NAN, 0.5];
    app.world_mut()
        .spawn((Mesh3d(mesh), MeshMorphWeights::Value { weights }, Transform::default()));
    settle(&mut app);
    app.update();
    let stats = app.world().resource::<SyncStats>();
    assert_eq!((stats.posed, stats.reconciled), (0, 0));
}

#[test]
fn rays_hit_the_mesh_that_was_swapped_in_in_the_frame_that_shows_it() {
    let mut app = headless_app();
    let (near, far) = (
        add_mesh(&mut app, Cuboid::default()),
        add_mesh(&mut app, Cuboid::new(1.0, 1.0, 9.0)),
    );
    let lod = ProxyLod::new(LodMetric::Distance, near.clone())
        .then(20.0, far)
        .hit_as(LodHits::Shown);
    app.world_mut().spawn((Mesh3d(near), Transform::default(), lod));
    let camera = app
        .world_mut()
        .spawn((Camera3d::default(), Transform::from_xyz(0.0, 0.0, 10.0)))
        .id();
    settle(&mut app);
    for (distance, face) in [(40.0, 4.5), (10.0, 0.5), (40.0, 4.5)] {
        app.world_mut()
            .entity_mut(camera)
            .insert(Transform::from_xyz(0.0, 0.0, distance));
        app.update();
        let hit = cast(&mut app, Ray3d::new(Vec3::Z * 100.0, Dir3::NEG_Z)).expect("it stands there");
        assert_eq!(hit.position.z, face, "seen from {distance} m");
    }
}

#[test]
fn a_skinned_mesh_that_is_swapped_in_is_never_hit_in_its_bind_pose() {
    let mut app = headless_app();
    let joint = Transform::from_xyz(7.0, 0.0, 0.0);
    let rig = spawn_rig(&mut app, with_one_joint(square()), &[joint]);
    let near = app.world().get::<Mesh3d>(rig.entity).expect("a mesh").0.clone();
    let far = add_mesh(&mut app, Cuboid::new(3.0, 3.0, 3.0));
    let lod = ProxyLod::new(LodMetric::Distance, near.clone())
        .then(20.0, far)
        .hit_as(LodHits::Shown);
    app.world_mut()
        .entity_mut(rig.entity)
        .insert((lod, Transform::default()));
    let place = |distance| Transform::from_xyz(0.0, 0.0, distance);
    let camera = app.world_mut().spawn((Camera3d::default(), place(60.0))).id();
    settle(&mut app);
    app.update();
    app.world_mut().entity_mut(camera).insert(place(10.0));
    app.update();
    assert_eq!(app.world().get::<Mesh3d>(rig.entity).expect("a mesh").0, near);
    let [corner, ..] = query(&mut app, |scene| scene.triangle(rig.entity, 0)).expect("a triangle");
    let is_of_square = corner.z.abs() < 1.0;
    assert!(!is_of_square || corner.x > 5.0, "{corner} is in the bind pose");
}
