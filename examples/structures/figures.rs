//! The text: what is shown, how far the ray has come, what it costs elsewhere, and the keys.

use bevy::prelude::*;

use crate::{explorer::Explorer, panel::panel, structure::Kind};

const HELP: &str = "\
1 tree  2 grid  3 k-d tree  4 octree  5 list
B      build it in another way
arrows one visit forward, back
Space  play      Home, End  jump
drag   aim the ray          R  first ray
Tab    two or three dimensions
N      other boxes
right button: turn, in three dimensions";

#[derive(Component)]
struct Figures;

pub fn plugin(app: &mut App) {
    app.add_systems(Startup, |mut commands: Commands| {
        commands.spawn(panel(Figures, ""));
    })
    .add_systems(Update, tell.run_if(resource_changed::<Explorer>));
}

fn tell(explorer: Res<Explorer>, mut text: Single<&mut Text, With<Figures>>) {
    let built = explorer.structure().built();
    let visits = explorer.visited().count();
    let tests: usize = explorer.visited().map(|(_, node)| node.boxes.len()).sum();
    let found = match explorer.nearest() {
        Some((number, at)) if explorer.step == explorer.trace.steps.len() => format!("hits box {number} at {at:.1}"),
        Some((number, at)) => format!("nearest so far: box {number} at {at:.1}"),
        None if explorer.step == explorer.trace.steps.len() => "hits nothing".into(),
        None => "nothing hit so far".into(),
    };
    let parts = match explorer.kind {
        Kind::Grid { .. } => "cells",
        Kind::List => "list",
        _ => "nodes",
    };
    let table: String = (explorer.costs.iter())
        .map(|&(kind, visits, tests)| {
            let mark = if kind == explorer.kind { '>' } else { ' ' };
            format!("{mark} {:<20}{visits:>6}{tests:>7}\n", kind.name())
        })
        .collect();
    text.0 = format!(
        "{}\n{} boxes, {} {parts}, depth {}, {:.1} kB\n\n\
         visit {visits:>3} of {}, {}\n\
         test  {tests:>3} of {}\n\
         {found}\n\n\
         this ray              visits  tests\n{table}\n{HELP}",
        explorer.kind.name(),
        explorer.boxes.boxes.len(),
        built.parts,
        built.depth,
        built.bytes as f32 / 1e3,
        explorer.trace.nodes().count(),
        match explorer.trace.steps.len() - explorer.step {
            _ if explorer.playing => "playing",
            0 => "at the end",
            _ => "paused",
        },
        explorer.trace.boxes_tested(),
    );
}
