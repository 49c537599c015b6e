//! The camera: above the plane, or around all boxes.

use bevy::{
    camera::ScalingMode,
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    prelude::*,
    window::PrimaryWindow,
};

use crate::explorer::Explorer;

/// The part of the window to the left that the figures have.
const PANEL: f32 = 0.34;

const SKY: Srgba = Srgba::rgb(0.055, 0.07, 0.095);

/// Looks at the boxes.
#[derive(Component)]
pub struct Eye {
    yaw: f32,
    pitch: f32,
}

pub fn plugin(app: &mut App) {
    app.insert_resource(ClearColor(SKY.into()))
        .insert_resource(GlobalAmbientLight {
            brightness: 700.0,
            ..default()
        })
        .add_systems(Startup, set_up)
        .add_systems(Update, (turn, look).chain());
}

fn set_up(mut commands: Commands) {
    commands.spawn((
        Eye { yaw: 0.6, pitch: -0.55 },
        Camera3d::default(),
        // Colours as they are named.
        Tonemapping::None,
        DebandDither::Disabled,
    ));
    commands.spawn((
        DirectionalLight {
            illuminance: 4500.0,
            ..default()
        },
        Transform::IDENTITY.looking_to(Vec3::new(-0.5, -1.0, -0.8), Vec3::Y),
    ));
}

/// Turns the view with the pointer, as long as the right button is held.
fn turn(
    buttons: Res<ButtonInput<MouseButton>>,
    window: Single<&Window, With<PrimaryWindow>>,
    mut last: Local<Option<Vec2>>,
    mut eye: Single<&mut Eye>,
) {
    let pointer = (window.cursor_position()).filter(|_| buttons.pressed(MouseButton::Right));
    if let (Some(from), Some(to)) = (*last, pointer)
        && from != to
    {
        eye.yaw -= 0.006 * (to.x - from.x);
        eye.pitch = (eye.pitch - 0.006 * (to.y - from.y)).clamp(-1.5, 1.5);
    }
    *last = pointer;
}

/// Puts the boxes into what the panel leaves of the window.
fn look(explorer: Res<Explorer>, eye: Single<(&Eye, &mut Transform, &mut Projection)>) {
    let (eye, mut transform, mut projection) = eye.into_inner();
    let size = explorer.boxes.size();
    let (rotation, view) = if explorer.boxes.three_d {
        let rotation = Quat::from_euler(EulerRot::YXZ, eye.yaw, eye.pitch, 0.0);
        (rotation, Vec2::new(0.95, 0.86) * size.length())
    } else {
        (Quat::IDENTITY, size.truncate() * Vec2::new(1.16, 1.08))
    };
    let place = Transform::from_translation(size / 2.0 + rotation * Vec3::Z * 300.0).with_rotation(rotation);
    transform.set_if_neq(place);
    *projection = Projection::Orthographic(OrthographicProjection {
        far: 1000.0,
        viewport_origin: Vec2::new((1.0 + PANEL) / 2.0, 0.5),
        scaling_mode: ScalingMode::AutoMin {
            min_width: view.x / (1.0 - PANEL),
            min_height: view.y,
        },
        ..OrthographicProjection::default_3d()
    });
}
