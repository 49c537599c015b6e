//! Selecting by a box or a lasso.

use std::time::Instant;

use bevy::prelude::*;
use bevy_sightline::prelude::*;

use crate::{
    interaction::{IsDrawing, Selected},
    outline::{Marquee, Mouse, Outline},
    scenery::Thing,
};

/// How things are selected, and how long it took to find them.
#[derive(Resource, Default)]
pub struct Selecting {
    pub settings: SelectionSettings,
    pub micros: f64,
}

pub fn plugin(app: &mut App) {
    app.init_resource::<Marquee>()
        .init_resource::<Selecting>()
        .add_systems(Update, (draw, select).chain());
}

/// A drag with Shift draws a box, and with Control a lasso.
fn draw(
    mut mouse: Mouse,
    keys: Res<ButtonInput<KeyCode>>,
    mut marquee: ResMut<Marquee>,
    mut is_drawing: ResMut<IsDrawing>,
) {
    let outline = if keys.any_pressed([KeyCode::ShiftLeft, KeyCode::ShiftRight]) {
        Some(Outline::Box)
    } else if keys.any_pressed([KeyCode::ControlLeft, KeyCode::ControlRight]) {
        Some(Outline::Lasso)
    } else {
        None
    };
    // A drag that has begun otherwise goes on as it was.
    let begins = mouse.has_just_pressed();
    marquee.follow(&mut mouse, outline.filter(|_| begins));
    is_drawing.0 = marquee.is_drawing;
}

/// Selects anew while there is something new to select by.
fn select(
    mut commands: Commands,
    scene: SceneQuery,
    view: Single<(&Camera, &GlobalTransform)>,
    marquee: Res<Marquee>,
    things: Query<(), With<Thing>>,
    selected: Query<Entity, With<Selected>>,
    mut selecting: ResMut<Selecting>,
    mut found: Local<Vec<Entity>>,
) {
    let Some(region) = marquee.region().filter(|_| marquee.is_drawing) else {
        return;
    };
    let (camera, eye) = *view;
    let is_thing = |entity| things.contains(entity);
    let settings = SceneQuerySettings::default().filter(&is_thing);
    let start = Instant::now();
    scene.select_on_screen(camera, eye, &region, &selecting.settings, &settings, &mut found);
    selecting.micros = start.elapsed().as_secs_f64() * 1e6;

    for entity in selected.iter().filter(|entity| found.binary_search(entity).is_err()) {
        commands.entity(entity).remove::<Selected>();
    }
    for &entity in found.iter().filter(|&&entity| !selected.contains(entity)) {
        commands.entity(entity).insert(Selected);
    }
}
