//! The systems that keep the index in step with the world.
//!
//! Whatever happens to an entity, it ends in [`Reconciler::reconcile`], which looks at the entity as it is now and
//! makes the index agree. So every way in has its way out, and no order of changes within a frame matters.
//!
//! There is one short cut, for what happens most: an entity of the index of which nothing but the `GlobalTransform` has
//! changed keeps all but its place. Such entities are [found](changes) and placed in parallel, and stored together.
//! Entities that are [posed](super::pose) are placed by their poses instead, in parallel too.
//!
//! Later in the frame only meshes are [swapped](swap), for what is shown then.

mod changes;
mod grid_upkeep;
mod reconcile;
mod swap;

use bevy::{
    asset::{AssetEvent, AssetId, Assets},
    ecs::{
        change_detection::{DetectChanges, DetectChangesMut, Res, ResMut},
        entity::Entity,
        message::{MessageCursor, Messages},
        resource::Resource,
        system::{Local, Query},
    },
    mesh::Mesh,
    platform::collections::HashSet,
    tasks::{AsyncComputeTaskPool, Task, TaskPool, futures::check_ready},
};

use super::{
    MeshBvhs, PosedMeshes, PosingStats, SpatialIndex, SpatialIndexSettings, SyncStats,
    pose::PoseInputs,
    spatial_index::{Contents, Moves},
};
use crate::{
    phase::phase,
    spatial::{SpatialQueries, aabb_tree::Rebuilt},
};
pub(super) use changes::Found;
use changes::{Changes, Removed};
use grid_upkeep::GridUpkeep;
use reconcile::{BoundedByMesh, Indexed, Reconciler};
use smallvec::SmallVec;
pub(crate) use swap::MeshSwaps;

/// Trees with fewer leaves than this are built anew within the frame: that takes about a millisecond.
const LEAST_BESIDE: usize = 2048;

/// Follows mesh assets that are loaded, modified and removed, and keeps their hierarchies.
pub(super) fn follow_mesh_assets(
    events: Res<Messages<AssetEvent<Mesh>>>,
    mut events_read: Local<MessageCursor<AssetEvent<Mesh>>>,
    assets: Res<Assets<Mesh>>,
    settings: Res<SpatialIndexSettings>,
    mut meshes: ResMut<MeshBvhs>,
    mut stats: ResMut<SyncStats>,
) {
    let phase = phase!("sightline/index/meshes");
    // To count frames is no change for those who watch the meshes.
    let quietly = meshes.bypass_change_detection();
    quietly.begin_frame(settings.meshes);
    // An asset that has changed several times is looked at once, as it is now.
    let has_missed_some = events_read.missed_messages(&events) > 0;
    let mut changed: HashSet<AssetId<Mesh>> = events_read
        .read(&events)
        .filter_map(|event| match *event {
            AssetEvent::Added { id }
            | AssetEvent::Modified { id }
            | AssetEvent::Removed { id }
            | AssetEvent::Unused { id } => Some(id),
            AssetEvent::LoadedWithDependencies { .. } => None,
        })
        .collect();
    if has_missed_some {
        changed.extend(quietly.known());
        quietly.note_missed();
    }
    let mut has_changed = !changed.is_empty();
    for id in changed {
        quietly.follow(id, &assets);
    }
    has_changed |= quietly.keep_up();
    if has_changed {
        meshes.set_changed();
    }
    stats.meshes = phase.end();
}

/// What [`follow_entities`] keeps from frame to frame.
#[derive(Default)]
pub(super) struct Memory {
    bounded_by_mesh: BoundedByMesh,
    grid_upkeep: GridUpkeep,
    /// What was posed for rays until the last frame.
    posed_for_rays: PosingStats,
    /// Buffers, kept for their memory.
    parts: Vec<Found>,
    moves: Moves,
    dirty: Vec<Entity>,
    new: Vec<(Entity, Contents)>,
}

/// Brings the index up to date with every entity that has changed in any way that matters.
pub(super) fn follow_entities(
    changes: Changes,
    mut removed: Removed,
    entities: Query<Indexed>,
    settings: Res<SpatialIndexSettings>,
    assets: Option<Res<Assets<Mesh>>>,
    mut meshes: ResMut<MeshBvhs>,
    mut poses: ResMut<PosedMeshes>,
    mut inputs: PoseInputs,
    mut index: ResMut<SpatialIndex>,
    mut stats: ResMut<SyncStats>,
    mut memory: Local<Memory>,
) {
    let phase = phase!("sightline/index/sync");
    let Memory {
        bounded_by_mesh,
        grid_upkeep,
        posed_for_rays,
        parts,
        moves,
        dirty,
        new,
    } = &mut *memory;
    grid_upkeep.follow(&settings, &mut index);
    let find = phase!("sightline/index/find");
    inputs.read_events();
    changes.find(&index, parts);
    let changed_alone: usize = parts.iter().map(|found| found.dirty.len()).sum();
    let posing = phase!("sightline/index/posing");
    let quietly = poses.bypass_change_detection();
    quietly.follow(&inputs, &index, &meshes, settings.posed_meshes_kept, parts);
    let posing = posing.end();
    let posed_before = std::mem::replace(posed_for_rays, quietly.stats());
    let mut posed = 0;
    let mut moved = 0;
    for found in &mut *parts {
        moved += found.moves.len();
        dirty.append(&mut found.dirty);
        posed += std::mem::take(&mut found.posed);
    }
    if posed > 0 {
        poses.set_changed();
    }
    // After a long pause: whatever is or was there is looked at.
    if removed.has_missed_some() {
        dirty.extend(index.known());
        dirty.extend(bounded_by_mesh.entities());
        dirty.extend(entities.iter().map(|item| item.entity()));
    }
    dirty.extend(removed.read());
    dirty.extend(inputs.newly_posed());
    if meshes.bypass_change_detection().take_missed() {
        dirty.extend(bounded_by_mesh.entities());
    }
    if meshes.has_changed() {
        dirty.extend(meshes.drain_changed().flat_map(|mesh| bounded_by_mesh.of(mesh)));
    }
    if dirty.len() > changed_alone {
        // One entity may be in several lists.
        dirty.sort_unstable();
        dirty.dedup();
    }
    *stats = SyncStats {
        moved,
        reconciled: dirty.len(),
        posed,
        posing,
        posed_for_rays: posed_for_rays.meshes.saturating_sub(posed_before.meshes) as usize,
        posing_for_rays: posed_for_rays.time.saturating_sub(posed_before.time),
        meshes: std::mem::take(&mut stats.meshes),
        find: find.end(),
        ..SyncStats::default()
    };

    // Nothing to do must not count as a change of the index.
    if moved > 0 || !dirty.is_empty() {
        if !dirty.is_empty() {
            let mut reconciler = Reconciler {
                assets: assets.as_deref(),
                meshes: &mut meshes,
                poses: &mut poses,
                inputs: &inputs,
                index: &mut index,
                bounded_by_mesh,
                moves,
                new,
            };
            for &entity in &*dirty {
                reconciler.reconcile(entity, entities.get(entity).ok());
            }
        }
        let structures = phase!("sightline/index/structures");
        let found = parts.iter_mut().map(|found| &mut found.moves);
        let mut moves: SmallVec<[&mut Moves; 32]> = found.chain([moves]).collect();
        index.apply_moves(&mut moves);
        if !new.is_empty() {
            index.insert_many(new);
        }
        stats.structures = structures.end();
    }
    index.bypass_change_detection().note_sync(dirty);
    stats.total = phase.end();
}

/// The tree as it is built anew beside its use.
#[derive(Resource, Debug, Default)]
pub(super) struct Rebuilding(Option<Task<Rebuilt>>);

/// Whether there may be something for [`optimize`] to do.
pub(super) fn may_be_degraded(index: Res<SpatialIndex>, rebuilding: Res<Rebuilding>) -> bool {
    index.is_changed() || rebuilding.0.is_some()
}

/// Keeps queries fast, as far as there is anything to mend: a large tree is built anew beside its use.
pub(super) fn optimize(
    mut index: ResMut<SpatialIndex>,
    mut stats: ResMut<SyncStats>,
    mut rebuilding: ResMut<Rebuilding>,
) {
    let phase = phase!("sightline/index/optimize");
    // What has not changed for queries has not changed for those who watch the index.
    let tree = index.bypass_change_detection().tree_mut();
    if let Some(rebuilt) = rebuilding.0.as_mut().and_then(check_ready) {
        tree.adopt(rebuilt);
        rebuilding.0 = None;
        stats.optimized = true;
    }
    // What has come while it was built may have worn it already, and nothing may change any more.
    if rebuilding.0.is_none() && tree.is_degraded() {
        if tree.len() < LEAST_BESIDE {
            tree.rebuild();
            stats.optimized = true;
        } else {
            let rebuild = tree.begin_rebuild();
            let pool = AsyncComputeTaskPool::get_or_init(TaskPool::default);
            rebuilding.0 = Some(pool.spawn(async move { rebuild.run() }));
        }
    }
    stats.optimize = phase.end();
}
