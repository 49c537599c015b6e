//! Sprites in the index: rays, queries and pointers hit a `Sprite` where Bevy draws it.
//!
//! [`SpriteIndexPlugin`] gives every entity with a `Sprite` a flat surface, which is hit from both sides: the rectangle
//! that its image, [`rect`](bevy::sprite::Sprite::rect), texture atlas, [`custom_size`](bevy::sprite::Sprite::custom_size),
//! [`image_mode`](bevy::sprite::Sprite::image_mode) and `Anchor` make, with the image on it as it is drawn, also mirrored, scaled,
//! tiled and in nine slices. The [texture coordinates](crate::index::RayHit::uv) of a hit are those of the image, so that
//! they tell the pixel. A [`PickShape`](crate::index::PickShape) goes before the sprite.
//!
//! # Holes
//!
//! By default a ray passes through what is transparent, by the alpha of the image alone: see [`AlphaTest`]. What is kept
//! for that is one bit for each pixel, shared by all sprites with that image, and nothing if the image has no holes.
//! An image whose pixels cannot be read counts as opaque, with one warning: one in a compressed format, or one that has
//! been only in the render world since before a sprite used it.
//!
//! An image that is not loaded counts as opaque too; a sprite whose size depends on it is not hit until it is loaded.
//!
//! A `SpriteMesh` is no `Sprite`: Bevy draws it with a mesh that it stretches on the GPU, and so rays hit a unit square.
//!
//! # Order
//!
//! Of sprites that face the camera the one with the higher z comes first, whatever their scales, and however little
//! higher: the order does not suffer from the distance of the camera. Of several at the same z the one with the smaller
//! `Entity` comes first, which is the one that was spawned later as long as nothing has been despawned: so it is what
//! Bevy draws on top.
//!
//! # Differences from Bevy's own backend
//!
//! [`SpriteIndexPlugin`], beside `SpatialPickingPlugin`, takes Bevy's `sprite_picking` out of the schedule, which goes
//! through all sprites for every pointer, and answers in its place. Where Bevy's own answers differ:
//!
//! - It looks at sprites with a `Pickable` only. Here all are picked, as meshes are, unless
//!   [`MeshPickingSettings::require_markers`](bevy::picking::mesh_picking::MeshPickingSettings) is set.
//! - There, a sprite that blocks what is below it does so also if it is not hoverable. Here it is passed over, as meshes
//!   are.
//! - It looks through orthographic cameras only, and takes sprites by the z of their `Transform`, not by depth.
//! - Of sprites at the same z it takes the one that was spawned first.
//! - It takes every `image_mode` for `Auto`.
//! - It misses sprites whose image cannot be read; while an image without a size is loading, it hits one unit.

mod follow;
mod layout;
mod mask;
mod replace;
mod stats;
mod surface;

use bevy::{
    app::{App, Plugin, PostUpdate},
    asset::{AssetEvent, AssetEventSystems, Assets},
    ecs::{
        component::Component,
        message::Messages,
        reflect::{ReflectComponent, ReflectResource},
        resource::Resource,
        schedule::{IntoScheduleConfigs, common_conditions::resource_exists},
    },
    image::{Image, TextureAtlasLayout},
    reflect::{Reflect, std_traits::ReflectDefault},
};

pub use follow::SpriteMasks;
pub use stats::SpriteIndexStats;

use crate::index::{SpatialIndexPlugin, SpatialIndexSystems};

/// Which pixels of a sprite can be hit; as a component, of this sprite, whatever the [`SpriteIndexSettings`] say.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub enum AlphaTest {
    /// All of its rectangle.
    Off,
    /// The pixels whose alpha is above this, from 0 to 1. 0.1 by default, as in Bevy.
    Above(f32),
}

impl Default for AlphaTest {
    fn default() -> Self {
        Self::Above(0.1)
    }
}

/// How sprites are hit. May be changed at any time.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Resource, Default, Debug, Clone, PartialEq)]
pub struct SpriteIndexSettings {
    /// Which pixels can be hit, of all sprites without an [`AlphaTest`] of their own.
    pub alpha_test: AlphaTest,
}

/// Keeps the surfaces of all sprites in step with the world. Adds [`SpatialIndexPlugin`] by itself.
///
/// Needs no renderer, only Bevy's `ImagePlugin` and `TextureAtlasPlugin`; without them, sprites have no surface.
#[derive(Clone, Copy, Debug, Default)]
pub struct SpriteIndexPlugin;

impl Plugin for SpriteIndexPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(SpatialIndexPlugin)
            .init_resource::<SpriteIndexSettings>()
            .init_resource::<SpriteIndexStats>()
            .init_resource::<SpriteMasks>()
            .register_type::<AlphaTest>()
            .register_type::<SpriteIndexSettings>()
            .register_type::<SpriteIndexStats>()
            .add_systems(
                PostUpdate,
                follow::follow_sprites
                    .run_if(resource_exists::<Assets<Image>>)
                    .run_if(resource_exists::<Messages<AssetEvent<Image>>>)
                    .run_if(resource_exists::<Assets<TextureAtlasLayout>>)
                    .run_if(resource_exists::<Messages<AssetEvent<TextureAtlasLayout>>>)
                    .after(AssetEventSystems)
                    .before(SpatialIndexSystems::Sync),
            );
    }

    fn finish(&self, app: &mut App) {
        replace::replace_bevys_backend(app);
    }
}
