//! What is known of the selected entity.

use bevy::{
    camera::visibility::{InheritedVisibility, ViewVisibility},
    ecs::{
        change_detection::{DetectChangesMut, Res, ResMut},
        hierarchy::ChildOf,
        system::{InMut, Query},
    },
    mesh::Mesh3d,
};
use bevy_egui::egui::Ui;

use crate::{
    debug::inspector::{SightlineInspector, link::Names, plot::thousands},
    index::{MeshBvhs, SpatialIndex},
};

pub(in crate::debug::inspector) fn show(
    InMut(ui): InMut<Ui>,
    entities: Query<(
        Option<&ChildOf>,
        Option<&Mesh3d>,
        Option<&InheritedVisibility>,
        Option<&ViewVisibility>,
    )>,
    index: Res<SpatialIndex>,
    meshes: Option<Res<MeshBvhs>>,
    names: Names,
    mut inspector: ResMut<SightlineInspector>,
) {
    let Some(selected) = inspector.selected else {
        return;
    };
    let Ok((parent, mesh, inherited, seen)) = entities.get(selected) else {
        ui.weak(format!("{selected} is gone"));
        return;
    };
    let mut edited = *inspector;
    ui.horizontal(|ui| {
        ui.strong(names.of(selected));
        if ui.small_button("deselect").clicked() {
            edited.selected = None;
        }
    });
    if let Some(parent) = parent {
        ui.horizontal(|ui| {
            ui.label("child of");
            names.link(ui, parent.parent(), &mut edited);
        });
    }
    match index.aabb(selected) {
        Some(aabb) => ui.label(format!("box from {:.2} to {:.2}", aabb.min, aabb.max)),
        None => match index.refused().find(|(entity, _)| *entity == selected) {
            Some((_, reason)) => ui.label(format!("not in the index: {reason}")),
            None => ui.label("not in the index: it has no bounds, or NoSpatialIndex"),
        },
    };
    if let (Some(mesh), Some(meshes)) = (mesh, meshes) {
        match (meshes.triangles(mesh), meshes.progress(mesh)) {
            (_, Some(progress)) => ui.label(format!("its mesh is being built: {:.0}%", 100.0 * progress)),
            (Some(triangles), None) => ui.label(format!("{} triangles", thousands(triangles.len() as i64))),
            (None, None) => ui.label("its mesh has no triangles for rays to hit"),
        };
    }
    let is_hidden = inherited.is_some_and(|inherited| !inherited.get());
    let is_seen = seen.is_some_and(|seen| seen.get());
    ui.label(match (is_hidden, is_seen) {
        (true, _) => "hidden, by itself or an ancestor",
        (false, true) => "seen by some camera or light",
        (false, false) => "seen by no camera and no light",
    });
    inspector.set_if_neq(edited);
}
