//! How far a build has come, and how to stop it.

use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};

/// How far a build on another thread has come, and the means to call it off. To be shared with it, by an `Arc` for example.
#[derive(Debug, Default)]
pub struct BuildProgress {
    /// The bits of a number that is not negative: they grow as it does.
    fraction: AtomicU32,
    is_cancelled: AtomicBool,
}

impl BuildProgress {
    /// What part of the build is done, about: from 0 to 1, never less than before, and 1 only when all is done.
    pub fn fraction(&self) -> f32 {
        f32::from_bits(self.fraction.load(Ordering::Relaxed))
    }

    /// Calls the build off: it soon returns, with nothing.
    pub fn cancel(&self) {
        self.is_cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether the build was called off.
    pub fn is_cancelled(&self) -> bool {
        self.is_cancelled.load(Ordering::Relaxed)
    }

    /// Says that so much is done.
    pub(crate) fn reach(&self, fraction: f32) {
        self.fraction.fetch_max(fraction.to_bits(), Ordering::Relaxed);
    }
}

/// A build was called off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Cancelled;

/// A part of a build, on any number of threads.
#[derive(Debug)]
pub(crate) struct Stage<'a> {
    progress: Option<&'a BuildProgress>,
    from: f32,
    to: f32,
    total: usize,
    done: AtomicU64,
}

impl<'a> Stage<'a> {
    /// The part from one fraction of the build to another, of `total` steps.
    pub(crate) fn new(progress: Option<&'a BuildProgress>, from: f32, to: f32, total: usize) -> Self {
        Self {
            progress,
            from,
            to,
            total,
            done: AtomicU64::new(0),
        }
    }

    /// Says that so many more steps are done.
    pub(crate) fn advance(&self, steps: usize) -> Result<(), Cancelled> {
        let Some(progress) = self.progress else {
            return Ok(());
        };
        if progress.is_cancelled() {
            return Err(Cancelled);
        }
        let done = self.done.fetch_add(steps as u64, Ordering::Relaxed) + steps as u64;
        let part = (done as f32 / self.total.max(1) as f32).min(1.0);
        progress.reach(self.from + (self.to - self.from) * part);
        Ok(())
    }
}
