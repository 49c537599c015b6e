//! All groups, what belongs to them, and how they are nested.

mod members;
mod reading;

pub(super) use members::Family;
pub(super) use reading::{Contents, Flaw, Given, Group, MeshLevel};

use bevy::{
    ecs::entity::{Entity, EntityHashMap},
    platform::collections::HashSet,
};
use smallvec::SmallVec;

use super::{LodHits, ProxyLod, lens::Reaches, view_levels::ViewLevels};
use crate::index::DetailLevel;

/// The number of a group.
pub(crate) type GroupId = u32;

/// No group has this number.
const NO_GROUP: GroupId = GroupId::MAX;

/// All groups, what belongs to them, and how they are nested.
///
/// Whatever is at or below an entity that a level lists belongs to that level, unless a nearer one is listed: each entity
/// to one group at most. What a view shows of the group of its group decides about both, to any depth.
#[derive(Debug, Default)]
pub(super) struct Groups {
    records: Vec<Option<Group>>,
    free: Vec<GroupId>,
    /// Not to be given to others within the frame in which they were freed.
    freed: Vec<GroupId>,
    /// By index in the world; [`NO_GROUP`] for those that are roots of none.
    of_root: Vec<GroupId>,
    len: usize,
    /// Those whose roots move without what they list.
    loose: HashSet<GroupId>,
    /// By which levels an entity is listed: it is part of the first group of which it is not the root, and of its own.
    listed: EntityHashMap<SmallVec<[Within; 1]>>,
    /// By index in the world.
    members: Vec<Member>,
    /// What is read for each entity in each view.
    links: Vec<Link>,
    /// What is read to choose levels.
    pub reaches: Vec<Reaches>,
}

/// Some levels of a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Within {
    pub group: GroupId,
    /// One bit for each.
    pub levels: u8,
}

#[derive(Clone, Copy, Debug)]
struct Member {
    /// [`Entity::PLACEHOLDER`] if nobody with this index belongs to a group.
    entity: Entity,
    within: Within,
}

#[derive(Clone, Copy, Debug)]
struct Link {
    parent: Option<Within>,
    is_swapped: bool,
}

impl Groups {
    const NOBODY: Member = Member {
        entity: Entity::PLACEHOLDER,
        within: Within { group: 0, levels: 0 },
    };

    pub fn get(&self, id: GroupId) -> Option<&Group> {
        self.records.get(id as usize)?.as_ref()
    }

    pub fn get_mut(&mut self, id: GroupId) -> Option<&mut Group> {
        self.records.get_mut(id as usize)?.as_mut()
    }

    /// The group of which an entity is the root.
    pub fn of_root(&self, root: Entity) -> Option<GroupId> {
        let &id = self.of_root.get(root.index_u32() as usize)?;
        (id != NO_GROUP && self.get(id)?.root == root).then_some(id)
    }

    pub fn ids(&self) -> impl Iterator<Item = GroupId> + '_ {
        (0..self.records.len() as GroupId).filter(|&id| self.get(id).is_some())
    }

    /// Notes that what a group lists may move without its root.
    pub fn set_loose(&mut self, id: GroupId) {
        if let Some(group) = self.get_mut(id) {
            group.is_loose = true;
            self.loose.insert(id);
        }
    }

    /// Whether some list what is elsewhere than right below their roots.
    pub fn has_loose(&self) -> bool {
        !self.loose.is_empty()
    }

    pub fn len(&self) -> usize {
        self.len
    }

    /// To which levels an entity belongs.
    #[inline]
    pub fn of_member(&self, entity: Entity) -> Option<Within> {
        let member = self.members.get(entity.index_u32() as usize)?;
        (member.entity == entity).then_some(member.within)
    }

    /// Notes which levels could be shown, one bit for each.
    pub fn set_available(&mut self, id: GroupId, available: u8) {
        if let Some(group) = self.get_mut(id) {
            group.available = available;
        }
    }

    /// Notes of which levels some meshes are not loaded, one bit for each.
    pub fn set_missing(&mut self, id: GroupId, missing: u8) {
        if let Some(group) = self.get_mut(id) {
            group.missing = missing;
        }
    }

    /// Whether the levels of a group are meshes.
    pub fn is_swapped(&self, id: GroupId) -> bool {
        self.links[id as usize].is_swapped
    }

    /// The levels that decide about those of a group.
    pub fn parent(&self, id: GroupId) -> Option<Within> {
        self.links.get(id as usize)?.parent
    }

    /// Whether a view shows the entity of this number; `main` decides about meshes that are swapped. Where nothing is known
    /// the finest is shown.
    #[inline]
    pub fn shows(&self, view: Option<&ViewLevels>, main: Option<&ViewLevels>, number: u32) -> bool {
        self.is_at(number, shown_in(view, main))
    }

    /// Whether a view shows a group at all: none that it is in shows something else in its place.
    pub fn shows_group(&self, view: Option<&ViewLevels>, main: Option<&ViewLevels>, id: GroupId) -> bool {
        self.parent(id)
            .is_none_or(|within| self.are_shown(within, shown_in(view, main)))
    }

    /// Whether the entity of this number is at levels that are shown, to the outermost group: `shown` has one bit for each
    /// level of a group, of which it is also told whether its meshes are swapped.
    #[inline]
    pub fn is_at(&self, number: u32, shown: impl Fn(GroupId, bool) -> u8) -> bool {
        let member = self
            .members
            .get(number as usize)
            .filter(|member| member.within.levels != 0);
        member.is_none_or(|member| self.are_shown(member.within, shown))
    }

    /// Whether one of these levels is shown, and so up to the outermost group.
    #[inline]
    fn are_shown(&self, mut within: Within, shown: impl Fn(GroupId, bool) -> u8) -> bool {
        loop {
            let link = self.links[within.group as usize];
            if within.levels & shown(within.group, link.is_swapped) == 0 {
                return false;
            }
            match link.parent {
                Some(parent) => within = parent,
                None => return true,
            }
        }
    }

    /// Visits the members of a group, and those of the groups in it.
    pub fn visit_members(&self, id: GroupId, visit: &mut impl FnMut(Entity)) {
        if let Some(group) = self.get(id) {
            group.members.iter().for_each(|&member| visit(member));
            group
                .nested
                .iter()
                .for_each(|&nested| self.visit_members(nested, visit));
        }
    }

    /// What an entity is to queries, if it belongs to a group.
    pub fn detail_level(&self, entity: Entity) -> Option<DetailLevel> {
        let mut within = self.of_member(entity)?;
        let mut detail = DetailLevel::AsShown;
        loop {
            let link = self.links[within.group as usize];
            if !link.is_swapped && self.get(within.group)?.hits == LodHits::Finest {
                if within.levels & 1 == 0 {
                    return Some(DetailLevel::Coarser);
                }
                detail = DetailLevel::Finest;
            }
            match link.parent {
                Some(parent) => within = parent,
                None => return Some(detail),
            }
        }
    }

    /// Begins a frame: what was freed in the last may be used again.
    pub fn begin_frame(&mut self) {
        self.free.append(&mut self.freed);
    }

    /// Adds a group, or reads it anew. Groups that are affected, itself among them, are added to `dirty`. Returns what it
    /// was, if its meshes were swapped, and it has none any more.
    pub fn insert(
        &mut self,
        root: Entity,
        lod: &ProxyLod,
        flaws: &mut Vec<Flaw>,
        dirty: &mut Vec<GroupId>,
    ) -> Option<Group> {
        let mut group = Group::read(root, lod, flaws);
        let mut swapped = None;
        let id = match self.of_root(root) {
            Some(id) => {
                self.unlist(id, dirty);
                if let Some(mut old) = self.records[id as usize].take() {
                    group.members = std::mem::take(&mut old.members);
                    group.nested = std::mem::take(&mut old.nested);
                    (group.given, group.bounds) = (old.given, old.bounds);
                    if old.mesh_levels() != 0 && group.mesh_levels() == 0 {
                        group.given = Given::default();
                        swapped = Some(old);
                    }
                }
                id
            }
            None => {
                let id = self.free.pop().unwrap_or_else(|| {
                    self.records.push(None);
                    self.links.push(Link {
                        parent: None,
                        is_swapped: false,
                    });
                    self.reaches.push(Reaches::NONE);
                    self.records.len() as GroupId - 1
                });
                let number = root.index_u32() as usize;
                if self.of_root.len() <= number {
                    self.of_root.resize(number + 1, NO_GROUP);
                }
                self.of_root[number] = id;
                self.len += 1;
                id
            }
        };
        // Whoever has what is in this group now has to give it back.
        let listed = group.listed().map(|(entity, _)| entity);
        for entity in listed.chain([root]) {
            dirty.extend(self.of_member(entity).map(|within| within.group));
            let inner = self.of_root(entity).filter(|&inner| inner != id);
            dirty.extend(inner.and_then(|inner| Some(self.parent(inner)?.group)));
        }
        dirty.extend(self.parent(id).map(|parent| parent.group));
        dirty.push(id);
        for (entity, levels) in group.listed() {
            let by = self.listed.entry(entity).or_default();
            match by.iter_mut().find(|within| within.group == id) {
                Some(own) => own.levels |= levels,
                None => by.push(Within { group: id, levels }),
            }
        }
        self.links[id as usize].is_swapped = matches!(group.contents, Contents::Meshes(_));
        self.records[id as usize] = Some(group);
        swapped
    }

    /// Takes a group out, if there is one. Those that are affected are added to `dirty`, and whatever may have belonged to
    /// it to `touched`.
    pub fn remove(&mut self, root: Entity, dirty: &mut Vec<GroupId>, touched: &mut Vec<Entity>) -> Option<Group> {
        let id = self.of_root(root)?;
        self.of_root[root.index_u32() as usize] = NO_GROUP;
        self.len -= 1;
        self.unlist(id, dirty);
        let group = self.records[id as usize].take()?;
        dirty.extend(self.links[id as usize].parent.take().map(|parent| parent.group));
        for &nested in &group.nested {
            self.leave(nested, id);
            dirty.push(nested);
        }
        for &member in &group.members {
            self.release(member, id);
            touched.push(member);
        }
        self.reaches[id as usize] = Reaches::NONE;
        self.loose.remove(&id);
        self.freed.push(id);
        Some(group)
    }

    /// Forgets what a group lists. Whoever lists it as well is added to `dirty`.
    fn unlist(&mut self, id: GroupId, dirty: &mut Vec<GroupId>) {
        let Some(group) = &self.records[id as usize] else {
            return;
        };
        for (entity, _) in group.listed() {
            if let Some(by) = self.listed.get_mut(&entity) {
                by.retain(|within| within.group != id);
                dirty.extend(by.iter().map(|within| within.group));
                if by.is_empty() {
                    self.listed.remove(&entity);
                }
            }
        }
    }
}

/// The levels that a view shows of a group, if it is known what it shows; of swapped meshes, what the main one does.
#[inline]
fn shown_in<'a>(view: Option<&'a ViewLevels>, main: Option<&'a ViewLevels>) -> impl Fn(GroupId, bool) -> u8 + 'a {
    move |id, is_swapped| {
        let levels = if is_swapped { main } else { view };
        levels.map_or(1, |levels| levels.shown(id))
    }
}
