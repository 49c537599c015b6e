//! `bevy_sightline` against its peers.
//!
//! ```sh
//! cargo run --release -p head_to_head              # all groups
//! cargo run --release -p head_to_head -- picking   # one group
//! cargo run --release -p head_to_head -- --quick   # smaller scenes, for a first look
//! ```
//!
//! Every case runs both sides in turn in one process, checks that both gave the same answers, and prints one line,
//! tab separated:
//!
//! ```text
//! RATIO   <group>/<case>   <ours, ns>   <peer, ns>   <peer / ours>   <peer>
//! ```
//!
//! Times are medians. A ratio over 1 means that we are faster.

mod allocated;
mod bounding;
mod compare;
#[cfg(feature = "embree")]
mod embree;
mod geometry;
mod headless;
mod mesh;
mod mesh_mesh;
mod overhead;
mod picking;
mod spatial;
mod sprites;
mod sync;
mod visibility;

use std::process::ExitCode;

/// The groups, in the order in which they run.
const GROUPS: [(&str, fn(Effort)); 18] = [
    ("bounding", bounding::run),
    ("build", spatial::build::run),
    ("choosing", spatial::choosing::run),
    ("culling", visibility::culling::run),
    ("geometry", geometry::run),
    ("lights", visibility::lights::run),
    ("lod", visibility::lod::run),
    ("memory", spatial::memory::run),
    ("mesh", mesh::run),
    ("nearest", spatial::nearest::run),
    ("neighbours", spatial::neighbours::run),
    ("occlusion", visibility::occlusion::run),
    ("overhead", overhead::run),
    ("overlaps", spatial::overlaps::run),
    ("picking", picking::run),
    ("rays", spatial::rays::run),
    ("sync", sync::run),
    ("updates", spatial::updates::run),
];

/// How much to measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Effort {
    /// Small scenes only.
    Quick,
    /// Everything.
    Full,
}

fn main() -> ExitCode {
    let (options, names): (Vec<String>, Vec<String>) = std::env::args().skip(1).partition(|arg| arg.starts_with("--"));
    let unknown_option = options.iter().find(|option| *option != "--quick");
    let unknown_group = names.iter().find(|name| GROUPS.iter().all(|(group, _)| group != name));
    if let Some(unknown) = unknown_option.or(unknown_group) {
        eprintln!(
            "unknown: {unknown}; there are --quick and the groups {:?}",
            GROUPS.map(|(group, _)| group)
        );
        return ExitCode::FAILURE;
    }
    let effort = if options.is_empty() {
        Effort::Full
    } else {
        Effort::Quick
    };
    for (group, run) in GROUPS {
        if names.is_empty() || names.iter().any(|name| name == group) {
            run(effort);
        }
    }
    ExitCode::SUCCESS
}
