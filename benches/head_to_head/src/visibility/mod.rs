//! Whole visibility stages against Bevy's whole stages, each in an app of its own with the same world.
//!
//! A stage is timed where it stands in `PostUpdate`, under the executor of the app, between fixed points: after all that
//! is propagated and before the first system of the stage, to the end of the schedule. So whatever a side does for its
//! answer is counted, wherever it does it. Both use the same threads, and what they see is compared after every frame.
//!
//! Two things are not in the times: Bevy's propagation of `Visibility`, which both sides have and which has nothing to do
//! here, and how the index follows the world ([`SpatialIndexSystems`]), except where everything moves: there it is
//! counted in. Elsewhere a comment tells what it took, mostly to find out that nothing had moved.
//!
//! [`SpatialIndexSystems`]: bevy_sightline::index::SpatialIndexSystems

pub(crate) mod culling;
mod frames;
pub(crate) mod lights;
pub(crate) mod lod;
pub(crate) mod occlusion;
mod scene;
mod side;

use bevy::tasks::{ComputeTaskPool, TaskPool};

const PEER: &str = "bevy 0.19.1";

/// Makes sure that there are threads to work on before an app takes fewer: left to itself, Bevy keeps one of two cores
/// for other things and then runs its queries on one thread.
fn set_up_threads(group: &str) {
    let pool = ComputeTaskPool::get_or_init(TaskPool::default);
    println!("# {group}: {} threads", pool.thread_num());
}
