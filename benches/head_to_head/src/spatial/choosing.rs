//! Our structures against each other: the tables of the documentation of `spatial`, in Markdown.

use std::cell::RefCell;

use bevy::math::{
    Vec3A,
    bounding::{Aabb3d, BoundingSphere},
};
use bevy_sightline::spatial::{BruteForce, Octree, SpatialQueries, UniformGrid};

use super::{
    motion::{Motion, Movement},
    ours::{self, Holds, Moving, Static},
    probes::FrustumProbe,
    queries::{Found, NearQueries, PairQueries, RegionQueries, Scratch, same_distances, same_parameter},
    race::{Side, measure},
    scenes::{MakeScene, Scene},
    updates::{Upkeep, run_frames},
};
use crate::Effort;

/// Queries in a turn.
const TURN: usize = 256;

/// How each structure is made of boxes, and up to how many.
const STRUCTURES: [(&str, usize, MakeStructure); 5] = [
    ("`AabbTree`", usize::MAX, |boxes| Box::new(ours::moving_tree(boxes))),
    ("`UniformGrid`", usize::MAX, |boxes| {
        Box::new(Moving::new(UniformGrid::default(), boxes, |_| {}))
    }),
    ("`Octree`", usize::MAX, |boxes| {
        Box::new(Moving::new(Octree::new(), boxes, |_| {}))
    }),
    ("`KdTree`", usize::MAX, |boxes| {
        Box::new(Static::new(boxes, ours::kd_tree))
    }),
    ("`BruteForce`", 1_000, |boxes| {
        Box::new(Moving::new(BruteForce::new(), boxes, |_| {}))
    }),
];

type MakeStructure = fn(&[Aabb3d]) -> Box<dyn Structure>;

/// A structure by its name.
type Named = (&'static str, Box<dyn Structure>);

/// Medians by the names of the structures, in nanoseconds.
type Figures = Vec<(&'static str, f64)>;

/// What a structure is measured by.
trait Structure: Upkeep {
    fn sphere(&self, sphere: &BoundingSphere) -> Found;
    fn aabb(&self, aabb: &Aabb3d) -> Found;
    fn frustum(&self, frustum: &FrustumProbe) -> Found;
    fn eight_nearest(&self, point: Vec3A, scratch: &mut Scratch) -> [f32; 8];
    fn pairs(&self) -> Found;
    fn memory(&self) -> usize;
}

impl<T: Upkeep + Holds> Structure for T {
    fn sphere(&self, sphere: &BoundingSphere) -> Found {
        self.structure().find(sphere)
    }

    fn aabb(&self, aabb: &Aabb3d) -> Found {
        self.structure().find(aabb)
    }

    fn frustum(&self, frustum: &FrustumProbe) -> Found {
        self.structure().find(frustum)
    }

    fn eight_nearest(&self, point: Vec3A, scratch: &mut Scratch) -> [f32; 8] {
        self.structure().nearest(point, scratch)
    }

    fn pairs(&self) -> Found {
        PairQueries::pairs(self.structure())
    }

    fn memory(&self) -> usize {
        self.structure().memory()
    }
}

/// What is measured: the columns.
const COLUMNS: [&str; 11] = [
    "build",
    "1 % move",
    "10 % move",
    "100 % move",
    "closest ray",
    "sphere",
    "box",
    "8 nearest",
    "frustum",
    "all pairs",
    "bytes a box",
];

pub(crate) fn run(effort: Effort) {
    for make in [Scene::uniform as MakeScene, Scene::clustered, Scene::city, Scene::mixed] {
        println!("\n{}\n", make(1).name);
        println!("| structure | boxes | {} |", COLUMNS.join(" | "));
        println!("|---|---|{}", "---|".repeat(COLUMNS.len()));
        for &(size, n) in effort.sizes() {
            print(size, &figures(&make(n), effort));
        }
    }
}

/// The figures of each structure, column by column.
fn figures(scene: &Scene, effort: Effort) -> Vec<Figures> {
    let (boxes, n) = (scene.boxes.as_slice(), scene.boxes.len());
    let fitting = || STRUCTURES.iter().filter(|(_, most, _)| n <= *most);
    let mut all: Vec<Named> = fitting().map(|(name, _, make)| (*name, make(boxes))).collect();

    let turns = effort.turns() / 2;
    let builds = vec![boxes; (1_000_000 / n).clamp(3, turns)];
    let mut sides: Vec<_> = (fitting())
        .map(|&(name, _, make)| {
            Side::new(name, move |boxes: &&[Aabb3d]| {
                make(boxes);
            })
        })
        .collect();
    let build = measure("build", 1, &builds, &mut sides, |a, b| a == b);

    let few = (100_000 / n).clamp(1, 100);
    let spheres = scene.query_spheres(TURN * turns);
    let boxes = scene.query_boxes(TURN * turns, 1.0);
    let frusta: Vec<_> = scene.frusta(few * turns).into_iter().map(FrustumProbe::new).collect();
    let points = scene.points(TURN * turns);
    let scratch = RefCell::new(Scratch::new());
    let queries = [
        answers(
            &all,
            TURN,
            &scene.random_rays(TURN * turns),
            same_parameter,
            |s, ray| s.closest(ray),
        ),
        answers(&all, TURN, &spheres, Found::eq, |s, sphere| s.sphere(sphere)),
        answers(&all, TURN, &boxes, Found::eq, |s, aabb| s.aabb(aabb)),
        answers(&all, TURN, &points, same_distances, |s, point| {
            s.eight_nearest(*point, &mut scratch.borrow_mut())
        }),
        answers(&all, few, &frusta, Found::eq, |s, frustum| s.frustum(frustum)),
        answers(
            &all,
            1,
            &vec![(); (1_000_000 / n).clamp(3, turns)],
            Found::eq,
            |s, ()| s.pairs(),
        ),
        all.iter()
            .map(|(name, s)| (*name, s.memory() as f64 / n as f64))
            .collect(),
    ];
    let moves = [0.01, 0.1, 1.0].map(|share| {
        let frames = (10_000_000.0 / (n as f32 * share)).clamp(20.0, 120.0);
        run_frames(
            &mut all,
            &mut Movement::new(scene, Motion::Drift(share)),
            frames as usize,
        )
    });
    [build].into_iter().chain(moves).chain(queries).collect()
}

fn answers<Q, A>(
    all: &[Named],
    turn: usize,
    queries: &[Q],
    same: impl Fn(&A, &A) -> bool,
    query: impl Fn(&dyn Structure, &Q) -> A,
) -> Figures {
    let query = &query;
    let mut sides: Vec<Side<Q, A>> = Vec::new();
    for (name, structure) in all {
        sides.push(Side::new(name, move |asked| query(&**structure, asked)));
    }
    measure("choosing", turn, queries, &mut sides, same)
}

/// Prints a row for each structure. The best of each column is bold.
fn print(size: &str, columns: &[Figures]) {
    for (row, (name, _)) in columns[0].iter().enumerate() {
        let cells = columns.iter().enumerate().map(|(column, figures)| {
            let figure = figures[row].1;
            let text = if column + 1 == columns.len() {
                format!("{figure:.0}")
            } else {
                readable(figure)
            };
            let best = figures.iter().all(|(_, other)| figure <= *other);
            if best { format!("**{text}**") } else { text }
        });
        println!("| {name} | {size} | {} |", cells.collect::<Vec<_>>().join(" | "));
    }
}

fn readable(ns: f64) -> String {
    match ns {
        ..1e3 => format!("{ns:.0} ns"),
        ..1e5 => format!("{:.1} µs", ns / 1e3),
        ..1e6 => format!("{:.0} µs", ns / 1e3),
        ..1e8 => format!("{:.1} ms", ns / 1e6),
        _ => format!("{:.0} ms", ns / 1e6),
    }
}
