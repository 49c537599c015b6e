//! A camera that goes by itself until somebody takes it over.

use bevy::{camera_controller::free_camera::FreeCameraState, prelude::*};

/// Whether somebody steers the free camera now.
pub fn is_steered(keys: &ButtonInput<KeyCode>, buttons: &ButtonInput<MouseButton>) -> bool {
    let controls = [
        KeyCode::KeyW,
        KeyCode::KeyA,
        KeyCode::KeyS,
        KeyCode::KeyD,
        KeyCode::KeyE,
        KeyCode::KeyQ,
    ];
    keys.any_pressed(controls) || buttons.pressed(MouseButton::Right)
}

/// Puts the free camera somewhere, so that going by hand goes on from there.
pub fn put(place: Transform, transform: &mut Transform, state: &mut FreeCameraState) {
    *transform = place;
    (state.yaw, state.pitch, _) = place.rotation.to_euler(EulerRot::YXZ);
}
