//! Following the groups: what they are, and what belongs to them.

use std::time::Duration;

use bevy::ecs::{
    change_detection::{ContiguousRef, Ref, ResMut},
    entity::{Entity, EntityHashSet},
    entity_disabling::Disabled,
    hierarchy::{ChildOf, Children},
    lifecycle::RemovedComponents,
    name::NameOrEntity,
    query::{Allow, Changed, With},
    system::{Commands, Local, Query, SystemParam},
};
use tracing::warn;

use super::{
    LodChoices, LodStats, ProxyLod,
    groups::{Family, Flaw, Group, GroupId, Groups},
    mesh_roots::give_back,
    place::Change,
};
use crate::{
    index::{DetailLevel, ticks::Since},
    phase::phase,
};

/// What has changed since the last frame.
#[derive(SystemParam)]
pub(super) struct Changes<'w, 's> {
    lods: Query<'w, 's, (Entity, Ref<'static, ProxyLod>)>,
    lods_changed: Query<'w, 's, Entity, Changed<ProxyLod>>,
    removed: RemovedComponents<'w, 's, ProxyLod>,
    enabled: RemovedComponents<'w, 's, Disabled>,
    children: Query<'w, 's, (Entity, Ref<'static, Children>), With<DetailLevel>>,
    children_changed: Query<'w, 's, Entity, (Changed<Children>, With<DetailLevel>)>,
    children_removed: RemovedComponents<'w, 's, Children>,
    members_removed: RemovedComponents<'w, 's, DetailLevel>,
}

impl Changes<'_, '_> {
    /// Finds groups that are new, or were changed, and entities with other children than before.
    fn find(&self, changed: &mut Vec<Entity>, restructured: &mut Vec<Entity>) {
        changed.clear();
        restructured.clear();
        match self.lods.contiguous_iter() {
            Ok(tables) => tables.for_each(|(entities, lods)| collect(entities, &lods, changed)),
            // Something decides which entities are disabled that is not stored in tables.
            Err(_) => changed.extend(&self.lods_changed),
        }
        match self.children.contiguous_iter() {
            Ok(tables) => tables.for_each(|(entities, children)| collect(entities, &children, restructured)),
            Err(_) => restructured.extend(&self.children_changed),
        }
    }
}

/// Collects the entities of a table of which a column has changed.
fn collect<T>(entities: &[Entity], column: &ContiguousRef<T>, found: &mut Vec<Entity>) {
    Since::last_read(column).collect(entities, &[column.changed_ticks_slice()], found);
}

/// Buffers, kept for their memory.
#[derive(Default)]
pub(super) struct Buffers {
    found: Vec<Entity>,
    restructured: Vec<Entity>,
    dirty: Vec<GroupId>,
    touched: Vec<Entity>,
    new_levels: Vec<(Entity, DetailLevel)>,
    warned: EntityHashSet,
}

/// Brings the groups up to date, and tells the index what their members are.
pub(super) fn follow_groups(
    mut changes: Changes,
    lods: Query<(NameOrEntity, &ProxyLod), Allow<Disabled>>,
    entities: Query<(Option<&Children>, Option<&ChildOf>), Allow<Disabled>>,
    members: Query<&DetailLevel, Allow<Disabled>>,
    mut choices: ResMut<LodChoices>,
    mut stats: ResMut<LodStats>,
    mut commands: Commands,
    mut buffers: Local<Buffers>,
) {
    stats.follow = Duration::ZERO;
    let _phase = phase!("sightline/lod/follow").adds_to(&mut stats.follow);
    let Buffers {
        found,
        restructured,
        dirty,
        touched,
        new_levels,
        warned,
    } = &mut *buffers;
    let LodChoices {
        groups,
        reassigned,
        pending,
        streaming_changes,
        other_children,
        ..
    } = &mut *choices;
    groups.begin_frame();
    reassigned.clear();
    touched.clear();

    for root in changes.removed.read().filter(|&root| !lods.contains(root)) {
        warned.remove(&root);
        let id = groups.of_root(root);
        if let Some(group) = groups.remove(root, dirty, touched) {
            id.into_iter().for_each(|id| pending.note(id, Change::Restructured));
            give_back(&group, &mut commands);
            *streaming_changes += u64::from(group.streams());
        }
    }
    changes.find(found, restructured);
    // What changed while it was disabled was not found.
    let enabled = found.len();
    found.extend(changes.enabled.read());
    restructured.extend(&found[enabled..]);
    for &root in &*found {
        if let Ok((name, lod)) = lods.get(root) {
            let mut flaws = Vec::new();
            let streamed = streams(groups, root);
            if let Some(swapped) = groups.insert(root, lod, &mut flaws, dirty) {
                give_back(&swapped, &mut commands);
            }
            *streaming_changes += u64::from(streamed || streams(groups, root));
            warn_once(&name, root, &flaws, warned);
        }
    }
    restructured.append(other_children);
    restructured.extend(changes.children_removed.read().chain(changes.members_removed.read()));
    for &entity in &*restructured {
        dirty.extend(groups.of_member(entity).map(|within| within.group));
        if let Some(id) = groups.of_root(entity) {
            dirty.push(id);
            // What is below a root may belong to the group that this one is in.
            dirty.extend(groups.parent(id).map(|parent| parent.group));
        }
    }
    if dirty.is_empty() && touched.is_empty() {
        return;
    }

    dirty.sort_unstable();
    dirty.dedup();
    dirty.retain(|&id| groups.get(id).is_some());
    let family = |entity| {
        let (children, parent) = entities.get(entity).ok()?;
        Some(Family {
            children: children.map_or(&[], |children| children),
            parent: parent.map(ChildOf::parent),
        })
    };
    for &id in &*dirty {
        groups.release_nested(id, touched);
    }
    for &id in &*dirty {
        let mut flaws = Vec::new();
        groups.find_members(id, &family, &mut flaws, touched);
        if let Some(Ok((name, _))) = groups.get(id).map(|group| lods.get(group.root)) {
            warn_once(&name, name.entity, &flaws, warned);
        }
    }
    // What is nested is as detailed as what it is in.
    for &id in &*dirty {
        groups.visit_members(id, &mut |member| touched.push(member));
    }
    touched.sort_unstable();
    touched.dedup();
    for &entity in &*touched {
        let wanted = groups.detail_level(entity);
        let is_now = members.get(entity).ok().copied();
        match wanted {
            Some(level) if is_now != wanted && entities.contains(entity) => new_levels.push((entity, level)),
            None if is_now.is_some() => {
                commands.entity(entity).try_remove::<DetailLevel>();
            }
            _ => {}
        }
    }
    if !new_levels.is_empty() {
        commands.try_insert_batch(std::mem::take(new_levels));
    }
    reassigned.append(touched);
    dirty.drain(..).for_each(|id| pending.note(id, Change::Restructured));
}

/// Whether an entity is the root of a group that has meshes loaded when they come near.
fn streams(groups: &Groups, root: Entity) -> bool {
    let group = groups.of_root(root).and_then(|id| groups.get(id));
    group.is_some_and(Group::streams)
}

fn warn_once(name: &impl std::fmt::Display, root: Entity, flaws: &[Flaw], warned: &mut EntityHashSet) {
    if let Some(flaw) = flaws.first()
        && warned.insert(root)
    {
        warn!("the levels of detail of {name} ({root}) are not shown as they should be: {flaw}");
    }
}
