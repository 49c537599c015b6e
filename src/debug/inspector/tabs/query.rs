//! The ray under the mouse.

use std::time::Duration;

use bevy::ecs::{
    change_detection::{DetectChangesMut, ResMut},
    system::{InMut, Local},
};
use bevy_egui::egui::{Grid, Ui};

use super::figures;
use crate::{
    debug::inspector::{SightlineInspector, comparison::timed, link::Names, mouse_ray::MouseRay, plot::thousands},
    index::{EntityTest, RayHit, SceneQuery, SceneQuerySettings},
};

/// The most hits in the list.
const MOST_HITS: usize = 50;

pub(in crate::debug::inspector) fn show(
    InMut(ui): InMut<Ui>,
    scene: SceneQuery,
    mut mouse: ResMut<MouseRay>,
    names: Names,
    mut inspector: ResMut<SightlineInspector>,
    mut hits: Local<Vec<RayHit>>,
) {
    ui.horizontal(|ui| {
        ui.checkbox(&mut mouse.is_held, "hold this ray");
        ui.weak("it stays too while the mouse is over the panel");
    });
    let Some((camera, ray)) = mouse.ray else {
        ui.weak("there is no ray yet: move the mouse over the scene");
        return;
    };
    let settings = SceneQuerySettings::default();
    // First, so that what is timed finds in the caches what it needs, the one as the other.
    let trace = scene.trace_ray(ray, &settings);
    let (hit, nearest) = timed(|| scene.cast_ray(ray, &settings));
    let ((), all) = timed(|| scene.cast_ray_all(ray, &settings, &mut hits));
    figures(
        ui,
        "ray",
        [
            ("camera", names.of(camera)),
            ("from", format!("{:.3}", ray.origin)),
            ("direction", format!("{:.3}", *ray.direction)),
            ("nodes visited", thousands(trace.tree.nodes().count() as i64)),
            ("boxes tested", thousands(trace.tree.boxes_tested() as i64)),
            ("entities whose boxes it enters", thousands(trace.entities.len() as i64)),
            ("entities tested", thousands(trace.entities_tested() as i64)),
            ("triangles tested", thousands(trace.triangles_tested() as i64)),
            ("time for the nearest hit", micros(nearest)),
            ("time for all hits", micros(all)),
        ],
    );
    ui.separator();
    let mut edited = *inspector;
    match hit {
        None => ui.strong("It hits nothing"),
        Some(_) => ui.strong(format!("It hits {}, the nearest first", thousands(hits.len() as i64))),
    };
    Grid::new("hits").num_columns(3).striped(true).show(ui, |ui| {
        for hit in hits.iter().take(MOST_HITS) {
            names.link(ui, hit.entity, &mut edited);
            ui.monospace(format!("{:.3}", hit.distance));
            match &hit.triangle {
                Some(triangle) => ui.label(format!("triangle {}", triangle.index)),
                None => ui.label("shape or volume"),
            };
            ui.end_row();
        }
    });
    if hits.len() > MOST_HITS {
        ui.weak(format!("and {} more", hits.len() - MOST_HITS));
    }
    ui.collapsing("What the search for the nearest did, in order", |ui| {
        Grid::new("visited").num_columns(3).striped(true).show(ui, |ui| {
            for visited in trace.entities.iter().take(MOST_HITS) {
                names.link(ui, visited.entity, &mut edited);
                ui.monospace(format!("{:.3}", visited.entered_at));
                ui.label(match (&visited.hit, visited.is_nearest) {
                    (Some(_), true) => "hit: nearest so far",
                    (Some(_), false) => "hit, not nearer",
                    (None, _) => test_name(&visited.test),
                });
                ui.end_row();
            }
        });
    });
    inspector.set_if_neq(edited);
}

/// How a thing was missed.
fn test_name(test: &EntityTest) -> &'static str {
    match test {
        EntityTest::None => "not admitted, or nothing to hit",
        EntityTest::BoundingVolume => "missed by its bounding volume",
        EntityTest::Shape => "missed by its shape",
        EntityTest::Triangles(_) | EntityTest::Hierarchy { .. } => "missed by its triangles",
    }
}

fn micros(time: Duration) -> String {
    format!("{:.1} µs", 1e6 * time.as_secs_f64())
}
