//! Entities by their names, to click on.

use bevy::ecs::{
    entity::Entity,
    name::Name,
    system::{Query, SystemParam},
};
use bevy_egui::egui::{RichText, Ui};

use super::SightlineInspector;

/// What entities are called.
#[derive(SystemParam)]
pub(super) struct Names<'w, 's> {
    names: Query<'w, 's, &'static Name>,
}

impl Names<'_, '_> {
    /// The name and the number of an entity.
    pub fn of(&self, entity: Entity) -> String {
        match self.names.get(entity) {
            Ok(name) => format!("{name} ({entity})"),
            Err(_) => entity.to_string(),
        }
    }

    /// The same, to click on, which selects the entity.
    pub fn link(&self, ui: &mut Ui, entity: Entity, inspector: &mut SightlineInspector) {
        let is_selected = inspector.selected == Some(entity);
        if ui
            .selectable_label(is_selected, RichText::new(self.of(entity)).monospace())
            .clicked()
        {
            inspector.selected = Some(entity);
        }
    }
}
