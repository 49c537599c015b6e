//! The texts in the corners of the window.

use bevy::prelude::*;

/// A dark panel at the top left with a text, which is marked with `marker`. Pointers pass through.
pub fn panel(marker: impl Component, text: &str) -> impl Bundle {
    let corner = Node {
        left: px(12),
        top: px(12),
        ..default()
    };
    panel_in(corner, marker, text)
}

/// The same at the bottom left.
#[allow(dead_code, reason = "most examples have one panel")]
pub fn panel_at_bottom(marker: impl Component, text: &str) -> impl Bundle {
    let corner = Node {
        left: px(12),
        bottom: px(12),
        ..default()
    };
    panel_in(corner, marker, text)
}

fn panel_in(corner: Node, marker: impl Component, text: &str) -> impl Bundle {
    (
        Node {
            position_type: PositionType::Absolute,
            padding: UiRect::axes(px(12), px(8)),
            border_radius: BorderRadius::all(px(6)),
            ..corner
        },
        BackgroundColor(Color::srgba(0.05, 0.08, 0.12, 0.75)),
        Pickable::IGNORE,
        children![(
            marker,
            Text::new(text),
            TextFont::from_font_size(15.0),
            Pickable::IGNORE
        )],
    )
}
