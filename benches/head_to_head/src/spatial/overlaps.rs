//! Boxes that touch a region, and pairs of boxes that touch.

use parry3d::partitioning::BvhBuildStrategy;

use super::{
    OURS, ours,
    peers::{bvh, obvhs, parry, rstar},
    probes::{FrustumProbe, LargeBox, ObbProbe, Probe},
    queries::{Found, PairQueries, RegionQueries},
    race::{Side, race},
    scenes::{MakeScene, Scene},
};
use crate::Effort;

/// Queries in a turn.
const TURN: usize = 256;

pub(crate) fn run(effort: Effort) {
    for make in [Scene::uniform as MakeScene, Scene::city] {
        for &(size, n) in effort.sizes() {
            Field::new(make(n)).run(size, effort);
        }
    }
}

/// A scene in every structure.
struct Field {
    ours: ours::Tree,
    obvhs: obvhs::Binary,
    parry: parry::Parry,
    flat: bvh::Flat,
    rstar: rstar::Rstar,
    scene: Scene,
}

impl Field {
    fn new(scene: Scene) -> Self {
        Self {
            ours: ours::tree(&scene.boxes),
            obvhs: obvhs::Binary::build(&scene.boxes),
            parry: parry::Parry::build(&scene.boxes, BvhBuildStrategy::Binned),
            flat: bvh::Flat::build(&scene.boxes),
            rstar: rstar::Rstar::build(&scene.boxes),
            scene,
        }
    }

    fn run(&self, size: &str, effort: Effort) {
        let (scene, n) = (&self.scene, self.scene.boxes.len());
        let case = |name| format!("overlaps/{name}-{}-{size}", scene.name);
        let small = TURN * effort.turns();
        self.find(&case("box"), TURN, &scene.query_boxes(small, 1.0));
        self.find(&case("sphere"), TURN, &scene.query_spheres(small));
        let obbs: Vec<_> = scene.query_obbs(small).into_iter().map(ObbProbe::new).collect();
        self.find(&case("obb"), TURN, &obbs);

        // What finds much: fewer in a turn.
        let turn = (1_000_000 / n).clamp(1, TURN / 4);
        let large = turn * effort.turns();
        let boxes = scene.query_boxes(large, 12.0).into_iter().map(LargeBox);
        self.find(&case("large-box"), turn, &boxes.collect::<Vec<_>>());
        let frusta = scene.frusta(large).into_iter().map(FrustumProbe::new);
        self.find(&case("frustum"), turn, &frusta.collect::<Vec<_>>());

        let rounds = (3_000_000 / n).clamp(5, 40);
        let mut sides = [
            pairs(OURS, &self.ours),
            pairs(obvhs::BINARY, &self.obvhs),
            pairs(parry::BINNED, &self.parry),
            pairs(rstar::NAME, &self.rstar),
        ];
        race(&case("pairs"), 1, &vec![(); rounds], &mut sides, |a, b| a == b);
    }

    fn find<P: Probe>(&self, case: &str, turn: usize, probes: &[P]) {
        let mut sides = [
            find(OURS, &self.ours),
            find(obvhs::BINARY, &self.obvhs),
            find(parry::BINNED, &self.parry),
            find(bvh::NAME, &self.flat),
            find(rstar::NAME, &self.rstar),
        ];
        race(case, turn, probes, &mut sides, |a, b| a == b);
    }
}

pub(crate) fn find<'a, P: Probe>(name: &'static str, queries: &'a impl RegionQueries) -> Side<'a, P, Found> {
    Side::new(name, |probe| queries.find(probe))
}

fn pairs<'a>(name: &'static str, queries: &'a impl PairQueries) -> Side<'a, (), Found> {
    Side::new(name, |()| queries.pairs())
}
