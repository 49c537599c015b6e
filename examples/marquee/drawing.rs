//! What only a window can show: the outline as it is drawn, and the panel.

use bevy::prelude::*;
use bevy_sightline::prelude::*;

use crate::{
    marquee::{self, Choice, Selection},
    outline,
    panel::panel,
};

#[derive(Component)]
struct SelectionText;

pub fn plugin(app: &mut App) {
    app.add_plugins(outline::window_plugin)
        .add_systems(Startup, spawn_text)
        .add_systems(Update, tell.after(marquee::select));
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
