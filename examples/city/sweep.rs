//! A pointer that sweeps the view and clicks, and what it finds, held against Bevy's ray cast.

use std::time::Instant;

use bevy::{
    picking::{
        backend::ray::RayMap,
        mesh_picking::ray_cast::{MeshRayCast, MeshRayCastSettings},
        pointer::PointerAction,
    },
    prelude::*,
};
use bevy_sightline::prelude::*;
use serde_json::Value;

use crate::{
    options::Options,
    pointer::{self, Step},
    times::Times,
};

/// How often the pointer is pressed and released.
const FRAMES_PER_CLICK: u32 = 8;
const ROWS: u32 = 24;

/// What the sweep has found so far.
#[derive(Resource, Default)]
struct Findings {
    is_on: bool,
    picks: u32,
    hits: u32,
    over: u32,
    clicks: u32,
    disagreements: u32,
    sightline: Times,
    bevy: Times,
}

/// Takes note of what is found.
pub fn watch(app: &mut App) {
    app.init_resource::<Findings>()
        .add_systems(Update, compare_with_bevy)
        .add_observer(|_: On<Pointer<Over>>, mut findings: ResMut<Findings>| findings.over += 1)
        .add_observer(|_: On<Pointer<Click>>, mut findings: ResMut<Findings>| findings.clicks += 1);
}

/// Sweeps, with everything at its finest, which is what Bevy's ray cast knows.
pub fn run(app: &mut App) -> Result<[(&'static str, Value); 8], String> {
    let frames = app.world().resource::<Options>().frames;
    app.world_mut().resource_mut::<LodSettings>().enabled = false;
    app.update();
    app.insert_resource(Findings {
        is_on: true,
        sightline: Times::of_last(frames as usize),
        bevy: Times::of_last(frames as usize),
        ..default()
    });
    pointer::play(app, sweep(frames));
    app.world_mut().resource_mut::<LodSettings>().enabled = true;
    let mut findings = app.world_mut().resource_mut::<Findings>();
    findings.is_on = false;
    if findings.hits == 0 || findings.over == 0 || findings.clicks == 0 {
        return Err("the pointer has met nothing".into());
    }
    if findings.disagreements > frames / 100 {
        return Err(format!(
            "{} disagreements with Bevy are more than rounding explains",
            findings.disagreements
        ));
    }
    let [ours, bevy] = [&findings.sightline, &findings.bevy].map(|times| f64::from(times.median()) * 1e3);
    Ok([
        ("picks", findings.picks.into()),
        ("hits", findings.hits.into()),
        ("over_events", findings.over.into()),
        ("click_events", findings.clicks.into()),
        ("disagreements_with_bevy", findings.disagreements.into()),
        ("median_pick_us", ours.into()),
        ("median_bevy_mesh_ray_cast_us", bevy.into()),
        ("times_faster", (bevy / ours).into()),
    ])
}

/// Moves the pointer along the rows of the view, back and forth, and clicks at times.
fn sweep(frames: u32) -> impl Iterator<Item = Step> {
    let per_row = frames.div_ceil(ROWS);
    (0..frames).map(move |frame| {
        let (row, column) = (frame / per_row, frame % per_row);
        let along = (column as f32 + 0.5) / per_row as f32;
        let x = if row.is_multiple_of(2) { along } else { 1.0 - along };
        let action = match frame % FRAMES_PER_CLICK {
            0 => Some(PointerAction::Press(PointerButton::Primary)),
            1 => Some(PointerAction::Release(PointerButton::Primary)),
            _ => None,
        };
        (Vec2::new(x, (row as f32 + 0.5) / ROWS as f32), action)
    })
}

/// Casts the ray of the pointer once more, with ours and with Bevy's ray cast, and notes the times and the answers.
fn compare_with_bevy(rays: Res<RayMap>, scene: SceneQuery, mut bevy: MeshRayCast, mut findings: ResMut<Findings>) {
    if !findings.is_on {
        return;
    }
    let settings = SceneQuerySettings::default().with_visibility(QueryVisibility::VisibleInView);
    for (_, ray) in rays.iter() {
        let start = Instant::now();
        let ours = scene.cast_ray(*ray, &settings);
        let between = Instant::now();
        let theirs = bevy.cast_ray(*ray, &MeshRayCastSettings::default()).first();
        let end = Instant::now();

        findings.sightline.add((between - start).as_secs_f32() * 1e3);
        findings.bevy.add((end - between).as_secs_f32() * 1e3);
        findings.picks += 1;
        findings.hits += u32::from(ours.is_some());
        let same = match (ours, theirs) {
            (None, None) => true,
            (Some(ours), Some((_, theirs))) => (ours.distance - theirs.distance).abs() <= 1e-4 * theirs.distance,
            _ => false,
        };
        findings.disagreements += u32::from(!same);
    }
}
