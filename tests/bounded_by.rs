//! The bounding volume that guards the triangles of an entity.

use bevy::prelude::*;
use bevy_sightline::{
    index::{MeshBvhs, RayCastBackfaces},
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

/// Rays hit an entity alike with every kind of volume, and often enough.
fn assert_kinds_agree(app: &mut App, entity: Entity, rays: &[Ray3d]) {
    let hits = |app: &mut App| -> Vec<Option<RayHit>> { rays.iter().map(|ray| cast(app, *ray)).collect() };
    let plain = hits(app);
    assert!(plain.iter().flatten().count() > 100);
    for kind in KINDS {
        app.world_mut().entity_mut(entity).insert(BoundedBy(kind));
        settle(app);
        assert_eq!(hits(app), plain, "{kind:?}");
    }
}

#[test]
fn the_kind_of_volume_changes_no_hit() {
    let mut rng = rng(5);
    let meshes: [Mesh; 4] = [
        Torus::new(0.5, 1.0).into(),
        Cone::new(1.0, 2.0).into(),
        Plane3d::new(Vec3::Z, Vec2::ONE).into(),
        Tetrahedron::default().into(),
    ];
    for mesh in meshes {
        let mut app = headless_app();
        let entity = spawn_mesh(&mut app, mesh, Transform::from_rotation(random_rotation(&mut rng)));
        settle(&mut app);
        let rays: Vec<Ray3d> =
            std::iter::repeat_with(|| ray_towards(*random_dir(&mut rng) * 5.0, random_point(&mut rng, 1.0)))
                .take(2000)
                .collect();
        assert_kinds_agree(&mut app, entity, &rays);
    }
}

#[test]
fn rays_from_afar_at_the_rim_of_a_mesh_hit_alike_with_every_kind() {
    let mut rng = rng(6);
    for _ in 0..20 {
        let corners: [Vec3; 3] = std::array::from_fn(|_| random_point(&mut rng, 1.0));
        let mut app = headless_app();
        let mesh = Triangle3d::new(corners[0], corners[1], corners[2]);
        let entity = spawn_mesh(&mut app, mesh, Transform::IDENTITY);
        app.world_mut().entity_mut(entity).insert(RayCastBackfaces);
        settle(&mut app);
        let rays: Vec<Ray3d> = (0..600)
            .map(|i| {
                let distance = [10.0, 100.0, 1e3, 1e6][i % 4];
                let along = [0.0, 0.5, rng.random_range(0.0..1.0)][i % 3];
                let target = corners[i % 3].lerp(corners[(i + 1) % 3], along);
                ray_towards(target + *random_dir(&mut rng) * distance, target)
            })
            .collect();
        assert_kinds_agree(&mut app, entity, &rays);
    }
}

#[test]
fn a_volume_is_built_in_the_background_once_per_mesh_and_kind() {
    let mut app = headless_app();
    let mesh = add_mesh(&mut app, Sphere::new(1.0));
    for kind in [BoundingKind::Hull, BoundingKind::Hull, BoundingKind::Aabb] {
        app.world_mut().spawn((Mesh3d(mesh.clone()), BoundedBy(kind)));
    }
    settle(&mut app);
    assert_eq!(app.world().resource::<MeshBvhs>().building(), 0);
    assert_eq!(
        app.world().resource::<MeshBvhs>().volumes(&mesh).collect::<Vec<_>>(),
        [BoundingKind::Hull]
    );
}

#[test]
fn a_volume_follows_a_mesh_that_is_edited() {
    let mut app = headless_app();
    let mesh = add_mesh(&mut app, Sphere::new(1.0));
    app.world_mut()
        .spawn((Mesh3d(mesh.clone()), BoundedBy(BoundingKind::Sphere)));
    settle(&mut app);
    assert_eq!(hit_at(&mut app, Vec3::X * 2.0), None);
    app.world_mut()
        .resource_mut::<Assets<Mesh>>()
        .insert(&mesh, Sphere::new(3.0).into())
        .expect("the asset is there");
    settle(&mut app);
    assert!(hit_at(&mut app, Vec3::X * 2.0).is_some());
}
