//! Pointers pick sprites, as with Bevy's own backend.

use bevy::{
    app::Plugins,
    asset::AssetPlugin,
    camera::{CameraPlugin, RenderTarget, visibility::VisibilitySystems},
    image::{ImagePlugin, TextureAtlasPlugin},
    input::InputPlugin,
    mesh::MeshPlugin,
    picking::{
        DefaultPickingPlugins,
        backend::PointerHits,
        hover::HoverMap,
        pointer::{Location, PointerAction, PointerId, PointerInput},
    },
    prelude::*,
    render::{camera::camera_system, texture::ManualTextureViews},
    sprite::{Anchor, SpritePickingMode, SpritePickingSettings, SpritePlugin},
    text::TextPlugin,
    window::{PrimaryWindow, WindowPlugin, WindowRef},
};
use bevy_sightline::prelude::*;
use rand::Rng;

use crate::{common::rng, scene::*};

/// An app with a camera and Bevy's own backend, which plugins of ours may replace.
fn app_with<M>(plugins: impl Plugins<M>) -> App {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        AssetPlugin::default(),
        TransformPlugin,
        ImagePlugin::default(),
        TextureAtlasPlugin,
        MeshPlugin,
        WindowPlugin::default(),
        CameraPlugin,
        InputPlugin,
        DefaultPickingPlugins,
        TextPlugin,
        SpritePlugin,
    ));
    app.add_plugins(plugins)
        .init_resource::<ManualTextureViews>()
        .add_systems(PostUpdate, camera_system.before(VisibilitySystems::UpdateFrusta));
    app.finish();
    app.cleanup();
    app.world_mut().spawn(Camera2d);
    app
}

/// Which sprite of a scene it is.
#[derive(Component, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
struct Id(usize);

/// Sprites on top of each other, of any kind that Bevy's backend knows, the same in every app.
fn spawn_scene(app: &mut App, seed: u64) {
    let rng = &mut rng(seed);
    let size = UVec2::new(64, 48);
    let texels: Vec<u8> = (0..size.x * size.y).map(|_| rng.random()).collect();
    // Holes of four by four pixels.
    let holes = move |pixel: UVec2| texels[(pixel.y / 4 * size.x + pixel.x / 4) as usize];
    let sheet = add_image(app, image(size, holes));
    let layout = add_atlas(app, UVec2::new(16, 12), 4, 4);
    for id in 0..300 {
        let texture_atlas = rng.random_bool(0.5).then(|| TextureAtlas {
            layout: layout.clone(),
            index: rng.random_range(0..16),
        });
        let custom_size = rng
            .random_bool(0.5)
            .then(|| Vec2::new(rng.random_range(20.0..200.0), rng.random_range(20.0..200.0)));
        let rect = rng.random_bool(0.3).then(|| Rect::new(1.5, 2.0, 11.0, 9.5));
        let sprite = Sprite {
            image: sheet.clone(),
            texture_atlas,
            custom_size,
            rect,
            flip_x: rng.random(),
            flip_y: rng.random(),
            ..default()
        };
        let anchor = [Anchor::CENTER, Anchor::TOP_LEFT, Anchor(Vec2::new(0.2, -0.7))][rng.random_range(0..3)];
        let mut scale = || rng.random_range(0.3_f32..3.0) * if rng.random() { 1.0 } else { -1.0 };
        let scale = Vec3::new(scale(), scale(), 1.0);
        let z = rng.random_range(-50.0..50.0);
        let place = Transform::from_xyz(rng.random_range(-600.0..600.0), rng.random_range(-330.0..330.0), z)
            .with_rotation(Quat::from_rotation_z(rng.random_range(0.0..7.0)))
            .with_scale(scale);
        // What cannot be hovered does not block either: there the two differ.
        let is_hoverable = rng.random_bool(0.9);
        let pickable = Pickable {
            should_block_lower: is_hoverable && rng.random_bool(0.2),
            is_hoverable,
        };
        app.world_mut().spawn((Id(id), sprite, anchor, place, pickable));
    }
    app.update();
    app.update();
}

fn move_to(app: &mut App, position: Vec2) {
    let mut windows = app.world_mut().query_filtered::<Entity, With<PrimaryWindow>>();
    let window = windows.single(app.world()).expect("a window");
    let target = RenderTarget::Window(WindowRef::Primary).normalize(Some(window));
    let location = Location {
        target: target.expect("a window"),
        position,
    };
    let moved = PointerAction::Move { delta: Vec2::ONE };
    app.world_mut()
        .write_message(PointerInput::new(PointerId::Mouse, location, moved));
    app.update();
}

/// The sprites under the mouse at a position in the window, with the depth and the place of the hit.
fn hovered_at(app: &mut App, position: Vec2) -> Vec<(Id, f32, Vec3)> {
    move_to(app, position);
    let mut ids = app.world_mut().query::<&Id>();
    let world = app.world();
    let hovered = world.resource::<HoverMap>().get(&PointerId::Mouse);
    let mut hovered: Vec<_> = (hovered.into_iter().flatten())
        .filter_map(|(&entity, hit)| Some((*ids.get(world, entity).ok()?, hit.depth, hit.position?)))
        .collect();
    hovered.sort_by_key(|(id, ..)| *id);
    hovered
}

fn picks_what_bevy_picks(seed: u64, test: AlphaTest, mode: SpritePickingMode) {
    let (mut ours, mut bevys) = (app_with(SightlinePlugins), app_with(()));
    ours.world_mut().resource_mut::<SpriteIndexSettings>().alpha_test = test;
    bevys.world_mut().resource_mut::<SpritePickingSettings>().picking_mode = mode;
    spawn_scene(&mut ours, seed);
    spawn_scene(&mut bevys, seed);
    let rng = &mut rng(seed + 1);
    let mut picked = 0;
    for _ in 0..150 {
        let position = Vec2::new(rng.random_range(0.0..1280.0), rng.random_range(0.0..720.0));
        let [ours, bevys] = [&mut ours, &mut bevys].map(|app| hovered_at(app, position));
        let same = ours.len() == bevys.len()
            && (ours.iter().zip(&bevys)).all(|(ours, bevys)| {
                ours.0 == bevys.0 && (ours.1 - bevys.1).abs() < 1e-3 && ours.2.distance(bevys.2) < 1e-2
            });
        assert!(same, "at {position}: {ours:?}, not {bevys:?}");
        picked += ours.len();
    }
    assert!(picked > 100, "only {picked} picks");
}

#[test]
fn pointers_pick_the_rectangles_that_bevy_picks() {
    picks_what_bevy_picks(1, AlphaTest::Off, SpritePickingMode::BoundingBox);
}

#[test]
fn pointers_pick_the_pixels_that_bevy_picks() {
    picks_what_bevy_picks(2, AlphaTest::default(), SpritePickingMode::AlphaThreshold(0.1));
    picks_what_bevy_picks(3, AlphaTest::Above(0.6), SpritePickingMode::AlphaThreshold(0.6));
}

/// The pick messages of one frame in which the pointer is in the middle of the window.
fn messages(app: &mut App) -> usize {
    app.update();
    app.world_mut().resource_mut::<Messages<PointerHits>>().clear();
    move_to(app, Vec2::new(640.0, 360.0));
    let messages = app.world().resource::<Messages<PointerHits>>();
    let cursor = &mut messages.get_cursor();
    let mut ids = 0;
    for hits in cursor.read(messages) {
        ids += hits
            .picks
            .iter()
            .filter(|(entity, _)| app.world().get::<Id>(*entity).is_some())
            .count();
    }
    ids
}

#[test]
fn a_sprite_is_picked_once_for_bevys_backend_is_replaced() {
    let mut app = app_with(SightlinePlugins);
    let sprite = Sprite::from_color(Color::WHITE, Vec2::splat(10.0));
    app.world_mut().spawn((Id(0), sprite, Pickable::default()));
    assert_eq!(messages(&mut app), 1);
}

#[test]
fn bevys_backend_stays_where_ours_does_not_pick() {
    let mut app = app_with(SpriteIndexPlugin);
    let sprite = Sprite::from_color(Color::WHITE, Vec2::splat(10.0));
    app.world_mut().spawn((Id(0), sprite, Pickable::default()));
    assert_eq!(messages(&mut app), 1);
}

#[test]
fn a_sprite_needs_no_pickable() {
    let mut app = app_with(SightlinePlugins);
    let sprite = Sprite::from_color(Color::WHITE, Vec2::splat(10.0));
    app.world_mut().spawn((Id(7), sprite));
    app.update();
    let ids: Vec<Id> = hovered_at(&mut app, Vec2::new(640.0, 360.0))
        .into_iter()
        .map(|(id, ..)| id)
        .collect();
    assert_eq!(ids, [Id(7)]);
}

#[test]
fn a_pointer_reaches_through_a_hole() {
    let mut app = app_with(SightlinePlugins);
    let board = add_image(&mut app, chess_board(UVec2::splat(2)));
    let board = Sprite {
        custom_size: Some(Vec2::splat(100.0)),
        ..Sprite::from_image(board)
    };
    let wall = Sprite::from_color(Color::WHITE, Vec2::splat(100.0));
    app.world_mut().spawn((Id(0), board));
    app.world_mut()
        .spawn((Id(1), wall, Transform::from_xyz(0.0, 0.0, -1.0)));
    app.update();
    let at = |app: &mut App, x: f32, y: f32| hovered_at(app, Vec2::new(640.0 + x, 360.0 + y))[0].0;
    assert_eq!(at(&mut app, -25.0, -25.0), Id(0), "the opaque top left");
    assert_eq!(at(&mut app, 25.0, -25.0), Id(1), "the transparent top right");
}
