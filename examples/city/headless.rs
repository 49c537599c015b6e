//! The city without a window: a synthetic pointer does all that a hand would, and every answer is held against another.

use std::{fs, time::Duration};

use bevy::{prelude::*, time::TimeUpdateStrategy};
use bevy_sightline::{
    index::{MeshBvhs, SimplifiedMesh},
    mesh::TriangleMesh,
    prelude::*,
};

use crate::{
    checks,
    interaction::{Hovered, Selected},
    loading::load,
    options::Options,
    picture,
    pointer::{self, Step},
    sweep,
    traffic::Traveller,
};

/// Checks everything, and prints the report.
pub fn run(mut app: App) -> AppExit {
    match check_and_report(&mut app) {
        Ok(()) => AppExit::Success,
        Err(message) => {
            eprintln!("{message}");
            AppExit::error()
        }
    }
}

/// Clicks on one tower and comes to rest on another.
fn select_and_hover() -> impl Iterator<Item = Step> {
    let (tower, other_tower) = (Vec2::new(0.195, 0.55), Vec2::new(0.68, 0.5));
    pointer::click(tower).into_iter().chain([(other_tower, None); 2])
}

fn check_and_report(app: &mut App) -> Result<(), String> {
    sweep::watch(app);
    load(app)?;
    let mut report = describe(app);
    let mut note = |name: &str, value: serde_json::Value| report.insert(name.into(), value);
    for (name, value) in sweep::run(app)? {
        note(name, value);
    }
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::ZERO));
    checks::check_drag(app)?;
    let boxed = checks::check_box(app)?;
    note("in_a_box", boxed.into());
    let in_view = checks::check_culling(app)?;
    note("in_view", in_view.into());
    let levels = checks::check_levels(app)?;
    note("in_view_at_levels", levels.to_vec().into());
    let hidden = checks::check_occlusion(app)?;
    note("hidden_in_a_street", hidden.into());

    pointer::play(app, select_and_hover());
    let world = app.world_mut();
    let hovered = world.query::<&Hovered>().iter(world).len();
    let selected = world.query::<&Selected>().iter(world).len();
    if (hovered, selected) != (1, 1) {
        return Err(format!(
            "{hovered} things are hovered and {selected} selected, and should be one each"
        ));
    }
    let options = app.world().resource::<Options>().clone();
    let drawn = app
        .world_mut()
        .run_system_cached_with(picture::draw, options.picture.clone());
    let picture_ms = match drawn {
        Ok(Ok(ms)) => ms,
        Ok(Err(error)) => return Err(format!("no picture: {error}")),
        Err(error) => return Err(format!("no picture: {error}")),
    };
    note("picture_ms", picture_ms.into());
    print_report(&report);
    println!("picture: {}", options.picture.display());
    if let Some(file) = &options.json {
        let report = serde_json::Value::from(report);
        fs::write(file, format!("{report:#}\n"))
            .map_err(|error| format!("cannot write {}: {error}", file.display()))?;
    }
    Ok(())
}

/// What there is.
fn describe(app: &mut App) -> serde_json::Map<String, serde_json::Value> {
    let world = app.world_mut();
    let moving = world.query::<&Traveller>().iter(world).len();
    // Of what is swapped, the finest.
    let mut meshes = world.query::<(&Mesh3d, Option<&SimplifiedMesh>)>();
    let finest = |(shown, hit): (&Mesh3d, Option<&SimplifiedMesh>)| hit.map_or(shown.id(), |finest| finest.0.id());
    let meshes: Vec<AssetId<Mesh>> = meshes.iter(world).map(finest).collect();
    let bvhs = world.resource::<MeshBvhs>();
    let triangles: usize = meshes
        .iter()
        .filter_map(|id| bvhs.triangles(*id))
        .map(TriangleMesh::len)
        .sum();
    let figures = [
        ("entities", world.resource::<SpatialIndex>().len()),
        ("moving", moving),
        ("groups_with_levels", world.resource::<LodChoices>().len()),
        ("occluders", world.resource::<Occluders>().len()),
        ("triangles_in_all", triangles),
    ];
    figures
        .map(|(name, value)| (name.to_string(), value.into()))
        .into_iter()
        .collect()
}

fn print_report(report: &serde_json::Map<String, serde_json::Value>) {
    for (name, value) in report {
        let value = value
            .as_f64()
            .filter(|_| value.is_f64())
            .map_or(value.to_string(), |v| format!("{v:.2}"));
        println!("{:<30}{value:>14}", name.replace('_', " "));
    }
}
