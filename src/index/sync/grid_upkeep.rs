//! The grid is there while it is asked for.

use bevy::ecs::change_detection::{DetectChanges, DetectChangesMut, Res, ResMut};
use tracing::warn;

use crate::{
    index::{SpatialIndex, SpatialIndexSettings},
    spatial::uniform_grid::GridSettings,
};

/// Decides from frame to frame whether there is a grid.
#[derive(Debug, Default)]
pub(super) struct GridUpkeep {
    /// How a grid is to be: the last settings that are sound.
    settings: Option<GridSettings>,
    /// For how many frames nobody has asked for it, if somebody ever has.
    idle: Option<u32>,
}

impl GridUpkeep {
    pub fn follow(&mut self, settings: &Res<SpatialIndexSettings>, index: &mut ResMut<SpatialIndex>) {
        if settings.is_changed() {
            if settings.grid.is_none_or(|grid| grid.is_sound()) {
                self.settings = settings.grid;
            } else {
                warn!(
                    "the grid stays as it is, for there is none with these settings: {:?}",
                    settings.grid
                );
            }
        }
        self.idle = if index.bypass_change_detection().take_grid_asked() {
            Some(0)
        } else {
            self.idle.map(|idle| idle.saturating_add(1))
        };
        let is_kept = self.idle.is_some_and(|idle| idle <= settings.grid_kept);
        let wanted = self.settings.filter(|_| is_kept);
        // No answer changes.
        if wanted != index.grid_settings() {
            index.bypass_change_detection().set_grid(wanted);
        }
    }
}
