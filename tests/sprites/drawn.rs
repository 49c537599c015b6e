//! A sprite is hit where Bevy draws it, and tells the pixel that is drawn there.

use bevy::{
    prelude::*,
    sprite::{Anchor, BorderRect, SliceScaleMode, SpriteImageMode, SpriteScalingMode, TextureSlice, TextureSlicer},
};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use crate::{common::*, scene::*};

const IMAGE: UVec2 = UVec2::new(64, 48);
const TILE: UVec2 = UVec2::new(16, 12);

/// Closer than this to an edge, rounding decides.
const EDGE: f32 = 1e-3;

struct Sheet {
    image: Handle<Image>,
    layout: Handle<TextureAtlasLayout>,
}

fn with_sheet() -> (App, Sheet) {
    let mut app = app();
    let image = add_image(&mut app, image(IMAGE, |_| 255));
    let layout = add_atlas(&mut app, TILE, 4, 4);
    (app, Sheet { image, layout })
}

/// A sprite with any of what it may have, and its anchor.
fn random_sprite(rng: &mut ChaCha8Rng, sheet: &Sheet) -> (Sprite, Anchor) {
    let texture_atlas = rng.random_bool(0.5).then(|| TextureAtlas {
        layout: sheet.layout.clone(),
        index: rng.random_range(0..16),
    });
    let rect = rng.random_bool(0.4).then(|| {
        let min = Vec2::new(rng.random_range(0.0..5.0), rng.random_range(0.0..5.0));
        Rect::from_corners(
            min,
            min + Vec2::new(rng.random_range(1.0..8.0), rng.random_range(1.0..6.0)),
        )
    });
    let custom_size = rng
        .random_bool(0.5)
        .then(|| Vec2::new(rng.random_range(2.0..90.0), rng.random_range(2.0..90.0)));
    let anchors = [
        Anchor::CENTER,
        Anchor::TOP_LEFT,
        Anchor::BOTTOM_CENTER,
        Anchor(Vec2::new(0.3, -1.2)),
    ];
    let sprite = Sprite {
        image: sheet.image.clone(),
        texture_atlas,
        rect,
        custom_size,
        flip_x: rng.random(),
        flip_y: rng.random(),
        ..default()
    };
    (sprite, anchors[rng.random_range(0..anchors.len())])
}

/// Rotated, mirrored, stretched, and somewhere.
fn random_place(rng: &mut ChaCha8Rng) -> Transform {
    let mut scale = || rng.random_range(0.2_f32..3.0) * if rng.random() { 1.0 } else { -1.0 };
    let scale = Vec3::new(scale(), scale(), 1.0);
    Transform::from_translation(random_point(rng, 200.0))
        .with_rotation(Quat::from_rotation_z(rng.random_range(0.0..7.0)))
        .with_scale(scale)
}

/// Compares what rays tell of random sprites with what `oracle` says of the same points in their local space: the pixel
/// there, and how far from an edge the point is, in pixels.
fn agree(
    seed: u64,
    sprite: impl Fn(&mut ChaCha8Rng, &Sheet) -> (Sprite, Anchor),
    oracle: impl Fn(&World, &Sprite, Anchor, Vec2) -> (Option<Vec2>, f32),
) {
    let (mut app, sheet) = with_sheet();
    let rng = &mut rng(seed);
    let mut hits = 0;
    for _ in 0..60 {
        let ((sprite, anchor), place) = (sprite(rng, &sheet), random_place(rng));
        let entity = app.world_mut().spawn((sprite.clone(), anchor, place)).id();
        app.update();
        for _ in 0..60 {
            let point = random_point(rng, 100.0).truncate() * rng.random_range(0.1..1.0);
            let (expected, margin) = oracle(app.world(), &sprite, anchor, point);
            if margin < EDGE {
                continue;
            }
            let world = place.transform_point(point.extend(0.0));
            let found = hit(&mut app, world.x, world.y).map(|hit| pixel(hit, IMAGE));
            let near = |(found, expected): (Vec2, Vec2)| found.distance(expected) < 2e-3;
            let same = found.is_some() == expected.is_some() && found.zip(expected).is_none_or(near);
            assert!(
                same,
                "{found:?}, not {expected:?}, at {point} of {sprite:?} at {anchor:?}"
            );
            hits += usize::from(found.is_some());
        }
        app.world_mut().despawn(entity);
    }
    assert!(hits > 100, "only {hits} hits");
}

/// How far a point is inside or outside of a rectangle.
fn margin(rect: Rect, point: Vec2) -> f32 {
    let outside = (rect.min - point).max(point - rect.max);
    outside.max_element().abs()
}

#[test]
fn the_pixel_is_the_one_that_bevy_computes() {
    agree(1, random_sprite, |world, sprite, anchor, point| {
        let (images, layouts) = (world.resource(), world.resource());
        match sprite.compute_pixel_space_point(point, anchor, images, layouts) {
            // Half a pixel away from the next, whatever the size of the rectangle is.
            Ok(pixel) => (Some(pixel), 1.0),
            Err(pixel) => {
                let size = sprite.texture_atlas.as_ref().map_or(IMAGE, |_| TILE).as_vec2();
                let rect = sprite.rect.unwrap_or(Rect::from_corners(Vec2::ZERO, size));
                let corner = sprite.texture_atlas.as_ref().map_or(Vec2::ZERO, |atlas| {
                    let index = atlas.index as u32;
                    (UVec2::new(index % 4, index / 4) * TILE).as_vec2()
                });
                let rect = Rect::from_corners(rect.min + corner, rect.max + corner);
                (None, margin(rect, pixel))
            }
        }
    });
}

/// The pixel at a point of a sprite that is drawn in these slices around `center`, as Bevy's renderer places them.
fn pixel_in(slices: &[TextureSlice], sprite: &Sprite, center: Vec2, point: Vec2) -> (Option<Vec2>, f32) {
    let flip = Vec2::new(
        if sprite.flip_x { -1.0 } else { 1.0 },
        if sprite.flip_y { -1.0 } else { 1.0 },
    );
    let mut least = f32::INFINITY;
    let mut pixel = None;
    for slice in slices {
        let area = Rect::from_center_size(center + slice.offset * flip, slice.draw_size);
        least = least.min(margin(area, point));
        if area.contains(point) {
            let from_top_left = (point - area.center()) * flip * Vec2::new(1.0, -1.0) / slice.draw_size + 0.5;
            pixel = Some(slice.texture_rect.min + slice.texture_rect.size() * from_top_left);
        }
    }
    (pixel, least)
}

fn source_of(sprite: &Sprite) -> Rect {
    match &sprite.texture_atlas {
        Some(atlas) => {
            let index = atlas.index as u32;
            let min = (UVec2::new(index % 4, index / 4) * TILE).as_vec2();
            Rect::from_corners(min, min + TILE.as_vec2())
        }
        None => sprite.rect.unwrap_or(Rect::from_corners(Vec2::ZERO, IMAGE.as_vec2())),
    }
}

fn center_of(sprite: &Sprite, anchor: Anchor) -> Vec2 {
    let rect = sprite.rect.map(|rect| rect.size());
    -anchor.as_vec() * sprite.custom_size.or(rect).unwrap_or(Vec2::ZERO)
}

#[test]
fn nine_slices_lie_as_bevy_slices_them() {
    let random = |rng: &mut ChaCha8Rng, sheet: &Sheet| {
        let (mut sprite, anchor) = random_sprite(rng, sheet);
        let mode = |rng: &mut ChaCha8Rng| match rng.random() {
            true => SliceScaleMode::Stretch,
            false => SliceScaleMode::Tile {
                stretch_value: rng.random_range(0.05..2.0),
            },
        };
        let inset = |rng: &mut ChaCha8Rng| Vec2::new(rng.random_range(0.0..4.0), rng.random_range(0.0..4.0)).floor();
        sprite.image_mode = SpriteImageMode::Sliced(TextureSlicer {
            border: BorderRect {
                min_inset: inset(rng),
                max_inset: inset(rng),
            },
            center_scale_mode: mode(rng),
            sides_scale_mode: mode(rng),
            max_corner_scale: rng.random_range(0.5..2.0),
        });
        (sprite, anchor)
    };
    agree(2, random, |_, sprite, anchor, point| {
        let SpriteImageMode::Sliced(slicer) = &sprite.image_mode else {
            unreachable!("all are sliced");
        };
        let slices = slicer.compute_slices(source_of(sprite), sprite.custom_size);
        pixel_in(&slices, sprite, center_of(sprite, anchor), point)
    });
}

#[test]
fn tiles_lie_as_bevy_tiles_them() {
    let random = |rng: &mut ChaCha8Rng, sheet: &Sheet| {
        let (mut sprite, anchor) = random_sprite(rng, sheet);
        sprite.image_mode = SpriteImageMode::Tiled {
            tile_x: rng.random(),
            tile_y: rng.random(),
            stretch_value: rng.random_range(0.05..2.0),
        };
        (sprite, anchor)
    };
    agree(3, random, |_, sprite, anchor, point| {
        let SpriteImageMode::Tiled {
            tile_x,
            tile_y,
            stretch_value,
        } = sprite.image_mode
        else {
            unreachable!("all are tiled");
        };
        let slice = TextureSlice {
            texture_rect: source_of(sprite),
            draw_size: sprite.custom_size.unwrap_or(IMAGE.as_vec2()),
            offset: Vec2::ZERO,
        };
        let slices = slice.tiled(stretch_value, (tile_x, tile_y));
        pixel_in(&slices, sprite, center_of(sprite, anchor), point)
    });
}

/// An image of 64 by 48 pixels in a square of 96 by 96: what is drawn at points of the square.
fn scaled(mode: SpriteScalingMode, flip_x: bool, flip_y: bool, points: [Vec2; 3]) -> [Option<Vec2>; 3] {
    let (mut app, sheet) = with_sheet();
    app.world_mut().spawn(Sprite {
        image: sheet.image,
        custom_size: Some(Vec2::splat(96.0)),
        image_mode: SpriteImageMode::Scale(mode),
        flip_x,
        flip_y,
        ..default()
    });
    app.update();
    points.map(|point| hit(&mut app, point.x, point.y).map(|hit| pixel(hit, IMAGE).round()))
}

#[test]
fn an_image_that_fits_leaves_the_rest_of_its_square_free() {
    // Half as large again: 96 by 72.
    let (top, middle, bottom) = (Vec2::new(-48.0, 42.0), Vec2::ZERO, Vec2::new(-48.0, -42.0));
    let points = [top, middle, bottom];
    let at = |x, y| Some(Vec2::new(x, y));
    use SpriteScalingMode::*;
    assert_eq!(scaled(FitCenter, false, false, points), [None, at(32.0, 24.0), None]);
    assert_eq!(
        scaled(FitStart, false, false, points),
        [at(0.0, 4.0), at(32.0, 32.0), None]
    );
    assert_eq!(
        scaled(FitEnd, false, false, points),
        [None, at(32.0, 16.0), at(0.0, 44.0)]
    );
    assert_eq!(
        scaled(FitStart, true, true, points),
        [at(64.0, 44.0), at(32.0, 16.0), None]
    );
}

#[test]
fn an_image_that_fills_its_square_shows_a_part_of_itself() {
    // Twice as large: 128 by 96, so that a quarter of its width is not seen.
    let points = [Vec2::new(-48.0, 48.0), Vec2::ZERO, Vec2::new(48.0, -48.0)];
    let at = |x, y| Some(Vec2::new(x, y));
    use SpriteScalingMode::*;
    let expected = [at(8.0, 0.0), at(32.0, 24.0), at(56.0, 48.0)];
    assert_eq!(scaled(FillCenter, false, false, points), expected);
    let expected = [at(0.0, 0.0), at(24.0, 24.0), at(48.0, 48.0)];
    assert_eq!(scaled(FillStart, false, false, points), expected);
    let expected = [at(16.0, 0.0), at(40.0, 24.0), at(64.0, 48.0)];
    assert_eq!(scaled(FillEnd, false, false, points), expected);
    // Bevy mirrors what is in the window, after it has chosen the window from the side where it is drawn.
    let expected = [at(64.0, 48.0), at(40.0, 24.0), at(16.0, 0.0)];
    assert_eq!(scaled(FillStart, true, true, points), expected);
}

#[test]
fn a_border_of_no_width_is_no_cell() {
    let (mut app, sheet) = with_sheet();
    app.world_mut().spawn(Sprite {
        image: sheet.image,
        image_mode: SpriteImageMode::Sliced(TextureSlicer::default()),
        ..default()
    });
    app.update();
    let corners = [Vec2::new(-32.0, 24.0), Vec2::new(32.0, -24.0)];
    let pixels = corners.map(|corner| hit(&mut app, corner.x, corner.y).map(|hit| pixel(hit, IMAGE)));
    assert_eq!(pixels, [Some(Vec2::ZERO), Some(IMAGE.as_vec2())]);
}

#[test]
fn a_slice_with_holes_has_them_where_they_are_drawn() {
    let mut app = app();
    // A frame of two pixels around a hole.
    let size = UVec2::splat(8);
    let frame = image(size, |pixel| {
        if pixel.min(size - 1 - pixel).min_element() < 2 {
            255
        } else {
            0
        }
    });
    let frame = add_image(&mut app, frame);
    app.world_mut().spawn(Sprite {
        image: frame,
        custom_size: Some(Vec2::new(100.0, 40.0)),
        image_mode: SpriteImageMode::Sliced(TextureSlicer {
            border: BorderRect::all(2.0),
            ..default()
        }),
        ..default()
    });
    app.update();
    for (place, is_hit) in [
        ((0.0, 0.0), false),
        ((47.9, 0.0), false),
        ((48.1, 0.0), true),
        ((0.0, 17.9), false),
        ((0.0, 18.1), true),
    ] {
        assert_eq!(hit(&mut app, place.0, place.1).is_some(), is_hit, "{place:?}");
    }
}

#[test]
fn a_sprite_that_is_flattened_along_its_own_normal_is_still_where_it_is_drawn() {
    let (mut app, sheet) = with_sheet();
    let place = Transform::from_xyz(5.0, 0.0, 2.0).with_scale(Vec3::new(2.0, 2.0, 0.0));
    let sprite = app.world_mut().spawn((Sprite::from_image(sheet.image), place)).id();
    app.update();
    let found = hit(&mut app, 68.0, 47.0).expect("inside");
    assert_eq!((found.entity, found.distance, found.normal), (sprite, 998.0, Vec3::Z));
}
