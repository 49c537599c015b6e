//! What is drawn of the structures, and other structures over the same entities.

use bevy::{
    ecs::{
        change_detection::Res,
        entity::Entity,
        system::{InMut, Local},
        world::World,
    },
    gizmos::gizmos::Gizmos,
    math::bounding::Aabb3d,
    tasks::{AsyncComputeTaskPool, Task, TaskPool, futures::check_ready},
};
use bevy_egui::egui::{CollapsingHeader, Color32, Grid, Ui};

use super::bytes;
use crate::{
    debug::{
        gizmos::{DrawStructures, SightlineGizmoStats, SightlineGizmos, StructureStyle},
        inspector::{comparison::Comparison, panel::run, plot::thousands, settings::edit_gizmos},
    },
    index::SpatialIndex,
    spatial::SpatialQueries,
};

/// What is kept between frames.
#[derive(Default)]
pub(in crate::debug::inspector) struct Compared {
    running: Option<Task<Comparison>>,
    comparison: Option<Comparison>,
    draw_kd_tree: bool,
    draw_octree: bool,
}

pub(in crate::debug::inspector) fn show(InMut(ui): InMut<Ui>, world: &mut World) {
    CollapsingHeader::new("What is drawn in the scene")
        .default_open(true)
        .show(ui, |ui| {
            run(ui, world, edit_gizmos);
            run(ui, world, show_left_out);
        });
    ui.separator();
    ui.strong("Other structures over the same entities");
    run(ui, world, compare);
}

fn show_left_out(InMut(ui): InMut<Ui>, stats: Res<SightlineGizmoStats>) {
    let counts = [
        ("nodes", stats.nodes),
        ("cells", stats.cells),
        ("leaves", stats.leaves),
        ("volumes", stats.volumes),
        ("frusta", stats.frusta),
        ("occluders", stats.occluders),
        ("rays", stats.rays),
        ("lods", stats.lods),
    ];
    for (name, count) in counts.iter().filter(|(_, count)| count.drawn + count.left_out > 0) {
        let (drawn, left_out) = (thousands(count.drawn as i64), thousands(count.left_out as i64));
        ui.weak(format!("{name}: {drawn} drawn, {left_out} left out"));
    }
}

fn compare(
    InMut(ui): InMut<Ui>,
    index: Res<SpatialIndex>,
    mut compared: Local<Compared>,
    gizmos: Option<Gizmos<SightlineGizmos>>,
) {
    let Compared {
        running,
        comparison,
        draw_kd_tree,
        draw_octree,
    } = &mut *compared;
    if let Some(done) = running.as_mut().and_then(check_ready) {
        *comparison = Some(done);
        *running = None;
    }
    if running.is_some() {
        ui.horizontal(|ui| {
            ui.spinner();
            ui.label("structures are being built and asked");
        });
    } else if ui.button("Build and measure").clicked() {
        let mut boxes: Vec<(Entity, Aabb3d)> = Vec::with_capacity(index.len());
        index.tree().visit_all(|key, aabb| boxes.push((key.entity, *aabb)));
        let pool = AsyncComputeTaskPool::get_or_init(TaskPool::default);
        *running = Some(pool.spawn(async move { Comparison::of(&boxes) }));
    }
    let Some(comparison) = comparison else {
        return;
    };
    show_costs(ui, comparison);
    ui.horizontal(|ui| {
        ui.checkbox(draw_kd_tree, "draw the k-d tree");
        ui.checkbox(draw_octree, "draw the octree");
    });
    let Some(mut gizmos) = gizmos else {
        return;
    };
    let style = StructureStyle {
        depths: gizmos.config_ext.depths.clone(),
        limit: gizmos.config_ext.limit,
        ..StructureStyle::default()
    };
    if let Some(kd_tree) = comparison.kd_tree.as_ref().filter(|_| *draw_kd_tree) {
        gizmos.kd_tree(kd_tree, &style);
    }
    if *draw_octree {
        gizmos.octree(&comparison.octree, &style);
    }
}

fn show_costs(ui: &mut Ui, comparison: &Comparison) {
    ui.label(format!(
        "{} boxes, as they were when this was measured",
        thousands(comparison.entities as i64)
    ));
    Grid::new("costs").num_columns(5).striped(true).show(ui, |ui| {
        for heading in ["", "build", "memory", "a ray", "a small box"] {
            ui.weak(heading);
        }
        ui.end_row();
        for cost in &comparison.costs {
            ui.label(cost.name);
            ui.monospace(format!("{:.2} ms", 1e3 * cost.build.as_secs_f64()));
            ui.monospace(bytes(cost.memory));
            ui.monospace(format!("{:.2} µs", 1e6 * cost.ray.as_secs_f64()));
            ui.monospace(format!("{:.2} µs", 1e6 * cost.overlap.as_secs_f64()));
            if cost.wrong > 0 {
                ui.colored_label(Color32::LIGHT_RED, format!("{} wrong", cost.wrong));
            }
            ui.end_row();
        }
    });
}
