//! Settings: every resource and every component of this crate that can be reflected, edited where it lives.

use bevy::{
    ecs::{
        change_detection::DetectChangesMut,
        entity::Entity,
        reflect::{AppTypeRegistry, ReflectComponent, ReflectResource},
        system::{In, InMut},
        world::World,
    },
    gizmos::config::GizmoConfigStore,
    reflect::{TypeRegistration, TypeRegistry},
};
use bevy_egui::egui::{CollapsingHeader, Ui};

use super::{SightlineInspector, reflect::Editor};
use crate::debug::gizmos::SightlineGizmos;

/// Edits the resources of these modules of this crate whose names end in `Settings`.
pub(super) fn edit_settings((InMut(ui), In(modules)): (InMut<Ui>, In<&'static [&'static str]>), world: &mut World) {
    edit_all(ui, world, |world, registration| {
        let is_settings = registration.contains::<ReflectResource>()
            && registration
                .type_info()
                .type_path_table()
                .short_path()
                .ends_with("Settings")
            && modules.iter().any(|module| is_within(registration, module));
        let id = is_settings.then(|| world.components().get_id(registration.type_id()))??;
        world.resource_entities().get(id)
    });
}

/// Edits the components of this crate that an entity has.
pub(super) fn edit_components((InMut(ui), In(entity)): (InMut<Ui>, In<Entity>), world: &mut World) {
    edit_all(ui, world, |_, registration| {
        (!registration.contains::<ReflectResource>() && is_within(registration, "")).then_some(entity)
    });
}

/// Edits what is drawn.
pub(super) fn edit_gizmos(InMut(ui): InMut<Ui>, world: &mut World) {
    let registry = world.resource::<AppTypeRegistry>().clone();
    let registry = registry.read();
    let editor = editor(world, &registry);
    let Some(mut store) = world.get_resource_mut::<GizmoConfigStore>() else {
        ui.weak("nothing can be drawn: the app has no GizmoPlugin");
        return;
    };
    if let Some((config, gizmos)) = store.get_config_mut::<SightlineGizmos>() {
        ui.checkbox(&mut config.enabled, "enabled");
        let mut edited = gizmos.clone();
        if editor.edit(ui, &mut edited) {
            *gizmos = edited;
        }
    }
}

fn editor<'a>(world: &World, registry: &'a TypeRegistry) -> Editor<'a> {
    let selected = world
        .get_resource::<SightlineInspector>()
        .and_then(|inspector| inspector.selected);
    Editor { registry, selected }
}

/// Edits the components that are registered and mutable, each on the entity that `place` tells, in the order of names.
fn edit_all(ui: &mut Ui, world: &mut World, place: impl Fn(&World, &TypeRegistration) -> Option<Entity>) {
    let registry = world.resource::<AppTypeRegistry>().clone();
    let registry = registry.read();
    let editor = editor(world, &registry);
    let mut found: Vec<(&TypeRegistration, &ReflectComponent, Entity)> = registry
        .iter()
        .filter_map(|registration| {
            let entity = place(world, registration)?;
            let component = registration.data::<ReflectComponent>()?;
            let id = world.components().get_id(registration.type_id())?;
            let is_mutable = world.components().get_info(id)?.mutable();
            let has_it = world.get_entity(entity).is_ok_and(|of| of.contains_id(id));
            (has_it && is_mutable).then_some((registration, component, entity))
        })
        .collect();
    found.sort_unstable_by_key(|(registration, ..)| registration.type_info().type_path());
    for (registration, component, entity) in found {
        let name = registration.type_info().type_path_table().short_path();
        CollapsingHeader::new(name).id_salt((name, entity)).show(ui, |ui| {
            let Some(mut value) = component.reflect_mut(world.entity_mut(entity)) else {
                return;
            };
            // Only what the user changes is a change for those who watch.
            if editor.edit(ui, value.bypass_change_detection().as_partial_reflect_mut()) {
                value.set_changed();
            }
        });
    }
}

/// Whether a type is in a module of this crate, or in any if no module is named.
fn is_within(registration: &TypeRegistration, module: &str) -> bool {
    let path = registration.type_info().type_path();
    let within = path.strip_prefix("bevy_sightline::");
    within.is_some_and(|within| within.starts_with(module))
}
