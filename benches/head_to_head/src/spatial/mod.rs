//! The spatial structures against their peers: boxes with keys, and nothing behind them.
//!
//! All peers that can do the same work run in turn with ours, with the same queries, in one thread and a default build,
//! and all answers are compared. A row names the best of them; the line below it, which begins with `#`, gives all.

pub(crate) mod build;
pub(crate) mod choosing;
#[cfg(feature = "embree")]
mod embree;
pub(crate) mod memory;
mod motion;
pub(crate) mod nearest;
pub(crate) mod neighbours;
mod ours;
pub(crate) mod overlaps;
pub(crate) mod peers;
mod probes;
mod queries;
pub(crate) mod race;
pub(crate) mod rays;
mod scenes;
pub(crate) mod updates;

use crate::Effort;

/// The name of our side.
pub(crate) const OURS: &str = "bevy_sightline";

impl Effort {
    /// The numbers of boxes, with their names.
    fn sizes(self) -> &'static [(&'static str, usize)] {
        const SIZES: [(&str, usize); 4] = [("1k", 1_000), ("10k", 10_000), ("100k", 100_000), ("1M", 1_000_000)];
        match self {
            Self::Quick => &SIZES[..2],
            Self::Full => &SIZES,
        }
    }

    /// How many turns a race takes.
    fn turns(self) -> usize {
        match self {
            Self::Quick => 40,
            Self::Full => 120,
        }
    }
}
