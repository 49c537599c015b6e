//! What is indexed, what is not, and what that costs.

use std::time::Duration;

use bevy::{
    diagnostic::DiagnosticsStore,
    ecs::{
        change_detection::{DetectChangesMut, Res, ResMut},
        system::{InMut, Local},
    },
};
use bevy_egui::egui::{Color32, Ui};

use super::{Seldom, bytes, figures};
use crate::{
    debug::inspector::{
        SightlineInspector,
        link::Names,
        plot::{counts, phases, thousands},
    },
    index::{BrokenIndex, MeshBvhs, SpatialIndex, SpatialIndexStats},
};

/// The most refused entities in the list.
const MOST_REFUSED: usize = 100;

pub(in crate::debug::inspector) fn show(
    InMut(ui): InMut<Ui>,
    mut index: ResMut<SpatialIndex>,
    meshes: Res<MeshBvhs>,
    store: Option<Res<DiagnosticsStore>>,
    names: Names,
    mut inspector: ResMut<SightlineInspector>,
    mut stats: Local<Seldom<SpatialIndexStats>>,
    mut validated: Local<Option<Result<(), BrokenIndex>>>,
) {
    let stats = stats.get(Duration::from_millis(500), |stats| *stats = index.stats());
    figures(
        ui,
        "index",
        [
            ("entities", thousands(stats.entities as i64)),
            ("refused", thousands(stats.refused as i64)),
            ("nodes", thousands(stats.nodes as i64)),
            ("depth", stats.depth.to_string()),
            ("boxes that a random ray meets", format!("{:.1}", stats.sah_cost)),
            (
                "smallest cells of the grid",
                stats
                    .cell_size
                    .map_or("no grid".to_owned(), |size| format!("{size:.3}")),
            ),
            ("memory of the tree", bytes(stats.tree_memory)),
            ("memory of the grid", bytes(stats.grid_memory)),
            ("memory of the tables", bytes(stats.table_memory)),
            ("memory of meshes", bytes(meshes.memory())),
            ("meshes that are being built", meshes.building().to_string()),
        ],
    );
    ui.horizontal(|ui| {
        if ui.button("Validate").clicked() {
            *validated = Some(index.validate());
        }
        if ui.button("Rebuild").clicked() {
            index.rebuild();
            *validated = None;
        }
        match *validated {
            None => {}
            Some(Ok(())) => {
                ui.colored_label(Color32::LIGHT_GREEN, "the index is whole");
            }
            Some(Err(error)) => {
                ui.colored_label(Color32::LIGHT_RED, error.to_string());
            }
        }
    });
    let refused = index.refused();
    let left_out = refused.len();
    if left_out > 0 {
        ui.collapsing(format!("Refused: {left_out}"), |ui| {
            let mut edited = *inspector;
            for (entity, reason) in refused.take(MOST_REFUSED) {
                names.link(ui, entity, &mut edited);
                ui.indent(entity, |ui| ui.weak(reason.to_string()));
            }
            if left_out > MOST_REFUSED {
                ui.weak(format!("and {} more", left_out - MOST_REFUSED));
            }
            inspector.set_if_neq(edited);
        });
    }
    ui.separator();
    if let Some(store) = store {
        ui.strong("Phases of a frame");
        phases(ui, &store);
        ui.separator();
        ui.strong("Each frame");
        counts(ui, &store, &["index", "meshes", "sprite"]);
    }
}
