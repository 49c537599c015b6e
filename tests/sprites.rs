//! Sprites are hit where Bevy draws them, and picked as by Bevy's own backend.

#[allow(dead_code, reason = "shared with the other tests")]
mod common;

#[path = "sprites/drawn.rs"]
mod drawn;
#[path = "sprites/follow.rs"]
mod follow;
#[path = "sprites/holes.rs"]
mod holes;
#[path = "sprites/order.rs"]
mod order;
#[path = "sprites/picking.rs"]
mod picking;
#[path = "readme/sprite.rs"]
#[rustfmt::skip]
#[expect(dead_code, reason = "that it compiles is what it is for")]
mod readme_sprite;
#[path = "sprites/scene.rs"]
mod scene;
#[path = "sprites/selection.rs"]
mod selection;
