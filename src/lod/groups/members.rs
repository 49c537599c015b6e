//! What belongs to groups: whatever is at and below what they list.

use bevy::ecs::entity::Entity;
use smallvec::SmallVec;

use super::{
    Flaw, Group, GroupId, Groups, Member, Within,
    reading::{Contents, MeshLevel},
};

/// The relations of an entity that exists.
#[derive(Clone, Copy, Debug)]
pub(in crate::lod) struct Family<'a> {
    pub children: &'a [Entity],
    pub parent: Option<Entity>,
}

impl Groups {
    /// Lets go of the groups in a group, before it is found out anew which are. Whatever is in them is added to `touched`.
    pub fn release_nested(&mut self, id: GroupId, touched: &mut Vec<Entity>) {
        self.visit_members(id, &mut |member| touched.push(member));
        let nested = self.get_mut(id).map(|group| std::mem::take(&mut group.nested));
        for nested in nested.into_iter().flatten() {
            self.leave(nested, id);
        }
    }

    /// Has a group be in another no more.
    pub(super) fn leave(&mut self, id: GroupId, outer: GroupId) {
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

    pub(super) fn release(&mut self, entity: Entity, id: GroupId) {
        if self.of_member(entity).is_some_and(|within| within.group == id) {
            self.members[entity.index_u32() as usize] = Self::NOBODY;
        }
    }
}
