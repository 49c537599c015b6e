//! Diagnostics as figures, with a plot of the last measurements.

use bevy::diagnostic::{Diagnostic, DiagnosticsStore};
use bevy_egui::egui::{Grid, Sense, Stroke, Ui, emath::lerp, epaint::PathShape, pos2};

/// The size of a plot, in points.
const SIZE: [f32; 2] = [170.0, 18.0];

/// The times of all phases of a frame.
pub(super) fn phases(ui: &mut Ui, store: &DiagnosticsStore) {
    rows(ui, store, "phases", |path, suffix| {
        path.starts_with("sightline/") && suffix.trim() == "ms"
    });
}

/// What is counted of these plugins.
pub(super) fn counts(ui: &mut Ui, store: &DiagnosticsStore, plugins: &[&str]) {
    rows(ui, store, "counts", |path, suffix| {
        suffix.trim() != "ms" && is_of(path, plugins)
    });
}

/// All that is measured of these plugins.
pub(super) fn diagnostics(ui: &mut Ui, store: &DiagnosticsStore, plugins: &[&str]) {
    rows(ui, store, "diagnostics", |path, _| is_of(path, plugins));
}

fn is_of(path: &str, plugins: &[&str]) -> bool {
    let within = path.strip_prefix("sightline/");
    let plugin = within.and_then(|within| within.split('/').next());
    plugin.is_some_and(|plugin| plugins.contains(&plugin))
}

/// Diagnostics in the order of their paths: name, last value, plot.
fn rows(ui: &mut Ui, store: &DiagnosticsStore, id: &str, is_shown: impl Fn(&str, &str) -> bool) {
    let mut found: Vec<&Diagnostic> = store
        .iter()
        .filter(|diagnostic| is_shown(diagnostic.path().as_str(), &diagnostic.suffix))
        .collect();
    found.sort_unstable_by(|a, b| a.path().as_str().cmp(b.path().as_str()));
    if found.is_empty() {
        ui.weak("nothing is measured");
        return;
    }
    Grid::new(id).num_columns(3).striped(true).show(ui, |ui| {
        for diagnostic in found {
            let path = diagnostic.path().as_str();
            ui.label(path.strip_prefix("sightline/").unwrap_or(path));
            let value = diagnostic.smoothed().or_else(|| diagnostic.value()).unwrap_or_default();
            ui.monospace(format!("{:>9} {}", figure(value), diagnostic.suffix.trim()));
            plot(ui, diagnostic);
            ui.end_row();
        }
    });
}

/// A number with as many digits as are worth reading.
pub(super) fn figure(value: f64) -> String {
    match value.abs() {
        _ if !value.is_finite() => value.to_string(),
        _ if value.fract() == 0.0 => thousands(value as i64),
        size if size >= 100.0 => format!("{value:.0}"),
        size if size >= 1.0 => format!("{value:.2}"),
        _ => format!("{value:.3}"),
    }
}

/// A whole number with its thousands set apart.
pub(super) fn thousands(value: i64) -> String {
    let digits = value.unsigned_abs().to_string();
    let groups = digits.as_bytes().rchunks(3).rev();
    let groups: Vec<&str> = groups.filter_map(|group| std::str::from_utf8(group).ok()).collect();
    format!("{}{}", if value < 0 { "-" } else { "" }, groups.join(","))
}

/// The measurements that are kept, from zero up to the greatest of them.
fn plot(ui: &mut Ui, diagnostic: &Diagnostic) {
    let (response, painter) = ui.allocate_painter(SIZE.into(), Sense::hover());
    let area = response.rect.shrink(1.0);
    painter.rect_filled(response.rect, 2.0, ui.visuals().extreme_bg_color);
    let most = diagnostic.values().copied().fold(0.0, f64::max);
    let count = diagnostic.history_len();
    if count < 2 || most <= 0.0 || !most.is_finite() {
        return;
    }
    let points = diagnostic.values().enumerate().map(|(index, &value)| {
        let across = index as f32 / (count - 1) as f32;
        let up = (value.max(0.0) / most) as f32;
        pos2(lerp(area.x_range(), across), lerp(area.y_range(), 1.0 - up))
    });
    painter.add(PathShape::line(
        points.collect(),
        Stroke::new(1.0, ui.visuals().hyperlink_color),
    ));
    let average = diagnostic.average().unwrap_or_default();
    response.on_hover_text(format!(
        "average {} {unit}, at most {} {unit} of the last {count}",
        figure(average),
        figure(most),
        unit = diagnostic.suffix.trim(),
    ));
}
