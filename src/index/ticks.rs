//! What has changed in a table, found many rows at once.

use std::ops::Range;

use bevy::ecs::{
    change_detection::{ContiguousRef, MAX_CHANGE_AGE, Tick},
    component::Component,
    entity::Entity,
    lifecycle::RemovedComponents,
};

use crate::spatial::simd::{Simd, Task, dispatch, prefetch};

/// The rows of a table that are looked at one by one where one of them is new: one bit for each.
const BLOCK: usize = u64::BITS as usize;

/// The rows that are looked at together: mostly, none of them is new.
const STRIDE: usize = 16 * BLOCK;

/// So many ticks are brought close at once.
const TICKS_PER_LINE: usize = 64 / size_of::<Tick>();

/// The time since a system has last looked.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Since {
    this_run: u32,
    /// Ticks are new that are younger.
    age: u32,
}

impl Since {
    /// Since the system that reads this column ran.
    pub fn last_read<T>(column: &ContiguousRef<T>) -> Self {
        let (last_run, this_run) = (column.last_run_tick().get(), column.this_run_tick().get());
        Self {
            this_run,
            age: this_run.wrapping_sub(last_run).min(MAX_CHANGE_AGE),
        }
    }

    /// Since the system that reads this column ran, or since `seen` if it has not looked at the column from then on.
    pub fn last_looked<T>(column: &ContiguousRef<T>, seen: Option<Tick>) -> Self {
        let since = Self::last_read(column);
        let age = seen.map_or(MAX_CHANGE_AGE, |seen| since.this_run.wrapping_sub(seen.get()));
        Self {
            age: age.min(MAX_CHANGE_AGE),
            ..since
        }
    }

    /// [`Tick::is_newer_than`].
    #[inline(always)]
    pub fn is_newer(self, tick: Tick) -> bool {
        self.this_run.wrapping_sub(tick.get()) < self.age
    }

    /// Which of the ticks, as many as a number has bits, are newer.
    pub fn newer(self, ticks: &[Tick]) -> u64 {
        let rows = ticks.iter().enumerate();
        rows.fold(0, |newer, (row, &tick)| newer | u64::from(self.is_newer(tick)) << row)
    }

    /// The parts of some rows of a table, as long as a number has bits, in which some tick of some column is newer.
    pub fn blocks_with_newer<'a>(
        self,
        columns: &'a [&'a [Tick]],
        rows: Range<usize>,
    ) -> impl Iterator<Item = Range<usize>> + 'a {
        let any_newer = move |rows: &Range<usize>| {
            columns.iter().any(|ticks| {
                // Mostly all rows are looked at, one stretch after the other, and their memory is waited for.
                for line in ticks[rows.end..].iter().take(STRIDE).step_by(TICKS_PER_LINE) {
                    prefetch(line);
                }
                dispatch(AnyNewer {
                    since: self,
                    ticks: &ticks[rows.clone()],
                })
            })
        };
        parts(rows, STRIDE)
            .filter(any_newer)
            .flat_map(|stride| parts(stride, BLOCK))
            .filter(any_newer)
    }
}

impl Since {
    /// Adds the entities of a table to `found` in whose row some tick of some column is newer.
    pub fn collect(self, entities: &[Entity], columns: &[&[Tick]], found: &mut Vec<Entity>) {
        for block in self.blocks_with_newer(columns, 0..entities.len()) {
            let newer = columns.iter().map(|ticks| self.newer(&ticks[block.clone()]));
            let newer = newer.fold(0, |all, newer| all | newer);
            found.extend(ones(newer).map(|row| entities[block.start + row as usize]));
        }
    }
}

/// Whether any tick is newer: many at once.
struct AnyNewer<'a> {
    since: Since,
    ticks: &'a [Tick],
}

impl Task for AnyNewer<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> bool {
        let mut any = 0;
        for tick in self.ticks {
            any |= u32::from(self.since.is_newer(*tick));
        }
        any != 0
    }
}

/// Rows, cut into parts of some length.
fn parts(rows: Range<usize>, len: usize) -> impl Iterator<Item = Range<usize>> {
    let end = rows.end;
    rows.step_by(len).map(move |start| start..end.min(start + len))
}

/// When each value of a column was changed, if the table has it.
pub(crate) fn changed<T>(column: Option<ContiguousRef<'_, T>>) -> Option<&'_ [Tick]> {
    column.map(|column| column.changed_ticks_slice())
}

/// When each value of a column was added, if the table has it.
pub(crate) fn added<T>(column: Option<ContiguousRef<'_, T>>) -> Option<&'_ [Tick]> {
    column.map(|column| column.added_ticks_slice())
}

/// The places of the bits that are set.
#[inline]
pub(crate) fn ones(mut bits: u64) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let place = (bits != 0).then(|| bits.trailing_zeros());
        bits &= bits.wrapping_sub(1);
        place
    })
}

/// Whether Bevy has forgotten some removals before they could be read, after a pause of some frames.
pub(crate) fn misses<T: Component>(removed: &RemovedComponents<T>) -> bool {
    let cursor = removed.reader();
    removed
        .messages()
        .is_some_and(|messages| cursor.missed_messages(messages) > 0)
}
