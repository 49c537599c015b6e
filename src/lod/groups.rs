//! All groups, what belongs to them, and how they are nested.

use std::fmt;

use bevy::{
    asset::{AssetPath, Handle},
    camera::primitives::Aabb,
    ecs::entity::{Entity, EntityHashMap},
    mesh::Mesh,
    platform::collections::HashSet,
};
use smallvec::SmallVec;

use super::{
    LodContent, LodHits, LodMetric, LodReference, ProxyLod,
    lens::{MAX_LEVELS, Reaches},
    view_levels::ViewLevels,
};
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

/// A group.
#[derive(Clone, Debug)]
pub(super) struct Group {
    pub root: Entity,
    pub contents: Contents,
    pub metric: LodMetric,
    pub reference: LodReference,
    pub bias: f32,
    pub hits: LodHits,
    pub given_bounds: Option<Aabb>,
    pub thresholds: SmallVec<[f32; MAX_LEVELS]>,
    /// One bit for each level that could be shown.
    pub available: u8,
    /// Those of which some meshes are not loaded.
    pub missing: u8,
    /// The box around all of its meshes, if these are swapped.
    pub mesh_bounds: Option<Aabb>,
    /// Its bounds in the space of the root, as far as they are known.
    pub bounds: Option<Aabb>,
    /// Whether what it lists is elsewhere than right below its root, and so may move by itself unnoticed.
    pub is_loose: bool,
    /// Those of no nearer group.
    pub members: Vec<Entity>,
    /// The groups of which it shows or hides the roots.
    pub nested: Vec<GroupId>,
    /// The level whose mesh its root has.
    pub applied: Option<u8>,
    /// What else its root has been given.
    pub given: Given,
}

/// What an entity has been given because its meshes are swapped.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Given {
    /// A box around all of its meshes.
    pub has_bounds: bool,
    /// The finest mesh, for rays.
    pub has_simplified_mesh: bool,
}

/// What the levels of a group show.
#[derive(Clone, Debug)]
pub(super) enum Contents {
    Meshes(SmallVec<[MeshLevel; 4]>),
    /// Nothing is an empty list.
    Entities(SmallVec<[Vec<Entity>; 4]>),
}

/// A mesh that is swapped in.
#[derive(Clone, Debug)]
pub(super) enum MeshLevel {
    Mesh(Handle<Mesh>),
    Streamed(AssetPath<'static>),
    Nothing,
}

/// The relations of an entity that exists.
#[derive(Clone, Copy, Debug)]
pub(super) struct Family<'a> {
    pub children: &'a [Entity],
    pub parent: Option<Entity>,
}

/// What is wrong with a group; it is shown all the same, as far as that goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Flaw {
    TooManyLevels,
    MixedContents,
    NothingBeforeOthers,
    Threshold,
    Bias,
    /// An entity is listed by two groups.
    Shared(Entity),
    /// The group is part of itself.
    Cycle,
}

impl fmt::Display for Flaw {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::TooManyLevels => write!(f, "it has more than {MAX_LEVELS} levels; those after are left out"),
            Self::MixedContents => write!(
                f,
                "it has levels that are meshes and levels that are entities; those unlike the first are left out"
            ),
            Self::NothingBeforeOthers => write!(
                f,
                "a level that shows nothing is not the last; those after are left out"
            ),
            Self::Threshold => write!(
                f,
                "a threshold, or how many pixels of error there may be, is NaN or negative, or thresholds are not in order; levels may never be shown"
            ),
            Self::Bias => write!(f, "its bias is not a positive number, and counts as 1"),
            Self::Shared(entity) => write!(f, "{entity} is part of another group, and not of this one"),
            Self::Cycle => write!(f, "it is part of itself"),
        }
    }
}

impl Group {
    /// Reads a component, as far as it makes sense.
    fn read(root: Entity, lod: &ProxyLod, flaws: &mut Vec<Flaw>) -> Self {
        let mut thresholds = SmallVec::new();
        let is_mesh = |content: &LodContent| matches!(content, LodContent::Mesh(_) | LodContent::Streamed(_));
        let first_is_mesh = lod.levels.iter().find_map(|level| match level.content {
            LodContent::Nothing => None,
            _ => Some(is_mesh(&level.content)),
        });
        let mut contents = if first_is_mesh == Some(false) {
            Contents::Entities(SmallVec::new())
        } else {
            Contents::Meshes(SmallVec::new())
        };
        for (number, level) in lod.levels.iter().enumerate() {
            if thresholds.len() == MAX_LEVELS {
                flaws.push(Flaw::TooManyLevels);
                break;
            }
            match (&mut contents, &level.content) {
                (Contents::Meshes(levels), LodContent::Mesh(mesh)) => levels.push(MeshLevel::Mesh(mesh.clone())),
                (Contents::Meshes(levels), LodContent::Streamed(path)) => {
                    levels.push(MeshLevel::Streamed(path.clone()));
                }
                (Contents::Meshes(levels), LodContent::Nothing) => levels.push(MeshLevel::Nothing),
                (Contents::Entities(levels), LodContent::Entities(entities)) => levels.push(entities.clone()),
                (Contents::Entities(levels), LodContent::Nothing) => levels.push(Vec::new()),
                _ => {
                    flaws.push(Flaw::MixedContents);
                    continue;
                }
            }
            thresholds.push(level.threshold);
            if level.content == LodContent::Nothing && number + 1 < lod.levels.len() {
                flaws.push(Flaw::NothingBeforeOthers);
                break;
            }
        }
        let rest = thresholds.get(1..).unwrap_or(&[]);
        let are_numbers = rest.iter().all(|&threshold: &f32| threshold >= 0.0);
        let are_in_order = rest.windows(2).all(|pair| match lod.metric {
            LodMetric::Height => pair[0] >= pair[1],
            LodMetric::Distance => pair[0] <= pair[1],
            LodMetric::PixelError(_) => true,
        });
        let is_sound = !matches!(lod.metric, LodMetric::PixelError(pixels) if pixels.is_nan() || pixels <= 0.0);
        if !are_numbers || !are_in_order || !is_sound {
            flaws.push(Flaw::Threshold);
        }
        let is_sound = lod.bias > 0.0 && lod.bias.is_finite();
        if !is_sound {
            flaws.push(Flaw::Bias);
        }
        Self {
            root,
            contents,
            metric: lod.metric,
            reference: lod.reference,
            bias: if is_sound { lod.bias } else { 1.0 },
            hits: lod.hits,
            given_bounds: lod.bounds,
            thresholds,
            available: 0,
            missing: 0,
            mesh_bounds: None,
            bounds: None,
            is_loose: false,
            members: Vec::new(),
            nested: Vec::new(),
            applied: None,
            given: Given::default(),
        }
    }

    /// How many levels there are.
    pub fn levels(&self) -> usize {
        self.thresholds.len()
    }

    /// The entities that levels list, with the levels of each.
    fn listed(&self) -> impl Iterator<Item = (Entity, u8)> + '_ {
        let levels: &[Vec<Entity>] = match &self.contents {
            Contents::Entities(levels) => levels,
            Contents::Meshes(_) => &[],
        };
        (levels.iter().enumerate())
            .flat_map(|(level, entities)| entities.iter().map(move |&entity| (entity, 1 << level)))
    }

    /// The levels that show a mesh.
    fn mesh_levels(&self) -> u8 {
        match &self.contents {
            Contents::Meshes(levels) => levels.iter().enumerate().fold(0, |bits, (number, level)| {
                bits | u8::from(!matches!(level, MeshLevel::Nothing)) << number
            }),
            Contents::Entities(_) => 0,
        }
    }
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

    /// Lets go of the groups in a group, before it is found out anew which are. Whatever is in them is added to `touched`.
    pub fn release_nested(&mut self, id: GroupId, touched: &mut Vec<Entity>) {
        self.visit_members(id, &mut |member| touched.push(member));
        let nested = self.get_mut(id).map(|group| std::mem::take(&mut group.nested));
        for nested in nested.into_iter().flatten() {
            self.leave(nested, id);
        }
    }

    /// Has a group be in another no more.
    fn leave(&mut self, id: GroupId, outer: GroupId) {
        let parent = &mut self.links[id as usize].parent;
        if parent.is_some_and(|parent| parent.group == outer) {
            *parent = None;
        }
    }

    /// Finds out anew what belongs to a group, by the `children` of entities, with their parents: after all groups that
    /// are found anew have [released](Self::release_nested) theirs. Whatever did or does is added to `touched`.
    pub fn find_members<'a>(
        &mut self,
        id: GroupId,
        family: &impl Fn(Entity) -> Option<Family<'a>>,
        flaws: &mut Vec<Flaw>,
        touched: &mut Vec<Entity>,
    ) {
        let Some(mut group) = self.records[id as usize].take() else {
            return;
        };
        for member in group.members.drain(..) {
            self.release(member, id);
            touched.push(member);
        }
        group.is_loose = false;
        let mut available = group.mesh_levels();
        if available != 0 {
            self.claim(
                group.root,
                Within {
                    group: id,
                    levels: available,
                },
                &mut group,
            );
        }
        let listed: SmallVec<[(Entity, u8); 8]> = group.listed().collect();
        for (entity, _) in listed {
            let Some(found) = family(entity) else {
                continue;
            };
            let Some(within) = self.claim_of(entity, id, &group) else {
                flaws.push(Flaw::Shared(entity));
                continue;
            };
            group.is_loose |= entity != group.root && found.parent != Some(group.root);
            if self.of_member(entity).is_some_and(|other| other.group == id) {
                continue;
            }
            available |= within.levels;
            self.walk(entity, within, &mut group, family, flaws);
        }
        // To show nothing is always possible.
        let levels = group.levels();
        let last_is_empty = match &group.contents {
            Contents::Meshes(levels) => matches!(levels.last(), Some(MeshLevel::Nothing)),
            Contents::Entities(levels) => levels.last().is_some_and(Vec::is_empty),
        };
        available |= u8::from(last_is_empty) << levels.saturating_sub(1);
        group.available = available;
        touched.extend(&group.members);
        if group.is_loose {
            self.loose.insert(id);
        } else {
            self.loose.remove(&id);
        }
        self.records[id as usize] = Some(group);
    }

    /// The levels of a group that show an entity, unless it is part of another.
    fn claim_of(&self, entity: Entity, id: GroupId, group: &Group) -> Option<Within> {
        let by = self.listed.get(&entity)?;
        if entity == group.root {
            return by.iter().find(|within| within.group == id).copied();
        }
        let own = self.of_root(entity);
        let first = by.iter().find(|within| Some(within.group) != own);
        first.filter(|within| within.group == id).copied()
    }

    /// Takes what is at and below an entity into a group, but for what is listed otherwise.
    fn walk<'a>(
        &mut self,
        top: Entity,
        within: Within,
        group: &mut Group,
        family: &impl Fn(Entity) -> Option<Family<'a>>,
        flaws: &mut Vec<Flaw>,
    ) {
        let mut open: SmallVec<[Entity; 16]> = SmallVec::from_slice(&[top]);
        while let Some(entity) = open.pop() {
            let by = self.listed.get(&entity).map_or(&[][..], |by| by);
            let is_own = by.iter().any(|other| other.group == within.group);
            let inner = self.of_root(entity).filter(|&inner| inner != within.group);
            let is_of_inner = inner.is_some_and(|inner| by.iter().any(|other| other.group == inner));
            if entity != top && (is_own || !by.is_empty() && !is_of_inner) {
                continue;
            }
            let mut is_claimed = is_of_inner;
            if let Some(inner) = inner {
                if self.is_within(within.group, inner) {
                    flaws.push(Flaw::Cycle);
                    continue;
                }
                self.links[inner as usize].parent = Some(within);
                group.nested.push(inner);
                is_claimed |= self.links[inner as usize].is_swapped;
            }
            if !is_claimed {
                self.claim(entity, within, group);
            }
            if !is_of_inner {
                open.extend(family(entity).into_iter().flat_map(|family| family.children).copied());
            }
        }
    }

    /// Whether a group is another, or in it.
    fn is_within(&self, id: GroupId, outer: GroupId) -> bool {
        let mut at = Some(id);
        while let Some(id) = at {
            if id == outer {
                return true;
            }
            at = self.links[id as usize].parent.map(|parent| parent.group);
        }
        false
    }

    fn claim(&mut self, entity: Entity, within: Within, group: &mut Group) {
        let number = entity.index_u32() as usize;
        if self.members.len() <= number {
            self.members.resize(number + 1, Self::NOBODY);
        }
        self.members[number] = Member { entity, within };
        group.members.push(entity);
    }

    fn release(&mut self, entity: Entity, id: GroupId) {
        if self.of_member(entity).is_some_and(|within| within.group == id) {
            self.members[entity.index_u32() as usize] = Self::NOBODY;
        }
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
