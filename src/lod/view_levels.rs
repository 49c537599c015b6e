//! The levels of all groups in one view, and when each has to be looked at again.
//!
//! Each choice knows how far the view may move before another can be right. The view sums up how far it has moved, and a
//! group is *due* when that sum has reached what it was, plus the slack, when the group was last looked at. Of each
//! [`BLOCK`] of groups the earliest is known, so that a view that stands still looks at nothing, and one that moves at
//! the groups that are near a switch.

use bevy::math::{DVec3, Vec3};

use super::{
    groups::{GroupId, Groups},
    lens::{Lens, Reaches},
};

/// Groups of which only the earliest is asked.
const BLOCK: usize = 16;

/// No level has been chosen yet.
const UNKNOWN: u8 = u8::MAX;

/// The levels of all groups in one view.
#[derive(Debug, Default)]
pub(crate) struct ViewLevels {
    groups: Vec<InView>,
    /// Until when levels stay, in seconds; empty if none does.
    stays_until: Vec<f64>,
    /// Of each group, the distance moved from which on it is to be looked at again.
    due: Vec<f64>,
    /// The earliest of each block, or something earlier.
    block_due: Vec<f64>,
    moved: f64,
    sight: Option<Sight>,
    /// What has switched in this frame.
    switches: Vec<Switch>,
    /// What has come or gone with that, by number.
    switched: Vec<u32>,
    /// The same of no other view at any other time.
    version: u64,
    /// The last version, if what has switched since is known.
    before: Option<u64>,
}

/// What a view shows of a group.
#[derive(Clone, Copy, Debug)]
struct InView {
    /// What the metric asks for.
    wanted: u8,
    /// What is there of that.
    shown: u8,
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
        let known = self.groups.get(group as usize).map_or(UNKNOWN, |group| group.shown);
        if known == UNKNOWN { 0 } else { known }
    }

    /// The level that the metric asks for.
    pub(super) fn wanted(&self, group: GroupId) -> u8 {
        let known = self.groups.get(group as usize).map_or(UNKNOWN, |group| group.wanted);
        if known == UNKNOWN { 0 } else { known }
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
    /// gone; `available` has one bit for each level of a group that could be shown.
    pub(super) fn update(
        &mut self,
        sight: Sight,
        reaches: &[Reaches],
        available: &[u8],
        changed: &[GroupId],
        now: f64,
    ) {
        self.switches.clear();
        let known = self.groups.len();
        self.groups.resize(reaches.len(), InView::UNKNOWN);
        let staying = if sight.dwell > 0.0 { reaches.len() } else { 0 };
        self.stays_until.resize(staying, f64::NEG_INFINITY);
        self.due.resize(reaches.len(), f64::NEG_INFINITY);
        self.block_due.resize(reaches.len().div_ceil(BLOCK), f64::NEG_INFINITY);
        if reaches.len() > known {
            self.block_due[known / BLOCK..].fill(f64::NEG_INFINITY);
        }

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
            self.moved += way.length() * (1.0 + f64::from(f32::EPSILON));
        } else {
            self.block_due.fill(f64::NEG_INFINITY);
            self.due.fill(f64::NEG_INFINITY);
        }
        for &group in changed {
            let place = group as usize;
            (self.due[place], self.block_due[place / BLOCK]) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
            if reaches[place].levels == 0 {
                self.groups[place] = InView::UNKNOWN;
                if let Some(until) = self.stays_until.get_mut(place) {
                    *until = f64::NEG_INFINITY;
                }
            }
        }

        for block in 0..self.block_due.len() {
            if self.block_due[block] > self.moved {
                continue;
            }
            let groups = block * BLOCK..reaches.len().min((block + 1) * BLOCK);
            let mut earliest = f64::INFINITY;
            for group in groups {
                if self.due[group] <= self.moved {
                    self.due[group] = self.look(group, &sight, &reaches[group], available[group], now);
                }
                earliest = earliest.min(self.due[group]);
            }
            self.block_due[block] = earliest;
        }
    }

    /// Looks at one group; returns when to look again.
    fn look(&mut self, group: usize, sight: &Sight, reaches: &Reaches, available: u8, now: f64) -> f64 {
        if reaches.levels == 0 {
            return f64::INFINITY;
        }
        let state = &mut self.groups[group];
        let known = (state.wanted != UNKNOWN).then_some(state.wanted);
        let choice = reaches.choose(&sight.lens, sight.eye, known.unwrap_or(0), sight.stay);
        let until = self.stays_until.get_mut(group);
        if known.is_some_and(|known| known != choice.level) && until.as_ref().is_some_and(|until| now < **until) {
            return f64::NEG_INFINITY;
        }
        if known != Some(choice.level) {
            state.wanted = choice.level;
            if let Some(until) = until {
                *until = now + sight.dwell;
            }
        }
        let shown = stand_in(choice.level, available);
        if shown != state.shown {
            self.switches.push(Switch {
                group: group as GroupId,
                from: (state.shown != UNKNOWN).then_some(state.shown),
                to: shown,
            });
            state.shown = shown;
        }
        self.moved + f64::from(choice.slack)
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
