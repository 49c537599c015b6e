//! A flight through the city: over the roofs, down into a street, and up again.

use bevy::{
    camera_controller::free_camera::{FreeCamera, FreeCameraState},
    prelude::*,
};

use crate::{
    by_hand,
    options::Options,
    plan::{PITCH, Plan},
    route::Route,
};

/// How long a round takes in the window, in seconds.
const SECONDS: f32 = 45.0;
/// The longest step, in seconds, so that slow frames do not jump.
const LONGEST_STEP: f32 = 0.2;
/// The size of the round, in metres, where the city is not smaller.
const SIZE: f32 = 560.0;

/// Of the round, in parts of its size; heights are in metres.
const POINTS: [[f32; 3]; 10] = [
    [0.28, 90.0, 0.62],
    [0.10, 60.0, 0.50],
    [0.0, 14.0, 0.34],
    [0.0, 3.0, 0.12],
    [0.0, 2.2, -0.14],
    [0.0, 9.0, -0.40],
    [-0.16, 48.0, -0.60],
    [-0.46, 75.0, -0.44],
    [-0.52, 120.0, 0.10],
    [-0.20, 130.0, 0.60],
];

/// Whether the camera flies by itself, and how far around it is.
#[derive(Resource, Default)]
pub struct Flight {
    pub is_on: bool,
    along: f32,
}

/// The way around the middle of the city.
pub fn route(blocks: u32) -> Route {
    let plan = Plan { blocks };
    let size = plan.half_size().min(SIZE);
    // The middle of a street.
    let street = (blocks / 2) as f32 * PITCH - plan.half_size();
    Route::through(POINTS.map(|[x, y, z]| Vec3::new(street + x * size, y, z * size)))
}

pub fn window_plugin(app: &mut App) {
    let blocks = app.world().resource::<Options>().blocks;
    app.init_resource::<Flight>()
        .insert_resource(route(blocks))
        .add_systems(Update, (take_over, fly).chain());
}

fn take_over(keys: Res<ButtonInput<KeyCode>>, buttons: Res<ButtonInput<MouseButton>>, mut flight: ResMut<Flight>) {
    if by_hand::is_steered(&keys, &buttons) {
        flight.is_on = false;
    }
    flight.is_on ^= keys.just_pressed(KeyCode::KeyF);
}

fn fly(
    time: Res<Time>,
    route: Res<Route>,
    mut flight: ResMut<Flight>,
    camera: Single<(&mut Transform, &mut FreeCameraState), With<FreeCamera>>,
) {
    if flight.is_on {
        flight.along += time.delta_secs().min(LONGEST_STEP) / SECONDS;
        let (mut transform, mut state) = camera.into_inner();
        by_hand::put(route.place(flight.along), &mut transform, &mut state);
    }
}
