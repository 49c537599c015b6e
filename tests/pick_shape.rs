//! Entities whose surface is a shape rather than a mesh.

use std::sync::Arc;

use bevy::{
    ecs::system::RunSystemOnce,
    math::{Vec3A, bounding::Aabb3d},
    prelude::*,
};
use bevy_sightline::{
    geometry::{ray::Ray, surface::SurfaceHit},
    index::{RayCastBackfaces, Refusal},
    prelude::*,
};
use rand::Rng;

use crate::common::*;

/// What the smallest of servers has: no assets, no meshes, no window.
fn server() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, SpatialIndexPlugin));
    app
}

fn spawn(app: &mut App, shape: impl Surface + 'static, transform: Transform) -> Entity {
    let entity = app.world_mut().spawn((PickShape::new(shape), transform)).id();
    app.update();
    entity
}

#[test]
fn a_server_without_assets_hits_a_shape_without_a_mesh() {
    let mut app = server();
    let entity = spawn(&mut app, Sphere::new(2.0), Transform::from_xyz(5.0, 0.0, 0.0));
    let ray = Ray3d::new(Vec3::new(5.0, 0.0, 10.0), Dir3::NEG_Z);
    let cast = move |scene: SceneQuery| scene.cast_ray(ray, &SceneQuerySettings::default());
    let hit = app
        .world_mut()
        .run_system_once(cast)
        .expect("the plugin is there")
        .expect("a hit");
    assert_eq!((hit.entity, hit.distance, hit.triangle), (entity, 8.0, None));
    assert_eq!((hit.position, hit.normal), (Vec3::new(5.0, 0.0, 2.0), Vec3::Z));
    assert!(hit.uv.is_some());
}

#[test]
fn a_shape_takes_the_place_of_the_mesh() {
    let mut app = headless_app();
    let entity = spawn_mesh(&mut app, Cuboid::from_length(4.0), Transform::IDENTITY);
    app.world_mut()
        .entity_mut(entity)
        .insert(PickShape::new(Sphere::new(1.0)));
    settle(&mut app);
    assert_eq!(hit_at(&mut app, Vec3::ZERO).map(|hit| hit.distance), Some(99.0));
    assert_eq!(hit_at(&mut app, Vec3::X * 1.5), None, "beside the sphere, on the cube");

    app.world_mut().entity_mut(entity).remove::<PickShape>();
    settle(&mut app);
    assert_eq!(hit_at(&mut app, Vec3::X * 1.5).map(|hit| hit.distance), Some(98.0));
}

#[test]
fn a_shape_that_sticks_out_of_the_mesh_is_hit_there() {
    let mut app = headless_app();
    let entity = spawn_cube(&mut app, Vec3::ZERO);
    app.world_mut()
        .entity_mut(entity)
        .insert(PickShape::new(Sphere::new(3.0)));
    settle(&mut app);
    assert!(hit_at(&mut app, Vec3::X * 2.0).is_some());
}

#[test]
fn a_shape_that_is_replaced_is_hit_where_it_is_now() {
    let mut app = headless_app();
    let entity = spawn(&mut app, Sphere::new(1.0), Transform::IDENTITY);
    assert_eq!(hit_at(&mut app, Vec3::ZERO).map(|hit| hit.distance), Some(99.0));
    app.world_mut()
        .entity_mut(entity)
        .insert(PickShape::new(Sphere::new(5.0)));
    app.update();
    assert_eq!(hit_at(&mut app, Vec3::X * 4.0).map(|hit| hit.distance), Some(97.0));
}

#[test]
fn a_shape_that_is_removed_leaves_the_index() {
    let mut app = headless_app();
    let entity = spawn(&mut app, Sphere::new(1.0), Transform::IDENTITY);
    assert!(index(&app).contains(entity));
    app.world_mut().entity_mut(entity).remove::<PickShape>();
    app.update();
    assert!(!index(&app).contains(entity));
}

#[test]
fn the_normal_of_a_stretched_shape_stands_on_the_stretched_surface() {
    let mut app = headless_app();
    let scale = Vec3::new(4.0, 1.0, 1.0);
    spawn(&mut app, Sphere::new(1.0), Transform::from_scale(scale));
    let hit = cast(&mut app, Ray3d::new(Vec3::new(2.0, 10.0, 0.0), Dir3::NEG_Y)).expect("a hit");
    let gradient = (hit.position / (scale * scale)).normalize();
    assert!(
        hit.normal.abs_diff_eq(gradient, 1e-5),
        "{} is not {gradient}",
        hit.normal
    );
}

#[test]
fn a_ray_from_inside_leaves_a_shape_unless_it_has_back_faces() {
    let mut app = headless_app();
    let entity = spawn(&mut app, Sphere::new(1.0), Transform::IDENTITY);
    let ray = Ray3d::new(Vec3::ZERO, Dir3::X);
    assert_eq!(cast(&mut app, ray), None);
    app.world_mut().entity_mut(entity).insert(RayCastBackfaces);
    app.update();
    assert_eq!(
        cast(&mut app, ray).map(|hit| (hit.distance, hit.normal)),
        Some((1.0, Vec3::X))
    );
}

#[test]
fn a_flattened_shape_is_hit_by_no_ray() {
    let mut app = headless_app();
    let entity = spawn(
        &mut app,
        Sphere::new(1.0),
        Transform::from_scale(Vec3::new(1.0, 1.0, 0.0)),
    );
    assert!(index(&app).contains(entity));
    assert_eq!(hit_at(&mut app, Vec3::ZERO), None);
}

#[test]
fn a_shape_without_end_is_refused_until_it_has_one() {
    let mut app = headless_app();
    let entity = spawn(&mut app, InfinitePlane3d::new(Vec3::Z), Transform::IDENTITY);
    assert_eq!(index(&app).refused().collect::<Vec<_>>(), [(entity, Refusal::Shape)]);

    app.world_mut()
        .entity_mut(entity)
        .insert(PickShape::new(Plane3d::new(Vec3::Z, Vec2::splat(1000.0))));
    app.update();
    assert_eq!(index(&app).refused().len(), 0);
    assert_eq!(hit_at(&mut app, Vec3::X * 900.0).map(|hit| hit.distance), Some(100.0));
}

/// A surface of the user's own: everything at `z = 0` within a unit square, with the claim of any box.
struct Card {
    aabb: Aabb3d,
}

impl Surface for Card {
    fn aabb(&self) -> Option<Aabb3d> {
        Some(self.aabb)
    }

    fn closest_hit(&self, ray: &Ray, _: Backfaces) -> Option<SurfaceHit> {
        let t = -ray.origin().z / ray.direction().z;
        let point = ray.at(t);
        let within = t >= ray.t_min() && t <= ray.t_max() && point.abs().max_element() <= 0.5;
        within.then(|| SurfaceHit::new(t, Vec3::Z, Vec2::new(point.x, point.y) + 0.5))
    }
}

#[test]
fn a_custom_surface_is_hit_as_its_own_test_says() {
    let mut app = headless_app();
    let aabb = Aabb3d::new(Vec3::ZERO, Vec3::new(0.5, 0.5, 0.0));
    let surface: Arc<dyn Surface> = Arc::new(Card { aabb });
    for x in [0.0, 10.0] {
        app.world_mut()
            .spawn((PickShape::from(surface.clone()), Transform::from_xyz(x, 0.0, 1.0)));
    }
    app.update();
    for x in [0.0, 10.0] {
        let hit = hit_at(&mut app, Vec3::new(x + 0.25, 0.0, 0.0)).expect("a hit");
        assert_eq!((hit.distance, hit.uv), (99.0, Some(Vec2::new(0.75, 0.5))));
    }
}

#[test]
fn a_custom_surface_with_a_nan_box_is_refused() {
    let mut app = headless_app();
    let aabb = Aabb3d {
        min: Vec3A::NAN,
        max: Vec3A::NAN,
    };
    let entity = spawn(&mut app, Card { aabb }, Transform::IDENTITY);
    assert_eq!(index(&app).refused().collect::<Vec<_>>(), [(entity, Refusal::Shape)]);
}

#[test]
fn a_bounded_surface_and_a_group_are_hit_as_the_surfaces_in_them() {
    let mut app = headless_app();
    let bounded = BoundedSurface::in_aabb(Sphere::new(1.0)).expect("a sphere has an end");
    let mut group = SurfaceGroup::default();
    group.push(bounded);
    group.push(Cuboid::new(0.5, 6.0, 0.5));
    spawn(&mut app, group, Transform::IDENTITY);
    assert_eq!(hit_at(&mut app, Vec3::ZERO).map(|hit| hit.distance), Some(99.0));
    assert_eq!(hit_at(&mut app, Vec3::Y * 2.0).map(|hit| hit.distance), Some(99.75));
    assert_eq!(hit_at(&mut app, Vec3::new(2.0, 2.0, 0.0)), None);
}

#[test]
fn line_of_sight_ends_at_a_shape() {
    let mut app = headless_app();
    spawn(&mut app, Cylinder::new(1.0, 4.0), Transform::IDENTITY);
    let sees = |app: &mut App, y: f32| {
        query(app, move |scene| {
            scene.line_of_sight(
                Vec3::new(-5.0, y, 0.0),
                Vec3::new(5.0, y, 0.0),
                &SceneQuerySettings::default(),
            )
        })
    };
    assert!(!sees(&mut app, 1.0));
    assert!(sees(&mut app, 3.0));
}

#[test]
fn rays_find_among_many_shapes_what_a_scan_of_all_finds() {
    let mut rng = rng(77);
    let mut app = headless_app();
    let shapes: [Arc<dyn Surface>; 7] = [
        Arc::new(Sphere::new(1.0)),
        Arc::new(Cuboid::new(1.0, 2.0, 0.5)),
        Arc::new(Cylinder::new(0.7, 2.0)),
        Arc::new(Capsule3d::new(0.5, 1.0)),
        Arc::new(Cone::new(1.0, 2.0)),
        Arc::new(Torus::new(0.5, 1.2)),
        Arc::new(Tetrahedron::default()),
    ];
    let mut placed = Vec::new();
    for _ in 0..200 {
        let shape = shapes[rng.random_range(0..shapes.len())].clone();
        let transform = Transform {
            translation: random_point(&mut rng, 15.0),
            rotation: random_rotation(&mut rng),
            scale: Vec3::from_array(std::array::from_fn(|_| rng.random_range(0.5..2.0))),
        };
        let entity = app.world_mut().spawn((PickShape::from(shape.clone()), transform)).id();
        placed.push((entity, shape, transform));
    }
    app.update();
    let mut hits = 0;
    for _ in 0..2000 {
        let ray = ray_towards(random_point(&mut rng, 20.0), random_point(&mut rng, 15.0));
        let world = Ray::from_ray3d(ray, f32::INFINITY).expect("a sound ray");
        let scanned = (placed.iter())
            .filter_map(|(entity, shape, transform)| {
                let local = world.transformed_by(&transform.compute_affine().as_daffine3().inverse())?;
                Some((shape.closest_hit(&local, Backfaces::Cull)?.t, *entity))
            })
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let found = cast(&mut app, ray).map(|hit| (hit.distance, hit.entity));
        assert_eq!(found, scanned);
        hits += usize::from(found.is_some());
    }
    assert!(hits > 500, "only {hits} rays hit anything");
}

#[test]
fn a_shape_without_anything_else_has_a_place() {
    let mut app = server();
    let entity = app.world_mut().spawn(PickShape::new(Sphere::new(1.0))).id();
    app.update();
    assert!(index(&app).contains(entity));
}

#[test]
fn a_shape_that_is_not_drawn_is_in_view_unless_it_is_hidden() {
    let mut app = headless_app();
    let entity = spawn(&mut app, Sphere::new(1.0), Transform::IDENTITY);
    let is_hit = |app: &mut App| {
        let settings = SceneQuerySettings::default().with_visibility(QueryVisibility::VisibleInView);
        query(app, move |scene| {
            scene.any_hit(Ray3d::new(Vec3::Z * 9.0, Dir3::NEG_Z), &settings)
        })
    };
    assert!(is_hit(&mut app));
    app.world_mut().entity_mut(entity).insert(Visibility::Hidden);
    app.update();
    assert!(!is_hit(&mut app));
}

/// A surface that claims to be hit at any parameter.
struct Liar(f32);

impl Surface for Liar {
    fn aabb(&self) -> Option<Aabb3d> {
        Some(Aabb3d::new(Vec3::ZERO, Vec3::ONE))
    }

    fn closest_hit(&self, _: &Ray, _: Backfaces) -> Option<SurfaceHit> {
        Some(SurfaceHit::new(self.0, Vec3::Z, Vec2::ZERO))
    }
}

#[test]
fn a_custom_surface_that_is_hit_where_the_ray_is_not_is_not_hit() {
    for t in [f32::NAN, -1.0, f32::INFINITY] {
        let mut app = headless_app();
        let mut group = SurfaceGroup::new();
        group.push(Liar(t));
        spawn(&mut app, group, Transform::IDENTITY);
        spawn(&mut app, Liar(t), Transform::IDENTITY);
        assert_eq!(hit_at(&mut app, Vec3::ZERO), None, "{t}");
        let ray = ray_towards(Vec3::Z * 100.0, Vec3::ZERO);
        let any = query(&mut app, |scene| scene.any_hit(ray, &SceneQuerySettings::default()));
        assert!(!any, "{t}");
    }
}
