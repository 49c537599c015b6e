//! Selecting what a box or a lasso touches while it is drawn.

use std::time::Instant;

use bevy::{color::palettes::tailwind::AMBER_400, prelude::*};
use bevy_sightline::prelude::*;

use crate::{
    outline::{Marquee, Mouse, Outline},
    scenery::{Ground, Models},
};

/// How things are selected.
#[derive(Resource, Default)]
pub struct Choice(pub SelectionSettings);

/// What is selected, in ascending order, and how long it took to find that.
#[derive(Resource, Default)]
pub struct Selection {
    pub entities: Vec<Entity>,
    pub micros: f64,
}

pub fn plugin(app: &mut App) {
    app.init_resource::<Marquee>()
        .init_resource::<Choice>()
        .init_resource::<Selection>()
        .add_systems(Startup, mix_highlight)
        .add_systems(Update, (draw, choose, select).chain());
}

fn draw(mut mouse: Mouse, keys: Res<ButtonInput<KeyCode>>, mut marquee: ResMut<Marquee>) {
    let is_lasso = keys.any_pressed([KeyCode::ShiftLeft, KeyCode::ShiftRight]);
    marquee.follow(&mut mouse, Some(if is_lasso { Outline::Lasso } else { Outline::Box }));
}

fn choose(keys: Res<ButtonInput<KeyCode>>, mut choice: ResMut<Choice>) {
    if keys.just_pressed(KeyCode::KeyT) {
        choice.0.mode = match choice.0.mode {
            SelectionMode::Touching => SelectionMode::Enclosed,
            SelectionMode::Enclosed => SelectionMode::Touching,
        };
    }
    if keys.just_pressed(KeyCode::KeyB) {
        choice.0.precision = match choice.0.precision {
            SelectionPrecision::Mesh => SelectionPrecision::Bounds,
            SelectionPrecision::Bounds => SelectionPrecision::Mesh,
        };
    }
}

/// The paint of what is selected.
#[derive(Resource)]
pub struct Highlight(Handle<StandardMaterial>);

fn mix_highlight(mut commands: Commands, mut materials: ResMut<Assets<StandardMaterial>>) {
    commands.insert_resource(Highlight(materials.add(StandardMaterial {
        base_color: AMBER_400.into(),
        emissive: LinearRgba::from(AMBER_400) * 0.5,
        perceptual_roughness: 0.85,
        ..default()
    })));
}

/// Selects anew while there is something new to select by.
pub fn select(
    scene: SceneQuery,
    view: Single<(&Camera, &GlobalTransform)>,
    marquee: Res<Marquee>,
    choice: Res<Choice>,
    ground: Query<(), With<Ground>>,
    highlight: Res<Highlight>,
    models: Res<Models>,
    mut selection: ResMut<Selection>,
    mut things: Query<&mut MeshMaterial3d<StandardMaterial>>,
    mut found: Local<Vec<Entity>>,
) {
    let Some(region) = marquee.region() else { return };
    if !marquee.is_drawing && !choice.is_changed() {
        return;
    }
    let (camera, eye) = *view;
    let is_thing = |entity| !ground.contains(entity);
    let settings = SceneQuerySettings::default().filter(&is_thing);
    let start = Instant::now();
    scene.select_on_screen(camera, eye, &region, &choice.0, &settings, &mut found);
    selection.micros = start.elapsed().as_secs_f64() * 1e6;

    let mut paint = |entities: &[Entity], others: &[Entity], paint: &Handle<StandardMaterial>| {
        for &entity in entities {
            if let (Err(_), Ok(mut material)) = (others.binary_search(&entity), things.get_mut(entity)) {
                material.0 = paint.clone();
            }
        }
    };
    paint(&selection.entities, &found, &models.painted);
    paint(&found, &selection.entities, &highlight.0);
    std::mem::swap(&mut selection.entities, &mut found);
}
