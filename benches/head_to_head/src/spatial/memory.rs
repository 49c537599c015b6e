//! The bytes that each structure has allocated for a box: the figures of the rows are bytes.
//!
//! Those of the peers come with the boxes, where their trees have only indices of them in the leaves.

use bevy_sightline::spatial::SpatialQueries;
use parry3d::partitioning::BvhBuildStrategy;

use super::{
    OURS, ours,
    peers::{bvh, obvhs, parry},
    race::report,
    scenes::{MakeScene, Scene},
};
use crate::Effort;

pub(crate) fn run(effort: Effort) {
    for make in [Scene::uniform as MakeScene, Scene::city] {
        for &(size, n) in effort.sizes() {
            let scene = make(n);
            let boxes = &scene.boxes;
            let bytes = [
                (OURS, ours::tree(boxes).memory()),
                (obvhs::BINARY, obvhs::Binary::build(boxes).memory()),
                (obvhs::WIDE, obvhs::Wide::build(boxes).memory()),
                (
                    parry::BINNED,
                    parry::Parry::build(boxes, BvhBuildStrategy::Binned).memory(),
                ),
                (bvh::NAME, bvh::Flat::build(boxes).memory()),
            ];
            let per_box = |(name, bytes)| (name, bytes as f64 / n as f64);
            report(
                &format!("memory/{}-{size}", scene.name),
                bytes.into_iter().map(per_box).collect(),
            );
        }
    }
}
