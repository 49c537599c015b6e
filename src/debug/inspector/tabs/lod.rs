//! Which levels of detail are shown, and what that saves.

use std::time::{Duration, Instant};

use bevy::{
    asset::{AssetId, Assets},
    diagnostic::{DiagnosticPath, DiagnosticsStore},
    ecs::{
        change_detection::{DetectChangesMut, Res, ResMut},
        entity::{Entity, EntityHashSet},
        system::{Commands, InMut, Local, Query, SystemParam},
    },
    mesh::{Mesh, Mesh3d},
};
use bevy_egui::egui::{Grid, Slider, Ui};

use super::{Seldom, bytes, culling::choose_view, figures};
use crate::{
    culling::VisibleSet,
    debug::inspector::{
        SightlineInspector,
        link::Names,
        plot::{diagnostics, figure, thousands},
    },
    index::MeshBvhs,
    lod::{LodBias, LodChoices, LodContent, LodSettings, LodStreamingStats, MAX_LEVELS, ProxyLod},
};

const SWITCHED: DiagnosticPath = DiagnosticPath::const_new("sightline/lod/switched");

/// How deep groups are looked into: bad data may have one within itself.
const DEEPEST: usize = 64;

/// What a view shows of all groups.
#[derive(Debug, Default)]
pub(in crate::debug::inspector) struct Tally {
    view: Option<Entity>,
    /// How many groups are at each level.
    levels: [usize; MAX_LEVELS],
    /// How many are stood in for by a group around them.
    stood_in_for: usize,
    /// The triangles in view, and what they would be with all groups at their finest levels.
    drawn: usize,
    full: usize,
}

#[derive(SystemParam)]
pub(in crate::debug::inspector) struct Groups<'w, 's> {
    choices: Res<'w, LodChoices>,
    groups: Query<'w, 's, &'static ProxyLod>,
    meshes: Query<'w, 's, &'static Mesh3d>,
    bvhs: Res<'w, MeshBvhs>,
    assets: Option<Res<'w, Assets<Mesh>>>,
}

impl Groups<'_, '_> {
    fn count(&self, view: Entity, seen: &VisibleSet) -> Tally {
        let mut tally = Tally {
            view: Some(view),
            ..Tally::default()
        };
        for root in self.choices.roots() {
            match self.choices.shown_level(root, view) {
                Some(level) => tally.levels[level.min(MAX_LEVELS - 1)] += 1,
                None => tally.stood_in_for += 1,
            }
        }
        // Each group once, whatever it shows.
        let mut counted = EntityHashSet::default();
        for &entity in seen.entities() {
            let drawn = self.triangles_of(entity);
            tally.drawn += drawn;
            let group = self.choices.group_of(entity).map(|(root, _)| root);
            let group = group.or_else(|| self.groups.contains(entity).then_some(entity));
            match group {
                None => tally.full += drawn,
                Some(root) => {
                    let outermost = self.outermost(root);
                    if counted.insert(outermost) {
                        tally.full += self.triangles_of_finest(outermost, 0);
                    }
                }
            }
        }
        tally
    }

    /// The group around all groups around this one.
    fn outermost(&self, mut root: Entity) -> Entity {
        for _ in 0..DEEPEST {
            match self.choices.group_of(root) {
                Some((around, _)) if around != root => root = around,
                _ => break,
            }
        }
        root
    }

    fn triangles_of(&self, entity: Entity) -> usize {
        self.meshes.get(entity).map_or(0, |mesh| self.triangles_in(mesh.id()))
    }

    fn triangles_in(&self, mesh: AssetId<Mesh>) -> usize {
        // A mesh that is only shown has no hierarchy, one that is only in the renderer no indices.
        let indices = || self.assets.as_ref()?.get(mesh)?.try_indices().ok();
        match self.bvhs.triangles(mesh) {
            Some(triangles) => triangles.len(),
            None => indices().map_or(0, |indices| indices.len() / 3),
        }
    }

    fn triangles_of_finest(&self, root: Entity, depth: usize) -> usize {
        let Some(finest) = self.groups.get(root).ok().and_then(|group| group.levels.first()) else {
            return self.triangles_of(root);
        };
        match &finest.content {
            LodContent::Mesh(mesh) => self.triangles_in(mesh.id()),
            LodContent::Entities(members) if depth < DEEPEST => members
                .iter()
                .map(|&member| match self.groups.contains(member) {
                    true => self.triangles_of_finest(member, depth + 1),
                    false => self.triangles_of(member),
                })
                .sum(),
            _ => 0,
        }
    }
}

pub(in crate::debug::inspector) fn show(
    InMut(ui): InMut<Ui>,
    views: Query<(Entity, &VisibleSet)>,
    biases: Query<&LodBias>,
    groups: Groups,
    mut settings: ResMut<LodSettings>,
    streaming: Option<Res<LodStreamingStats>>,
    store: Option<Res<DiagnosticsStore>>,
    names: Names,
    mut inspector: ResMut<SightlineInspector>,
    mut tally: Local<Seldom<Tally>>,
    mut commands: Commands,
) {
    let mut edited = *inspector;
    let Some((view, seen)) = choose_view(ui, &views, &names, &mut edited.view) else {
        ui.weak("no camera has a VisibleSet: the app has none, or no ViewCullingPlugin");
        return;
    };
    inspector.set_if_neq(edited);
    if tally.value.view != Some(view) {
        *tally = Seldom::default();
    }
    let tally = tally.get(Duration::from_millis(500), |tally| *tally = groups.count(view, seen));
    let percent = 100.0 * tally.drawn as f64 / tally.full.max(1) as f64;
    let switches = store.as_deref().map_or(0.0, switches_per_second);
    figures(
        ui,
        "lod",
        [
            ("groups", thousands(groups.choices.len() as i64)),
            ("switches per second, all views", figure(switches)),
            ("triangles in view", thousands(tally.drawn as i64)),
            ("at full detail they would be", thousands(tally.full as i64)),
            ("drawn of them", format!("{percent:.1}%")),
        ],
    );
    Grid::new("levels").num_columns(2).striped(true).show(ui, |ui| {
        for (level, &count) in tally.levels.iter().enumerate().filter(|(_, count)| **count > 0) {
            ui.label(format!("groups at level {level}"));
            ui.monospace(thousands(count as i64));
            ui.end_row();
        }
        if tally.stood_in_for > 0 {
            ui.label("stood in for by a group around them");
            ui.monospace(thousands(tally.stood_in_for as i64));
            ui.end_row();
        }
    });
    ui.separator();
    edit_biases(ui, view, &biases, &mut settings, &mut commands);
    if let Some(streaming) = streaming {
        ui.separator();
        ui.label(format!(
            "streamed meshes: {} loaded with {}, {} loading, {} failed",
            streaming.loaded,
            bytes(streaming.memory),
            streaming.loading,
            streaming.failed
        ));
    }
    ui.separator();
    ui.strong("Each frame");
    if let Some(store) = store {
        diagnostics(ui, &store, &["lod", "simplify"]);
    }
}

fn edit_biases(
    ui: &mut Ui,
    view: Entity,
    biases: &Query<&LodBias>,
    settings: &mut ResMut<LodSettings>,
    commands: &mut Commands,
) {
    let mut edited = **settings;
    ui.checkbox(&mut edited.enabled, "choose levels");
    bias(ui, &mut edited.bias, "bias, all views");
    bias(ui, &mut edited.shadow_bias, "bias, shadows");
    settings.set_if_neq(edited);
    let of_view = biases.get(view).copied().unwrap_or_default();
    let mut edited = of_view;
    bias(ui, &mut edited.0, "bias, this view");
    if edited != of_view {
        commands.entity(view).try_insert(edited);
    }
}

fn bias(ui: &mut Ui, bias: &mut f32, name: &str) {
    ui.add(Slider::new(bias, 0.05..=20.0).logarithmic(true).text(name));
}

fn switches_per_second(store: &DiagnosticsStore) -> f64 {
    let now = Instant::now();
    let Some(diagnostic) = store.get(&SWITCHED) else {
        return 0.0;
    };
    let measurements = diagnostic.measurements();
    let recent = measurements.filter(|measurement| now.duration_since(measurement.time) < Duration::from_secs(1));
    recent.map(|measurement| measurement.value).sum()
}
