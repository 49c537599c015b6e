//! Building from a list of triangles, at equal quality.
//!
//! The quality of a tree is the rate of incoherent rays through it. The peer of a row is the build that takes the least
//! time of those whose rays take no more than a tenth longer than ours; where there is none, the one with the fastest
//! rays. The lines below the row give all builds, with their rays.

use bevy_sightline::geometry::ray::Ray;
use obvhs::BvhBuildParams;

use super::{
    Hit, MeshRays, Named, TURN, by,
    models::Model,
    ours,
    peers::{bvh::Flat, obvhs as peer, parry::Parry},
    rays, same,
};
use crate::{
    Effort,
    spatial::{
        OURS,
        race::{Side, measure, report},
    },
};

/// How a tree is built: anew at every call.
type Build<'a> = Box<dyn Fn() -> Box<dyn MeshRays> + 'a>;

/// How much longer rays may take through a tree of equal quality.
const EQUAL: f64 = 1.1;

const BINARY: [(&str, BvhBuildParams); 5] = [
    ("obvhs 0.4 Bvh2, fastest", BvhBuildParams::fastest_build()),
    ("obvhs 0.4 Bvh2, very fast", BvhBuildParams::very_fast_build()),
    ("obvhs 0.4 Bvh2, fast", BvhBuildParams::fast_build()),
    ("obvhs 0.4 Bvh2, medium", BvhBuildParams::medium_build()),
    ("obvhs 0.4 Bvh2, slow", BvhBuildParams::slow_build()),
];

const WIDE: [(&str, BvhBuildParams); 5] = [
    (
        "obvhs 0.4 CwBvh, fastest",
        three_to_a_leaf(BvhBuildParams::fastest_build()),
    ),
    ("obvhs 0.4 CwBvh, very fast", BvhBuildParams::very_fast_build()),
    ("obvhs 0.4 CwBvh, fast", BvhBuildParams::fast_build()),
    ("obvhs 0.4 CwBvh, medium", BvhBuildParams::medium_build()),
    ("obvhs 0.4 CwBvh, slow", BvhBuildParams::slow_build()),
];

/// With one to a leaf, which is what the preset says, the wide tree is larger, and made no faster.
const fn three_to_a_leaf(params: BvhBuildParams) -> BvhBuildParams {
    BvhBuildParams {
        max_prims_per_leaf: 3,
        ..params
    }
}

pub(crate) fn run(model: &Model, _: Effort) {
    let our_source = ours::source(model);
    let source = peer::source(model);
    let ours = |fast: bool| -> (&'static str, Build) {
        let build = if fast { ours::build_fast } else { ours::build };
        let source = &our_source;
        (OURS, Box::new(move || Box::new(build(source))))
    };
    let source = &source;
    for (case, fast) in [("build", false), ("build-fast", true)] {
        let mut builds = vec![ours(fast)];
        for (name, params) in BINARY {
            let build = move || -> Box<dyn MeshRays> { Box::new(peer::Binary::build_from(source, params)) };
            builds.push((name, Box::new(build)));
        }
        for (name, params) in WIDE {
            let build = move || -> Box<dyn MeshRays> { Box::new(peer::Wide::build_from(source, params)) };
            builds.push((name, Box::new(build)));
        }
        builds.push(("parry3d 0.31", Box::new(|| Box::new(Parry::build(model)))));
        builds.push(("bvh 0.13 flat", Box::new(|| Box::new(Flat::build(model)))));
        race_builds(model, &format!("mesh/{case}-{}", model.name), &builds);

        #[cfg(feature = "embree")]
        {
            let mut builds = vec![ours(fast)];
            builds.extend(super::embree::Embree::builds(model, fast));
            race_builds(model, &format!("mesh/{case}-{}-embree", model.name), &builds);
        }
    }
}

fn race_builds(model: &Model, case: &str, builds: &[(&'static str, Build)]) {
    let rounds = (1_000_000 / model.triangles.len()).clamp(3, 8);
    let mut sides: Vec<Side<(), ()>> = (builds.iter())
        .map(|(name, build)| Side::new(name, |()| drop(build())))
        .collect();
    let times = measure(case, 1, &vec![(); rounds], &mut sides, |(), ()| true);
    drop(sides);

    let built = (builds.iter()).map(|(name, build)| Named {
        name,
        rays: build(),
        bytes: 0,
    });
    let built: Vec<Named> = built.collect();
    let incoherent = rays::incoherent(model, 20 * TURN);
    let mut sides: Vec<Side<Ray, Option<Hit>>> = by(&built, |side, ray| side.closest(ray));
    let rays = measure(case, TURN, &incoherent, &mut sides, |a, b| same(model, a, b));

    let both = || times.iter().copied().zip(rays.iter().map(|&(_, ns)| ns));
    let (ours, of_ours) = (times[0], rays[0].1);
    let peers = || both().skip(1);
    let equal = peers().filter(|&(_, ns)| ns <= EQUAL * of_ours);
    let peer = equal
        .min_by(|a, b| a.0.1.total_cmp(&b.0.1))
        .or_else(|| peers().min_by(|a, b| a.1.total_cmp(&b.1)));
    let (peer, _) = peer.expect("peers");
    report(case, vec![ours, peer]);
    for ((name, time), ns) in both() {
        println!("#\t{case}\t{:.1} ms, then {ns:.0} ns a ray\t{name}", time / 1e6);
    }
}
