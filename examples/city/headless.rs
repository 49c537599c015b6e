//! The city without a window: a synthetic pointer sweeps the view, and a report tells what it met.

use std::{fs, time::Instant};

use bevy::{
    picking::{
        backend::ray::RayMap,
        mesh_picking::ray_cast::{MeshRayCast, MeshRayCastSettings},
        pointer::PointerAction,
    },
    prelude::*,
};
use bevy_sightline::{index::MeshBvhs, mesh::TriangleMesh, prelude::*};

use crate::{
    interaction::{Hovered, Selected},
    options::Options,
    picture,
    pointer::{self, Step},
    shared,
    traffic::Traveller,
};

/// How often the pointer is pressed and released.
const FRAMES_PER_CLICK: u32 = 8;
const ROWS: u32 = 24;

/// What the sweep has found so far.
#[derive(Resource, Default)]
struct Findings {
    picks: u32,
    hits: u32,
    over: u32,
    clicks: u32,
    disagreements: u32,
    sightline_ns: Vec<u64>,
    bevy_ns: Vec<u64>,
}

/// Runs the scene until it is loaded, then for the frames of the sweep, and prints the report.
pub fn run(mut app: App) -> AppExit {
    app.init_resource::<Findings>()
        .add_systems(Update, compare_with_bevy)
        .add_observer(|_: On<Pointer<Over>>, mut findings: ResMut<Findings>| findings.over += 1)
        .add_observer(|_: On<Pointer<Click>>, mut findings: ResMut<Findings>| findings.clicks += 1);
    if let Err(message) = shared::load(&mut app) {
        eprintln!("{message}");
        return AppExit::error();
    }
    *app.world_mut().resource_mut::<Findings>() = default();

    let options = app.world().resource::<Options>().clone();
    pointer::play(&mut app, sweep(options.frames));
    pointer::play(&mut app, select_and_hover());

    let picture_ms = app
        .world_mut()
        .run_system_cached_with(picture::draw, options.picture.clone());
    let report = match picture_ms {
        Ok(Ok(ms)) => report(&mut app, ms),
        Ok(Err(error)) => {
            eprintln!("no picture: {error}");
            return AppExit::error();
        }
        Err(error) => {
            eprintln!("no picture: {error}");
            return AppExit::error();
        }
    };
    print_report(&report);
    if report["disagreements_with_bevy"].as_u64() > Some(u64::from(options.frames / 100)) {
        eprintln!("more disagreements with Bevy than rounding explains");
        return AppExit::error();
    }
    println!("picture: {}", options.picture.display());
    if let Some(file) = &options.report
        && let Err(error) = fs::write(file, format!("{report:#}\n"))
    {
        eprintln!("cannot write {}: {error}", file.display());
        return AppExit::error();
    }
    AppExit::Success
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

/// Clicks on one tower and comes to rest on another, for the picture.
fn select_and_hover() -> impl Iterator<Item = Step> {
    let (tower, other_tower) = (Vec2::new(0.195, 0.55), Vec2::new(0.68, 0.5));
    pointer::click(tower).into_iter().chain([(other_tower, None); 2])
}

/// Casts the ray of the pointer once more, with ours and with Bevy's ray cast, and notes the times and the answers.
fn compare_with_bevy(rays: Res<RayMap>, scene: SceneQuery, mut bevy: MeshRayCast, mut findings: ResMut<Findings>) {
    let settings = SceneQuerySettings::default().with_visibility(QueryVisibility::VisibleInView);
    for (_, ray) in rays.iter() {
        let start = Instant::now();
        let ours = scene.cast_ray(*ray, &settings);
        let between = Instant::now();
        let theirs = bevy.cast_ray(*ray, &MeshRayCastSettings::default()).first();
        let end = Instant::now();

        findings.sightline_ns.push((between - start).as_nanos() as u64);
        findings.bevy_ns.push((end - between).as_nanos() as u64);
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

fn report(app: &mut App, picture_ms: f64) -> serde_json::Value {
    let world = app.world_mut();
    let moving = world.query::<&Traveller>().iter(world).len();
    let hovered = world.query::<&Hovered>().iter(world).len();
    let selected = world.query::<&Selected>().iter(world).len();
    let meshes: Vec<AssetId<Mesh>> = world.query::<&Mesh3d>().iter(world).map(|mesh| mesh.id()).collect();
    let bvhs = world.resource::<MeshBvhs>();
    let triangles: usize = meshes
        .iter()
        .filter_map(|id| bvhs.triangles(*id))
        .map(TriangleMesh::len)
        .sum();
    let entities = world.resource::<SpatialIndex>().len();
    let mut findings = world.resource_mut::<Findings>();
    let sightline_us = median_us(&mut findings.sightline_ns);
    let bevy_us = median_us(&mut findings.bevy_ns);
    serde_json::json!({
        "entities": entities,
        "moving": moving,
        "triangles": triangles,
        "picks": findings.picks,
        "hits": findings.hits,
        "over_events": findings.over,
        "click_events": findings.clicks,
        "hovered_at_end": hovered,
        "selected_at_end": selected,
        "disagreements_with_bevy": findings.disagreements,
        "median_pick_us": sightline_us,
        "median_bevy_mesh_ray_cast_us": bevy_us,
        "times_faster": bevy_us / sightline_us,
        "picture_ms": picture_ms,
    })
}

fn median_us(ns: &mut [u64]) -> f64 {
    ns.sort_unstable();
    ns.get(ns.len() / 2).map_or(f64::NAN, |median| *median as f64 / 1000.0)
}

fn print_report(report: &serde_json::Value) {
    for (name, value) in report.as_object().expect("the report is an object") {
        let value = value
            .as_f64()
            .filter(|_| value.is_f64())
            .map_or(value.to_string(), |v| format!("{v:.2}"));
        println!("{:<30}{value:>14}", name.replace('_', " "));
    }
}
