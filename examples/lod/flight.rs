//! The player's way through the city, by itself or by hand.

use bevy::{
    camera_controller::free_camera::{FreeCamera, FreeCameraState},
    input::mouse::{AccumulatedMouseScroll, MouseScrollUnit},
    prelude::*,
    window::PrimaryWindow,
};
use bevy_sightline::prelude::*;

use crate::{
    by_hand,
    options::Options,
    plan::Plan,
    route::Route,
    views::{Bird, Player},
};

/// The longest step, in seconds, so that slow frames do not jump.
const LONGEST_STEP: f32 = 0.2;
/// How far the player swings back and forth, in metres, and how often in a second.
const SWING: f32 = 4.0;
const SWINGS: f32 = 0.6;
/// What a step of the wheel multiplies the field of view with, and between which it stays, in degrees.
const ZOOM: f32 = 0.88;
const NARROWEST: f32 = 3.0;
const WIDEST: f32 = 75.0;

/// Along a street and back over the roofs, in parts of half the side of the city; heights are in metres.
const POINTS: [[f32; 3]; 10] = [
    [0.0, 8.0, 0.66],
    [0.0, 3.0, 0.34],
    [0.0, 3.0, 0.06],
    [0.0, 5.0, -0.20],
    [-0.10, 30.0, -0.44],
    [-0.30, 55.0, -0.52],
    [-0.48, 62.0, -0.34],
    [-0.50, 58.0, 0.0],
    [-0.40, 45.0, 0.36],
    [-0.22, 40.0, 0.70],
];

/// The way through a city of so many blocks.
pub fn route(blocks: u32) -> Route {
    let plan = Plan { blocks };
    Route::through(POINTS.map(|[x, y, z]| {
        let [x, z] = [x, z].map(|part| part * plan.half_size());
        Vec3::new(plan.main_street() + x, y, z)
    }))
}

/// Where a player that stays in one place is, after so many seconds.
pub fn swing(place: &Transform, seconds: f32) -> Transform {
    let along = SWING * (seconds * SWINGS * std::f32::consts::TAU).sin();
    Transform::from_translation(place.translation + place.forward() * along).with_rotation(place.rotation)
}

/// How the player flies.
#[derive(Resource)]
pub struct Flight {
    on: bool,
    /// In parts of the route.
    pub along: f32,
    /// Where the player swings back and forth, if it does, and for how many seconds.
    pub swing: Option<(Transform, f32)>,
    /// Whether the bird follows.
    pub is_followed: bool,
}

pub fn plugin(app: &mut App) {
    app.insert_resource(Flight {
        on: true,
        along: 0.0,
        swing: None,
        is_followed: true,
    })
    .add_systems(Update, ((take_over, fly).chain(), zoom));
}

fn take_over(
    keys: Res<ButtonInput<KeyCode>>,
    buttons: Res<ButtonInput<MouseButton>>,
    mut flight: ResMut<Flight>,
    player: Single<&Transform, With<Player>>,
) {
    if by_hand::is_steered(&keys, &buttons) {
        (flight.on, flight.swing) = (false, None);
    }
    if keys.just_pressed(KeyCode::Space) {
        flight.on ^= true;
        flight.swing = None;
    }
    if keys.just_pressed(KeyCode::KeyB) {
        flight.swing = match flight.swing {
            Some(_) => None,
            None => Some((**player, 0.0)),
        };
    }
    flight.is_followed ^= keys.just_pressed(KeyCode::KeyF);
}

fn fly(
    time: Res<Time>,
    options: Res<Options>,
    route: Res<Route>,
    mut flight: ResMut<Flight>,
    player: Single<(&mut Transform, &mut FreeCameraState), (With<Player>, With<FreeCamera>)>,
) {
    let step = time.delta_secs().min(LONGEST_STEP);
    let (mut transform, mut state) = player.into_inner();
    if let Some((place, seconds)) = &mut flight.swing {
        *seconds += step;
        by_hand::put(swing(place, *seconds), &mut transform, &mut state);
    } else if flight.on {
        if options.measure.is_none() {
            flight.along += step / options.seconds as f32;
        }
        by_hand::put(route.place(flight.along), &mut transform, &mut state);
    }
}

/// The wheel changes the field of view of the half that the mouse is over.
fn zoom(
    scroll: Res<AccumulatedMouseScroll>,
    keys: Res<ButtonInput<KeyCode>>,
    window: Single<&Window, With<PrimaryWindow>>,
    mut player: Single<(&mut Projection, &mut LodBias), (With<Player>, Without<Bird>)>,
    mut bird: Single<&mut Projection, With<Bird>>,
) {
    let steps = match scroll.unit {
        MouseScrollUnit::Line => scroll.delta.y,
        MouseScrollUnit::Pixel => scroll.delta.y / MouseScrollUnit::SCROLL_UNIT_CONVERSION_FACTOR,
    };
    let (of_player, bias) = &mut *player;
    if keys.just_pressed(KeyCode::KeyR) {
        for projection in [&mut **of_player, &mut **bird] {
            set_field_of_view(projection, PerspectiveProjection::default().fov);
        }
        **bias = LodBias::default();
    }
    if steps == 0.0 {
        return;
    }
    let is_right = window
        .cursor_position()
        .is_some_and(|place| place.x > window.width() / 2.0);
    let projection = if is_right { &mut **bird } else { &mut **of_player };
    let now = field_of_view(projection);
    let wanted = now * ZOOM.powf(steps);
    set_field_of_view(projection, wanted.clamp(NARROWEST.to_radians(), WIDEST.to_radians()));
}

/// From top to bottom, in radians.
pub fn field_of_view(projection: &Projection) -> f32 {
    match projection {
        Projection::Perspective(perspective) => perspective.fov,
        _ => PerspectiveProjection::default().fov,
    }
}

fn set_field_of_view(projection: &mut Projection, fov: f32) {
    if let Projection::Perspective(perspective) = projection {
        perspective.fov = fov;
    }
}
