//! What has changed in a table, found many rows at once.

use std::ops::Range;

use bevy::ecs::change_detection::{ContiguousRef, Tick};

/// The rows of a table that are looked at together: one bit for each.
pub(crate) const BLOCK: usize = u64::BITS as usize;

/// The time since a system has last looked.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Since {
    pub last_run: Tick,
    pub this_run: Tick,
}

impl Since {
    /// Since the system that reads this column ran.
    pub fn last_read<T>(column: &ContiguousRef<T>) -> Self {
        Self {
            last_run: column.last_run_tick(),
            this_run: column.this_run_tick(),
        }
    }

    /// Which of up to [`BLOCK`] ticks are newer, bit by bit.
    pub fn newer(self, ticks: &[Tick]) -> u64 {
        let is_new = |tick: &Tick| tick.is_newer_than(self.last_run, self.this_run);
        // Without a branch, many at once.
        if !ticks.iter().fold(false, |any, tick| any | is_new(tick)) {
            return 0;
        }
        let rows = ticks.iter().enumerate();
        rows.fold(0, |changed, (row, tick)| changed | u64::from(is_new(tick)) << row)
    }
}

/// When each value of a column was changed, if the table has it.
pub(crate) fn changed<T>(column: Option<ContiguousRef<'_, T>>) -> Option<&'_ [Tick]> {
    column.map(|column| column.changed_ticks_slice())
}

/// When each value of a column was added, if the table has it.
pub(crate) fn added<T>(column: Option<ContiguousRef<'_, T>>) -> Option<&'_ [Tick]> {
    column.map(|column| column.added_ticks_slice())
}

/// Some rows of a table, block by block.
pub(crate) fn blocks(rows: Range<usize>) -> impl Iterator<Item = Range<usize>> {
    let end = rows.end;
    rows.step_by(BLOCK).map(move |start| start..end.min(start + BLOCK))
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
