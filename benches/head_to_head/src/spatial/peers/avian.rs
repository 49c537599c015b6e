//! The tree of colliders of avian3d 0.8, which is obvhs and a policy.
//!
//! After `collider_tree::{update, optimization, tree}` there: boxes have a margin; those that have left theirs are
//! refitted one by one or all at once, and then re-inserted, or the paths to them are built anew, or all is, by how many
//! they are.

use bevy::math::{Vec3A, bounding::Aabb3d};
use bevy_sightline::geometry::ray::Ray;
use obvhs::{
    aabb::Aabb,
    bvh2::{Bvh2, reinsertion::ReinsertionOptimizer},
    ploc::{PlocBuilder, PlocSearchDistance, SortPrecision, rebuild::compute_rebuild_path_flags},
};

use super::{obvhs::aabb, rebuilt::closest};
use crate::spatial::{motion::Move, updates::Upkeep};

pub(crate) const NAME: &str = "obvhs 0.4 as in avian3d 0.8";

pub(crate) struct Avian {
    bvh: Bvh2,
    boxes: Vec<Aabb3d>,
    /// The margin of each box.
    margins: Vec<f32>,
    moved: Vec<u32>,
    leaves: Vec<u32>,
    flags: Vec<bool>,
    builder: PlocBuilder,
    optimizer: ReinsertionOptimizer,
}

impl Avian {
    pub fn build(boxes: &[Aabb3d]) -> Self {
        let margin = |aabb: &Aabb3d| (0.125 * (aabb.max - aabb.min).length() / 2.0).min(0.05);
        let margins: Vec<f32> = boxes.iter().map(margin).collect();
        let enlarged: Vec<Aabb> = boxes
            .iter()
            .zip(&margins)
            .map(|(aabb, margin)| enlarged(aabb, *margin))
            .collect();
        let mut builder = PlocBuilder::with_capacity(boxes.len());
        let mut bvh = builder.build(
            PlocSearchDistance::Minimum,
            &enlarged,
            (0..boxes.len() as u32).collect(),
            SortPrecision::U64,
            0,
        );
        bvh.init_primitives_to_nodes_if_uninit();
        bvh.init_parents_if_uninit();
        Self {
            bvh,
            boxes: boxes.to_vec(),
            margins,
            moved: Vec::new(),
            leaves: Vec::new(),
            flags: Vec::new(),
            builder,
            optimizer: ReinsertionOptimizer::default(),
        }
    }

    fn node(&self, key: u32) -> usize {
        self.bvh.primitives_to_nodes[key as usize] as usize
    }

    /// Gives what has moved new margins, and fits the nodes above: all nodes in one sweep, or only those.
    fn refit(&mut self, sweep: bool) {
        for index in 0..self.moved.len() {
            let key = self.moved[index];
            let node = self.node(key);
            let new = enlarged(&self.boxes[key as usize], self.margins[key as usize]);
            if sweep {
                self.bvh.nodes[node].set_aabb(new);
            } else {
                self.bvh.resize_node(node, new);
            }
        }
        if sweep {
            self.bvh.refit_all();
        }
    }

    fn optimize(&mut self, share: f32) {
        let (distance, precision) = (PlocSearchDistance::Minimum, SortPrecision::U64);
        let nodes = &self.bvh.primitives_to_nodes;
        self.leaves.clear();
        self.leaves.extend(self.moved.iter().map(|&key| nodes[key as usize]));
        if share < 0.15 {
            self.optimizer.run_with_candidates(&mut self.bvh, &self.leaves, 1);
        } else if share < 0.45 {
            self.bvh.init_parents_if_uninit();
            compute_rebuild_path_flags(&self.bvh, &self.leaves, &mut self.flags);
            let flags = &self.flags;
            (self.builder).partial_rebuild(&mut self.bvh, |node| flags[node], distance, precision, 0);
        } else {
            self.builder.full_rebuild(&mut self.bvh, distance, precision, 0);
        }
    }
}

impl Upkeep for Avian {
    fn frame(&mut self, moves: &[Move]) {
        self.moved.clear();
        for &(key, new) in moves {
            self.boxes[key as usize] = new;
            let stored = &self.bvh.nodes[self.node(key)].aabb;
            let new = aabb(&new);
            if (stored.min.cmpgt(new.min) | stored.max.cmplt(new.max)).any() {
                self.moved.push(key);
            }
        }
        if self.moved.is_empty() {
            return;
        }
        let share = self.moved.len() as f32 / self.boxes.len() as f32;
        let ordered = self.bvh.children_are_ordered_after_parents;
        self.refit(share >= if ordered { 0.06 } else { 0.3 });
        self.optimize(share);
    }

    fn closest(&self, ray: &Ray) -> Option<f32> {
        closest(&self.bvh, &self.boxes, ray)
    }
}

fn enlarged(exact: &Aabb3d, margin: f32) -> Aabb {
    let margin = Vec3A::splat(margin);
    aabb(&Aabb3d {
        min: exact.min - margin,
        max: exact.max + margin,
    })
}
