//! The index alone, as a server has it: runs with and without the default features.

use bevy::{
    camera::{CameraPlugin, CameraProjection, ComputedCameraValues, RenderTargetInfo},
    ecs::system::RunSystemOnce,
    image::ImagePlugin,
    mesh::MeshPlugin,
    prelude::*,
    window::WindowPlugin,
};
use bevy_sightline::{
    index::{MeshBvhs, RayCastBackfaces, SimplifiedMesh},
    prelude::*,
};

fn server() -> App {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        AssetPlugin::default(),
        TransformPlugin,
        ImagePlugin::default(),
        MeshPlugin,
        WindowPlugin::default(),
        CameraPlugin,
        SightlinePlugins,
    ));
    app
}

fn add(app: &mut App, mesh: impl Into<Mesh>) -> Handle<Mesh> {
    app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh)
}

/// What a ray down the z axis from z = 10 hits.
fn hit(app: &mut App) -> Option<RayHit> {
    app.update();
    let ray = Ray3d::new(Vec3::Z * 10.0, Dir3::NEG_Z);
    let cast = move |scene: SceneQuery| scene.cast_ray(ray, &SceneQuerySettings::default());
    app.world_mut().run_system_once(cast).expect("the plugin is there")
}

#[test]
fn a_server_casts_rays() {
    let mut app = server();
    let cube = add(&mut app, Cuboid::default());
    let entity = app.world_mut().spawn(Mesh3d(cube)).id();
    let found = hit(&mut app).expect("a cube");
    assert_eq!((found.entity, found.distance, found.normal), (entity, 9.5, Vec3::Z));
    while app.world().resource::<MeshBvhs>().building() > 0 {
        app.update();
    }
    assert_eq!(hit(&mut app), Some(found), "the same once the hierarchy is built");
    app.world_mut().despawn(entity);
    assert_eq!(hit(&mut app), None);
}

#[test]
fn a_simplified_mesh_is_hit_in_place_of_the_drawn_one() {
    let mut app = server();
    let (cube, large) = (
        add(&mut app, Cuboid::default()),
        add(&mut app, Cuboid::new(4.0, 4.0, 4.0)),
    );
    let entity = app.world_mut().spawn((Mesh3d(cube), SimplifiedMesh(large))).id();
    assert_eq!(hit(&mut app).map(|hit| hit.distance), Some(8.0));
    app.world_mut().entity_mut(entity).remove::<SimplifiedMesh>();
    assert_eq!(hit(&mut app).map(|hit| hit.distance), Some(9.5));
}

#[test]
fn back_faces_are_hit_where_the_entity_says_so() {
    let mut app = server();
    let plane = add(&mut app, Plane3d::new(Vec3::NEG_Z, Vec2::ONE));
    let entity = app.world_mut().spawn(Mesh3d(plane)).id();
    assert_eq!(hit(&mut app), None);
    app.world_mut().entity_mut(entity).insert(RayCastBackfaces);
    assert_eq!(hit(&mut app).map(|hit| hit.distance), Some(10.0));
    app.world_mut().entity_mut(entity).remove::<RayCastBackfaces>();
    assert_eq!(hit(&mut app), None);
}

#[test]
fn a_server_selects_what_is_on_the_screen_of_a_client() {
    let mut app = server();
    let cube = add(&mut app, Cuboid::default());
    let in_the_middle = app.world_mut().spawn(Mesh3d(cube.clone())).id();
    app.world_mut()
        .spawn((Mesh3d(cube), Transform::from_xyz(2.0, 0.0, 0.0)));
    app.update();
    let camera = Camera {
        computed: ComputedCameraValues {
            clip_from_view: PerspectiveProjection::default().get_clip_from_view(),
            target_info: Some(RenderTargetInfo {
                physical_size: UVec2::splat(100),
                scale_factor: 1.0,
            }),
            ..default()
        },
        ..default()
    };
    let select = move |scene: SceneQuery| {
        let (eye, middle) = (
            GlobalTransform::from_xyz(0.0, 0.0, 10.0),
            ScreenRegion::point(Vec2::splat(50.0)),
        );
        let (selection, settings) = (SelectionSettings::default(), SceneQuerySettings::default());
        let mut found = Vec::new();
        scene.select_on_screen(&camera, &eye, &middle, &selection, &settings, &mut found);
        found
    };
    let found = app.world_mut().run_system_once(select).expect("the plugin is there");
    assert_eq!(found, [in_the_middle]);
}
