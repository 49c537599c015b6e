//! Crowds of like-sized boxes: who is near whom.

use bevy::math::bounding::BoundingSphere;
use parry3d::partitioning::BvhBuildStrategy;

use super::{
    OURS, ours,
    overlaps::find,
    peers::{bvh, obvhs, parry, rstar},
    race::race,
    scenes::{MakeScene, Scene},
};
use crate::Effort;

/// Boxes that look around themselves in a turn.
const TURN: usize = 256;

pub(crate) fn run(effort: Effort) {
    for make in [Scene::flat_crowd as MakeScene, Scene::crowd_in_space] {
        for &(size, n) in effort.sizes() {
            let scene = make(n);
            let boxes = &scene.boxes;
            let ours = ours::grid(boxes);
            let obvhs = obvhs::Binary::build(boxes);
            let parry = parry::Parry::build(boxes, BvhBuildStrategy::Binned);
            let flat = bvh::Flat::build(boxes);
            let rstar = rstar::Rstar::build(boxes);
            let tree = ours::tree(boxes);
            let spheres: Vec<BoundingSphere> = scene.query_spheres(TURN * effort.turns());
            let mut sides = [
                find(OURS, &ours),
                find(obvhs::BINARY, &obvhs),
                find(parry::BINNED, &parry),
                find(bvh::NAME, &flat),
                find(rstar::NAME, &rstar),
            ];
            let case = format!("neighbours/{}-{size}", scene.name);
            race(&case, TURN, &spheres, &mut sides, |a, b| a == b);
            let mut sides = [find(OURS, &ours), find("our tree", &tree)];
            race(&(case + "-tree"), TURN, &spheres, &mut sides, |a, b| a == b);
        }
    }
}
