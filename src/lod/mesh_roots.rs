//! What the roots of groups whose meshes are swapped are given: a box that stays the same, and what rays hit.

use bevy::{
    asset::{AssetEvent, AssetId, Assets},
    camera::{
        primitives::{Aabb, MeshAabb},
        visibility::{NoAutoAabb, NoFrustumCulling},
    },
    ecs::{
        change_detection::{DetectChangesMut, Res, ResMut},
        message::MessageReader,
        query::Has,
        system::{Commands, Local, Query},
    },
    mesh::{Mesh, Mesh3d},
    platform::collections::{HashMap, HashSet},
};

use super::{
    LodChoices, LodHits, LodStats,
    groups::{Contents, Group, GroupId, MeshLevel},
    place::Change,
    streaming::StreamedMeshes,
};
use crate::{index::SimplifiedMesh, phase::phase};

/// Takes back what an entity was given for its swapped meshes.
pub(super) fn give_back(group: &Group, commands: &mut Commands) {
    if group.given.has_bounds {
        // Bevy computes the box of the mesh anew.
        commands.entity(group.root).try_remove::<(Aabb, NoAutoAabb)>();
    }
    if group.given.has_simplified_mesh {
        commands.entity(group.root).try_remove::<SimplifiedMesh>();
    }
    if let (Contents::Meshes(levels), Some(1..)) = (&group.contents, group.applied)
        && let Some(MeshLevel::Mesh(finest)) = levels.first()
    {
        commands.entity(group.root).try_insert(Mesh3d(finest.clone()));
    }
}

/// The boxes of meshes, and whose levels they are.
#[derive(Default)]
pub(super) struct MeshBoxes {
    boxes: HashMap<AssetId<Mesh>, Option<Aabb>>,
    users: HashMap<AssetId<Mesh>, HashSet<GroupId>>,
}

/// Gives entities whose meshes are swapped the box of all of them, so that it stays the same, and has rays hit the finest.
pub(super) fn bound_swapped(
    assets: Option<Res<Assets<Mesh>>>,
    mut events: MessageReader<AssetEvent<Mesh>>,
    roots: Query<(
        Option<&Aabb>,
        Has<NoAutoAabb>,
        Has<NoFrustumCulling>,
        Option<&SimplifiedMesh>,
    )>,
    streamed: Res<StreamedMeshes>,
    mut choices: ResMut<LodChoices>,
    mut stats: ResMut<LodStats>,
    mut commands: Commands,
    mut meshes: Local<MeshBoxes>,
    mut due: Local<Vec<GroupId>>,
) {
    let _phase = phase!("sightline/lod/follow").adds_to(&mut stats.follow);
    let LodChoices { groups, pending, .. } = choices.bypass_change_detection();
    let MeshBoxes { boxes, users } = &mut *meshes;
    for event in events.read() {
        let (AssetEvent::Added { id } | AssetEvent::Modified { id } | AssetEvent::Removed { id }) = *event else {
            continue;
        };
        if boxes.remove(&id).is_some() {
            due.extend(users.remove(&id).into_iter().flatten());
        }
    }
    due.extend(pending.ids());
    if due.is_empty() {
        return;
    }
    due.sort_unstable();
    due.dedup();
    let Some(assets) = assets else {
        due.clear();
        return;
    };
    for id in due.drain(..) {
        let Some(group) = groups.get_mut(id) else {
            continue;
        };
        let Contents::Meshes(levels) = &group.contents else {
            continue;
        };
        let Ok((aabb, has_own_bounds, is_never_culled, simplified)) = roots.get(group.root) else {
            continue;
        };
        let mut around = group.given_bounds;
        let mut available = 0;
        for (number, level) in levels.iter().enumerate() {
            let mesh = match level {
                MeshLevel::Mesh(mesh) => mesh.id(),
                MeshLevel::Streamed(path) => match streamed.loaded(path) {
                    Some(mesh) => mesh.id(),
                    None => continue,
                },
                MeshLevel::Nothing => {
                    available |= 1 << number;
                    continue;
                }
            };
            let of_mesh = boxes
                .entry(mesh)
                .or_insert_with(|| assets.get(mesh).and_then(MeshAabb::compute_aabb));
            users.entry(mesh).or_default().insert(id);
            if let Some(of_mesh) = of_mesh {
                available |= 1 << number;
                around = Some(around.map_or(*of_mesh, |around| union(&around, of_mesh)));
            }
        }
        group.mesh_bounds = around;
        let mut root = commands.entity(group.root);
        if let Some(around) = around
            && !is_never_culled
            && (group.given.has_bounds || !has_own_bounds)
            && aabb != Some(&around)
        {
            group.given.has_bounds = true;
            root.try_insert((around, NoAutoAabb));
        }
        if let Some(MeshLevel::Mesh(finest)) = levels.first()
            && group.hits == LodHits::Finest
            && (group.given.has_simplified_mesh || simplified.is_none())
        {
            if simplified.is_none_or(|simplified| simplified.0 != *finest) {
                root.try_insert(SimplifiedMesh(finest.clone()));
            }
            group.given.has_simplified_mesh = true;
        } else if std::mem::take(&mut group.given.has_simplified_mesh) {
            root.try_remove::<SimplifiedMesh>();
        }
        groups.set_available(id, available);
        pending.note(id, Change::Resized);
    }
}

fn union(one: &Aabb, other: &Aabb) -> Aabb {
    Aabb::from_min_max(one.min().min(other.min()).into(), one.max().max(other.max()).into())
}
