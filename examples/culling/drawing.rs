//! The frustum, the nodes of the tree that it makes one look at, and the figures.

use std::{any::TypeId, time::Duration};

use bevy::{
    camera::{
        primitives::Frustum,
        visibility::{RenderLayers, VisibilitySystems, VisibleEntities},
    },
    camera_controller::free_camera::FreeCamera,
    color::palettes::tailwind::{AMBER_400, EMERALD_400, ROSE_600},
    gizmos::config::{DefaultGizmoConfigGroup, GizmoConfigStore},
    prelude::*,
    time::common_conditions::on_timer,
};
use bevy_sightline::{culling::ViewCullingSettings, prelude::*};

use crate::{
    nodes::{self, Side},
    options::Options,
    panel::panel,
    plan::Plan,
    stopwatch::{Method, Stopwatch},
    times::Times,
    views::MARKS,
};

/// For how many frames Bevy culls at first, to be compared with.
const TRIAL: usize = 10;

const HELP: &str = "\
Space: who culls    B: boxes of the tree    V: view from above    F: hold still
W A S D E Q, right mouse button: fly";

/// What was looked at in this frame.
#[derive(Resource, Default)]
struct Counts {
    inside: u32,
    across: u32,
    outside: u32,
}

#[derive(Resource)]
struct ShowBoxes(bool);

#[derive(Component)]
struct Figures;

/// Whether Bevy has culled for comparison.
#[derive(Default)]
enum Trial {
    #[default]
    ToCome,
    Running,
    Over,
}

pub fn plugin(app: &mut App) {
    app.init_resource::<Counts>()
        .insert_resource(ShowBoxes(true))
        .add_systems(Startup, set_up)
        .add_systems(
            Update,
            (
                choose_method,
                show_boxes,
                tell.run_if(on_timer(Duration::from_millis(200))),
            ),
        )
        .add_systems(
            PostUpdate,
            (draw_frustum, draw_nodes)
                .after(VisibilitySystems::UpdateFrusta)
                .after(SpatialIndexSystems::Optimize),
        );
}

fn set_up(mut commands: Commands, mut gizmos: ResMut<GizmoConfigStore>) {
    let (config, _) = gizmos.config_mut::<DefaultGizmoConfigGroup>();
    config.render_layers = RenderLayers::layer(MARKS);
    config.line.width = 1.5;
    commands.spawn(panel(Figures, "loading"));
}

/// Lets Bevy cull for some frames when all is loaded, and leaves the choice to Space from then on.
fn choose_method(
    keys: Res<ButtonInput<KeyCode>>,
    things: Query<&Mesh3d>,
    meshes: Res<Assets<Mesh>>,
    mut watch: ResMut<Stopwatch>,
    mut settings: ResMut<ViewCullingSettings>,
    mut trial: Local<Trial>,
) {
    match *trial {
        Trial::ToCome => {
            if things.iter().all(|mesh| meshes.contains(mesh)) {
                watch.forget();
                settings.enabled = false;
                *trial = Trial::Running;
            }
        }
        Trial::Running => {
            if watch.culling(Method::Bevy).len() >= TRIAL {
                settings.enabled = true;
                *trial = Trial::Over;
            }
        }
        Trial::Over => settings.enabled ^= keys.just_pressed(KeyCode::Space),
    }
}

fn show_boxes(keys: Res<ButtonInput<KeyCode>>, mut show: ResMut<ShowBoxes>) {
    show.0 ^= keys.just_pressed(KeyCode::KeyB);
}

/// The edges that leave the camera, as far as the city goes.
fn draw_frustum(
    options: Res<Options>,
    flying: Single<(&Camera, &GlobalTransform), With<FreeCamera>>,
    mut gizmos: Gizmos,
) {
    let (camera, transform) = *flying;
    let length = 1.2 * Plan { blocks: options.blocks }.half_size();
    let eye = transform.translation();
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let ends = corners.map(|(x, y)| {
        let near = camera.ndc_to_world(transform, Vec3::new(x, y, 1.0));
        let along = near.map_or(Vec3::ZERO, |near| (near - eye).normalize_or_zero());
        eye + along * length
    });
    for end in ends {
        gizmos.line(eye, end, Color::WHITE);
    }
    gizmos.lineloop(ends, Color::WHITE);
}

fn draw_nodes(
    frustum: Single<&Frustum, With<FreeCamera>>,
    index: Res<SpatialIndex>,
    show: Res<ShowBoxes>,
    mut counts: ResMut<Counts>,
    mut gizmos: Gizmos,
) {
    *counts = default();
    nodes::visit(&index, &frustum.0, |side, aabb| {
        let (count, color) = match side {
            Side::Inside => (&mut counts.inside, EMERALD_400),
            Side::Across => (&mut counts.across, AMBER_400),
            Side::Outside => (&mut counts.outside, ROSE_600),
        };
        *count += 1;
        if show.0 {
            gizmos.aabb_3d(*aabb, Transform::IDENTITY, color);
        }
    });
}

fn tell(
    watch: Res<Stopwatch>,
    settings: Res<ViewCullingSettings>,
    counts: Res<Counts>,
    index: Res<SpatialIndex>,
    flying: Single<&VisibleEntities, With<FreeCamera>>,
    mut text: Single<&mut Text, With<Figures>>,
) {
    let mark = |chosen| if chosen { ">" } else { " " };
    let tell = |times: &Times| times.tell(3, "...");
    let Counts {
        inside,
        across,
        outside,
    } = *counts;
    let (ours, bevy) = (watch.culling(Method::Sightline), watch.culling(Method::Bevy));
    let ratio = bevy.median() / ours.median();
    let times = if ratio.is_finite() {
        format!(", {ratio:.1} times as long")
    } else {
        String::new()
    };
    text.0 = format!(
        "{} bevy_sightline: {} a frame, and {} for the index\n\
         {} Bevy: {} a frame{times}\n\
         {} of {} things kept\n\
         {} nodes looked at: {inside} inside, {outside} outside, {across} across\n\n{HELP}",
        mark(settings.enabled),
        tell(ours),
        tell(watch.index()),
        mark(!settings.enabled),
        tell(bevy),
        flying.len(TypeId::of::<Mesh3d>()),
        index.len(),
        inside + across + outside,
    );
}
