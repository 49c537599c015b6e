//! Two cameras: one that flies, and one that looks at the whole city from above.

use std::f32::consts::TAU;

use bevy::{
    camera::{ClearColorConfig, Viewport, visibility::RenderLayers},
    camera_controller::free_camera::{FreeCamera, FreeCameraState},
    prelude::*,
    window::PrimaryWindow,
};

use crate::{by_hand, options::Options, plan::Plan, scenery::Ground, stopwatch::Stopwatch};

/// What only the view from above shows.
pub const MARKS: usize = 1;
/// What only the flying camera shows: the ground that it always sees.
const BACKDROP: usize = 2;

/// The part of the window that the flying camera has, in width and height, and its distance from the edges in pixels.
const INSET: f32 = 0.34;
const MARGIN: f32 = 14.0;

/// The ground under the city from above.
const SHADE: Srgba = Srgba::rgb(0.045, 0.055, 0.075);

/// Looks from above.
#[derive(Component)]
pub struct Overview;

/// Around the small picture.
#[derive(Component)]
struct InsetFrame;

/// Whether the camera flies by itself.
#[derive(Resource)]
struct Flight {
    on: bool,
    /// In rounds.
    along: f32,
}

pub fn plugin(app: &mut App) {
    app.insert_resource(Flight { on: true, along: 0.0 })
        .add_systems(PostStartup, (set_up, frame_inset))
        .add_systems(Update, (steer, fly, show_overview, lay_out).chain());
}

/// Where the flying camera is: low over the roofs, on a round through the city, looking inwards and outwards by turns.
pub fn place(along: f32, blocks: u32) -> Transform {
    let radius = 0.42 * Plan { blocks }.half_size();
    let angle = along * TAU;
    let (sin, cos) = angle.sin_cos();
    let eye = Vec3::new(cos * radius, 55.0 + 25.0 * (3.0 * angle).sin(), sin * radius);
    let heading = angle + 0.9 * (2.0 * angle).sin();
    let forward = Vec3::new(-heading.sin(), -0.22, heading.cos());
    Transform::from_translation(eye).looking_to(forward, Vec3::Y)
}

fn set_up(
    mut commands: Commands,
    options: Res<Options>,
    flying: Single<(Entity, &mut Camera), With<FreeCamera>>,
    grounds: Query<(Entity, &Name), With<Ground>>,
) {
    let half = Plan { blocks: options.blocks }.half_size();
    let (flying, mut camera) = flying.into_inner();
    camera.order = 1;
    commands
        .entity(flying)
        .insert(RenderLayers::from_layers(&[0, BACKDROP]));
    commands.spawn((
        Overview,
        Camera3d::default(),
        Camera {
            clear_color: ClearColorConfig::Custom(SHADE.into()),
            ..default()
        },
        Projection::from(PerspectiveProjection {
            far: 10.0 * half,
            ..default()
        }),
        // Beside the middle, so that the small picture covers little of the city.
        Transform::from_xyz(0.3 * half, 2.15 * half, 1.5 * half)
            .looking_at(Vec3::new(0.3 * half, 0.0, 0.17 * half), Vec3::Y),
        RenderLayers::from_layers(&[0, MARKS]),
        IsDefaultUiCamera,
    ));
    for (ground, name) in &grounds {
        if ["countryside", "streets"].contains(&name.as_str()) {
            commands.entity(ground).insert(RenderLayers::layer(BACKDROP));
        }
    }
}

fn frame_inset(mut commands: Commands) {
    commands.spawn((
        InsetFrame,
        Node {
            position_type: PositionType::Absolute,
            right: px(MARGIN),
            bottom: px(MARGIN),
            width: percent(100.0 * INSET),
            height: percent(100.0 * INSET),
            ..default()
        },
        Outline::new(px(2), px(0), Color::WHITE),
        Pickable::IGNORE,
    ));
}

fn steer(keys: Res<ButtonInput<KeyCode>>, buttons: Res<ButtonInput<MouseButton>>, mut flight: ResMut<Flight>) {
    if by_hand::is_steered(&keys, &buttons) {
        flight.on = false;
    }
    flight.on ^= keys.just_pressed(KeyCode::KeyF);
}

fn fly(
    time: Res<Time>,
    options: Res<Options>,
    mut flight: ResMut<Flight>,
    flying: Single<(&mut Transform, &mut FreeCameraState)>,
) {
    if !flight.on {
        return;
    }
    flight.along = (flight.along + time.delta_secs() / 60.0).fract();
    let (mut transform, mut state) = flying.into_inner();
    by_hand::put(place(flight.along, options.blocks), &mut transform, &mut state);
}

fn show_overview(
    keys: Res<ButtonInput<KeyCode>>,
    mut commands: Commands,
    overview: Single<(Entity, &mut Camera), With<Overview>>,
    flying: Single<Entity, With<FreeCamera>>,
    mut frame: Single<&mut Visibility, With<InsetFrame>>,
    mut watch: ResMut<Stopwatch>,
) {
    if !keys.just_pressed(KeyCode::KeyV) {
        return;
    }
    let (overview, mut camera) = overview.into_inner();
    camera.is_active = !camera.is_active;
    frame.toggle_inherited_hidden();
    // One view costs less than two.
    watch.forget();
    let (shows, other) = if camera.is_active {
        (overview, *flying)
    } else {
        (*flying, overview)
    };
    commands.entity(shows).insert(IsDefaultUiCamera);
    commands.entity(other).remove::<IsDefaultUiCamera>();
}

/// Puts the flying camera into its corner of the window, or gives it the whole.
fn lay_out(
    window: Single<&Window, With<PrimaryWindow>>,
    overview: Single<&Camera, With<Overview>>,
    mut flying: Single<&mut Camera, (With<FreeCamera>, Without<Overview>)>,
) {
    let size = window.physical_size();
    let inset = (size.as_vec2() * INSET).as_uvec2();
    let margin = UVec2::splat((MARGIN * window.scale_factor()) as u32);
    let fits = (inset + margin).cmplt(size).all() && inset.cmpgt(UVec2::ZERO).all();
    let corner = (overview.is_active && fits).then(|| Viewport {
        physical_position: size - inset - margin,
        physical_size: inset,
        ..default()
    });
    let place = |viewport: &Option<Viewport>| viewport.as_ref().map(|v| (v.physical_position, v.physical_size));
    if place(&flying.viewport) != place(&corner) {
        flying.viewport = corner;
    }
}
