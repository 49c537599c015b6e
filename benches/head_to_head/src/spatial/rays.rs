//! Rays through boxes: the first, any, and all.

use bevy_sightline::geometry::ray::Ray;
use parry3d::partitioning::BvhBuildStrategy;

use super::{
    OURS, ours,
    peers::{bvh, obvhs, parry},
    queries::{RayQueries, same_parameter},
    race::{Side, race},
    scenes::{MakeScene, Scene},
};
use crate::Effort;

/// Rays in a turn: a turn is so short that few are interrupted on a busy machine.
pub(crate) const TURN: usize = 512;

/// One that is raced, by its name.
type Named = (&'static str, Box<dyn RayQueries>);

pub(crate) fn run(effort: Effort) {
    for make in [Scene::uniform as MakeScene, Scene::city] {
        for &(size, n) in effort.sizes() {
            let scene = make(n);
            let boxes = &scene.boxes;
            let peers: Vec<Named> = vec![
                (OURS, Box::new(ours::best_tree(boxes))),
                (obvhs::BINARY, Box::new(obvhs::Binary::build(boxes))),
                (obvhs::WIDE, Box::new(obvhs::Wide::build(boxes))),
                (
                    parry::BINNED,
                    Box::new(parry::Parry::build(boxes, BvhBuildStrategy::Binned)),
                ),
                (
                    parry::PLOC,
                    Box::new(parry::Parry::build(boxes, BvhBuildStrategy::Ploc)),
                ),
                (bvh::NAME, Box::new(bvh::Flat::build(boxes))),
            ];
            race_all(&scene, size, "", peers, effort);
            #[cfg(feature = "embree")]
            {
                use super::embree::{Embree, NAME};
                let sides: Vec<Named> = vec![
                    (OURS, Box::new(ours::best_tree(boxes))),
                    (NAME, Box::new(Embree::build(boxes))),
                ];
                race_all(&scene, size, "-embree", sides, effort);
            }
        }
    }
}

fn race_all(scene: &Scene, size: &str, suffix: &str, sides: Vec<Named>, effort: Effort) {
    let random = scene.random_rays(TURN * effort.turns());
    let camera = scene.camera_rays(TURN * effort.turns());
    let case = |name| format!("rays/{name}-{}-{size}{suffix}", scene.name);
    race(
        &case("closest-random"),
        TURN,
        &random,
        &mut by(&sides, |side, ray| side.closest(ray)),
        same_parameter,
    );
    race(
        &case("closest-camera"),
        TURN,
        &camera,
        &mut by(&sides, |side, ray| side.closest(ray)),
        same_parameter,
    );
    race(
        &case("any"),
        TURN,
        &random,
        &mut by(&sides, |side, ray| side.any(ray)),
        |a, b| a == b,
    );
    race(
        &case("all"),
        TURN,
        &random,
        &mut by(&sides, |side, ray| side.all(ray)),
        |a, b| a == b,
    );
}

fn by<'a, A: 'a>(sides: &'a [Named], query: fn(&dyn RayQueries, &Ray) -> A) -> Vec<Side<'a, Ray, A>> {
    let side = |(name, side): &'a Named| Side::new(name, move |ray| query(&**side, ray));
    sides.iter().map(side).collect()
}
