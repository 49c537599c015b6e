//! The texts in the corners of the window.

use bevy::prelude::*;

/// A dark panel at the top left with a text, which is marked with `marker`. Pointers pass through.
#[allow(dead_code, reason = "some examples have other panels")]
pub fn panel(marker: impl Component, text: &str) -> impl Bundle {
    panel_at(Corner::TopLeft, 15.0, marker, text)
}

/// Where a panel is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(dead_code, reason = "most examples have one panel")]
pub enum Corner {
    TopLeft,
    BottomLeft,
}

/// The same in a corner, in letters of a size.
pub fn panel_at(corner: Corner, font_size: f32, marker: impl Component, text: &str) -> impl Bundle {
    let (top, bottom) = match corner {
        Corner::TopLeft => (px(12), auto()),
        Corner::BottomLeft => (auto(), px(12)),
    };
    (
        Node {
            position_type: PositionType::Absolute,
            left: px(12),
            top,
            bottom,
            padding: UiRect::axes(px(12), px(8)),
            border_radius: BorderRadius::all(px(6)),
            ..default()
        },
        BackgroundColor(Color::srgba(0.05, 0.08, 0.12, 0.75)),
        Pickable::IGNORE,
        children![(
            marker,
            Text::new(text),
            TextFont::from_font_size(font_size),
            Pickable::IGNORE
        )],
    )
}
