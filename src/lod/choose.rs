//! Choosing levels for every view, and telling of what has switched.

use std::time::Duration;

use bevy::{
    ecs::{
        change_detection::{DetectChanges, Res, ResMut, Tick},
        entity::{Entity, EntityHashSet},
        query::With,
        system::{Commands, Local, Query},
    },
    time::Time,
};

use super::{
    LodChoices, LodStats, LodSwapped,
    choices::LodView,
    eyes::{Eyes, shadow_bias},
    groups::{GroupId, Groups},
    place::{Change, Movements, Places},
    view_levels::{Sight, ViewLevels},
};
use crate::{
    index::{DetailLevel, NoSpatialIndex, SpatialIndex},
    phase::phase,
};

/// Buffers, kept for their memory, and what was told.
#[derive(Default)]
pub(super) struct Memory {
    views: Vec<(LodView, Sight)>,
    warned: EntityHashSet,
    /// How often the index was synchronised.
    syncs: u64,
    /// When the children of roots were last looked at.
    seen_at: Option<Tick>,
}

/// Chooses the levels for every view, and triggers [`LodSwapped`] for those that are entities.
pub(super) fn choose_levels(
    eyes: Eyes,
    time: Option<Res<Time>>,
    index: Res<SpatialIndex>,
    movements: Movements,
    unindexed: Query<(), (With<DetailLevel>, With<NoSpatialIndex>)>,
    places: Places,
    mut choices: ResMut<LodChoices>,
    mut stats: ResMut<LodStats>,
    mut commands: Commands,
    mut memory: Local<Memory>,
) {
    let phase = phase!("sightline/lod/choose");
    let Memory {
        views,
        warned,
        syncs,
        seen_at,
    } = &mut *memory;
    // Whatever has bounds and has moved has moved in the index, if that was asked; and so has what is below a root.
    let is_synchronised = index.syncs() != *syncs;
    *syncs = index.syncs();
    let choices = &mut *choices;
    if choices.groups.len() == 0 && choices.pending.ids().is_empty() {
        choices.views.clear();
        *stats = LodStats {
            follow: stats.follow,
            choose: phase.end(),
            ..LodStats::default()
        };
        return;
    }
    if index.is_changed() || !is_synchronised || !unindexed.is_empty() || choices.groups.has_loose() {
        let LodChoices {
            groups,
            pending,
            other_children,
            ..
        } = choices;
        movements.visit(|entity, by_itself| groups.note_movement(entity, by_itself, pending));
        movements.find_other_children(seen_at, other_children);
        // Those that are new have been looked at with their children.
        let is_known = |&root: &Entity| {
            groups
                .of_root(root)
                .is_some_and(|id| !pending.has(id, Change::Restructured))
        };
        other_children.retain(is_known);
        for &root in &*other_children {
            groups.loosen(root, pending);
        }
    }
    choices.groups.loosen_unindexed(&choices.pending, &index);
    choices.groups.place(&mut choices.pending, &places);

    choices.shadows_follow_cameras = shadow_bias(eyes.settings()) == 1.0;
    let main = eyes.look(views, warned);
    let has_other_main = std::mem::replace(&mut choices.main, main) != main;

    let now = time.map_or(0.0, |time| time.elapsed_secs_f64());
    let LodChoices {
        groups,
        views: levels,
        others,
        pending,
        versions,
        ..
    } = choices;
    levels.retain(|view, _| views.iter().any(|(other, _)| other == view));
    for &(view, sight) in &*views {
        let levels = levels.entry(view).or_default();
        levels.update(sight, &groups.reaches, pending.ids(), now);
        levels.list_members(groups);
        if let LodView::Camera(view) = view {
            tell(view, levels, groups, &mut commands);
        }
    }
    // Meshes are swapped for all views, and so is what is shown of none.
    let swapped: Vec<GroupId> = match main.and_then(|main| levels.get(&LodView::Camera(main))) {
        Some(levels) => levels
            .switches()
            .iter()
            .map(|switch| switch.group)
            .filter(|&id| groups.is_swapped(id))
            .collect(),
        None => Vec::new(),
    };
    others.list_members(groups);
    for levels in levels.values_mut().chain([others]) {
        levels.list_members_of(&swapped, groups);
        levels.settle(has_other_main, versions);
    }
    *stats = LodStats {
        groups: groups.len(),
        looked_at: levels.values().map(ViewLevels::looked_at).sum(),
        switched: levels.values().map(|levels| levels.switches().len()).sum(),
        follow: stats.follow,
        choose: Duration::ZERO,
    };
    swapped.into_iter().for_each(|id| pending.note(id, Change::Displaced));
    if has_other_main {
        let swapped = groups.ids().filter(|&id| groups.is_swapped(id));
        swapped.for_each(|id| pending.note(id, Change::Displaced));
    }
    stats.choose = phase.end();
}

/// Tells the observers of what has switched for a camera.
fn tell(view: Entity, levels: &ViewLevels, groups: &Groups, commands: &mut Commands) {
    for switch in levels.switches() {
        if let Some(from) = switch.from
            && let Some(group) = groups.get(switch.group)
            && !groups.is_swapped(switch.group)
        {
            commands.trigger(LodSwapped {
                entity: group.root,
                view,
                from: from.into(),
                to: switch.to.into(),
            });
        }
    }
}
