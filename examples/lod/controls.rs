//! The keys that change how levels are chosen.

use bevy::prelude::*;
use bevy_sightline::prelude::*;

use crate::stopwatch::Stopwatch;

/// So large does everything seem to be when all of it is shown at the finest level.
const ALL_FINEST: f32 = 1e9;

/// Whether anything but the finest levels is shown.
pub fn has_levels(settings: &LodSettings) -> bool {
    settings.bias < ALL_FINEST
}

pub fn set_levels(settings: &mut LodSettings, are_on: bool) {
    settings.bias = if are_on { 1.0 } else { ALL_FINEST };
}

pub fn plugin(app: &mut App) {
    app.add_systems(Update, choose);
}

fn choose(keys: Res<ButtonInput<KeyCode>>, mut settings: ResMut<LodSettings>, watch: Res<Stopwatch>) {
    if keys.just_pressed(KeyCode::KeyH) {
        let usual = LodSettings::default().hysteresis;
        settings.hysteresis = if settings.hysteresis > 0.0 { 0.0 } else { usual };
    }
    if keys.just_pressed(KeyCode::KeyL) {
        println!("{}", *watch);
        let are_on = has_levels(&settings);
        set_levels(&mut settings, !are_on);
    }
}
