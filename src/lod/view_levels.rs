//! The levels of all groups in one view, and when each has to be looked at again.
//!
//! Each choice knows how far the view may move before another can be right. The view sums up how far it has moved, and a
//! group is *due* when that sum has reached what it was, plus the slack, when the group was last looked at. Of each
//! [`BLOCK`] of groups the earliest is known, so that a view that stands still looks at nothing, and one that moves at
//! the groups that are near a switch.

use bevy::{
    math::{DVec3, Vec3},
    platform::collections::HashMap,
};

use crate::{index::ticks::ones, spatial::simd::prefetch};

use super::{
    groups::{GroupId, Groups},
    lens::{Lens, Reaches},
};

/// Groups of which only the earliest is asked.
const BLOCK: usize = 16;

/// No level has been chosen yet.
const UNKNOWN: u8 = u8::MAX;

/// The way after which it is summed up anew, in world units: so that sums are never rounded by more than a hair.
const LONGEST_WAY: f32 = 1024.0;

/// The levels of all groups in one view.
#[derive(Debug, Default)]
pub(crate) struct ViewLevels {
    blocks: Vec<Block>,
    /// The earliest of each block, or something earlier.
    block_due: Vec<f32>,
    /// What is to be looked at in this frame: buffers, kept for their memory.
    due_blocks: Vec<u32>,
    due_groups: Vec<GroupId>,
    /// Since when levels are wanted, in seconds; empty if none has to stay.
    since: Vec<f64>,
    moved: f32,
    /// The levels from which groups fade to the one that is shown.
    fading: HashMap<GroupId, u8>,
    sight: Option<Sight>,
    /// How many groups were looked at in this frame.
    looked_at: usize,
    /// What has switched in this frame.
    switches: Vec<Switch>,
    /// What has come or gone with that, by number.
    switched: Vec<u32>,
    /// The same of no other view at any other time.
    version: u64,
    /// The last version, if what has switched since is known.
    before: Option<u64>,
}

/// Some groups.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
struct Block {
    /// Of each group, the distance moved from which on it is to be looked at again.
    due: [f32; BLOCK],
    groups: [InView; BLOCK],
}

/// What a view shows of a group.
#[derive(Clone, Copy, Debug)]
struct InView {
    /// What the metric asks for.
    wanted: u8,
    /// What is there of that.
    shown: u8,
}

impl Block {
    const UNKNOWN: Self = Self {
        due: [f32::NEG_INFINITY; BLOCK],
        groups: [InView::UNKNOWN; BLOCK],
    };
}

impl InView {
    const UNKNOWN: Self = Self {
        wanted: UNKNOWN,
        shown: UNKNOWN,
    };
}

/// From where a view looks, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sight {
    pub eye: Vec3,
    pub lens: Lens,
    /// From which multiple of its distance on a coarser level takes over.
    pub stay: f32,
    /// For how long a level stays, in seconds.
    pub dwell: f64,
}

/// A group shows another level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Switch {
    pub group: GroupId,
    /// If it is not the first that is known.
    pub from: Option<u8>,
    pub to: u8,
}

impl ViewLevels {
    /// The level that is shown of a group: the finest, as long as nothing is known of it.
    #[inline]
    pub fn level(&self, group: GroupId) -> u8 {
        let block = self.blocks.get(group as usize / BLOCK);
        let known = block.map_or(UNKNOWN, |block| block.groups[group as usize % BLOCK].shown);
        if known == UNKNOWN { 0 } else { known }
    }

    /// The levels that are shown of a group, one bit for each: two where it fades.
    #[inline]
    pub(super) fn shown(&self, group: GroupId) -> u8 {
        let shown = 1 << self.level(group);
        if self.fading.is_empty() {
            return shown;
        }
        shown | self.fading.get(&group).map_or(0, |level| 1 << level)
    }

    /// Shows a level beside the one that is shown.
    pub(super) fn begin_fade(&mut self, group: GroupId, from: u8) {
        self.fading.insert(group, from);
    }

    /// Shows but one level again, of whatever belongs to the group by now.
    pub(super) fn end_fade(&mut self, group: GroupId, groups: &Groups, versions: &mut u64) {
        self.fading.remove(&group);
        self.list_members_of(&[group], groups);
        self.settle(false, versions);
    }

    /// From where it looks, if it has looked.
    pub(super) fn eye(&self) -> Option<Vec3> {
        self.sight.map(|sight| sight.eye)
    }

    /// How large it shows things, if it has looked.
    pub(super) fn lens(&self) -> Option<&Lens> {
        self.sight.as_ref().map(|sight| &sight.lens)
    }

    /// The level that the metric asks for, if that is known.
    pub(super) fn wanted(&self, group: GroupId) -> Option<u8> {
        let wanted = self.blocks.get(group as usize / BLOCK)?.groups[group as usize % BLOCK].wanted;
        (wanted != UNKNOWN).then_some(wanted)
    }

    /// Which levels of a group the view is near, one bit for each: where it would show them at `margin` times its distance,
    /// or a fraction as small.
    pub(super) fn near(&self, reaches: &Reaches, margin: f32) -> u8 {
        self.sight
            .as_ref()
            .map_or(u8::MAX, |sight| reaches.near(&sight.lens, sight.eye, margin))
    }

    /// How many groups were looked at in this frame.
    pub(super) fn looked_at(&self) -> usize {
        self.looked_at
    }

    pub(super) fn switches(&self) -> &[Switch] {
        &self.switches
    }

    /// The same of no other view at any other time.
    pub fn version(&self) -> u64 {
        self.version
    }

    /// Whatever may be shown otherwise than in another version, by number; `None` if that is not known.
    pub fn switched_since(&self, version: u64) -> Option<&[u32]> {
        if version == self.version {
            Some(&[])
        } else {
            (self.before == Some(version)).then_some(&self.switched)
        }
    }

    /// Lists whatever has come or gone with what has switched.
    pub(super) fn list_members(&mut self, groups: &Groups) {
        self.switched.clear();
        for switch in self.switches.iter().filter(|switch| !groups.is_swapped(switch.group)) {
            groups.visit_members(switch.group, &mut |member| self.switched.push(member.index_u32()));
        }
    }

    /// Lists whatever belongs to these groups as well.
    pub(super) fn list_members_of(&mut self, ids: &[GroupId], groups: &Groups) {
        for &id in ids {
            groups.visit_members(id, &mut |member| self.switched.push(member.index_u32()));
        }
    }

    /// Ends a frame; `versions` is the last version of any view.
    pub(super) fn settle(&mut self, has_changed_otherwise: bool, versions: &mut u64) {
        if has_changed_otherwise || !self.switched.is_empty() || self.version == 0 {
            *versions += 1;
            self.before = (!has_changed_otherwise && self.version != 0).then_some(self.version);
            self.version = *versions;
        }
    }

    /// Chooses the levels as of `now`, in seconds. `changed` are the groups that have changed since the last time, come, or
    /// gone.
    pub(super) fn update(&mut self, sight: Sight, reaches: &[Reaches], changed: &[GroupId], now: f64) {
        self.switches.clear();
        let blocks = reaches.len().div_ceil(BLOCK);
        self.blocks.resize(blocks, Block::UNKNOWN);
        self.block_due.resize(blocks, f32::NEG_INFINITY);
        let staying = if sight.dwell > 0.0 { reaches.len() } else { 0 };
        self.since.resize(staying, f64::NEG_INFINITY);

        let before = self.sight.replace(sight);
        let sees_as_before = before.is_some_and(|before| {
            Sight {
                eye: sight.eye,
                ..before
            } == sight
        });
        if let Some(before) = before.filter(|_| sees_as_before) {
            let way: DVec3 = sight.eye.as_dvec3() - before.eye.as_dvec3();
            // Rounded up, so that nothing is looked at too late.
            if way != DVec3::ZERO {
                self.moved = (self.moved + way.length() as f32).next_up().next_up();
            }
        }
        if !sees_as_before || self.moved > LONGEST_WAY {
            self.look_at_all();
        }
        for &group in changed {
            let (block, place) = (group as usize / BLOCK, group as usize % BLOCK);
            (self.blocks[block].due[place], self.block_due[block]) = (f32::NEG_INFINITY, f32::NEG_INFINITY);
            if reaches[group as usize].levels == 0 {
                self.blocks[block].groups[place] = InView::UNKNOWN;
                if let Some(since) = self.since.get_mut(group as usize) {
                    *since = f64::NEG_INFINITY;
                }
            }
        }

        self.find_due(reaches);
        let due = std::mem::take(&mut self.due_groups);
        self.looked_at = due.len();
        for &group in &due {
            let (block, place) = (group as usize / BLOCK, group as usize % BLOCK);
            self.blocks[block].due[place] = self.look(group as usize, &sight, &reaches[group as usize], now);
        }
        self.due_groups = due;
        for &block in &self.due_blocks {
            let earliest = |earliest, &due: &f32| if due < earliest { due } else { earliest };
            let block = block as usize;
            self.block_due[block] = self.blocks[block].due.iter().fold(f32::INFINITY, earliest);
        }
    }

    /// Lists what is to be looked at. Its memory is asked for a step ahead: with many groups, it is waited for otherwise.
    fn find_due(&mut self, reaches: &[Reaches]) {
        let moved = self.moved;
        self.due_blocks.clear();
        for (block, &due) in self.block_due.iter().enumerate() {
            if due <= moved {
                self.due_blocks.push(block as u32);
                prefetch(&self.blocks[block]);
            }
        }
        self.due_groups.clear();
        for &block in &self.due_blocks {
            let due = self.blocks[block as usize].due.iter().enumerate();
            let are_due = due.fold(0, |are_due, (place, &due)| are_due | u64::from(due <= moved) << place);
            for place in ones(are_due) {
                let group = block * BLOCK as u32 + place;
                if let Some(reaches) = reaches.get(group as usize) {
                    self.due_groups.push(group);
                    prefetch(reaches);
                } else {
                    self.blocks[block as usize].due[place as usize] = f32::INFINITY;
                }
            }
        }
    }

    /// Has all groups looked at.
    fn look_at_all(&mut self) {
        self.moved = 0.0;
        self.block_due.fill(f32::NEG_INFINITY);
        self.blocks.iter_mut().for_each(|block| block.due = Block::UNKNOWN.due);
    }

    /// Looks at one group; returns when to look again.
    fn look(&mut self, group: usize, sight: &Sight, reaches: &Reaches, now: f64) -> f32 {
        if reaches.levels == 0 {
            return f32::INFINITY;
        }
        let state = &mut self.blocks[group / BLOCK].groups[group % BLOCK];
        let known = (state.wanted < reaches.levels).then_some(state.wanted);
        let choice = reaches.choose(&sight.lens, sight.eye, known.unwrap_or(0), sight.stay);
        let mut due = (self.moved + choice.slack).next_down();
        if known != Some(choice.level) {
            state.wanted = choice.level;
            if let Some(since) = self.since.get_mut(group) {
                match known {
                    Some(known) if now < *since + sight.dwell => (state.wanted, due) = (known, f32::NEG_INFINITY),
                    _ => *since = now,
                }
            }
        }
        let shown = stand_in(state.wanted, reaches.available);
        if shown != state.shown {
            self.switches.push(Switch {
                group: group as GroupId,
                from: (state.shown != UNKNOWN).then_some(state.shown),
                to: shown,
            });
            state.shown = shown;
        }
        due
    }
}

/// What is shown if a level is asked for and these are there: the finest that is there, in the place of what is not.
pub(super) fn stand_in(level: u8, available: u8) -> u8 {
    if available == 0 || available >> level & 1 == 1 {
        level
    } else {
        available.trailing_zeros() as u8
    }
}
