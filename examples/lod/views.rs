//! The two halves of the window: what the player sees, and the same from a bird's eye.

use bevy::{
    camera::{Viewport, visibility::RenderLayers},
    camera_controller::free_camera::FreeCamera,
    gizmos::config::{DefaultGizmoConfigGroup, GizmoConfigStore},
    prelude::*,
    transform::TransformSystems,
    window::PrimaryWindow,
};
use bevy_sightline::prelude::*;

use crate::{
    flight::{self, Flight},
    options::Options,
    town::SKY,
};

/// What only the bird shows.
const MARKS: usize = 1;

const FRUSTUM: Srgba = Srgba::rgb(0.10, 0.12, 0.18);
/// How far the player's frustum is drawn, in metres, and how high above the street.
const REACH: f32 = 420.0;
const GROUND: f32 = 0.5;

/// The camera on the left.
#[derive(Component)]
pub struct Player;

/// The camera on the right.
#[derive(Component)]
pub struct Bird;

pub fn plugin(app: &mut App) {
    app.add_systems(Startup, set_up)
        .add_systems(Update, lay_out)
        .add_systems(PostUpdate, follow_player.before(TransformSystems::Propagate));
}

/// What only a window needs.
pub fn window_plugin(app: &mut App) {
    app.add_systems(Startup, layer_gizmos)
        .add_systems(PostUpdate, draw_frustum.after(TransformSystems::Propagate));
}

fn set_up(mut commands: Commands, options: Res<Options>) {
    let route = flight::route(options.blocks);
    let projection = || {
        Projection::from(PerspectiveProjection {
            far: 3000.0,
            ..default()
        })
    };
    let place = route.place(0.0);
    commands.spawn((
        Bird,
        Camera3d::default(),
        Camera { order: 1, ..default() },
        projection(),
        RenderLayers::from_layers(&[0, MARKS]),
        above(&place),
    ));
    commands.spawn((
        Player,
        Camera3d::default(),
        projection(),
        LodBias::default(),
        place,
        IsDefaultUiCamera,
        DistanceFog {
            color: SKY.into(),
            falloff: FogFalloff::from_visibility_color(2500.0, SKY.into()),
            ..default()
        },
        FreeCamera {
            walk_speed: 30.0,
            run_speed: 120.0,
            // The wheel zooms.
            scroll_factor: 0.0,
            // Nothing else than the mouse grabs it.
            keyboard_key_toggle_cursor_grab: KeyCode::F12,
            ..default()
        },
    ));
    commands.insert_resource(route);
}

fn layer_gizmos(mut gizmos: ResMut<GizmoConfigStore>) {
    let (config, _) = gizmos.config_mut::<DefaultGizmoConfigGroup>();
    config.render_layers = RenderLayers::layer(MARKS);
    config.line.width = 2.0;
    config.depth_bias = -0.9;
}

/// Where one looks at a player from.
pub fn above(player: &Transform) -> Transform {
    let foot = player.translation.with_y(0.0);
    Transform::from_translation(foot + Vec3::new(0.0, 330.0, 225.0)).looking_at(foot + Vec3::NEG_Z * 105.0, Vec3::Y)
}

fn follow_player(
    flight: Option<Res<Flight>>,
    player: Single<&Transform, (With<Player>, Without<Bird>)>,
    mut bird: Single<&mut Transform, With<Bird>>,
) {
    if flight.is_none_or(|flight| flight.is_followed) {
        **bird = above(*player);
    }
}

/// Gives each camera its half of the window.
fn lay_out(
    window: Single<&Window, With<PrimaryWindow>>,
    mut player: Single<&mut Camera, (With<Player>, Without<Bird>)>,
    mut bird: Single<&mut Camera, With<Bird>>,
) {
    let size = window.physical_size();
    let middle = size.x / 2;
    if middle == 0 || size.y == 0 {
        return;
    }
    for (camera, from, to) in [(&mut **player, 0, middle), (&mut **bird, middle, size.x)] {
        let (position, size) = (UVec2::new(from, 0), UVec2::new(to - from, size.y));
        let is_there = |v: &Viewport| (v.physical_position, v.physical_size) == (position, size);
        if !camera.viewport.as_ref().is_some_and(is_there) {
            camera.viewport = Some(Viewport {
                physical_position: position,
                physical_size: size,
                ..default()
            });
        }
    }
}

/// What the player's frustum is above, on the ground, with the eye above it.
pub fn frustum_lines(camera: &Camera, transform: &GlobalTransform) -> [[Vec3; 2]; 4] {
    let eye = transform.translation();
    let corner = |x| {
        let along = camera
            .ndc_to_world(transform, Vec3::new(x, 0.0, 1.0))
            .map_or(Vec3::ZERO, |near| (near - eye).with_y(0.0));
        (eye + along.normalize_or_zero() * REACH).with_y(GROUND)
    };
    let (foot, left, right) = (eye.with_y(GROUND), corner(-1.0), corner(1.0));
    [[foot, left], [foot, right], [left, right], [foot, eye]]
}

fn draw_frustum(player: Single<(&Camera, &GlobalTransform), With<Player>>, mut gizmos: Gizmos) {
    let (camera, transform) = *player;
    for [from, to] in frustum_lines(camera, transform) {
        gizmos.line(from, to, FRUSTUM);
    }
    let flat = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    gizmos.circle(Isometry3d::new(transform.translation(), flat), 5.0, FRUSTUM);
}
