//! What only a window can show: the outline as it is drawn, and the panel.

use bevy::{color::palettes::tailwind::SKY_300, prelude::*};
use bevy_sightline::prelude::*;

use crate::{
    marquee::{self, Choice, Marquee, Selection},
    panel::panel,
};

/// Between the lines that fill the outline, in pixels.
const HATCHING: f32 = 4.0;

/// Lines that are in front of everything.
#[derive(Default, Reflect, GizmoConfigGroup)]
struct OnTheScreen;

#[derive(Component)]
struct SelectionText;

pub fn plugin(app: &mut App) {
    app.insert_gizmo_config(
        OnTheScreen,
        GizmoConfig {
            depth_bias: -1.0,
            ..default()
        },
    )
    .add_systems(Startup, spawn_text)
    .add_systems(Update, tell.after(marquee::select))
    .add_systems(PostUpdate, draw_outline.after(SpatialIndexSystems::Sync));
}

fn spawn_text(mut commands: Commands) {
    commands.spawn(panel(SelectionText, ""));
}

fn tell(
    selection: Res<Selection>,
    choice: Res<Choice>,
    index: Res<SpatialIndex>,
    mut text: Single<&mut Text, With<SelectionText>>,
) {
    let mode = match choice.0.mode {
        SelectionMode::Touching => "touched",
        SelectionMode::Enclosed => "enclosed",
    };
    let precision = match choice.0.precision {
        SelectionPrecision::Mesh => "meshes",
        SelectionPrecision::Bounds => "bounds",
    };
    let found = if selection.micros > 0.0 {
        format!(
            "{} of {} things selected, in {:.0} microseconds",
            selection.entities.len(),
            index.len(),
            selection.micros,
        )
    } else {
        "Drag a box with the left mouse button, or a lasso with Shift held.".into()
    };
    text.0 = format!("{found}\n[T] {mode}   [B] by their {precision}");
}

/// Draws the outline on the screen, and fills it by the even-odd rule.
fn draw_outline(marquee: Res<Marquee>, view: Single<(&Camera, &GlobalTransform)>, mut gizmos: Gizmos<OnTheScreen>) {
    if !marquee.is_drawing {
        return;
    }
    let (camera, eye) = *view;
    // Just behind the near plane.
    let lift = |place: Vec2| Some(camera.viewport_to_world(eye, place).ok()?.get_point(0.01));
    let mut line = |from: Vec2, to: Vec2, color: Srgba| {
        if let (Some(from), Some(to)) = (lift(from), lift(to)) {
            gizmos.line(from, to, color);
        }
    };
    let corners = marquee.corners();
    for [left, right] in hatching(&corners) {
        line(left, right, SKY_300.with_alpha(0.25));
    }
    for (&from, &to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        line(from, to, SKY_300);
    }
}

/// Level lines through a polygon, by the even-odd rule.
fn hatching(corners: &[Vec2]) -> Vec<[Vec2; 2]> {
    let heights = corners.iter().map(|corner| corner.y);
    let (top, bottom) = heights.fold((f32::INFINITY, f32::NEG_INFINITY), |(top, bottom), y| {
        (top.min(y), bottom.max(y))
    });
    let mut lines = Vec::new();
    let rows = ((bottom - top) / HATCHING).max(0.0) as u32;
    for y in (0..rows).map(|row| top + (row as f32 + 0.5) * HATCHING) {
        let edges = corners.iter().zip(corners.iter().cycle().skip(1));
        let crossed = edges.filter(|(from, to)| (from.y > y) != (to.y > y));
        let mut crossings: Vec<f32> = crossed
            .map(|(from, to)| from.x + (to.x - from.x) * (y - from.y) / (to.y - from.y))
            .collect();
        crossings.sort_unstable_by(f32::total_cmp);
        lines.extend(
            crossings
                .chunks_exact(2)
                .map(|pair| [Vec2::new(pair[0], y), Vec2::new(pair[1], y)]),
        );
    }
    lines
}
