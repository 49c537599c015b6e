//! What the tests of sprites share: an app, and images.

use bevy::{image::TextureAtlasPlugin, prelude::*, sprite::SpritePlugin, text::TextPlugin};
use bevy_sightline::prelude::*;

use crate::common::*;

/// A headless app with sprites.
pub fn app() -> App {
    headless_app_with(|app| {
        // Bevy's sprites draw text too where it is built with the examples.
        app.add_plugins((TextureAtlasPlugin, TextPlugin, SpritePlugin));
    })
}

/// An image whose pixels have the alpha that `alpha` says.
pub fn image(size: UVec2, alpha: impl Fn(UVec2) -> u8) -> Image {
    let mut image = Image::default();
    image.texture_descriptor.size.width = size.x;
    image.texture_descriptor.size.height = size.y;
    let pixels = (0..size.y).flat_map(|y| (0..size.x).map(move |x| UVec2::new(x, y)));
    image.data = Some(pixels.flat_map(|pixel| [255, 255, 255, alpha(pixel)]).collect());
    image
}

/// An image of which every other pixel is transparent, like a chess board with an opaque pixel at the top left.
pub fn chess_board(size: UVec2) -> Image {
    image(
        size,
        |pixel| if (pixel.x + pixel.y).is_multiple_of(2) { 255 } else { 0 },
    )
}

/// Adds an image asset.
pub fn add_image(app: &mut App, image: Image) -> Handle<Image> {
    app.world_mut().resource_mut::<Assets<Image>>().add(image)
}

/// Adds an atlas of `columns` by `rows` tiles.
pub fn add_atlas(app: &mut App, tile: UVec2, columns: u32, rows: u32) -> Handle<TextureAtlasLayout> {
    let layout = TextureAtlasLayout::from_grid(tile, columns, rows, None, None);
    app.world_mut().resource_mut::<Assets<TextureAtlasLayout>>().add(layout)
}

/// What a ray down the z axis hits at a point, with the default settings.
pub fn hit(app: &mut App, x: f32, y: f32) -> Option<RayHit> {
    cast(app, down_at(x, y))
}

/// Which entity that is.
pub fn entity_at(app: &mut App, x: f32, y: f32) -> Option<Entity> {
    hit(app, x, y).map(|hit| hit.entity)
}

/// A ray down the z axis, from where the camera of a 2D game is.
pub fn down_at(x: f32, y: f32) -> Ray3d {
    Ray3d::new(Vec3::new(x, y, 1000.0), Dir3::NEG_Z)
}

/// The pixel that was hit, in an image of such a size.
pub fn pixel(hit: RayHit, size: UVec2) -> Vec2 {
    hit.uv.expect("sprites have texture coordinates") * size.as_vec2()
}
