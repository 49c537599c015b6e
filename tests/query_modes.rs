//! What rays hit on an entity with a mesh, by choice: its triangles or a volume around them.

use bevy::{math::Affine3A, prelude::*};
use bevy_sightline::{
    geometry::{
        ray::{Ray, triangle::Backfaces},
        surface::VolumeSurface,
        volume::Volume,
    },
    index::{MeshBvhs, MeshStatus, RayCastBackfaces, SimplifiedMesh},
    prelude::*,
};
use rand::Rng;

use crate::common::*;

const KINDS: [BoundingKind; 4] = [
    BoundingKind::Sphere,
    BoundingKind::Aabb,
    BoundingKind::Obb,
    BoundingKind::Hull,
];

/// An app with one entity, hit as a volume of this kind, which is built.
fn app_with(kind: BoundingKind, mesh: impl Into<Mesh>, transform: Transform) -> (App, Entity) {
    let mut app = headless_app();
    let entity = spawn_mesh(&mut app, mesh, transform);
    insert(&mut app, entity, HitSurface::Volume(kind));
    (app, entity)
}

fn insert(app: &mut App, entity: Entity, bundle: impl Bundle) {
    app.world_mut().entity_mut(entity).insert(bundle);
    settle(app);
    app.update();
}

fn status(app: &App, entity: Entity) -> Option<MeshStatus> {
    let mesh = app.world().get::<Mesh3d>(entity).expect("a mesh entity");
    app.world().resource::<MeshBvhs>().status(&mesh.0)
}

fn ring() -> Torus {
    Torus::new(0.5, 1.5)
}

/// A ray through the hole of a ring that lies around the y axis.
fn through_the_hole() -> Ray3d {
    Ray3d::new(Vec3::new(0.0, 10.0, 0.0), Dir3::NEG_Y)
}

#[test]
fn by_default_the_triangles_are_hit() {
    let mut app = headless_app();
    let entity = spawn_mesh(&mut app, ring(), Transform::IDENTITY);
    settle(&mut app);
    assert_eq!(cast(&mut app, through_the_hole()), None);
    insert(&mut app, entity, HitSurface::default());
    assert_eq!(cast(&mut app, through_the_hole()), None);
}

#[test]
fn a_volume_is_hit_where_there_are_no_triangles_and_until_it_is_taken_away() {
    for (kind, height) in [
        (BoundingKind::Sphere, 1.5),
        (BoundingKind::Aabb, 0.5),
        (BoundingKind::Obb, 0.5),
        (BoundingKind::Hull, 0.5),
    ] {
        let (mut app, entity) = app_with(kind, ring(), Transform::IDENTITY);
        let hit = cast(&mut app, through_the_hole()).expect("a hit");
        assert_eq!((hit.entity, hit.triangle, hit.uv), (entity, None, None), "{kind:?}");
        assert!(
            (hit.distance - (10.0 - height)).abs() < 1e-2,
            "{kind:?} at {}",
            hit.distance
        );
        assert!(hit.normal.abs_diff_eq(Vec3::Y, 1e-2), "{kind:?}: {}", hit.normal);
        let any = |app: &mut App| {
            query(app, |scene| {
                scene.any_hit(through_the_hole(), &SceneQuerySettings::default())
            })
        };
        assert!(any(&mut app));

        app.world_mut().entity_mut(entity).remove::<HitSurface>();
        settle(&mut app);
        assert_eq!(cast(&mut app, through_the_hole()), None, "{kind:?}");
        assert!(!any(&mut app));
    }
}

#[test]
fn the_kind_may_be_changed_at_any_time() {
    let (mut app, entity) = app_with(BoundingKind::Sphere, ring(), Transform::IDENTITY);
    for (kind, distance) in [
        (BoundingKind::Aabb, 9.5),
        (BoundingKind::Sphere, 8.5),
        (BoundingKind::Hull, 9.5),
    ] {
        insert(&mut app, entity, HitSurface::Volume(kind));
        let hit = cast(&mut app, through_the_hole()).expect("a hit");
        assert!((hit.distance - distance).abs() < 1e-2, "{kind:?} at {}", hit.distance);
    }
}

#[test]
fn the_triangles_are_hit_until_the_volume_is_built_and_the_box_is_there_at_once() {
    for kind in KINDS {
        let mut app = headless_app();
        let entity = spawn_mesh(&mut app, ring(), Transform::IDENTITY);
        app.world_mut().entity_mut(entity).insert(HitSurface::Volume(kind));
        app.update();
        let hit = cast(&mut app, through_the_hole());
        assert_eq!(hit.is_some(), kind == BoundingKind::Aabb, "{kind:?}");
        let rim = Ray3d::new(Vec3::new(1.0, 10.0, 0.0), Dir3::NEG_Y);
        assert!(cast(&mut app, rim).is_some());
    }
}

#[test]
fn a_volume_that_sticks_out_of_the_box_of_the_entity_is_hit_there() {
    let (mut app, entity) = app_with(BoundingKind::Sphere, Cuboid::default(), Transform::IDENTITY);
    let beside = Vec3::new(0.8, 0.0, 0.0);
    assert_eq!(hit_at(&mut app, beside).map(|hit| hit.entity), Some(entity));
    insert(&mut app, entity, HitSurface::Mesh);
    assert_eq!(hit_at(&mut app, beside), None);
    let aabb = index(&app).aabb(entity).expect("an indexed entity");
    assert!(aabb.max.x < 0.6, "its box is that of its mesh again");
}

#[test]
fn the_volumes_of_a_moved_scaled_mirrored_and_sheared_entity_are_hit_as_they_would_be_at_home() {
    let mut rng = rng(80);
    for round in 0..24 {
        let kind = KINDS[round % KINDS.len()];
        let mesh = Mesh::from(Tetrahedron::default());
        let (mut app, entity) = app_with(kind, mesh.clone(), Transform::IDENTITY);
        let scale = Vec3::from_array(std::array::from_fn(|_| rng.random_range(0.2..3.0)));
        let scale = if round % 3 == 0 {
            scale * Vec3::new(-1.0, 1.0, 1.0)
        } else {
            scale
        };
        let parent = Transform::from_scale(scale).with_translation(random_point(&mut rng, 5.0));
        let parent = app.world_mut().spawn(parent).id();
        insert(
            &mut app,
            entity,
            (ChildOf(parent), Transform::from_rotation(random_rotation(&mut rng))),
        );
        let world_from_local: Affine3A = app.world().get::<GlobalTransform>(entity).expect("a place").affine();
        let corners = bevy_sightline::mesh::TriangleMesh::from_mesh(&mesh).expect("a usable mesh");
        let corners = corners.corners_of_all().flatten().map(bevy::math::Vec3A::from);
        let volume = VolumeSurface::new(kind.enclosing(corners).expect("a bounded mesh"));

        let mut hits = 0;
        for _ in 0..200 {
            let target = world_from_local.transform_point3(random_point(&mut rng, 1.0));
            let ray = ray_towards(target + *random_dir(&mut rng) * 20.0, target);
            let own = Ray::from_ray3d(ray, f32::INFINITY).expect("a finite ray");
            let local = own
                .transformed_by(&world_from_local.as_daffine3().inverse())
                .expect("a finite ray");
            let expected = volume.closest_hit(&local, Backfaces::Cull);
            let hit = cast(&mut app, ray);
            assert_eq!(
                hit.map(|hit| hit.distance),
                expected.map(|hit| hit.t),
                "{kind:?} {ray:?}"
            );
            hits += hit.iter().len();
            if let Some(hit) = hit {
                assert!(hit.normal.dot(*ray.direction) <= 1e-6 && hit.normal.is_normalized());
            }
        }
        assert!(hits > 20, "{kind:?}: {hits} hits");
    }
}

#[test]
fn the_hull_of_a_convex_mesh_is_hit_like_the_mesh() {
    let mut rng = rng(81);
    for mesh in [
        Mesh::from(Cuboid::new(1.0, 2.0, 3.0)),
        Sphere::new(1.0).mesh().ico(4).expect("few faces"),
    ] {
        let place = Transform::from_rotation(random_rotation(&mut rng)).with_scale(Vec3::new(1.0, -2.0, 0.5));
        let (mut app, hull) = app_with(BoundingKind::Hull, mesh.clone(), place);
        let offset = Vec3::X * 1000.0;
        spawn_mesh(&mut app, mesh, place.with_translation(offset));
        settle(&mut app);
        for _ in 0..300 {
            let (from, to) = (*random_dir(&mut rng) * 9.0, random_point(&mut rng, 1.0));
            let of_hull = cast(&mut app, ray_towards(from, to));
            let of_mesh = cast(&mut app, ray_towards(from + offset, to + offset));
            if let Some(of_mesh) = of_mesh {
                let of_hull = of_hull.expect("a hull contains its mesh");
                assert_eq!(of_hull.entity, hull);
                assert!(
                    (of_hull.distance - of_mesh.distance).abs() < 2e-3,
                    "{of_hull:?} {of_mesh:?}"
                );
            }
        }
    }
}

#[test]
fn under_a_transform_that_flattens_the_entity_its_triangles_are_hit() {
    for kind in KINDS {
        let flat = Transform::from_scale(Vec3::new(1.0, 1.0, 0.0));
        let (mut app, entity) = app_with(kind, Cuboid::default(), flat);
        let hit = hit_at(&mut app, Vec3::ZERO).expect("a hit");
        assert!(hit.triangle.is_some(), "{kind:?}");
        assert_eq!(hit_at(&mut app, Vec3::X * 0.8), None);
        insert(&mut app, entity, Transform::IDENTITY);
        assert_eq!(hit_at(&mut app, Vec3::ZERO).map(|hit| hit.triangle), Some(None));
    }
}

#[test]
fn the_volume_of_a_flat_mesh_is_hit_from_both_sides() {
    let (front, back) = (
        Ray3d::new(Vec3::Z * 5.0, Dir3::NEG_Z),
        Ray3d::new(Vec3::NEG_Z * 5.0, Dir3::Z),
    );
    for kind in KINDS {
        let quad = Plane3d::new(Vec3::Z, Vec2::splat(1.0));
        let (mut app, _) = app_with(kind, quad, Transform::IDENTITY);
        for ray in [front, back] {
            let hit = cast(&mut app, ray).expect("a hit");
            let depth = if kind == BoundingKind::Sphere { 2f32.sqrt() } else { 0.0 };
            assert!(
                (hit.distance - 5.0 + depth).abs() < 1e-5,
                "{kind:?} at {}",
                hit.distance
            );
            assert!(
                hit.normal.abs_diff_eq(-*ray.direction, 1e-5),
                "{kind:?}: {}",
                hit.normal
            );
        }
    }
}

#[test]
fn a_ray_from_inside_leaves_a_volume_unless_back_faces_count() {
    for kind in KINDS {
        let (mut app, entity) = app_with(kind, Cuboid::default(), Transform::IDENTITY);
        let ray = Ray3d::new(Vec3::ZERO, Dir3::X);
        assert_eq!(cast(&mut app, ray), None, "{kind:?}");
        insert(&mut app, entity, RayCastBackfaces);
        let hit = cast(&mut app, ray).expect("the far side");
        let expected = if kind == BoundingKind::Sphere {
            0.75f32.sqrt()
        } else {
            0.5
        };
        assert!((hit.distance - expected).abs() < 1e-5, "{kind:?} at {}", hit.distance);
        assert!(hit.normal.abs_diff_eq(Vec3::X, 1e-5), "{kind:?}: {}", hit.normal);
    }
}

#[test]
fn a_volume_follows_a_mesh_that_is_edited() {
    for kind in KINDS {
        let (mut app, entity) = app_with(kind, Cuboid::default(), Transform::IDENTITY);
        let beside = Vec3::new(1.4, 0.0, 0.0);
        assert_eq!(hit_at(&mut app, beside), None);
        let mesh = app.world().get::<Mesh3d>(entity).expect("a mesh entity").0.clone();
        for mesh_now in [Cuboid::from_length(3.0), Cuboid::from_length(3.5)] {
            let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
            meshes.insert(&mesh, mesh_now.into()).expect("a live id");
            settle(&mut app);
            app.update();
            assert_eq!(hit_at(&mut app, beside).map(|hit| hit.triangle), Some(None), "{kind:?}");
        }
        let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
        meshes.insert(&mesh, Cuboid::default().into()).expect("a live id");
        settle(&mut app);
        app.update();
        assert_eq!(hit_at(&mut app, beside), None, "{kind:?}");
    }
}

#[test]
fn a_mesh_of_which_rays_hit_but_volumes_has_no_hierarchy_until_one_hits_its_triangles() {
    let (mut app, entity) = app_with(BoundingKind::Hull, ring(), Transform::IDENTITY);
    assert!(cast(&mut app, through_the_hole()).is_some());
    app.update();
    assert_eq!(status(&app, entity), Some(MeshStatus::Dormant));

    let mesh = app.world().get::<Mesh3d>(entity).expect("a mesh entity").clone();
    app.world_mut().spawn((mesh, Transform::from_xyz(50.0, 0.0, 0.0)));
    settle(&mut app);
    assert_eq!(status(&app, entity), Some(MeshStatus::Ready));
}

#[test]
fn an_entity_that_returns_to_its_triangles_gets_a_hierarchy() {
    let (mut app, entity) = app_with(BoundingKind::Sphere, ring(), Transform::IDENTITY);
    assert_eq!(status(&app, entity), Some(MeshStatus::Dormant));
    insert(&mut app, entity, HitSurface::Mesh);
    assert_eq!(status(&app, entity), Some(MeshStatus::Ready));
}

#[test]
fn a_volume_is_that_of_the_simplified_mesh_where_there_is_one() {
    let (mut app, entity) = app_with(BoundingKind::Aabb, Cuboid::default(), Transform::IDENTITY);
    let simplified = add_mesh(&mut app, Cuboid::from_length(4.0));
    insert(&mut app, entity, SimplifiedMesh(simplified));
    assert_eq!(hit_at(&mut app, Vec3::X * 1.9).map(|hit| hit.distance), Some(98.0));
}

#[test]
fn a_shape_comes_before_a_volume() {
    let (mut app, entity) = app_with(BoundingKind::Aabb, Cuboid::default(), Transform::IDENTITY);
    insert(&mut app, entity, PickShape::new(Sphere::new(2.0)));
    assert_eq!(hit_at(&mut app, Vec3::ZERO).map(|hit| hit.distance), Some(98.0));
    app.world_mut().entity_mut(entity).remove::<PickShape>();
    settle(&mut app);
    assert_eq!(hit_at(&mut app, Vec3::ZERO).map(|hit| hit.distance), Some(99.5));
}

#[test]
fn the_volume_that_guards_the_triangles_changes_nothing_about_the_one_that_is_hit() {
    let (mut app, entity) = app_with(BoundingKind::Sphere, ring(), Transform::IDENTITY);
    let before = cast(&mut app, through_the_hole());
    for kind in KINDS {
        insert(&mut app, entity, BoundedBy(kind));
        assert_eq!(cast(&mut app, through_the_hole()), before, "{kind:?}");
    }
}

#[test]
fn volumes_enclose_what_they_stand_for() {
    let mut rng = rng(82);
    for kind in KINDS {
        let points: Vec<_> = (0..40).map(|_| random_point(&mut rng, 3.0).into()).collect();
        let volume = VolumeSurface::new(kind.enclosing(points.iter().copied()).expect("finite points"));
        let aabb = Surface::aabb(&volume).expect("it has an end");
        for point in points {
            assert!(volume.volume().contains_point(point) && aabb.contains_point(point));
            // A ray that ends well inside enters first.
            let inside = point * 0.9;
            let ray = Ray::segment((inside + point.normalize_or_zero() * 20.0).into(), inside.into());
            let ray = ray.expect("two points");
            let entered = volume.volume().ray_intersection_at(&ray);
            let hit = volume.closest_hit(&ray, Backfaces::Cull);
            if volume.volume().contains_point(inside) {
                let (entered, t) = (entered.expect("it is inside"), hit.expect("it is inside").t);
                assert!((entered - t).abs() < 1e-5, "{kind:?}: {entered} {t}");
            }
        }
    }
}
