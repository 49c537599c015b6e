//! Where groups are, and how large.

use std::cmp::Reverse;

use bevy::{
    camera::primitives::Aabb,
    ecs::{
        change_detection::{Ref, Tick},
        entity::Entity,
        entity_disabling::Disabled,
        hierarchy::Children,
        query::{Allow, Changed, Or, With},
        system::{Query, SystemParam},
    },
    math::{DAffine3, Mat3A, Vec3A},
    transform::components::{GlobalTransform, Transform},
};
use smallvec::SmallVec;

use super::{
    LodReference, ProxyLod,
    groups::{Contents, Group, GroupId, Groups},
    lens::Reaches,
};
use crate::{
    geometry::volume::Volume,
    index::{
        DetailLevel, SpatialIndex,
        ticks::{Since, changed, ones},
    },
};

/// The groups that have changed since levels were last chosen.
#[derive(Debug, Default)]
pub(super) struct Pending {
    ids: Vec<GroupId>,
    /// By group.
    changes: Vec<Option<Change>>,
    /// The groups of what has moved with its parent.
    followers: Vec<GroupId>,
}

/// How a group has changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Change {
    /// It shows other levels, or is somewhere else.
    Displaced,
    /// It may have other bounds.
    Resized,
    /// It may have other members.
    Restructured,
}

impl Pending {
    pub fn note(&mut self, id: GroupId, change: Change) {
        let place = id as usize;
        if self.changes.len() <= place {
            self.changes.resize(place + 1, None);
        }
        if self.changes[place].is_none() {
            self.ids.push(id);
        }
        self.changes[place] = self.changes[place].max(Some(change));
    }

    pub fn ids(&self) -> &[GroupId] {
        &self.ids
    }

    pub fn clear(&mut self) {
        for id in self.ids.drain(..) {
            self.changes[id as usize] = None;
        }
    }

    /// Whether a group has changed in this way, or more so.
    pub fn has(&self, id: GroupId, change: Change) -> bool {
        let noted = self.changes.get(id as usize).copied().flatten();
        noted >= Some(change)
    }
}

/// It belongs to a group, or is the root of one.
type InGroup = Or<(With<DetailLevel>, With<ProxyLod>)>;

/// What has moved since the last frame.
#[derive(SystemParam)]
pub(super) struct Movements<'w, 's> {
    watched: Query<
        'w,
        's,
        (
            Entity,
            Ref<'static, GlobalTransform>,
            Option<Ref<'static, Transform>>,
            Option<Ref<'static, Aabb>>,
        ),
        InGroup,
    >,
    roots: Query<'w, 's, (Entity, Ref<'static, Children>), With<ProxyLod>>,
    changed: Query<
        'w,
        's,
        Entity,
        (
            InGroup,
            Or<(Changed<GlobalTransform>, Changed<Transform>, Changed<Aabb>)>,
        ),
    >,
}

/// Where entities are.
pub(super) type Places<'w, 's> = Query<'w, 's, (&'static GlobalTransform, Option<&'static Aabb>), Allow<Disabled>>;

impl Movements<'_, '_> {
    /// Whatever belongs to a group, or is the root of one, and has moved or got other bounds; with whether it has done so
    /// by itself, and not only with its parent.
    pub fn visit(&self, mut visit: impl FnMut(Entity, bool)) {
        let Ok(tables) = self.watched.contiguous_iter() else {
            // Something decides which entities are disabled that is not stored in tables.
            self.changed.iter().for_each(|entity| visit(entity, true));
            return;
        };
        for (entities, places, transforms, aabbs) in tables {
            let since = Since::last_read(&places);
            // Without a `Transform` of its own it is moved by somebody else.
            let is_placed = transforms.is_none();
            let columns = [changed(Some(places)), changed(transforms), changed(aabbs)];
            let columns: SmallVec<[_; 3]> = columns.into_iter().flatten().collect();
            for block in since.blocks_with_newer(&columns, 0..entities.len()) {
                let mut newer = columns.iter().map(|ticks| since.newer(&ticks[block.clone()]));
                let moved = newer.next().unwrap_or(0);
                let by_itself = newer.fold(if is_placed { moved } else { 0 }, |all, newer| all | newer);
                for row in ones(moved | by_itself) {
                    visit(entities[block.start + row as usize], by_itself >> row & 1 != 0);
                }
            }
        }
    }
}

impl Movements<'_, '_> {
    /// Finds roots that have other children than at `seen_at`, which becomes now. Called only in frames in which something
    /// has moved: as long as nothing does it does not matter what hangs where.
    pub fn find_other_children(&self, seen_at: &mut Option<Tick>, found: &mut Vec<Entity>) {
        let seen = *seen_at;
        let Ok(tables) = self.roots.contiguous_iter() else {
            found.extend(self.roots.iter().map(|(root, _)| root));
            return;
        };
        for (entities, children) in tables {
            let since = Since::last_looked(&children, seen);
            *seen_at = Some(children.this_run_tick());
            since.collect(entities, &[children.changed_ticks_slice()], found);
        }
    }
}

impl Groups {
    /// Notes that something has moved, or got other bounds, by itself or with its parent.
    pub fn note_movement(&self, entity: Entity, by_itself: bool, pending: &mut Pending) {
        let resizes = |id| by_itself || self.get(id).is_some_and(|group| group.is_loose);
        if let Some(within) = self.of_member(entity) {
            if resizes(within.group) {
                pending.note(within.group, Change::Resized);
            } else {
                pending.followers.push(within.group);
            }
        }
        if let Some(id) = self.of_root(entity) {
            pending.note(id, Change::Displaced);
            if let Some(parent) = self.parent(id)
                && resizes(parent.group)
            {
                pending.note(parent.group, Change::Resized);
            }
        }
    }

    /// Takes what a root lists for being anywhere, until it is found out where it is.
    pub fn loosen(&mut self, root: Entity, pending: &mut Pending) {
        if let Some(id) = self.of_root(root) {
            self.set_loose(id);
            pending.note(id, Change::Resized);
        }
    }

    /// The same of groups of which nothing is in the index, as of lamps: how they move, that does not tell.
    pub fn loosen_unindexed(&mut self, pending: &Pending, index: &SpatialIndex) {
        for &id in pending.ids() {
            let is_unindexed = |group: &Group| {
                let mut all = group.members.iter().chain([&group.root]);
                !all.any(|&entity| index.contains(entity))
            };
            if pending.has(id, Change::Restructured) && self.get(id).is_some_and(is_unindexed) {
                self.set_loose(id);
            }
        }
    }

    /// Finds out anew where groups are that have changed, and how large they are, those in others before these.
    pub fn place(&mut self, pending: &mut Pending, places: &Places) {
        // Whatever has not moved with the root of its group has moved with something else.
        let mut followers = std::mem::take(&mut pending.followers);
        for follower in followers.drain(..) {
            if pending.changes.get(follower as usize).is_none_or(Option::is_none) {
                pending.note(follower, Change::Resized);
            }
        }
        pending.followers = followers;
        for place in 0..pending.ids.len() {
            let mut id = pending.ids[place];
            // Those above one that was noted itself have their turn with that.
            while pending.has(id, Change::Resized)
                && let Some(parent) = self.parent(id)
                && !pending.has(parent.group, Change::Resized)
            {
                id = parent.group;
                pending.note(id, Change::Resized);
            }
        }
        let depth = |mut id: GroupId| {
            let mut depth = 0;
            while let Some(parent) = self.parent(id) {
                (id, depth) = (parent.group, depth + 1);
            }
            depth
        };
        // Mostly none is in another.
        if pending.ids.iter().any(|&id| self.parent(id).is_some()) {
            pending.ids.sort_by_cached_key(|&id| (Reverse(depth(id)), id));
        }
        for &id in &pending.ids {
            let Some(group) = self.get(id) else {
                continue;
            };
            let bounds = match group.given_bounds {
                // A place that was of no use may be good now.
                None if pending.has(id, Change::Resized) || group.bounds.is_none() => self.bounds_of(group, places),
                None => group.bounds,
                given => given,
            };
            let reaches = reaches(group, bounds, places);
            if let Some(group) = self.get_mut(id) {
                group.bounds = bounds;
            }
            self.reaches[id as usize] = reaches;
        }
    }

    /// The box of what the first level of a group shows, in the space of its root.
    fn bounds_of(&self, group: &Group, places: &Places) -> Option<Aabb> {
        let (root, own) = places.get(group.root).ok()?;
        if matches!(group.contents, Contents::Meshes(_)) {
            // What is never culled has none of its own.
            return own.copied().or(group.mesh_bounds);
        }
        let root_from_world = root.affine().as_daffine3().inverse();
        if !root_from_world.is_finite() {
            return None;
        }
        let mut around: Option<(Vec3A, Vec3A)> = None;
        let mut add = |world_from_local: DAffine3, local: &Aabb| {
            let root_from_local = (root_from_world * world_from_local).as_affine3a();
            let local = bevy::math::bounding::Aabb3d {
                min: local.min(),
                max: local.max(),
            };
            let aabb = local.transformed_by_affine(&root_from_local);
            let (min, max) = around.unwrap_or((aabb.min, aabb.max));
            around = Some((min.min(aabb.min), max.max(aabb.max)));
        };
        for &member in &group.members {
            let is_first = self.of_member(member).is_some_and(|within| within.levels & 1 == 1);
            if is_first && let Ok((place, Some(aabb))) = places.get(member) {
                add(place.affine().as_daffine3(), aabb);
            }
        }
        for &nested in &group.nested {
            let is_first = self.parent(nested).is_some_and(|within| within.levels & 1 == 1);
            if is_first
                && let Some(nested) = self.get(nested)
                && let Some(aabb) = &nested.bounds
                && let Ok((place, _)) = places.get(nested.root)
            {
                add(place.affine().as_daffine3(), aabb);
            }
        }
        let (min, max) = around.filter(|(min, max)| min.is_finite() && max.is_finite())?;
        Some(Aabb::from_min_max(min.into(), max.into()))
    }
}

/// What is needed of a group to choose its level.
fn reaches(group: &Group, bounds: Option<Aabb>, places: &Places) -> Reaches {
    let place = places.get(group.root).ok().zip(bounds).map(|((place, _), bounds)| {
        let world_from_root = place.affine();
        let matrix = world_from_root.matrix3;
        let center = world_from_root.transform_point3a(bounds.center);
        let half = box_half_extents(&matrix, bounds.half_extents);
        let around = match group.reference {
            LodReference::NearestPoint => (center - half, center + half),
            LodReference::Center => (center, center),
        };
        (around, 2.0 * radius(&matrix, bounds.half_extents), stretch(&matrix))
    });
    let (around, diameter, scale) = place.map_or((None, 0.0, 1.0), |(around, diameter, scale)| {
        (Some(around), diameter, scale)
    });
    let thresholds = group.thresholds.iter().skip(1).copied();
    let mut reaches = Reaches::new(group.metric, group.bias, diameter, scale, around, thresholds);
    let there = group.available & !group.missing;
    reaches.available = if there == 0 { group.available } else { there };
    reaches
}

/// The half extents of the world box around a transformed box.
fn box_half_extents(matrix: &Mat3A, half_extents: Vec3A) -> Vec3A {
    matrix.x_axis.abs() * half_extents.x + matrix.y_axis.abs() * half_extents.y + matrix.z_axis.abs() * half_extents.z
}

/// The radius of the sphere around a transformed box, by the farthest of its corners: the same however it is turned.
fn radius(matrix: &Mat3A, half_extents: Vec3A) -> f32 {
    let corners = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
    let corners = corners.map(|(y, z)| *matrix * (half_extents * Vec3A::new(1.0, y, z)));
    corners.into_iter().map(Vec3A::length).fold(0.0, f32::max)
}

/// By how much a transform stretches lengths at most: exact without shear, and never too little.
///
/// The square of it is the largest eigenvalue of `MᵀM`, which is at most the largest sum of a row (Gershgorin 1931).
fn stretch(matrix: &Mat3A) -> f32 {
    let gram = matrix.transpose() * *matrix;
    let row = |axis: Vec3A| axis.abs().element_sum();
    [gram.x_axis, gram.y_axis, gram.z_axis]
        .map(row)
        .into_iter()
        .fold(0.0, f32::max)
        .sqrt()
}
