//! Levels that are entities whose meshes are not loaded: others stand in for them until they are.

use bevy::{
    asset::{AssetEvent, AssetId, Assets},
    ecs::{
        change_detection::{DetectChangesMut, Res, ResMut},
        message::MessageReader,
        system::{Local, Query},
    },
    mesh::{Mesh, Mesh3d},
    platform::collections::{HashMap, HashSet},
};

use super::{
    LodChoices, LodStats,
    groups::{Contents, GroupId},
    place::Change,
};
use crate::{index::SpatialIndex, phase::phase};

/// Notes which levels of groups that have come or changed lack meshes, and of which these have been loaded.
pub(super) fn await_meshes(
    assets: Option<Res<Assets<Mesh>>>,
    mut events: MessageReader<AssetEvent<Mesh>>,
    index: Res<SpatialIndex>,
    meshes: Query<&Mesh3d>,
    mut choices: ResMut<LodChoices>,
    mut stats: ResMut<LodStats>,
    mut waiting: Local<HashMap<AssetId<Mesh>, HashSet<GroupId>>>,
    mut due: Local<Vec<GroupId>>,
) {
    let _phase = phase!("sightline/lod/follow").adds_to(&mut stats.follow);
    let Some(assets) = assets else {
        events.clear();
        return;
    };
    let LodChoices { groups, pending, .. } = choices.bypass_change_detection();
    if waiting.is_empty() {
        events.clear();
    }
    for event in events.read() {
        if let AssetEvent::Added { id } = event {
            due.extend(waiting.remove(id).into_iter().flatten());
        }
    }
    due.extend(
        pending
            .ids()
            .iter()
            .filter(|&&id| pending.has(id, Change::Restructured)),
    );
    // Those that were given other meshes.
    let changed = index.reconciled().iter().filter(|&&entity| meshes.contains(entity));
    due.extend(changed.filter_map(|&entity| Some(groups.of_member(entity)?.group)));
    due.sort_unstable();
    due.dedup();
    for id in due.drain(..) {
        let Some(group) = groups.get(id) else {
            continue;
        };
        if let Contents::Meshes(_) = group.contents {
            continue;
        }
        let mut missing = 0;
        for &member in &group.members {
            if let Ok(mesh) = meshes.get(member)
                && !assets.contains(mesh)
            {
                missing |= groups.of_member(member).map_or(0, |within| within.levels);
                waiting.entry(mesh.id()).or_default().insert(id);
            }
        }
        if missing != group.missing {
            groups.set_missing(id, missing);
            pending.note(id, Change::Resized);
        }
    }
}
