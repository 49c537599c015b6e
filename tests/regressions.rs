//! Bugs that were, each as the shortest test that failed for it.

use bevy::{
    math::{Vec3A, bounding::Aabb3d},
    prelude::*,
};
use bevy_sightline::geometry::ray::Ray;

use crate::common::{add_mesh, headless_app, query};
use bevy_sightline::prelude::*;

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
