//! The entity that is selected, in the scene.

use bevy::{
    ecs::{
        change_detection::{DetectChangesMut, Res, ResMut},
        entity::Entity,
        observer::On,
        query::With,
        system::{Commands, Local, Query},
    },
    picking::{
        events::{Click, Pointer},
        pointer::PointerButton,
    },
};

use super::SightlineInspector;
use crate::{debug::gizmos::ShowGizmos, index::SpatialIndex};

/// Selects what is clicked, if it is in the index.
pub(super) fn select_clicked(
    click: On<Pointer<Click>>,
    index: Res<SpatialIndex>,
    mut inspector: ResMut<SightlineInspector>,
) {
    let is_wanted = inspector.open && inspector.select_by_click && click.button == PointerButton::Primary;
    // Not what the click bubbles up to.
    if is_wanted && click.entity == click.original_event_target() && index.contains(click.entity) {
        let mut selected = *inspector;
        selected.selected = Some(click.entity);
        inspector.set_if_neq(selected);
    }
}

/// Marks the selected entity while the panel is open, unless it is marked anyway.
pub(super) fn mark_selected(
    inspector: Res<SightlineInspector>,
    marked_anyway: Query<(), With<ShowGizmos>>,
    mut marked: Local<Option<Entity>>,
    mut commands: Commands,
) {
    let wanted = inspector.selected.filter(|_| inspector.open);
    if *marked == wanted {
        return;
    }
    if let Some(before) = marked.take()
        && let Ok(mut before) = commands.get_entity(before)
    {
        before.try_remove::<ShowGizmos>();
    }
    if let Some(wanted) = wanted
        && !marked_anyway.contains(wanted)
        && let Ok(mut entity) = commands.get_entity(wanted)
    {
        entity.try_insert(ShowGizmos::default());
        *marked = Some(wanted);
    }
}
