//! Entities by their names, to click on.

use bevy::{
    camera::Camera,
    ecs::{
        entity::Entity,
        hierarchy::ChildOf,
        name::Name,
        system::{Query, SystemParam},
    },
};
use bevy_egui::egui::{RichText, Ui};

use super::SightlineInspector;

/// How far up a name is looked for.
const GENERATIONS: usize = 16;

/// What entities are called.
#[derive(SystemParam)]
pub(super) struct Names<'w, 's> {
    names: Query<'w, 's, &'static Name>,
    parents: Query<'w, 's, &'static ChildOf>,
    cameras: Query<'w, 's, &'static Camera>,
}

impl Names<'_, '_> {
    /// The name and the number of an entity: if it has no name, that of what it is a part of.
    pub fn of(&self, entity: Entity) -> String {
        let ancestors = self.parents.iter_ancestors(entity).take(GENERATIONS);
        if let Ok(name) = self.names.get(entity) {
            format!("{name} ({entity})")
        } else if self.cameras.contains(entity) {
            format!("camera ({entity})")
        } else if let Some(name) = self.names.iter_many(ancestors).next() {
            format!("part of {name} ({entity})")
        } else {
            entity.to_string()
        }
    }

    /// The same, to click on, which selects the entity.
    pub fn link(&self, ui: &mut Ui, entity: Entity, inspector: &mut SightlineInspector) {
        let is_selected = inspector.selected == Some(entity);
        let name = RichText::new(self.of(entity)).monospace();
        if ui.selectable_label(is_selected, name).clicked() {
            inspector.selected = Some(entity);
        }
    }
}
