//! What casts shadows for whom.

use bevy::{
    camera::{
        ShadowLodOrigin,
        visibility::{
            CascadesVisibleEntities, CubemapVisibleEntities, NoCpuCulling, NoFrustumCulling, RenderLayers,
            VisibilityRange, VisibleMeshEntities,
        },
    },
    light::{CascadeShadowConfigBuilder, NotShadowCaster},
    prelude::*,
};

use super::*;

/// The number of the face of a cube map that looks along +x.
const TO_THE_RIGHT: usize = 0;

/// A lamp at the origin, which reaches 10 m.
fn spawn_lamp(app: &mut App) -> Entity {
    let lamp = PointLight {
        shadow_maps_enabled: true,
        range: 10.0,
        ..default()
    };
    spawn(app, lamp)
}

/// A spot at the origin that points to the right.
fn spawn_spot(app: &mut App) -> Entity {
    let spot = SpotLight {
        shadow_maps_enabled: true,
        range: 10.0,
        ..default()
    };
    spawn(app, (spot, Transform::IDENTITY.looking_to(Vec3::X, Vec3::Y)))
}

/// A sun that shines straight down, with so many cascades.
fn spawn_sun(app: &mut App, num_cascades: usize) -> Entity {
    let sun = DirectionalLight {
        shadow_maps_enabled: true,
        ..default()
    };
    let cascades = CascadeShadowConfigBuilder {
        num_cascades,
        first_cascade_far_bound: 15.0,
        maximum_distance: 100.0,
        ..default()
    };
    let down = Transform::IDENTITY.looking_to(Vec3::NEG_Y, Vec3::Z);
    spawn(app, (sun, cascades.build(), down))
}

/// The list of a face.
fn on_face(app: &App, lamp: Entity, face: usize) -> Vec<Entity> {
    let faces = app.world().get::<CubemapVisibleEntities>(lamp).expect("a lamp");
    faces.get(face).entities.clone()
}

/// The list of a spot.
fn in_cone(app: &App, spot: Entity) -> Vec<Entity> {
    let list = app.world().get::<VisibleMeshEntities>(spot).expect("a spot");
    list.entities.clone()
}

/// The lists that a sun has for a camera.
fn in_cascades(app: &App, sun: Entity, camera: Entity) -> Vec<Vec<Entity>> {
    let views = app.world().get::<CascadesVisibleEntities>(sun).expect("a sun");
    let cascades = views.entities.get(&camera).into_iter().flatten();
    cascades.map(|list| list.entities.clone()).collect()
}

#[test]
fn a_lamp_lists_what_is_near_on_the_face_where_it_is() {
    of_both(|app| {
        spawn_camera(app);
        let (lamp, near) = (spawn_lamp(app), spawn_cube_at(app, 5.0, 0.0, 0.0));
        spawn_cube_at(app, 15.0, 0.0, 0.0);
        app.update();
        for face in 0..6 {
            let expected: &[Entity] = if face == TO_THE_RIGHT { &[near] } else { &[] };
            assert_eq!(on_face(app, lamp, face), expected, "face {face}");
        }
    });
}

#[test]
fn what_is_in_a_corner_is_on_all_faces_that_meet_there() {
    of_both(|app| {
        spawn_camera(app);
        let (lamp, cube) = (spawn_lamp(app), spawn_cube_at(app, 3.0, 3.0, 0.0));
        app.update();
        let faces: Vec<usize> = (0..6).filter(|&face| on_face(app, lamp, face) == [cube]).collect();
        assert_eq!(faces, [TO_THE_RIGHT, 2]);
    });
}

#[test]
fn a_lamp_moves_and_changes_its_range_in_the_frame_in_which_it_does() {
    of_both(|app| {
        spawn_camera(app);
        let (lamp, cube) = (spawn_lamp(app), spawn_cube_at(app, 5.0, 0.0, 0.0));
        app.update();
        insert(app, lamp, Transform::from_xyz(-8.0, 0.0, 0.0));
        app.update();
        assert_eq!(on_face(app, lamp, TO_THE_RIGHT), []);
        app.world_mut().get_mut::<PointLight>(lamp).expect("a lamp").range = 30.0;
        app.update();
        assert_eq!(on_face(app, lamp, TO_THE_RIGHT), [cube]);
    });
}

#[test]
fn a_spot_lists_what_is_in_its_cone() {
    of_both(|app| {
        spawn_camera(app);
        let (spot, cube) = (spawn_spot(app), spawn_cube_at(app, 5.0, 0.0, 0.0));
        spawn_cube_at(app, -5.0, 0.0, 0.0);
        spawn_cube_at(app, 0.0, 5.0, 0.0);
        spawn_cube_at(app, 15.0, 0.0, 0.0);
        app.update();
        assert_eq!(in_cone(app, spot), [cube]);
        insert(app, spot, Transform::IDENTITY.looking_to(Vec3::NEG_Z, Vec3::Y));
        app.update();
        assert_eq!(in_cone(app, spot), []);
    });
}

#[test]
fn a_sun_lists_for_each_cascade_what_may_cast_shadows_into_it() {
    of_both(|app| {
        let (camera, sun) = (spawn_camera(app), spawn_sun(app, 4));
        let near = spawn_cube(app);
        let far = spawn_cube_at(app, 0.0, 0.0, -70.0);
        // Far above all that the camera sees, where the light comes from.
        let above = spawn_cube_at(app, 0.0, 500.0, 0.0);
        spawn_cube_at(app, 300.0, 0.0, 0.0);
        app.update();
        let cascades = in_cascades(app, sun, camera);
        assert_eq!(cascades.len(), 4);
        assert_eq!(cascades[0], sorted([near, above]));
        assert!(cascades[3].contains(&far), "{cascades:?}");
        assert_eq!(listed::<Mesh3d>(app, camera), sorted([near, far]));
    });
}

#[test]
fn a_sun_has_cascades_for_each_active_camera() {
    of_both(|app| {
        let (first, second, sun) = (spawn_camera(app), spawn_camera(app), spawn_sun(app, 2));
        let cube = spawn_cube(app);
        app.update();
        assert_eq!(in_cascades(app, sun, first)[0], [cube]);
        assert_eq!(in_cascades(app, sun, second)[0], [cube]);
        app.world_mut().get_mut::<Camera>(second).expect("a camera").is_active = false;
        app.update();
        assert!(in_cascades(app, sun, second).is_empty());
        app.world_mut().despawn(first);
        app.update();
        assert!(in_cascades(app, sun, first).is_empty());
    });
}

#[test]
fn the_number_of_cascades_may_change() {
    of_both(|app| {
        let (camera, sun, cube) = (spawn_camera(app), spawn_sun(app, 1), spawn_cube(app));
        for num_cascades in [1, 4, 2] {
            let cascades = CascadeShadowConfigBuilder {
                num_cascades,
                ..default()
            };
            insert(app, sun, cascades.build());
            app.update();
            let lists = in_cascades(app, sun, camera);
            assert_eq!(lists.len(), num_cascades);
            assert!(lists.iter().any(|list| *list == [cube]), "{lists:?}");
        }
    });
}

#[test]
fn what_a_light_alone_sees_is_visible_and_in_no_list_of_a_camera() {
    of_both(|app| {
        let (camera, lamp) = (spawn_camera(app), spawn_lamp(app));
        let aside = spawn_cube_at(app, 8.0, 0.0, 0.0);
        assert_eq!(look(app, camera), []);
        assert_eq!(on_face(app, lamp, TO_THE_RIGHT), [aside]);
        assert!(is_seen(app, aside));
        app.world_mut().despawn(lamp);
        app.update();
        assert!(!is_seen(app, aside));
    });
}

#[test]
fn what_a_sun_alone_sees_is_visible_until_it_casts_no_shadows() {
    of_both(|app| {
        let (camera, sun) = (spawn_camera(app), spawn_sun(app, 4));
        let above = spawn_cube_at(app, 0.0, 500.0, 0.0);
        assert_eq!(look(app, camera), []);
        assert!(is_seen(app, above));
        app.world_mut()
            .get_mut::<DirectionalLight>(sun)
            .expect("a sun")
            .shadow_maps_enabled = false;
        app.update();
        assert!(in_cascades(app, sun, camera).is_empty());
        assert!(!is_seen(app, above));
    });
}

#[test]
fn a_lamp_without_shadows_keeps_its_lists_and_makes_nothing_visible() {
    of_both(|app| {
        spawn_camera(app);
        let (lamp, aside) = (spawn_lamp(app), spawn_cube_at(app, 8.0, 0.0, 0.0));
        app.update();
        app.world_mut()
            .get_mut::<PointLight>(lamp)
            .expect("a lamp")
            .shadow_maps_enabled = false;
        app.update();
        assert_eq!(on_face(app, lamp, TO_THE_RIGHT), [aside]);
        assert!(!is_seen(app, aside));
    });
}

#[test]
fn a_lamp_that_no_camera_sees_keeps_its_lists_and_makes_nothing_visible() {
    of_both(|app| {
        let camera = spawn_camera(app);
        let (lamp, aside) = (spawn_lamp(app), spawn_cube_at(app, 8.0, 0.0, 0.0));
        app.update();
        insert(app, camera, Transform::from_xyz(0.0, 0.0, -100.0));
        app.update();
        assert_eq!(on_face(app, lamp, TO_THE_RIGHT), [aside]);
        assert!(!is_seen(app, aside));
    });
}

#[test]
fn what_casts_no_shadows_is_in_no_list_of_a_light() {
    of_both(|app| {
        let (camera, lamp, sun) = (spawn_camera(app), spawn_lamp(app), spawn_sun(app, 1));
        let cube = spawn_cube_at(app, 2.0, 0.0, 0.0);
        app.update();
        assert_eq!(on_face(app, lamp, TO_THE_RIGHT), [cube]);
        insert(app, cube, NotShadowCaster);
        assert_eq!(look(app, camera), [cube]);
        assert_eq!(on_face(app, lamp, TO_THE_RIGHT), []);
        assert_eq!(in_cascades(app, sun, camera), [vec![]]);
        remove::<NotShadowCaster>(app, cube);
        app.update();
        assert_eq!(on_face(app, lamp, TO_THE_RIGHT), [cube]);
    });
}

#[test]
fn what_has_no_mesh_is_hidden_or_culled_by_the_gpu_casts_no_shadow() {
    of_both(|app| {
        spawn_camera(app);
        let (lamp, cube) = (spawn_lamp(app), spawn_cube_at(app, 2.0, 0.0, 0.0));
        let mesh = cube_of(app, cube);
        app.update();
        remove::<Mesh3d>(app, cube);
        app.update();
        assert_eq!(on_face(app, lamp, TO_THE_RIGHT), []);
        insert(app, cube, (mesh, Visibility::Hidden));
        app.update();
        assert_eq!(on_face(app, lamp, TO_THE_RIGHT), []);
        insert(app, cube, (Visibility::Inherited, NoCpuCulling));
        app.update();
        assert_eq!(on_face(app, lamp, TO_THE_RIGHT), []);
        remove::<NoCpuCulling>(app, cube);
        app.update();
        assert_eq!(on_face(app, lamp, TO_THE_RIGHT), [cube]);
    });
}

fn cube_of(app: &App, entity: Entity) -> Mesh3d {
    app.world().get::<Mesh3d>(entity).expect("a mesh").clone()
}

#[test]
fn without_frustum_culling_a_mesh_casts_shadows_everywhere() {
    of_both(|app| {
        spawn_camera(app);
        let (lamp, spot) = (spawn_lamp(app), spawn_spot(app));
        let cube = spawn_cube_at(app, 500.0, 0.0, 0.0);
        insert(app, cube, NoFrustumCulling);
        app.update();
        assert!((0..6).all(|face| on_face(app, lamp, face) == [cube]));
        assert_eq!(in_cone(app, spot), [cube]);
    });
}

#[test]
fn lights_have_layers() {
    of_both(|app| {
        let (camera, lamp, sun) = (spawn_camera(app), spawn_lamp(app), spawn_sun(app, 1));
        let both = RenderLayers::from_layers(&[0, 1]);
        insert(app, camera, both.clone());
        let (zero, one) = (spawn_cube_at(app, 2.0, 0.0, 0.0), spawn_cube_at(app, 2.0, 0.0, 0.0));
        insert(app, one, RenderLayers::layer(1));
        app.update();
        assert_eq!(on_face(app, lamp, TO_THE_RIGHT), [zero]);
        insert(app, lamp, RenderLayers::layer(1));
        insert(app, sun, both);
        app.update();
        assert_eq!(on_face(app, lamp, TO_THE_RIGHT), [one]);
        assert_eq!(in_cascades(app, sun, camera), [sorted([zero, one])]);
    });
}

#[test]
fn a_hidden_light_makes_nothing_visible() {
    of_both(|app| {
        let (camera, sun) = (spawn_camera(app), spawn_sun(app, 1));
        let above = spawn_cube_at(app, 0.0, 500.0, 0.0);
        app.update();
        insert(app, sun, Visibility::Hidden);
        app.update();
        assert!(in_cascades(app, sun, camera).is_empty());
        assert!(!is_seen(app, above));
    });
}

#[test]
fn ranges_are_seen_by_lamps_from_the_origin_of_shadow_levels_of_detail() {
    of_both(|app| {
        spawn_camera(app);
        let (lamp, cube) = (spawn_lamp(app), spawn_cube_at(app, 2.0, 0.0, 0.0));
        insert(app, cube, VisibilityRange::abrupt(0.0, 50.0));
        app.update();
        assert_eq!(on_face(app, lamp, TO_THE_RIGHT), [cube]);
        let origin = spawn(app, (ShadowLodOrigin, Transform::from_xyz(0.0, 0.0, 100.0)));
        app.update();
        assert_eq!(on_face(app, lamp, TO_THE_RIGHT), []);
        app.world_mut().despawn(origin);
        app.update();
        assert_eq!(on_face(app, lamp, TO_THE_RIGHT), [cube]);
    });
}

#[test]
fn a_caster_that_is_despawned_is_in_no_list() {
    of_both(|app| {
        let (camera, lamp, spot, sun) = (spawn_camera(app), spawn_lamp(app), spawn_spot(app), spawn_sun(app, 1));
        let cube = spawn_cube_at(app, 2.0, 0.0, 0.0);
        app.update();
        assert_eq!(in_cascades(app, sun, camera), [vec![cube]]);
        app.world_mut().despawn(cube);
        app.update();
        assert_eq!(on_face(app, lamp, TO_THE_RIGHT), []);
        assert_eq!(in_cone(app, spot), []);
        assert_eq!(in_cascades(app, sun, camera), [vec![]]);
    });
}

#[test]
fn lists_of_lights_are_in_order() {
    of_both(|app| {
        spawn_camera(app);
        let (lamp, spot) = (spawn_lamp(app), spawn_spot(app));
        let cubes: Vec<Entity> = (0..20)
            .map(|i| spawn_cube_at(app, 2.0 + (i * 7 % 5) as f32, 0.0, 0.0))
            .collect();
        app.update();
        app.world_mut().despawn(cubes[3]);
        let late = spawn_cube_at(app, 4.0, 0.0, 0.0);
        app.update();
        let left = cubes.iter().filter(|&&cube| cube != cubes[3]).copied();
        let expected = sorted(left.chain([late]));
        assert_eq!(on_face(app, lamp, TO_THE_RIGHT), expected);
        assert_eq!(in_cone(app, spot), expected);
    });
}
