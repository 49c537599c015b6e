//! Taking Bevy's own sprite backend out of the schedule.

use bevy::{
    app::{App, Plugin, PreUpdate},
    ecs::schedule::{InternedSystemSet, ScheduleCleanupPolicy},
    sprite::SpritePickingPlugin,
};
use tracing::warn;

use crate::picking::SpatialPickingPlugin;

/// Leaves the picking of sprites to [`SpatialPickingPlugin`], if that is there: with both backends everything would be
/// picked twice, and Bevy's `SpritePlugin` adds its own unasked.
pub(super) fn replace_bevys_backend(app: &mut App) {
    if !(app.is_plugin_added::<SpatialPickingPlugin>() && app.is_plugin_added::<SpritePickingPlugin>()) {
        return;
    }
    let removed = bevys_backend()
        .map(|backend| app.remove_systems_in_set(PreUpdate, backend, ScheduleCleanupPolicy::RemoveSystemsOnly));
    if !matches!(removed, Some(Ok(1))) {
        warn!("Bevy's own sprite picking stays: sprites with a Pickable are picked twice");
    }
}

/// The set of nothing but that system, which is private: it is the one that the plugin adds.
fn bevys_backend() -> Option<InternedSystemSet> {
    let mut app = App::empty();
    SpritePickingPlugin.build(&mut app);
    let schedule = app.get_schedule(PreUpdate)?;
    let (_, system, _) = schedule.graph().systems.iter().next()?;
    system.default_system_sets().into_iter().next()
}
