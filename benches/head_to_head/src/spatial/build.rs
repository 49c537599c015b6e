//! Building from nothing.

use ::obvhs::BvhBuildParams;
use bevy::math::bounding::Aabb3d;
use bevy_sightline::{geometry::ray::Ray, spatial::BuildStrategy};
use parry3d::partitioning::BvhBuildStrategy;

use super::{
    OURS, ours,
    peers::{bvh, obvhs, parry, rstar},
    queries::{RayQueries, same_parameter},
    race::{Side, race},
    rays::TURN,
    scenes::{MakeScene, Scene},
};
use crate::Effort;

pub(crate) fn run(effort: Effort) {
    for make in [Scene::uniform as MakeScene, Scene::city] {
        for &(size, n) in effort.sizes() {
            run_in(&make(n), size, effort);
        }
    }
}

fn run_in(scene: &Scene, size: &str, effort: Effort) {
    let rounds = (3_000_000 / scene.boxes.len()).clamp(3, 40);
    let queries = vec![scene.boxes.as_slice(); rounds];
    let case = format!("build/{}-{size}", scene.name);
    let mut sides = [
        side(OURS, ours::tree),
        side("obvhs 0.4 Bvh2, fast", |boxes| {
            obvhs::build(boxes, BvhBuildParams::fast_build())
        }),
        side("obvhs 0.4 Bvh2, medium", |boxes| {
            obvhs::build(boxes, BvhBuildParams::medium_build())
        }),
        side("obvhs 0.4 Bvh2, fastest", |boxes| {
            obvhs::build(boxes, BvhBuildParams::fastest_build())
        }),
        side(parry::BINNED, |boxes| parry::build(boxes, BvhBuildStrategy::Binned)),
        side(parry::PLOC, |boxes| parry::build(boxes, BvhBuildStrategy::Ploc)),
        side(bvh::NAME, bvh::Flat::build),
        side(rstar::NAME, rstar::Rstar::build),
    ];
    race(&case, 1, &queries, &mut sides, |a, b| a == b);

    for (strategy, name) in [
        (BuildStrategy::MiddleSplit, "middle-split"),
        (BuildStrategy::MedianSplit, "median-split"),
        (BuildStrategy::BinnedSah, "binned-sah"),
        (BuildStrategy::Ploc, "ploc"),
    ] {
        run_again(
            scene,
            strategy,
            &format!("{name}-{}-{size}", scene.name),
            rounds,
            effort,
        );
    }

    #[cfg(feature = "embree")]
    {
        let mut sides = [
            side(OURS, ours::tree),
            side(super::embree::NAME, super::embree::Embree::build),
        ];
        race(&(case + "-embree"), 1, &queries, &mut sides, |a, b| a == b);
    }
}

/// A side that builds, and answers with nothing: what it builds is dropped in its time.
fn side<'a, T>(name: &'static str, build: impl Fn(&[Aabb3d]) -> T + 'a) -> Side<'a, &'a [Aabb3d], ()> {
    Side::new(name, move |boxes: &&[Aabb3d]| {
        std::hint::black_box(build(boxes));
    })
}

/// Building anew by one of our strategies, and rays through what that gives.
fn run_again(scene: &Scene, strategy: BuildStrategy, names: &str, rounds: usize, effort: Effort) {
    let mut tree = ours::tree(&scene.boxes);
    let rebuild = |_: &()| {
        tree.rebuild_with(strategy);
    };
    let mut sides = [
        Side::new(OURS, rebuild),
        Side::new("obvhs 0.4 Bvh2, fastest", |()| {
            std::hint::black_box(obvhs::build(&scene.boxes, BvhBuildParams::fastest_build()));
        }),
    ];
    race(&format!("build/{names}"), 1, &vec![(); rounds], &mut sides, |a, b| {
        a == b
    });
    drop(sides);

    let peer = obvhs::Binary::build_with(&scene.boxes, BvhBuildParams::fastest_build());
    let mut sides = [closest(OURS, &tree), closest("obvhs 0.4 Bvh2, fastest", &peer)];
    let rays = scene.random_rays(TURN * effort.turns() / 2);
    race(
        &format!("build/closest-{names}"),
        TURN,
        &rays,
        &mut sides,
        same_parameter,
    );
}

fn closest<'a>(name: &'static str, queries: &'a impl RayQueries) -> Side<'a, Ray, Option<f32>> {
    Side::new(name, |ray| queries.closest(ray))
}
