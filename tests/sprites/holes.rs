//! Rays pass through what is transparent, by choice.

use bevy::{prelude::*, sprite::Sprite};
use bevy_sightline::{prelude::*, sprite::SpriteMasks};

use crate::{common::*, scene::*};

const BOARD: UVec2 = UVec2::splat(8);

/// A chess board of eight by eight pixels around the origin, with an opaque pixel at the top left.
fn with_board() -> (App, Entity) {
    let mut app = app();
    let board = add_image(&mut app, chess_board(BOARD));
    let sprite = app.world_mut().spawn(Sprite::from_image(board)).id();
    app.update();
    (app, sprite)
}

/// The middles of two pixels side by side: an opaque one, and a transparent one.
const PIXELS: [Vec2; 2] = [Vec2::new(-3.5, 3.5), Vec2::new(-2.5, 3.5)];

fn hits(app: &mut App) -> [bool; 2] {
    PIXELS.map(|place| hit(app, place.x, place.y).is_some())
}

#[test]
fn a_ray_passes_through_a_transparent_pixel_to_what_is_behind() {
    let (mut app, board) = with_board();
    let wall = Sprite::from_color(Color::WHITE, Vec2::splat(100.0));
    let wall = app.world_mut().spawn((wall, Transform::from_xyz(0.0, 0.0, -5.0))).id();
    app.update();
    assert_eq!(entity_at(&mut app, PIXELS[0].x, PIXELS[0].y), Some(board));
    assert_eq!(entity_at(&mut app, PIXELS[1].x, PIXELS[1].y), Some(wall));
}

#[test]
fn the_texture_coordinates_tell_the_pixel() {
    let (mut app, _) = with_board();
    let found = hit(&mut app, -3.25, 1.75).expect("an opaque pixel");
    assert_eq!(pixel(found, BOARD), Vec2::new(0.75, 2.25));
}

#[test]
fn the_settings_turn_the_test_off_and_on() {
    let (mut app, _) = with_board();
    assert_eq!(hits(&mut app), [true, false]);
    app.world_mut().resource_mut::<SpriteIndexSettings>().alpha_test = AlphaTest::Off;
    app.update();
    assert_eq!(hits(&mut app), [true, true]);
    app.world_mut().resource_mut::<SpriteIndexSettings>().alpha_test = AlphaTest::default();
    app.update();
    assert_eq!(hits(&mut app), [true, false]);
}

#[test]
fn a_sprite_may_have_a_test_of_its_own() {
    let (mut app, board) = with_board();
    app.world_mut().entity_mut(board).insert(AlphaTest::Off);
    app.update();
    assert_eq!(hits(&mut app), [true, true]);
    app.world_mut().entity_mut(board).insert(AlphaTest::Above(1.0));
    app.update();
    assert_eq!(hits(&mut app), [false, false]);
    app.world_mut().entity_mut(board).remove::<AlphaTest>();
    app.update();
    assert_eq!(hits(&mut app), [true, false]);
}

#[test]
fn alpha_has_to_be_above_the_threshold() {
    let mut app = app();
    let grey = add_image(&mut app, image(BOARD, |_| 51));
    let sprite = app
        .world_mut()
        .spawn((Sprite::from_image(grey), AlphaTest::Above(0.2)))
        .id();
    app.update();
    assert_eq!(entity_at(&mut app, 0.0, 0.0), None, "51 / 255 is 0.2");
    app.world_mut().entity_mut(sprite).insert(AlphaTest::Above(0.19));
    app.update();
    assert_eq!(entity_at(&mut app, 0.0, 0.0), Some(sprite));
}

#[test]
fn an_image_that_is_painted_anew_is_tested_anew() {
    let (mut app, board) = with_board();
    let handle = app.world().get::<Sprite>(board).expect("a sprite").image.clone();
    let inverse = image(
        BOARD,
        |pixel| if (pixel.x + pixel.y).is_multiple_of(2) { 0 } else { 255 },
    );
    let mut images = app.world_mut().resource_mut::<Assets<Image>>();
    *images.get_mut(&handle).expect("the image") = inverse;
    app.update();
    assert_eq!(hits(&mut app), [false, true]);
}

#[test]
fn sprites_share_the_mask_of_an_image_and_it_goes_with_the_last_of_them() {
    let mut app = app();
    let size = UVec2::splat(256);
    let board = add_image(&mut app, chess_board(size));
    let memory = |app: &App| app.world().resource::<SpriteMasks>().memory();
    let first = app.world_mut().spawn(Sprite::from_image(board.clone())).id();
    app.update();
    let of_one = memory(&app);
    assert!(
        (256 * 256 / 8..256 * 256 / 8 + 64).contains(&of_one),
        "a bit a pixel: {of_one}"
    );
    let second = app.world_mut().spawn(Sprite::from_image(board)).id();
    app.update();
    assert_eq!(memory(&app), of_one);
    for sprite in [first, second] {
        app.world_mut().despawn(sprite);
    }
    app.update();
    assert_eq!(memory(&app), 0);
}

#[test]
fn an_image_without_holes_takes_no_mask() {
    let mut app = app();
    let solid = add_image(&mut app, image(BOARD, |_| 255));
    let sprite = app.world_mut().spawn(Sprite::from_image(solid)).id();
    app.update();
    assert_eq!(entity_at(&mut app, 0.0, 0.0), Some(sprite));
    assert_eq!(app.world().resource::<SpriteMasks>().memory(), 0);
}

#[test]
fn an_image_that_cannot_be_read_counts_as_opaque() {
    let in_render_world = |board: &mut Image| board.data = None;
    let truncated = |board: &mut Image| board.data.as_mut().expect("pixels").truncate(7);
    let empty = |board: &mut Image| board.data = Some(Vec::new());
    for spoil in [in_render_world, truncated, empty] as [fn(&mut Image); 3] {
        let mut app = app();
        let mut board = chess_board(BOARD);
        spoil(&mut board);
        let board = add_image(&mut app, board);
        app.world_mut().spawn(Sprite::from_image(board));
        app.update();
        assert_eq!(hits(&mut app), [true, true]);
    }
}

#[test]
fn an_image_that_goes_to_the_render_world_after_it_was_read_keeps_its_holes() {
    let (mut app, board) = with_board();
    let handle = app.world().get::<Sprite>(board).expect("a sprite").image.clone();
    let mut images = app.world_mut().resource_mut::<Assets<Image>>();
    images.get_mut_untracked(&handle).expect("the image").data = None;
    app.world_mut()
        .spawn((Sprite::from_image(handle), Transform::from_xyz(0.0, 0.0, 1.0)));
    app.update();
    assert_eq!(hits(&mut app), [true, false]);
}

#[test]
fn line_of_sight_goes_through_holes() {
    let (mut app, _) = with_board();
    let sees = |app: &mut App, place: Vec2| {
        let (front, back) = (place.extend(1.0), place.extend(-1.0));
        query(app, |scene| {
            scene.line_of_sight(front, back, &SceneQuerySettings::default())
        })
    };
    assert_eq!(PIXELS.map(|place| sees(&mut app, place)), [false, true]);
}
