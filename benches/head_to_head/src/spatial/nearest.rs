//! The nearest boxes and the nearest points from a point.

use bevy::math::{Vec3A, bounding::Aabb3d};
use parry3d::partitioning::BvhBuildStrategy;

use super::{
    OURS, ours,
    peers::{bvh, kiddo, obvhs, parry, rstar},
    queries::{NearQueries, Scratch, same_distances},
    race::{Side, race},
    scenes::{MakeScene, Scene},
};
use crate::Effort;

/// Queries in a turn.
const TURN: usize = 256;

pub(crate) fn run(effort: Effort) {
    for make in [Scene::uniform as MakeScene, Scene::city] {
        for &(size, n) in effort.sizes() {
            let scene = make(n);
            let queries = scene.points(TURN * effort.turns());
            let names = [scene.name, size];
            run_in("boxes", &scene.boxes, names, &queries);
            let points = scene.boxes.iter().map(|aabb| {
                let middle = (aabb.min + aabb.max) / 2.0;
                Aabb3d {
                    min: middle,
                    max: middle,
                }
            });
            run_in("points", &points.collect::<Vec<_>>(), names, &queries);
        }
    }
}

fn run_in(what: &str, boxes: &[Aabb3d], names: [&str; 2], queries: &[Vec3A]) {
    let ours = ours::tree(boxes);
    let obvhs = obvhs::Binary::build(boxes);
    let parry = parry::Parry::build(boxes, BvhBuildStrategy::Binned);
    let flat = bvh::Flat::build(boxes);
    let rstar = rstar::Rstar::build(boxes);
    let of_points = (what == "points").then(|| (ours::point_tree(boxes), kiddo::Kiddo::build(boxes)));
    macro_rules! race_for {
        ($number:literal, $name:literal) => {
            let mut sides = vec![
                nearest::<$number>(OURS, &ours),
                nearest(obvhs::BINARY, &obvhs),
                nearest(parry::BINNED, &parry),
                nearest(bvh::NAME, &flat),
                nearest(rstar::NAME, &rstar),
            ];
            sides.extend(of_points.iter().map(|(_, kiddo)| nearest(kiddo::NAME, kiddo)));
            let [scene, size] = names;
            let case = format!("nearest/{}-{what}-{scene}-{size}", $name);
            race(&case, TURN, queries, &mut sides, same_distances);
            // The trees that have points only.
            if let Some((ours, kiddo)) = &of_points {
                let mut sides = [nearest::<$number>(OURS, ours), nearest(kiddo::NAME, kiddo)];
                race(&(case + "-kd-tree"), TURN, queries, &mut sides, same_distances);
            }
        };
    }
    race_for!(8, "k8");
    race_for!(1, "one");
}

fn nearest<'a, const N: usize>(name: &'static str, queries: &'a impl NearQueries) -> Side<'a, Vec3A, [f32; N]> {
    let mut scratch = Scratch::new();
    Side::new(name, move |point| queries.nearest(*point, &mut scratch))
}
