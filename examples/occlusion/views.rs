//! What is shown besides the street: the walker from behind and above, and the depth buffer.

use std::{f32::consts::FRAC_PI_2, time::Duration};

use bevy::{
    camera::{ClearColorConfig, Viewport, visibility::RenderLayers},
    gizmos::config::{DefaultGizmoConfigGroup, GizmoConfigStore},
    prelude::*,
    time::common_conditions::on_timer,
    transform::TransformSystems,
    window::PrimaryWindow,
};
use bevy_sightline::prelude::*;

use crate::{
    scenery::Ground,
    stopwatch::Stopwatch,
    walk::{Walker, set_out},
};

/// What only the view from above shows.
const MARKS: usize = 1;
/// What only the walker shows: the ground that it always sees.
const BACKDROP: usize = 2;

/// The part of the window that a small picture has, in width and height: of the view from above, and of the depths.
const ABOVE: Vec2 = Vec2::new(0.43, 0.52);
const DEPTHS: Vec2 = Vec2::new(0.28, 0.28);
/// Their distance from the edges in pixels.
const MARGIN: f32 = 14.0;

/// The ground from above.
const SHADE: Srgba = Srgba::rgb(0.060, 0.072, 0.100);
const FRUSTUM: Srgba = Srgba::rgb(1.0, 0.85, 0.25);
/// How far the frustum is drawn, and how far on the ground, in metres.
const NEAR_REACH: f32 = 110.0;
const FAR_REACH: f32 = 400.0;
/// The height of lines on the ground.
const GROUND: f32 = 0.3;

/// Looks from above.
#[derive(Component)]
pub struct Overview;

/// Shows the depth buffer.
#[derive(Component)]
struct Depths;

/// What is around the small pictures.
#[derive(Component)]
struct InsetFrame;

pub fn plugin(app: &mut App) {
    app.add_systems(PostStartup, (set_up.after(set_out), frame_insets))
        .add_systems(
            Update,
            (
                (show_insets, lay_out).chain(),
                show_depths.run_if(on_timer(Duration::from_millis(100))),
            ),
        )
        .add_systems(
            PostUpdate,
            (
                follow_walker.before(TransformSystems::Propagate),
                draw_frustum.after(TransformSystems::Propagate),
            ),
        );
}

/// Where one looks at a walker from: behind and above, with the way ahead in the middle.
pub fn above(walker: &Transform) -> Transform {
    let forward = walker.forward().with_y(0.0).normalize_or(Vec3::NEG_Z);
    let eye = walker.translation - 150.0 * forward + 310.0 * Vec3::Y;
    Transform::from_translation(eye).looking_at(walker.translation + 100.0 * forward, Vec3::Y)
}

fn set_up(
    mut commands: Commands,
    walker: Single<Entity, With<Walker>>,
    grounds: Query<(Entity, &Name), With<Ground>>,
    mut gizmos: ResMut<GizmoConfigStore>,
) {
    commands
        .entity(*walker)
        .insert((RenderLayers::from_layers(&[0, BACKDROP]), IsDefaultUiCamera));
    commands.spawn((
        Overview,
        Camera3d::default(),
        Camera {
            order: 1,
            clear_color: ClearColorConfig::Custom(SHADE.into()),
            ..default()
        },
        RenderLayers::from_layers(&[0, MARKS]),
    ));
    for (ground, name) in &grounds {
        if ["countryside", "streets"].contains(&name.as_str()) {
            commands.entity(ground).insert(RenderLayers::layer(BACKDROP));
        }
    }
    let (config, _) = gizmos.config_mut::<DefaultGizmoConfigGroup>();
    config.render_layers = RenderLayers::layer(MARKS);
    config.line.width = 2.0;
    config.depth_bias = -0.9;
}

fn frame_insets(mut commands: Commands, mut images: ResMut<Assets<Image>>) {
    let frame = |size: Vec2| Node {
        position_type: PositionType::Absolute,
        bottom: px(MARGIN),
        width: percent(100.0 * size.x),
        height: percent(100.0 * size.y),
        ..default()
    };
    let line = Outline::new(px(2), px(0), Color::srgb(0.85, 0.88, 0.92));
    let caption = |text: &str| {
        (
            Node {
                position_type: PositionType::Absolute,
                bottom: percent(100),
                left: px(-2),
                margin: UiRect::bottom(px(2)),
                padding: UiRect::axes(px(8), px(3)),
                ..default()
            },
            BackgroundColor(Color::srgba(0.05, 0.08, 0.12, 0.75)),
            Pickable::IGNORE,
            children![(Text::new(text), TextFont::from_font_size(13.0), Pickable::IGNORE)],
        )
    };
    commands.spawn((
        InsetFrame,
        Node {
            right: px(MARGIN),
            ..frame(ABOVE)
        },
        line,
        Pickable::IGNORE,
        children![caption("From above: seen in colour, hidden as blue ghosts")],
    ));
    commands.spawn((
        InsetFrame,
        Depths,
        Node {
            left: px(MARGIN),
            ..frame(DEPTHS)
        },
        ImageNode {
            image: images.add(Image::default()),
            image_mode: NodeImageMode::Stretch,
            ..default()
        },
        line,
        Pickable::IGNORE,
        children![caption("The depth buffer: the nearest buildings")],
    ));
}

fn show_insets(
    keys: Res<ButtonInput<KeyCode>>,
    mut overview: Single<&mut Camera, With<Overview>>,
    mut frames: Query<&mut Visibility, With<InsetFrame>>,
    mut watch: ResMut<Stopwatch>,
) {
    if keys.just_pressed(KeyCode::KeyV) {
        overview.is_active ^= true;
        for mut frame in &mut frames {
            frame.toggle_inherited_hidden();
        }
        // One view costs less than two.
        watch.forget();
    }
}

/// Puts the view from above into its corner of the window.
fn lay_out(window: Single<&Window, With<PrimaryWindow>>, mut overview: Single<&mut Camera, With<Overview>>) {
    let size = window.physical_size();
    let inset = (size.as_vec2() * ABOVE).as_uvec2();
    let margin = UVec2::splat((MARGIN * window.scale_factor()) as u32);
    if !((inset + margin).cmplt(size).all() && inset.cmpgt(UVec2::ZERO).all()) {
        return;
    }
    let corner = Some(Viewport {
        physical_position: size - inset - margin,
        physical_size: inset,
        ..default()
    });
    let place = |viewport: &Option<Viewport>| viewport.as_ref().map(|v| (v.physical_position, v.physical_size));
    if place(&overview.viewport) != place(&corner) {
        overview.viewport = corner;
    }
}

fn show_depths(
    buffer: Option<Single<&OcclusionBuffer, With<Walker>>>,
    mut node: Single<&mut ImageNode, With<Depths>>,
    mut images: ResMut<Assets<Image>>,
) {
    match buffer {
        Some(buffer) => {
            if let Some(mut image) = images.get_mut(&node.image) {
                buffer.depth().write_to_image(&mut image);
            }
            node.color = Color::WHITE;
        }
        None => node.color = Color::srgb(0.15, 0.15, 0.15),
    }
}

fn follow_walker(
    walker: Single<&Transform, (With<Walker>, Without<Overview>)>,
    mut overview: Single<&mut Transform, With<Overview>>,
) {
    **overview = above(*walker);
}

/// The beginning of the walker's frustum, and on the ground how it goes on.
pub fn frustum_lines(camera: &Camera, transform: &GlobalTransform) -> [[Vec3; 2]; 9] {
    let eye = transform.translation();
    let corner = |x, y, reach: f32| {
        let near = camera.ndc_to_world(transform, Vec3::new(x, y, 1.0));
        let along = near.map_or(Vec3::ZERO, |near| near - eye);
        let forward = transform.forward().dot(along).max(f32::MIN_POSITIVE);
        eye + along * (reach / forward)
    };
    let [left, right] = [-1.0, 1.0].map(|x| corner(x, 1.0, NEAR_REACH));
    let [far_left, far_right] = [-1.0, 1.0].map(|x| corner(x, 0.0, FAR_REACH).with_y(GROUND));
    let [foot, under_left, under_right] = [eye, left, right].map(|point| point.with_y(GROUND));
    [
        [foot, far_left],
        [foot, far_right],
        [far_left, far_right],
        [eye, left],
        [eye, right],
        [left, right],
        [left, under_left],
        [right, under_right],
        [under_left, under_right],
    ]
}

fn draw_frustum(walker: Single<(&Camera, &GlobalTransform), With<Walker>>, mut gizmos: Gizmos) {
    let (camera, transform) = *walker;
    for [from, to] in frustum_lines(camera, transform) {
        gizmos.line(from, to, FRUSTUM);
    }
    let flat = Quat::from_rotation_x(FRAC_PI_2);
    gizmos.circle(Isometry3d::new(transform.translation(), flat), 6.0, FRUSTUM);
}
