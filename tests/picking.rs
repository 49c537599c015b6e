//! Pointers pick what is under them, as with Bevy's own backend.

use bevy::{
    asset::uuid::Uuid,
    camera::{
        NormalizedRenderTarget, RenderTarget, ScalingMode, Viewport,
        visibility::{RenderLayers, VisibilitySystems},
    },
    ecs::system::RunSystemOnce,
    picking::{
        backend::{
            HitData, PointerHits,
            ray::{RayId, RayMap},
        },
        hover::HoverMap,
        mesh_picking::{
            MeshPickingCamera, MeshPickingPlugin, MeshPickingSettings,
            ray_cast::{RayCastBackfaces, RayCastVisibility, SimplifiedMesh},
        },
        pointer::{Location, PointerAction, PointerButton, PointerId, PointerInput},
    },
    prelude::*,
    render::{camera::camera_system, texture::ManualTextureViews},
    window::{PrimaryWindow, WindowRef},
};
use bevy_sightline::prelude::*;
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use crate::common::*;

/// The middle of the window.
const MIDDLE: Vec2 = Vec2::new(640.0, 360.0);
/// A corner of the window in which nothing is.
const ASIDE: Vec2 = Vec2::new(10.0, 10.0);

/// What pointers did, in order: the event and the entity it was for.
#[derive(Resource, Default)]
struct Log(Vec<(&'static str, Entity)>);

/// A headless app whose cameras know the size of their window, without a camera.
fn app_without_camera() -> App {
    app_without_camera_with(|_| {})
}

/// The same, with more plugins.
fn app_without_camera_with(add_plugins: impl FnOnce(&mut App)) -> App {
    let mut app = headless_app_with(add_plugins);
    app.init_resource::<ManualTextureViews>()
        .init_resource::<Log>()
        .add_systems(PostUpdate, camera_system.before(VisibilitySystems::UpdateFrusta));
    app.add_observer(log::<Over>)
        .add_observer(log::<Out>)
        .add_observer(log::<Press>)
        .add_observer(log::<Click>);
    app.add_observer(log::<DragStart>)
        .add_observer(log::<Drag>)
        .add_observer(log::<DragEnd>);
    app
}

/// An app with a camera at z = 10 that looks at the origin.
fn app_with_camera() -> (App, Entity) {
    let mut app = app_without_camera();
    let camera = app
        .world_mut()
        .spawn((Camera3d::default(), Transform::from_xyz(0.0, 0.0, 10.0)))
        .id();
    (app, camera)
}

fn log<E: std::fmt::Debug + Clone + Reflect + TypePath>(event: On<Pointer<E>>, mut log: ResMut<Log>) {
    if event.entity == event.original_event_target() {
        log.0.push((E::short_type_path(), event.entity));
    }
}

/// What has been logged since this was last called, but for the window, which is behind everything.
fn drain_log(app: &mut App) -> Vec<(&'static str, Entity)> {
    let window = window(app);
    let log = std::mem::take(&mut app.world_mut().resource_mut::<Log>().0);
    log.into_iter().filter(|(_, entity)| *entity != window).collect()
}

fn window(app: &mut App) -> Entity {
    app.world_mut()
        .query_filtered::<Entity, With<PrimaryWindow>>()
        .single(app.world())
        .expect("a window")
}

fn send(app: &mut App, pointer_id: PointerId, position: Vec2, action: PointerAction) {
    let window = window(app);
    let target = RenderTarget::Window(WindowRef::Primary)
        .normalize(Some(window))
        .expect("a window");
    let location = Location { target, position };
    app.world_mut()
        .write_message(PointerInput::new(pointer_id, location, action));
    app.update();
}

/// Presses the primary button of the mouse.
fn press(app: &mut App, position: Vec2) {
    send(
        app,
        PointerId::Mouse,
        position,
        PointerAction::Press(PointerButton::Primary),
    );
}

/// Releases it.
fn release(app: &mut App, position: Vec2) {
    send(
        app,
        PointerId::Mouse,
        position,
        PointerAction::Release(PointerButton::Primary),
    );
}

/// Moves the mouse to a position in the window, and runs a frame.
fn move_to(app: &mut App, position: Vec2) {
    send(
        app,
        PointerId::Mouse,
        position,
        PointerAction::Move { delta: Vec2::ONE },
    );
}

/// The entities under a pointer, in the order in which they were spawned.
fn hovered_by(app: &mut App, pointer: PointerId) -> Vec<Entity> {
    let window = window(app);
    let hovered = app
        .world()
        .resource::<HoverMap>()
        .get(&pointer)
        .into_iter()
        .flat_map(|hits| hits.keys());
    let mut hovered: Vec<Entity> = hovered.copied().filter(|entity| *entity != window).collect();
    hovered.sort_by_key(|entity| entity.index_u32());
    hovered
}

/// The entities under the mouse at a position in the window, once the index knows what there is.
fn hovered_at(app: &mut App, position: Vec2) -> Vec<Entity> {
    settle(app);
    move_to(app, position);
    hovered_by(app, PointerId::Mouse)
}

/// The hit of the mouse on an entity.
fn hit_on(app: &App, entity: Entity) -> HitData {
    app.world().resource::<HoverMap>()[&PointerId::Mouse]
        .get(&entity)
        .expect("a hovered entity")
        .clone()
}

/// Where a camera sees a point, in the window.
fn on_screen(app: &App, camera: Entity, point: Vec3) -> Vec2 {
    let camera = app.world().entity(camera);
    let (place, camera) = (camera.get::<GlobalTransform>(), camera.get::<Camera>());
    let position = camera
        .expect("a camera")
        .world_to_viewport(place.expect("a place"), point);
    position.expect("in view")
}

// --- Events ---

#[test]
fn a_pointer_picks_a_shape_without_a_mesh() {
    let (mut app, _) = app_with_camera();
    let shape = app.world_mut().spawn(PickShape::new(Sphere::new(1.0))).id();
    app.update();
    assert_eq!(hovered_at(&mut app, MIDDLE), [shape]);
    assert_eq!(hovered_at(&mut app, ASIDE), []);
}

#[test]
fn a_pointer_goes_over_an_entity_and_out_again() {
    let (mut app, _) = app_with_camera();
    let cube = spawn_cube(&mut app, Vec3::ZERO);
    settle(&mut app);
    move_to(&mut app, ASIDE);
    assert_eq!(drain_log(&mut app), []);
    move_to(&mut app, MIDDLE);
    assert_eq!(drain_log(&mut app), [("Over", cube)]);
    move_to(&mut app, ASIDE);
    assert_eq!(drain_log(&mut app), [("Out", cube)]);
}

#[test]
fn events_come_once_with_bevys_backend_beside_ours() {
    let mut app = app_without_camera_with(|app| _ = app.add_plugins(MeshPickingPlugin));
    let place = Transform::from_xyz(0.0, 0.0, 10.0);
    app.world_mut().spawn((Camera3d::default(), place));
    let cube = spawn_cube(&mut app, Vec3::ZERO);
    settle(&mut app);
    move_to(&mut app, MIDDLE);
    press(&mut app, MIDDLE);
    release(&mut app, MIDDLE);
    assert_eq!(drain_log(&mut app), [("Over", cube), ("Press", cube), ("Click", cube)]);
}

#[test]
fn an_entity_is_clicked() {
    let (mut app, _) = app_with_camera();
    let cube = spawn_cube(&mut app, Vec3::ZERO);
    settle(&mut app);
    move_to(&mut app, MIDDLE);
    press(&mut app, MIDDLE);
    release(&mut app, MIDDLE);
    assert_eq!(drain_log(&mut app), [("Over", cube), ("Press", cube), ("Click", cube)]);
}

#[test]
fn an_entity_is_dragged_to_where_another_is() {
    let (mut app, camera) = app_with_camera();
    let cube = spawn_cube(&mut app, Vec3::ZERO);
    let other = spawn_cube(&mut app, Vec3::X * 3.0);
    settle(&mut app);
    let there = on_screen(&app, camera, Vec3::X * 3.0);
    move_to(&mut app, MIDDLE);
    press(&mut app, MIDDLE);
    drain_log(&mut app);
    move_to(&mut app, there);
    assert_eq!(
        drain_log(&mut app),
        [("Out", cube), ("Over", other), ("DragStart", cube), ("Drag", cube)]
    );
    release(&mut app, there);
    assert_eq!(drain_log(&mut app), [("DragEnd", cube)]);
}

#[test]
fn an_observer_of_one_entity_is_told_of_the_ray_that_hit_it() {
    #[derive(Resource)]
    struct Clicked(RayHit);

    let (mut app, _) = app_with_camera();
    let cube = spawn_cube(&mut app, Vec3::ZERO);
    app.world_mut()
        .entity_mut(cube)
        .observe(|click: On<Pointer<Click>>, mut commands: Commands| {
            let hit = click.hit.extra_as::<RayHit>().expect("a hit of this backend");
            commands.insert_resource(Clicked(*hit));
        });
    settle(&mut app);
    move_to(&mut app, MIDDLE);
    press(&mut app, MIDDLE);
    release(&mut app, MIDDLE);
    assert_eq!(app.world().resource::<Clicked>().0.entity, cube);
}

#[test]
fn a_hit_carries_everything_that_is_known_of_it() {
    let (mut app, camera) = app_with_camera();
    let quad = spawn_mesh(&mut app, Rectangle::new(2.0, 2.0), Transform::default());
    settle(&mut app);
    let position = on_screen(&app, camera, Vec3::new(0.5, 0.25, 0.0));
    assert_eq!(hovered_at(&mut app, position), [quad]);
    let data = hit_on(&app, quad);
    let hit = data.extra_as::<RayHit>().expect("a hit of this backend");
    assert_eq!((data.camera, data.depth), (camera, hit.distance));
    assert_eq!((data.position, data.normal), (Some(hit.position), Some(hit.normal)));
    assert!(hit.position.abs_diff_eq(Vec3::new(0.5, 0.25, 0.0), 1e-3) && hit.normal.abs_diff_eq(Vec3::Z, 1e-5));
    assert!(
        hit.uv
            .expect("texture coordinates")
            .abs_diff_eq(Vec2::new(0.75, 0.375), 1e-3)
    );
    let HitTriangle {
        vertices: [a, b, c],
        barycentrics,
        ..
    } = hit.triangle.expect("a triangle");
    let weighted = a * barycentrics.x + b * barycentrics.y + c * barycentrics.z;
    assert!(weighted.abs_diff_eq(hit.position, 1e-4));
}

// --- What can be picked ---

#[test]
fn the_nearest_entity_hides_what_is_behind_it() {
    let (mut app, _) = app_with_camera();
    spawn_cube(&mut app, Vec3::NEG_Z * 3.0);
    let near = spawn_cube(&mut app, Vec3::ZERO);
    assert_eq!(hovered_at(&mut app, MIDDLE), [near]);
}

#[test]
fn ignored_and_unhoverable_entities_are_looked_through() {
    let unhoverable = Pickable {
        is_hoverable: false,
        should_block_lower: true,
    };
    for pickable in [Pickable::IGNORE, unhoverable] {
        let (mut app, _) = app_with_camera();
        let far = spawn_cube(&mut app, Vec3::NEG_Z * 3.0);
        let near = spawn_cube(&mut app, Vec3::ZERO);
        app.world_mut().entity_mut(near).insert(pickable);
        assert_eq!(hovered_at(&mut app, MIDDLE), [far]);
        app.world_mut().entity_mut(near).remove::<Pickable>();
        assert_eq!(hovered_at(&mut app, MIDDLE), [near]);
    }
}

#[test]
fn an_entity_that_does_not_block_is_hovered_with_what_is_behind_it() {
    let (mut app, _) = app_with_camera();
    let cubes = [0.0, -3.0, -6.0].map(|z| spawn_cube(&mut app, Vec3::Z * z));
    app.world_mut().entity_mut(cubes[0]).insert(Pickable {
        is_hoverable: true,
        should_block_lower: false,
    });
    assert_eq!(hovered_at(&mut app, MIDDLE), cubes[..2]);
}

#[test]
fn hidden_entities_are_not_picked() {
    let (mut app, _) = app_with_camera();
    let cube = spawn_cube(&mut app, Vec3::ZERO);
    app.world_mut().entity_mut(cube).insert(Visibility::Hidden);
    assert_eq!(hovered_at(&mut app, MIDDLE), []);
    app.world_mut().entity_mut(cube).insert(Visibility::Visible);
    assert_eq!(hovered_at(&mut app, MIDDLE), [cube]);
}

#[test]
fn the_settings_say_what_is_visible() {
    let (mut app, _) = app_with_camera();
    let cube = spawn_cube(&mut app, Vec3::ZERO);
    app.world_mut().entity_mut(cube).insert(Visibility::Hidden);
    let picked = |app: &mut App, visibility| {
        app.world_mut()
            .resource_mut::<MeshPickingSettings>()
            .ray_cast_visibility = visibility;
        hovered_at(app, MIDDLE)
    };
    assert_eq!(picked(&mut app, RayCastVisibility::Any), [cube]);
    assert_eq!(picked(&mut app, RayCastVisibility::Visible), []);
    assert_eq!(picked(&mut app, RayCastVisibility::VisibleInView), []);
    app.world_mut().entity_mut(cube).insert(Visibility::Visible);
    assert_eq!(picked(&mut app, RayCastVisibility::VisibleInView), [cube]);
}

#[test]
fn a_camera_picks_what_is_on_its_layers() {
    let (mut app, camera) = app_with_camera();
    let far = spawn_cube(&mut app, Vec3::NEG_Z * 3.0);
    let near = spawn_cube(&mut app, Vec3::ZERO);
    app.world_mut().entity_mut(near).insert(RenderLayers::layer(1));
    assert_eq!(hovered_at(&mut app, MIDDLE), [far]);
    app.world_mut().entity_mut(camera).insert(RenderLayers::layer(1));
    assert_eq!(hovered_at(&mut app, MIDDLE), [near]);
    app.world_mut().entity_mut(camera).insert(RenderLayers::layer(2));
    assert_eq!(hovered_at(&mut app, MIDDLE), []);
}

#[test]
fn where_markers_are_required_only_what_is_marked_is_picked() {
    let (mut app, camera) = app_with_camera();
    app.world_mut().resource_mut::<MeshPickingSettings>().require_markers = true;
    let cube = spawn_cube(&mut app, Vec3::ZERO);
    assert_eq!(hovered_at(&mut app, MIDDLE), []);
    app.world_mut().entity_mut(cube).insert(Pickable::default());
    assert_eq!(hovered_at(&mut app, MIDDLE), [], "the camera is not marked");
    app.world_mut().entity_mut(camera).insert(MeshPickingCamera);
    assert_eq!(hovered_at(&mut app, MIDDLE), [cube]);
    app.world_mut().entity_mut(cube).remove::<Pickable>();
    assert_eq!(hovered_at(&mut app, MIDDLE), [], "the cube is not marked");
}

#[test]
fn back_faces_are_picked_where_the_entity_says_so() {
    let (mut app, camera) = app_with_camera();
    let room = spawn_mesh(&mut app, Cuboid::new(30.0, 30.0, 30.0), Transform::default());
    assert_eq!(hovered_at(&mut app, MIDDLE), [], "the camera is inside");
    app.world_mut().entity_mut(room).insert(RayCastBackfaces);
    assert_eq!(hovered_at(&mut app, MIDDLE), [room]);
    assert_eq!(hit_on(&app, room).camera, camera);
}

#[test]
fn the_simplified_mesh_is_picked() {
    let (mut app, camera) = app_with_camera();
    let cube = spawn_cube(&mut app, Vec3::ZERO);
    let simple = add_mesh(&mut app, Cuboid::new(3.0, 0.2, 1.0));
    app.world_mut().entity_mut(cube).insert(SimplifiedMesh(simple));
    settle(&mut app);
    let (beside, above) = (
        on_screen(&app, camera, Vec3::X * 1.2),
        on_screen(&app, camera, Vec3::Y * 0.4),
    );
    assert_eq!(hovered_at(&mut app, beside), [cube]);
    assert_eq!(hovered_at(&mut app, above), []);
}

#[test]
fn a_mesh_in_two_dimensions_is_picked_from_both_sides() {
    let mut app = app_without_camera();
    let camera = app.world_mut().spawn(Camera2d).id();
    let mesh = add_mesh(&mut app, Circle::new(50.0));
    let turned = Transform::from_xyz(100.0, 0.0, 0.0).with_rotation(Quat::from_rotation_y(std::f32::consts::PI));
    let coins = [Transform::default(), turned].map(|place| app.world_mut().spawn((Mesh2d(mesh.clone()), place)).id());
    assert_eq!(hovered_at(&mut app, MIDDLE), [coins[0]]);
    assert_eq!(hovered_at(&mut app, MIDDLE + Vec2::new(130.0, 20.0)), [coins[1]]);
    assert_eq!(
        hovered_at(&mut app, MIDDLE + Vec2::new(48.0, 48.0)),
        [],
        "outside the circle, inside its box"
    );
    app.world_mut().despawn(camera);
    assert_eq!(hovered_at(&mut app, MIDDLE), []);
}

#[test]
fn of_meshes_in_two_dimensions_the_one_in_front_is_picked_through_a_camera_that_pans_and_zooms() {
    let mut app = app_without_camera();
    let projection = OrthographicProjection {
        scale: 0.5,
        ..OrthographicProjection::default_2d()
    };
    let pan = Transform::from_xyz(200.0, 100.0, 0.0);
    app.world_mut()
        .spawn((Camera2d, Projection::Orthographic(projection), pan));
    let mesh = add_mesh(&mut app, Rectangle::new(20.0, 10.0));
    let mut card = |x: f32, z: f32| {
        let place = Transform::from_xyz(200.0 + x, 100.0, z);
        app.world_mut().spawn((Mesh2d(mesh.clone()), place)).id()
    };
    let [front, back, behind_the_camera] = [card(0.0, 5.0), card(8.0, -900.0), card(16.0, 500.0)];
    // Two pixels are one unit: the cards end 20 pixels to either side of their middles.
    let at = |pixels: f32| MIDDLE + Vec2::X * pixels;
    assert_eq!(hovered_at(&mut app, at(0.0)), [front]);
    assert_eq!(
        hovered_at(&mut app, at(11.0)),
        [front],
        "where the other two are too, or not yet"
    );
    assert_eq!(
        hovered_at(&mut app, at(22.0)),
        [behind_the_camera],
        "an eye in two dimensions sees behind itself"
    );

    app.world_mut()
        .get_mut::<Transform>(front)
        .expect("a place")
        .translation
        .z = -950.0;
    assert_eq!(hovered_at(&mut app, at(0.0)), [back]);
    app.world_mut().despawn(back);
    assert_eq!(hovered_at(&mut app, at(0.0)), [front]);
    assert_eq!(hovered_at(&mut app, MIDDLE + Vec2::Y * 11.0), [], "above it");
}

// --- Cameras and pointers ---

#[test]
fn the_camera_on_top_picks_first() {
    let (mut app, _) = app_with_camera();
    let near = spawn_cube(&mut app, Vec3::ZERO);
    let overlay = spawn_mesh(&mut app, Cuboid::default(), Transform::from_xyz(0.0, 0.0, -3.0));
    app.world_mut().entity_mut(overlay).insert(RenderLayers::layer(1));
    let on_top = Camera { order: 1, ..default() };
    let place = Transform::from_xyz(0.0, 0.0, 10.0);
    let camera = app
        .world_mut()
        .spawn((Camera3d::default(), on_top, place, RenderLayers::layer(1)))
        .id();
    assert_eq!(
        hovered_at(&mut app, MIDDLE),
        [overlay],
        "farther away, and drawn on top"
    );
    assert_eq!(hit_on(&app, overlay).camera, camera);
    app.world_mut().get_mut::<Camera>(camera).expect("a camera").order = -1;
    assert_eq!(hovered_at(&mut app, MIDDLE), [near]);
}

#[test]
fn every_viewport_picks_through_its_own_camera() {
    let mut app = app_without_camera();
    let cameras = [(0, 0.0), (640, 100.0)].map(|(left, x)| {
        let viewport = Viewport {
            physical_position: UVec2::new(left, 0),
            physical_size: UVec2::new(640, 720),
            ..default()
        };
        let camera = Camera {
            viewport: Some(viewport),
            order: left as isize,
            ..default()
        };
        app.world_mut()
            .spawn((Camera3d::default(), camera, Transform::from_xyz(x, 0.0, 10.0)))
            .id()
    });
    let cubes = [0.0, 100.0].map(|x| spawn_cube(&mut app, Vec3::X * x));
    for (cube, (camera, x)) in cubes.into_iter().zip(cameras.into_iter().zip([320.0, 960.0])) {
        assert_eq!(hovered_at(&mut app, Vec2::new(x, 360.0)), [cube]);
        assert_eq!(hit_on(&app, cube).camera, camera);
    }
    assert_eq!(hovered_at(&mut app, MIDDLE), []);
}

#[test]
fn an_inactive_camera_does_not_pick() {
    let (mut app, camera) = app_with_camera();
    let cube = spawn_cube(&mut app, Vec3::ZERO);
    app.world_mut()
        .resource_mut::<MeshPickingSettings>()
        .ray_cast_visibility = RayCastVisibility::Visible;
    assert_eq!(hovered_at(&mut app, MIDDLE), [cube]);
    app.world_mut().get_mut::<Camera>(camera).expect("a camera").is_active = false;
    assert_eq!(hovered_at(&mut app, MIDDLE), []);
}

#[test]
fn an_orthographic_camera_picks_along_parallel_rays() {
    let mut app = app_without_camera();
    let scaling_mode = ScalingMode::FixedVertical { viewport_height: 7.2 };
    let projection = OrthographicProjection {
        scaling_mode,
        ..OrthographicProjection::default_3d()
    };
    let place = Transform::from_xyz(0.0, 0.0, 10.0);
    app.world_mut()
        .spawn((Camera3d::default(), Projection::Orthographic(projection), place));
    let far = spawn_cube(&mut app, Vec3::new(3.0, 0.0, -50.0));
    assert_eq!(hovered_at(&mut app, MIDDLE + Vec2::X * 340.0), [far]);
    assert_eq!(hovered_at(&mut app, MIDDLE + Vec2::X * 360.0), []);
}

#[test]
fn two_pointers_pick_at_the_same_time() {
    let (mut app, camera) = app_with_camera();
    let [left, right] = [-2.0, 2.0].map(|x| spawn_cube(&mut app, Vec3::X * x));
    let finger = PointerId::Custom(Uuid::from_u128(7));
    app.world_mut().spawn(finger);
    settle(&mut app);
    let [at_left, at_right] = [-2.0, 2.0].map(|x| on_screen(&app, camera, Vec3::X * x));
    move_to(&mut app, at_left);
    send(&mut app, finger, at_right, PointerAction::Move { delta: Vec2::ONE });
    assert_eq!(hovered_by(&mut app, PointerId::Mouse), [left]);
    assert_eq!(hovered_by(&mut app, finger), [right]);
}

#[test]
fn a_pointer_on_another_target_picks_nothing() {
    let (mut app, _) = app_with_camera();
    spawn_cube(&mut app, Vec3::ZERO);
    settle(&mut app);
    let target = NormalizedRenderTarget::None {
        width: 1280,
        height: 720,
    };
    let action = PointerAction::Move { delta: Vec2::ONE };
    let input = PointerInput::new(
        PointerId::Mouse,
        Location {
            target,
            position: MIDDLE,
        },
        action,
    );
    app.world_mut().write_message(input);
    app.update();
    assert_eq!(hovered_by(&mut app, PointerId::Mouse), []);
}

#[test]
fn what_is_picked_follows_the_scene_while_the_pointer_rests() {
    let (mut app, _) = app_with_camera();
    let cube = spawn_cube(&mut app, Vec3::ZERO);
    assert_eq!(hovered_at(&mut app, MIDDLE), [cube]);
    app.world_mut()
        .entity_mut(cube)
        .insert(Transform::from_xyz(5.0, 0.0, 0.0));
    settle(&mut app);
    app.update();
    assert_eq!(hovered_by(&mut app, PointerId::Mouse), []);
    app.world_mut().despawn(cube);
    let other = spawn_cube(&mut app, Vec3::ZERO);
    settle(&mut app);
    app.update();
    assert_eq!(hovered_by(&mut app, PointerId::Mouse), [other]);
}

// --- Next to Bevy's backend ---

/// Some 300 entities of all kinds.
fn spawn_random_scene(app: &mut App, rng: &mut ChaCha8Rng) {
    let meshes: [Mesh; 4] = [
        Cuboid::default().into(),
        Sphere::new(0.7).into(),
        Torus::new(0.3, 0.9).into(),
        Plane3d::default().mesh().size(2.0, 2.0).into(),
    ];
    let meshes = meshes.map(|mesh| add_mesh(app, mesh));
    // Inside all of the others but the plane: Bevy misses what sticks out of the box of the mesh that is drawn.
    let simple = add_mesh(app, Cuboid::new(0.5, 0.5, 0.5));
    for i in 0..300 {
        let mesh = meshes[i % meshes.len()].clone();
        let scale = random_point(rng, 2.0) + 0.05;
        let place = Transform::from_translation(random_point(rng, 8.0))
            .with_rotation(random_rotation(rng))
            .with_scale(scale);
        let mut entity = app.world_mut().spawn((Mesh3d(mesh), place));
        if rng.random_bool(0.5) {
            entity.insert(Pickable {
                is_hoverable: rng.random_bool(0.8),
                should_block_lower: rng.random(),
            });
        }
        if rng.random_bool(0.4) {
            entity.insert(RenderLayers::from_layers(
                [&[0][..], &[1], &[0, 1], &[2]][rng.random_range(0..4)],
            ));
        }
        if rng.random_bool(0.2) {
            entity.insert(Visibility::Hidden);
        }
        if rng.random_bool(0.2) {
            entity.insert(RayCastBackfaces);
        }
        if i % 12 < 3 {
            entity.insert(SimplifiedMesh(simple.clone()));
        }
    }
}

/// The hits that a backend reports, by camera order.
fn hits_of<M>(app: &mut App, backend: impl IntoSystem<(), (), M>) -> Vec<PointerHits> {
    app.world_mut().resource_mut::<Messages<PointerHits>>().clear();
    app.world_mut().run_system_once(backend).expect("the backend runs");
    let mut hits: Vec<PointerHits> = app
        .world_mut()
        .resource_mut::<Messages<PointerHits>>()
        .drain()
        .collect();
    hits.sort_by(|a, b| a.order.total_cmp(&b.order));
    hits
}

/// Takes away what no pointer event reaches: by the rule of Bevy's hover system, what has no `Pickable` blocks.
fn cut_where_blocked(app: &App, hits: &mut [PointerHits]) {
    for PointerHits { picks, .. } in hits {
        let blocks = |(entity, _): &(Entity, HitData)| {
            let pickable = app.world().entity(*entity).get::<Pickable>();
            pickable.is_none_or(|pickable| pickable.should_block_lower)
        };
        if let Some(blocker) = picks.iter().position(blocks) {
            picks.truncate(blocker + 1);
        }
    }
}

fn assert_same_hits(ours: &[PointerHits], bevys: &[PointerHits]) {
    let groups = |hits: &[PointerHits]| -> Vec<_> {
        let entities = |hits: &PointerHits| {
            hits.picks
                .iter()
                .map(|(entity, hit)| (*entity, hit.camera))
                .collect::<Vec<_>>()
        };
        hits.iter()
            .map(|hits| (hits.pointer, hits.order, entities(hits)))
            .collect()
    };
    assert_eq!(groups(ours), groups(bevys));
    let picks = |hits: &[PointerHits]| {
        hits.iter()
            .flat_map(|hits| hits.picks.clone())
            .map(|(_, hit)| hit)
            .collect::<Vec<_>>()
    };
    for (our, bevy) in picks(ours).into_iter().zip(picks(bevys)) {
        assert!((our.depth - bevy.depth).abs() <= 1e-4 * bevy.depth, "{our:?} {bevy:?}");
        let (our, bevy) = (our.position.expect("a position"), bevy.position.expect("a position"));
        assert!(our.abs_diff_eq(bevy, 1e-3), "{our} {bevy}");
    }
}

#[test]
fn picks_what_bevys_backend_picks() {
    for seed in 0..3 {
        let (mut app, camera) = app_with_camera();
        let mut rng = rng(80 + seed);
        spawn_random_scene(&mut app, &mut rng);
        app.world_mut().entity_mut(camera).insert(MeshPickingCamera);
        let on_top = Camera { order: 1, ..default() };
        let from_aside = Transform::from_xyz(12.0, 9.0, -14.0).looking_at(Vec3::ZERO, Vec3::Y);
        let layers = RenderLayers::from_layers(&[1, 2]);
        let other = app
            .world_mut()
            .spawn((Camera3d::default(), on_top, from_aside, layers))
            .id();
        settle(&mut app);
        let mut picks = 0;
        for i in 0..600 {
            let visibility = [
                RayCastVisibility::VisibleInView,
                RayCastVisibility::Visible,
                RayCastVisibility::Any,
            ][i % 3];
            let settings = MeshPickingSettings {
                require_markers: i % 5 == 0,
                ray_cast_visibility: visibility,
            };
            app.insert_resource(settings);
            let position = Vec2::new(rng.random_range(200.0..1080.0), rng.random_range(0.0..720.0));
            let rays = [camera, other].map(|id| {
                let entity = app.world().entity(id);
                let place = entity.get::<GlobalTransform>().expect("a place");
                let ray = entity
                    .get::<Camera>()
                    .expect("a camera")
                    .viewport_to_world(place, position);
                (RayId::new(id, PointerId::Mouse), ray.expect("a ray"))
            });
            app.world_mut().resource_mut::<RayMap>().map = rays.into_iter().collect();
            let mut bevys = hits_of(&mut app, bevy::picking::mesh_picking::update_hits);
            app.insert_resource(SpatialPickingSettings { report_blocked: true });
            let ours = hits_of(&mut app, bevy_sightline::picking::update_hits);
            assert_same_hits(&ours, &bevys);

            app.insert_resource(SpatialPickingSettings { report_blocked: false });
            cut_where_blocked(&app, &mut bevys);
            assert_same_hits(&hits_of(&mut app, bevy_sightline::picking::update_hits), &bevys);
            picks += ours.iter().map(|hits| hits.picks.len()).sum::<usize>();
        }
        assert!(picks > 300, "only {picks} picks");
    }
}
