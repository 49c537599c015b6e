//! What each half of the window shows, in figures, and the keys.

use std::time::Duration;

use bevy::{prelude::*, time::common_conditions::on_timer};
use bevy_sightline::prelude::*;

use crate::{
    controls::has_levels,
    flight::{Flight, field_of_view},
    paint::COLORS,
    stopwatch::Stopwatch,
    tally::{Counter, Switches, Tally},
    views::{Bird, Player},
};

const HELP: &str = "\
Space: fly, or W A S D E Q and right mouse button
wheel: zoom   R: reset   C: colours of levels
F: bird follows   B: swing back and forth
H: hysteresis   L: levels, or all at the finest";

const BACKGROUND: Color = Color::srgba(0.05, 0.08, 0.12, 0.85);

/// The text about what a camera shows: a title, a line for each level in its colour, and the rest.
#[derive(Component)]
struct Figures {
    view: Entity,
    title: &'static str,
    switches: usize,
}

/// What is switched on.
#[derive(Component)]
struct Modes;

pub fn plugin(app: &mut App) {
    let soon = on_timer(Duration::from_millis(250));
    app.add_systems(PostStartup, spawn).add_systems(
        Update,
        (
            count_switches.run_if(on_timer(Duration::from_secs(1))),
            (tell, tell_modes).run_if(soon),
        )
            .chain(),
    );
}

fn spawn(
    mut commands: Commands,
    player: Single<Entity, With<Player>>,
    bird: Single<Entity, (With<Bird>, Without<Player>)>,
) {
    let panel = |left: Val, top: Val, bottom: Val| {
        (
            Node {
                position_type: PositionType::Absolute,
                left,
                top,
                bottom,
                padding: UiRect::axes(px(12), px(8)),
                border_radius: BorderRadius::all(px(6)),
                ..default()
            },
            BackgroundColor(BACKGROUND),
            Pickable::IGNORE,
        )
    };
    let font = || TextFont::from_font_size(14.0);
    for (view, title) in [(*player, "The player's camera"), (*bird, "The bird's camera")] {
        let figures = Figures {
            view,
            title,
            switches: 0,
        };
        commands
            .spawn((panel(px(12), px(12), auto()), UiTargetCamera(view)))
            .with_children(|panel| {
                let text = (figures, Text::new(title), font(), Pickable::IGNORE);
                panel.spawn(text).with_children(|text| {
                    for color in COLORS {
                        text.spawn((TextSpan::default(), TextColor(color.into()), font()));
                    }
                    text.spawn((TextSpan::default(), font()));
                });
            });
    }
    commands
        .spawn((panel(px(12), auto(), px(12)), UiTargetCamera(*bird)))
        .with_child((Modes, Text::new(HELP), font(), Pickable::IGNORE));
    // Between the halves.
    let line = Node {
        position_type: PositionType::Absolute,
        width: px(2),
        height: percent(100),
        ..default()
    };
    commands.spawn((
        line,
        BackgroundColor(Color::BLACK),
        UiTargetCamera(*bird),
        Pickable::IGNORE,
    ));
}

fn count_switches(mut figures: Query<&mut Figures>, mut switches: ResMut<Switches>) {
    for mut figures in &mut figures {
        figures.switches = switches.take(figures.view);
    }
}

fn tell(
    figures: Query<(Entity, &Figures)>,
    counter: Counter,
    projections: Query<&Projection>,
    mut writer: TextUiWriter,
) {
    for (text, figures) in &figures {
        let Tally {
            houses,
            small,
            shown,
            full,
        } = counter.count(figures.view);
        let degrees = projections
            .get(figures.view)
            .map_or(0.0, |projection| field_of_view(projection).to_degrees());
        let names = ["at their finest", "without details", "as boxes", "in proxies of blocks"];
        *writer.text(text, 0) = format!("{}, {degrees:.0} degrees\n", figures.title);
        for (level, name) in names.into_iter().enumerate() {
            *writer.text(text, level + 1) = format!("{:>4} houses {name}\n", houses[level]);
        }
        *writer.text(text, names.len() + 1) = format!(
            "trees, lamps: {} / {} / {}, {} not shown\n\
             {:.0} k of {:.0} k triangles: {:.1} %\n\
             switches: {} a second",
            small[0],
            small[1],
            small[2],
            small[3],
            shown as f64 / 1e3,
            full as f64 / 1e3,
            100.0 * shown as f64 / full.max(1) as f64,
            figures.switches,
        );
    }
}

fn tell_modes(
    settings: Res<LodSettings>,
    flight: Res<Flight>,
    watch: Res<Stopwatch>,
    mut text: Single<&mut Text, With<Modes>>,
) {
    let levels = if has_levels(&settings) {
        "on"
    } else {
        "OFF: all at the finest"
    };
    let hysteresis = if settings.hysteresis > 0.0 { "on" } else { "OFF" };
    let bird = if flight.is_followed { "follows" } else { "STAYS" };
    text.0 = format!(
        "levels {levels}, hysteresis {hysteresis}, bird {bird}\n{}\n{HELP}",
        *watch
    );
}
