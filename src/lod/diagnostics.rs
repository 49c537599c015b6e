//! What choosing levels has cost, and what has come of it.

use std::time::Duration;

use bevy::{
    app::{App, Plugin, PostUpdate},
    diagnostic::{Diagnostic, DiagnosticPath, Diagnostics, RegisterDiagnostic},
    ecs::{change_detection::Res, reflect::ReflectResource, resource::Resource, schedule::IntoScheduleConfigs},
    reflect::{Reflect, std_traits::ReflectDefault},
};

use super::LodSystems;

/// What [`LodSystems::Choose`] did in the last frame, and how long it took.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Resource, Default, Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct LodStats {
    /// The groups that there are.
    pub groups: usize,
    /// The groups that were looked at in some view, as often as they were: near a switch, moved, or changed.
    pub looked_at: usize,
    /// The groups that switched in some view, as often as they did.
    pub switched: usize,
    /// The time that it took to choose.
    pub time: Duration,
}

/// Adds the [`LodStats`] to Bevy's `DiagnosticsStore` in every frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct LodDiagnosticsPlugin;

impl LodDiagnosticsPlugin {
    /// The groups that there are.
    pub const GROUPS: DiagnosticPath = DiagnosticPath::const_new("sightline/lod/groups");
    /// The groups that were looked at.
    pub const LOOKED_AT: DiagnosticPath = DiagnosticPath::const_new("sightline/lod/looked_at");
    /// The groups that switched.
    pub const SWITCHED: DiagnosticPath = DiagnosticPath::const_new("sightline/lod/switched");
    /// The time that it took, in milliseconds.
    pub const TIME: DiagnosticPath = DiagnosticPath::const_new("sightline/lod/time");
}

impl Plugin for LodDiagnosticsPlugin {
    fn build(&self, app: &mut App) {
        for path in [Self::GROUPS, Self::LOOKED_AT, Self::SWITCHED, Self::TIME] {
            app.register_diagnostic(Diagnostic::new(path).with_smoothing_factor(0.0));
        }
        app.add_systems(PostUpdate, measure_levels.after(LodSystems::Choose));
    }
}

fn measure_levels(stats: Option<Res<LodStats>>, mut diagnostics: Diagnostics) {
    let Some(stats) = stats else {
        return;
    };
    diagnostics.add_measurement(&LodDiagnosticsPlugin::GROUPS, || stats.groups as f64);
    diagnostics.add_measurement(&LodDiagnosticsPlugin::LOOKED_AT, || stats.looked_at as f64);
    diagnostics.add_measurement(&LodDiagnosticsPlugin::SWITCHED, || stats.switched as f64);
    diagnostics.add_measurement(&LodDiagnosticsPlugin::TIME, || 1000.0 * stats.time.as_secs_f64());
}
