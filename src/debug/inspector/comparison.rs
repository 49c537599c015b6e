//! Structures built over the boxes of the index, and asked the same, beside its use.

use std::time::{Duration, Instant};

use bevy::{
    ecs::entity::Entity,
    math::{
        Vec3A,
        bounding::{Aabb3d, BoundingVolume},
    },
};

use crate::{
    geometry::ray::Ray,
    spatial::{
        AabbTree, BruteForce, BuildStrategy, KdTree, Octree, SpatialQueries, SpatialUpdates, UniformGrid,
        kd_tree::SplitMethod, uniform_grid::GridSettings,
    },
};

/// How many rays, and how many small boxes, each structure is asked for.
const QUERIES: usize = 512;

/// How often it is asked them: the fastest time counts, for other threads take their turns between.
const TURNS: usize = 3;

/// How long a structure may be asked: brute force has to end some time.
const LONGEST: Duration = Duration::from_millis(200);

/// What a structure takes.
#[derive(Clone, Debug)]
pub(super) struct Cost {
    pub name: &'static str,
    pub build: Duration,
    pub memory: usize,
    /// For the first box that a random ray through the bounds meets.
    pub ray: Duration,
    /// For all boxes that meet a box a hundredth as long as the bounds, somewhere in them.
    pub overlap: Duration,
    /// How many boxes the rays met that are other ones than what brute force finds, which should be none.
    pub wrong: usize,
}

/// Structures over the same boxes, with what they take.
#[derive(Debug)]
pub(super) struct Comparison {
    pub entities: usize,
    pub costs: Vec<Cost>,
    pub kd_tree: Option<KdTree<Entity>>,
    pub octree: Octree<Entity>,
}

impl Comparison {
    /// Takes about as long as building eight structures: for another thread.
    pub fn of(boxes: &[(Entity, Aabb3d)]) -> Self {
        let questions = Questions::about(boxes);
        let mut costs = Vec::new();
        let truth = {
            let (brute_force, build) = timed(|| filled(BruteForce::default(), boxes));
            let (cost, truth) = questions.ask("brute force", &brute_force, build, None);
            costs.push(cost);
            truth
        };
        let strategies = [
            ("tree, middle split", BuildStrategy::MiddleSplit),
            ("tree, median split", BuildStrategy::MedianSplit),
            ("tree, binned SAH", BuildStrategy::BinnedSah),
            ("tree, PLOC", BuildStrategy::Ploc),
            ("tree, reinsertion", BuildStrategy::Reinsertion),
        ];
        for (name, strategy) in strategies {
            let mut tree = filled(AabbTree::default(), boxes);
            let ((), build) = timed(|| tree.rebuild_with(strategy));
            costs.push(questions.ask(name, &tree, build, Some(&truth)).0);
        }
        let (grid, build) = timed(|| filled(UniformGrid::new(GridSettings::default()), boxes));
        costs.push(questions.ask("uniform grid", &grid, build, Some(&truth)).0);
        let methods = [
            ("k-d tree, median", SplitMethod::Median),
            ("k-d tree, SAH", SplitMethod::Sah),
        ];
        let mut kd_tree = None;
        for (name, method) in methods {
            let (built, build) = timed(|| KdTree::new(boxes.iter().copied(), method).ok());
            let Some(tree) = built else { continue };
            costs.push(questions.ask(name, &tree, build, Some(&truth)).0);
            kd_tree = Some(tree);
        }
        let (octree, build) = timed(|| filled(Octree::new(), boxes));
        costs.push(questions.ask("octree", &octree, build, Some(&truth)).0);
        Self {
            entities: boxes.len(),
            costs,
            kd_tree,
            octree,
        }
    }
}

/// What it returns, and how long it took.
pub(super) fn timed<T>(run: impl FnOnce() -> T) -> (T, Duration) {
    let start = Instant::now();
    (run(), start.elapsed())
}

fn filled<S: SpatialUpdates<Entity>>(mut structure: S, boxes: &[(Entity, Aabb3d)]) -> S {
    // All of them are in the index, which holds sound boxes only.
    structure.insert_many(boxes.iter().copied());
    structure
}

/// What all structures are asked.
struct Questions {
    rays: Vec<Ray>,
    boxes: Vec<Aabb3d>,
}

impl Questions {
    /// The same questions about the same boxes.
    fn about(boxes: &[(Entity, Aabb3d)]) -> Self {
        let bounds = boxes.iter().map(|(_, aabb)| *aabb).reduce(|a, b| a.merge(&b));
        let bounds = bounds.unwrap_or(Aabb3d::new(Vec3A::ZERO, Vec3A::ONE));
        let mut random = Random(0x9e37_79b9_7f4a_7c15);
        let mut point = || bounds.min + (bounds.max - bounds.min) * random.point();
        let rays = std::iter::repeat_with(|| {
            let (from, to) = (point(), point());
            Ray::new(from, (to - from).try_normalize()?, f32::INFINITY)
        });
        let rays = rays.take(QUERIES).flatten().collect();
        let half_size = (bounds.max - bounds.min) * 0.005;
        let small = std::iter::repeat_with(|| Aabb3d::new(point(), half_size))
            .take(QUERIES)
            .collect();
        Self { rays, boxes: small }
    }

    /// Asks them, and compares with `truth` how far the rays go, as far as that was asked; and tells how far they go.
    fn ask<S: SpatialQueries<Entity>>(
        &self,
        name: &'static str,
        structure: &S,
        build: Duration,
        truth: Option<&[Option<f32>]>,
    ) -> (Cost, Vec<Option<f32>>) {
        let (distances, ray) = until_late(&self.rays, |ray| {
            structure.closest_box(ray).map(|(_, distance)| distance)
        });
        let mut found = Vec::new();
        let (_, overlap) = until_late(&self.boxes, |region| {
            found.clear();
            structure.find_in_region(region, &mut found);
        });
        let wrong = truth.map_or(0, |truth| truth.iter().zip(&distances).filter(|(a, b)| a != b).count());
        let cost = Cost {
            name,
            build,
            memory: structure.memory(),
            ray,
            overlap,
            wrong,
        };
        (cost, distances)
    }
}

/// Answers as many as there is time for, and how long one took.
fn until_late<Q, A>(questions: &[Q], mut answer: impl FnMut(&Q) -> A) -> (Vec<A>, Duration) {
    let start = Instant::now();
    let mut answers = Vec::with_capacity(questions.len());
    let mut fastest = Duration::MAX;
    for _ in 0..TURNS {
        answers.clear();
        let turn = Instant::now();
        for question in questions {
            answers.push(answer(question));
            if start.elapsed() > LONGEST {
                break;
            }
        }
        fastest = fastest.min(turn.elapsed() / answers.len().max(1) as u32);
    }
    (answers, fastest)
}

/// Numbers that look random (Marsaglia, *Xorshift RNGs*, 2003): the same every time.
struct Random(u64);

impl Random {
    /// Between zero and one along each axis.
    fn point(&mut self) -> Vec3A {
        Vec3A::from_array(std::array::from_fn(|_| {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            (self.0 >> 40) as f32 / (1_u32 << 24) as f32
        }))
    }
}
