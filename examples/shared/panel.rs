//! The text in the corner of the window.

use bevy::prelude::*;

/// A dark panel at the top left with a text, which is marked with `marker`. Pointers pass through.
pub fn panel(marker: impl Component, text: &str) -> impl Bundle {
    (
        Node {
            position_type: PositionType::Absolute,
            left: px(12),
            top: px(12),
            padding: UiRect::axes(px(12), px(8)),
            border_radius: BorderRadius::all(px(6)),
            ..default()
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
