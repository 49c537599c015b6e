//! Timing the phases of a frame, for stats and for `tracing`.

use std::time::{Duration, Instant};

use tracing::span::EnteredSpan;

/// A phase that has begun, within a span; both end together. Made by [`phase!`].
pub(crate) struct Phase {
    start: Instant,
    _span: EnteredSpan,
}

impl Phase {
    pub fn begin(span: EnteredSpan) -> Self {
        Self {
            start: Instant::now(),
            _span: span,
        }
    }

    /// Ends it; returns the time that it took.
    pub fn end(self) -> Duration {
        self.start.elapsed()
    }

    /// Adds the time that it takes to `total` when it is dropped.
    pub fn adds_to(self, total: &mut Duration) -> impl Drop + '_ {
        Adding { phase: self, total }
    }
}

struct Adding<'a> {
    phase: Phase,
    total: &'a mut Duration,
}

impl Drop for Adding<'_> {
    fn drop(&mut self) {
        *self.total += self.phase.start.elapsed();
    }
}

/// Begins a [`Phase`] in a span of this name: of level debug, which Bevy's `LogPlugin` leaves out unless it is asked for.
macro_rules! phase {
    ($name:literal) => {
        $crate::phase::Phase::begin(tracing::debug_span!($name).entered())
    };
}

pub(crate) use phase;
