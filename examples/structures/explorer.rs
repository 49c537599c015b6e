//! What is explored: boxes, a structure, a ray, and how far the ray has come.

use bevy::prelude::*;
use bevy_sightline::{
    geometry::ray::Ray,
    spatial::{Trace, TraceStep, TracedNode},
};

use crate::{
    boxes::Boxes,
    options::Options,
    structure::{Kind, Structure},
};

/// Seconds for a visit while it plays.
const PACE: f32 = 0.45;

#[derive(Resource)]
pub struct Explorer {
    pub boxes: Boxes,
    pub kind: Kind,
    /// Of every kind.
    structures: Vec<(Kind, Structure)>,
    pub ray: Ray,
    pub trace: Trace<u32>,
    /// So many steps of the trace have been taken.
    pub step: usize,
    pub playing: bool,
    /// What the ray costs in each structure: visits, and boxes tested.
    pub costs: Vec<(Kind, usize, usize)>,
}

pub fn plugin(app: &mut App) {
    let options = app.world().resource::<Options>().clone();
    let mut explorer = Explorer::new(Boxes::new(options.boxes, options.seed, options.three_d));
    explorer.choose(Kind::MAIN[(options.structure - 1).min(Kind::MAIN.len() - 1)]);
    explorer.step = options.step.min(explorer.trace.steps.len());
    app.insert_resource(explorer).add_systems(Update, play);
}

impl Explorer {
    pub fn new(boxes: Boxes) -> Self {
        let kind = Kind::MAIN[0];
        let structures = Kind::ALL.map(|kind| (kind, Structure::new(kind, &boxes.boxes)));
        let ray = boxes.first_ray();
        let mut explorer = Self {
            boxes,
            kind,
            structures: structures.into(),
            ray,
            trace: Trace::default(),
            step: 0,
            playing: false,
            costs: Vec::new(),
        };
        explorer.aim(ray);
        explorer
    }

    /// Divides the boxes in another way.
    pub fn choose(&mut self, kind: Kind) {
        self.kind = kind;
        self.aim(self.ray);
    }

    /// Sends another ray.
    pub fn aim(&mut self, ray: Ray) {
        self.ray = ray;
        self.step = 0;
        self.costs.clear();
        for (kind, structure) in &self.structures {
            let (_, trace) = structure.trace(&ray);
            self.costs.push((*kind, trace.nodes().count(), trace.boxes_tested()));
            if *kind == self.kind {
                self.trace = trace;
            }
        }
    }

    /// The one that is shown.
    pub fn structure(&self) -> &Structure {
        let shown = self.structures.iter().find(|(kind, _)| *kind == self.kind);
        &shown.unwrap_or(&self.structures[0]).1
    }

    /// The steps that have been taken.
    pub fn taken(&self) -> &[TraceStep<u32>] {
        &self.trace.steps[..self.step]
    }

    /// The nodes that have been visited, with the numbers of their steps.
    pub fn visited(&self) -> impl Iterator<Item = (usize, &TracedNode<u32>)> {
        (0..).zip(self.taken()).filter_map(|(step, taken)| match taken {
            TraceStep::Node(node) => Some((step, node)),
            TraceStep::Leaf(_) => None,
        })
    }

    /// How far the ray still matters, and the box that it has hit there.
    pub fn nearest(&self) -> Option<(u32, f32)> {
        let mut nearest = None;
        let mut limit = self.ray.t_max();
        for taken in self.taken() {
            if let TraceStep::Leaf(leaf) = taken
                && leaf.limit < limit
            {
                limit = leaf.limit;
                nearest = Some((leaf.key, limit));
            }
        }
        nearest
    }
}

/// Takes a step from time to time.
fn play(time: Res<Time>, mut since: Local<f32>, mut explorer: ResMut<Explorer>) {
    if !explorer.playing {
        return;
    }
    *since += time.delta_secs();
    if *since >= PACE {
        *since = 0.0;
        explorer.step += 1;
        if explorer.step >= explorer.trace.steps.len() {
            explorer.step = explorer.trace.steps.len();
            explorer.playing = false;
        }
    }
}
