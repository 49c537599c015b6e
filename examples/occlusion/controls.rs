//! The keys: who walks, and how occlusion works.

use bevy::{
    camera_controller::free_camera::{FreeCamera, FreeCameraState},
    prelude::*,
};
use bevy_sightline::prelude::*;

use crate::{
    by_hand,
    stopwatch::Stopwatch,
    walk::{Round, Walker},
};

/// In metres a second.
const SPEED: f32 = 6.0;
/// Where the walk begins, in metres after the first corner.
const START: f32 = 144.0;
/// The longest step, in seconds, so that slow frames do not jump.
const LONGEST_STEP: f32 = 0.2;

const RESOLUTIONS: [UVec2; 5] = [
    UVec2::new(256, 128),
    UVec2::new(512, 256),
    UVec2::new(1024, 512),
    UVec2::new(1280, 720),
    UVec2::new(1920, 1080),
];

/// Whether the camera walks by itself.
#[derive(Resource)]
struct Walk {
    on: bool,
    /// In metres.
    along: f32,
}

/// How occlusion works while it is on.
#[derive(Resource, Default)]
pub struct Settings(pub SoftwareOcclusion);

pub fn plugin(app: &mut App) {
    app.insert_resource(Walk { on: true, along: START })
        .init_resource::<Settings>()
        .add_systems(Update, ((take_over, walk).chain(), choose));
}

fn take_over(keys: Res<ButtonInput<KeyCode>>, buttons: Res<ButtonInput<MouseButton>>, mut walk: ResMut<Walk>) {
    if by_hand::is_steered(&keys, &buttons) {
        walk.on = false;
    }
    walk.on ^= keys.just_pressed(KeyCode::Space);
}

fn walk(
    time: Res<Time>,
    round: Res<Round>,
    mut walk: ResMut<Walk>,
    walker: Single<(&mut Transform, &mut FreeCameraState), (With<Walker>, With<FreeCamera>)>,
) {
    if !walk.on {
        return;
    }
    walk.along += SPEED * time.delta_secs().min(LONGEST_STEP);
    let (mut transform, mut state) = walker.into_inner();
    by_hand::put(round.place(walk.along), &mut transform, &mut state);
}

/// Occlusion is a component of the camera: it comes, changes and goes at any time.
fn choose(
    keys: Res<ButtonInput<KeyCode>>,
    mut commands: Commands,
    walker: Single<(Entity, Has<SoftwareOcclusion>), With<Walker>>,
    mut settings: ResMut<Settings>,
    mut watch: ResMut<Stopwatch>,
) {
    let (walker, is_on) = *walker;
    let old = settings.0;
    if keys.just_pressed(KeyCode::KeyM) {
        settings.0.mode = match old.mode {
            RasterMode::Strict => RasterMode::Fast,
            RasterMode::Fast => RasterMode::Strict,
        };
    }
    if keys.just_pressed(KeyCode::KeyR) {
        let now = RESOLUTIONS.iter().position(|&size| size == old.resolution);
        settings.0.resolution = RESOLUTIONS[now.map_or(0, |now| (now + 1) % RESOLUTIONS.len())];
    }
    let is_switched = keys.just_pressed(KeyCode::KeyO);
    if settings.0 != old {
        watch.with_occlusion = default();
    } else if !is_switched {
        return;
    }
    if is_on != is_switched {
        commands.entity(walker).insert(settings.0);
    } else {
        commands.entity(walker).remove::<(SoftwareOcclusion, OcclusionBuffer)>();
    }
}
