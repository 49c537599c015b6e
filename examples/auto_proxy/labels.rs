//! What is written in the window.

use bevy::prelude::*;
use bevy_sightline::prelude::*;

use crate::{
    gallery::{Gallery, pixels, pixels_at_one},
    panel::panel,
};

pub fn plugin(app: &mut App) {
    app.add_systems(Startup, set_up)
        .add_systems(Update, (add_labels, write_labels, write_panel));
}

/// Below the model with this number.
#[derive(Component)]
struct Label(usize);

#[derive(Component)]
struct Progress;

fn set_up(mut commands: Commands) {
    commands.spawn(panel(Progress, "loading"));
}

fn write_panel(gallery: Res<Gallery>, progress: Res<ProxyProgress>, mut text: Single<&mut Text, With<Progress>>) {
    let now = match gallery.took {
        Some(took) => format!(
            "levels of detail, made in {:.1} s\nL: edges of triangles",
            took.as_secs_f32()
        ),
        None => format!(
            "{} of {} meshes done, {:.0}%",
            progress.done,
            progress.total,
            100.0 * progress.fraction
        ),
    };
    if text.0 != now {
        text.0 = now;
    }
}

fn add_labels(mut commands: Commands, gallery: Res<Gallery>, labels: Query<&Label>) {
    if labels.is_empty() {
        for number in 0..gallery.columns.len() {
            commands.spawn((
                Label(number),
                Node {
                    position_type: PositionType::Absolute,
                    width: px(WIDTH),
                    ..default()
                },
                Text::default(),
                TextFont::from_font_size(15.0),
                TextLayout::justify(Justify::Center),
                TextColor(Color::srgb(0.03, 0.05, 0.08)),
            ));
        }
    }
}

/// Of a label, in pixels.
const WIDTH: f32 = 200.0;

fn write_labels(
    gallery: Res<Gallery>,
    camera: Single<(&Camera, &GlobalTransform), With<Camera3d>>,
    mut labels: Query<(&Label, &mut Node, &mut Text, &mut Visibility)>,
) {
    let (camera, eye) = *camera;
    for (label, mut node, mut text, mut visibility) in &mut labels {
        let column = &gallery.columns[label.0];
        let foot = column.bounds.map(|bounds| {
            let (min, max) = (Vec3::from(bounds.min), Vec3::from(bounds.max));
            Vec3::new((min.x + max.x) / 2.0, min.y, max.z)
        });
        let place = foot.and_then(|foot| camera.world_to_viewport(eye, foot).ok());
        visibility.set_if_neq(if place.is_some() {
            Visibility::Inherited
        } else {
            Visibility::Hidden
        });
        if let Some(place) = place {
            (node.left, node.top) = (px(place.x - WIDTH / 2.0), px(place.y + 10.0));
        }
        let triangles = column.triangles;
        let now = if label.0 == 0 {
            format!("{triangles} triangles\nthe original")
        } else {
            let distance = column.error * pixels_at_one(camera);
            let error = pixels(column, camera, eye);
            format!("{triangles} triangles\n{error:.1} px from here\n1 px from {distance:.1} m")
        };
        if text.0 != now {
            text.0 = now;
        }
    }
}
