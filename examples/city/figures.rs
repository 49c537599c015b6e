//! The panels: what there is and what it costs, and the keys.

use std::{any::TypeId, time::Duration};

use bevy::{
    camera::visibility::{VisibilityRange, VisibleEntities},
    picking::pointer::PointerInteraction,
    prelude::*,
    time::common_conditions::on_timer,
};
use bevy_sightline::prelude::*;

use crate::{
    blocks::Proxy,
    controls::{Inside, PickingIsOn},
    drawing::Selecting,
    flight::Flight,
    interaction::Selected,
    levels::OtherLevel,
    panel::{Corner, panel_at},
    scenery::Thing,
    stopwatch::{Stage, Stopwatch},
};

const FLY: &str = "W A S D E Q, right mouse button: fly";
const FONT_SIZE: f32 = 13.0;

/// The text at the top.
#[derive(Component)]
struct Figures;

/// The text at the bottom.
#[derive(Component)]
struct Keys;

/// Whether the panels are shown.
#[derive(Resource)]
struct AreShown(bool);

pub fn window_plugin(app: &mut App) {
    let soon = || on_timer(Duration::from_millis(250));
    app.insert_resource(AreShown(true))
        .add_systems(Startup, spawn)
        .add_systems(Update, (hide, tell.run_if(soon())));
    if app.world().contains_resource::<LodSettings>() {
        app.add_systems(Update, tell_keys);
    } else {
        app.add_systems(Update, tell_plain_keys);
    }
}

fn spawn(mut commands: Commands) {
    commands.spawn(panel_at(Corner::TopLeft, FONT_SIZE, Figures, "loading"));
    commands.spawn(panel_at(Corner::BottomLeft, FONT_SIZE, Keys, FLY));
}

/// H hides the panels and shows them again.
fn hide(
    keys: Res<ButtonInput<KeyCode>>,
    mut are_shown: ResMut<AreShown>,
    texts: Query<&ChildOf, Or<(With<Figures>, With<Keys>)>>,
    mut panels: Query<&mut Visibility>,
) {
    if !keys.just_pressed(KeyCode::KeyH) {
        return;
    }
    are_shown.0 ^= true;
    for text in &texts {
        if let Ok(mut panel) = panels.get_mut(text.parent()) {
            panel.toggle_inherited_hidden();
        }
    }
}

fn tell(
    camera: Single<(&VisibleEntities, Option<&OcclusionBuffer>), With<Camera3d>>,
    meshes: Query<(), With<Mesh3d>>,
    things: Query<(), With<Thing>>,
    parts: Query<(Has<Proxy>, Option<&OtherLevel>)>,
    ranges: Query<(), With<VisibilityRange>>,
    pointers: Query<&PointerInteraction>,
    names: Query<NameOrEntity>,
    selected: Query<(), With<Selected>>,
    choices: Option<Res<LodChoices>>,
    selecting: Option<Res<Selecting>>,
    watch: Res<Stopwatch>,
    mut text: Single<&mut Text, With<Figures>>,
) {
    let (visible, occlusion) = *camera;
    let visible = visible.get(TypeId::of::<Mesh3d>());
    let mut levels = [0; 3];
    let mut proxies = 0;
    for &entity in visible {
        let Ok((is_proxy, other)) = parts.get(entity) else {
            continue;
        };
        if is_proxy {
            proxies += 1;
        } else if let Some(other) = other {
            levels[if other.is_coarsest { 2 } else { 1 }] += 1;
        } else if let Some(level) = choices.as_ref().and_then(|choices| choices.swapped_level(entity)) {
            levels[level.min(2)] += 1;
        } else if ranges.contains(entity) {
            levels[0] += 1;
        }
    }
    let hidden = occlusion.map_or("-".into(), |buffer| grouped(buffer.stats().hidden));
    let hit = pointers.iter().find_map(PointerInteraction::get_nearest_hit);
    let under = hit.and_then(|(entity, hit)| Some((names.get(*entity).ok()?.name?, hit.depth)));
    let under = under.map_or("nothing".into(), |(name, depth)| format!("{name}, {depth:.1} m away"));
    let found = selecting.filter(|selecting| selecting.micros > 0.0);
    let found = found.map_or(String::new(), |selecting| {
        format!(" in {:.2} ms", selecting.micros / 1e3)
    });
    let time = |stage| watch.times(stage).tell(2, "...");
    text.0 = format!(
        "{} things, {} entities with meshes\n\
         in view {}, hidden {hidden}\n\
         levels {} / {} / {}, {} blocks as one\n\
         picking {}, index {}\n\
         visibility {}, levels {}\n\
         the whole frame {}, without the GPU\n\
         {under}\n\
         {} selected{found}",
        grouped(things.iter().len()),
        grouped(meshes.iter().len()),
        grouped(visible.len()),
        grouped(levels[0]),
        grouped(levels[1]),
        grouped(levels[2]),
        grouped(proxies),
        time(Stage::Picking),
        time(Stage::Index),
        time(Stage::Visibility),
        time(Stage::Levels),
        time(Stage::Frame),
        grouped(selected.iter().len()),
    );
}

/// With commas between thousands.
fn grouped(number: usize) -> String {
    let digits = number.to_string();
    let mut grouped = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    grouped
}

fn on_off(is_on: bool) -> &'static str {
    if is_on { "on" } else { "OFF" }
}

fn tell_keys(
    picking: Res<PickingIsOn>,
    culling: Res<ViewCullingSettings>,
    levels: Res<LodSettings>,
    occlusion: Query<(), With<SoftwareOcclusion>>,
    selecting: Res<Selecting>,
    inside: Res<Inside>,
    flight: Res<Flight>,
    mut text: Single<&mut Text, With<Keys>>,
) {
    let culling = if culling.enabled { "bevy_sightline" } else { "BEVY" };
    let mode = match selecting.settings.mode {
        SelectionMode::Touching => "touching",
        SelectionMode::Enclosed => "enclosing",
    };
    let inspector = if cfg!(feature = "inspector") {
        "   F1 inspector"
    } else {
        ""
    };
    let keys = format!(
        "P picking {}   C culling by {culling}   O occlusion {}   L levels {}   G inside: {}{inspector}\n\
         click: select   drag: move   Shift or Ctrl and drag: box or lasso   T {mode}\n\
         {FLY}   F by itself {}   H hide this",
        on_off(picking.0),
        on_off(!occlusion.is_empty()),
        on_off(levels.enabled),
        inside.name(),
        if flight.is_on { "on" } else { "off" },
    );
    text.set_if_neq(Text(keys));
}

fn tell_plain_keys(picking: Res<PickingIsOn>, flight: Res<Flight>, mut text: Single<&mut Text, With<Keys>>) {
    let keys = format!(
        "Bevy's built-ins alone   P picking {}\n\
         click: select   drag: move\n\
         {FLY}   F by itself {}   H hide this",
        on_off(picking.0),
        if flight.is_on { "on" } else { "off" },
    );
    text.set_if_neq(Text(keys));
}
