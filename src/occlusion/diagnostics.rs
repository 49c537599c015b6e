//! The figures of all cameras, for whoever reads Bevy's diagnostics.

use bevy::{
    app::{App, Plugin, PostUpdate},
    camera::visibility::VisibilitySystems,
    diagnostic::{Diagnostic, DiagnosticPath, Diagnostics, RegisterDiagnostic},
    ecs::{query::With, schedule::IntoScheduleConfigs, system::Query},
};

use super::{OcclusionBuffer, OcclusionStats, SoftwareOcclusion};

/// Adds the [`OcclusionStats`] of all cameras, added up, to Bevy's `DiagnosticsStore` in every frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct OcclusionDiagnosticsPlugin;

impl OcclusionDiagnosticsPlugin {
    /// The entities that were drawn to hide others.
    pub const OCCLUDERS: DiagnosticPath = DiagnosticPath::const_new("sightline/occlusion/occluders");
    /// The triangles that they have.
    pub const TRIANGLES: DiagnosticPath = DiagnosticPath::const_new("sightline/occlusion/triangles");
    /// The boxes that were tested.
    pub const TESTED: DiagnosticPath = DiagnosticPath::const_new("sightline/occlusion/tested");
    /// The entities that were passed over.
    pub const HIDDEN: DiagnosticPath = DiagnosticPath::const_new("sightline/occlusion/hidden");
}

impl Plugin for OcclusionDiagnosticsPlugin {
    fn build(&self, app: &mut App) {
        for path in [Self::OCCLUDERS, Self::TRIANGLES, Self::TESTED, Self::HIDDEN] {
            app.register_diagnostic(Diagnostic::new(path).with_smoothing_factor(0.0));
        }
        app.add_systems(PostUpdate, measure_occlusion.after(VisibilitySystems::CheckVisibility));
    }
}

fn measure_occlusion(buffers: Query<&OcclusionBuffer, With<SoftwareOcclusion>>, mut diagnostics: Diagnostics) {
    let total =
        |of: fn(&OcclusionStats) -> usize| buffers.iter().map(|buffer| of(buffer.stats())).sum::<usize>() as f64;
    diagnostics.add_measurement(&OcclusionDiagnosticsPlugin::OCCLUDERS, || {
        total(|stats| stats.occluders)
    });
    diagnostics.add_measurement(&OcclusionDiagnosticsPlugin::TRIANGLES, || {
        total(|stats| stats.triangles)
    });
    diagnostics.add_measurement(&OcclusionDiagnosticsPlugin::TESTED, || total(|stats| stats.tested));
    diagnostics.add_measurement(&OcclusionDiagnosticsPlugin::HIDDEN, || total(|stats| stats.hidden));
}
