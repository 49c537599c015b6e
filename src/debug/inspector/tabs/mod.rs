//! The tabs: each a system that draws to the panel.

pub(super) mod culling;
pub(super) mod index;
pub(super) mod lod;
pub(super) mod query;
pub(super) mod selected;
pub(super) mod structures;

use std::time::{Duration, Instant};

use bevy_egui::egui::{Grid, Ui};

/// A table of names and figures.
fn figures<const N: usize>(ui: &mut Ui, name: &str, rows: [(&str, String); N]) {
    Grid::new(name).num_columns(2).striped(true).show(ui, |ui| {
        for (name, figure) in rows {
            ui.label(name);
            ui.monospace(figure);
            ui.end_row();
        }
    });
}

/// Bytes, in the unit that suits them.
fn bytes(bytes: usize) -> String {
    match bytes {
        0..1_000 => format!("{bytes} B"),
        1_000..1_000_000 => format!("{:.1} kB", bytes as f64 / 1e3),
        _ => format!("{:.1} MB", bytes as f64 / 1e6),
    }
}

/// What costs too much to be found out in every frame.
#[derive(Debug)]
pub(in crate::debug::inspector) struct Seldom<T> {
    value: T,
    /// When it was found out last, and how long that took.
    found: Option<(Instant, Duration)>,
}

/// Finding it out may take this part of all time.
const SHARE: u32 = 20;

impl<T: Default> Default for Seldom<T> {
    fn default() -> Self {
        Self {
            value: T::default(),
            found: None,
        }
    }
}

impl<T> Seldom<T> {
    /// The value, found out anew if that was longer ago than this, or than what it costs allows.
    fn get(&mut self, every: Duration, find: impl FnOnce(&mut T)) -> &T {
        let is_old = |(at, took): (Instant, Duration)| at.elapsed() >= every.max(took * SHARE);
        if self.found.is_none_or(is_old) {
            let start = Instant::now();
            find(&mut self.value);
            self.found = Some((Instant::now(), start.elapsed()));
        }
        &self.value
    }
}
