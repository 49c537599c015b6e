//! The broad phase of rapier3d 0.35, which is the tree of parry3d and a policy.
//!
//! After `geometry::broad_phase_bvh` there: boxes have a margin; where few have left theirs, those are inserted anew and
//! the paths to them refitted, where many have, all is refitted in place and a part of the tree is built anew.

use bevy::math::bounding::Aabb3d;
use bevy_sightline::geometry::ray::Ray;
use parry3d::partitioning::{Bvh, BvhBuildStrategy, BvhLeafUpdateStatus, BvhWorkspace};

use super::parry::{self, aabb};
use crate::spatial::{motion::Move, updates::Upkeep};

pub(crate) const NAME: &str = "parry3d 0.31 as in rapier3d 0.35";

/// Four hundredths of the unit of length.
const MARGIN: f32 = 0.04;

pub(crate) struct Rapier {
    bvh: Bvh,
    boxes: Vec<Aabb3d>,
    workspace: BvhWorkspace,
    /// What has changed in this frame and in the one before.
    changed: [Vec<u32>; 2],
    changes_since_optimized: usize,
    inserts_anew: bool,
    frames: usize,
}

impl Rapier {
    pub fn build(boxes: &[Aabb3d]) -> Self {
        let mut workspace = BvhWorkspace::default();
        let mut bvh = parry::build(boxes, BvhBuildStrategy::Binned);
        bvh.refit(&mut workspace);
        Self {
            bvh,
            boxes: boxes.to_vec(),
            workspace,
            changed: [Vec::new(), Vec::new()],
            changes_since_optimized: 0,
            inserts_anew: true,
            frames: 0,
        }
    }
}

impl Upkeep for Rapier {
    fn frame(&mut self, moves: &[Move]) {
        self.frames += 1;
        let [changed, before] = &mut self.changed;
        changed.clear();
        for (key, new) in moves {
            self.boxes[*key as usize] = *new;
            let status = if self.inserts_anew {
                self.bvh.reinsert_or_update_if_present(aabb(new), *key, MARGIN)
            } else {
                self.bvh.update_partially_if_present(aabb(new), *key, MARGIN)
            };
            if status != Some(BvhLeafUpdateStatus::Unchanged) {
                changed.push(*key);
                self.changes_since_optimized += usize::from(!self.inserts_anew);
            }
        }
        let leaves = self.boxes.len();
        self.inserts_anew = changed.len() * 16 < leaves;
        let optimizes = self.changes_since_optimized > 0
            && (changed.len() * 16 >= leaves
                || (self.frames.is_multiple_of(8) && self.changes_since_optimized * 64 >= leaves));
        let refits_all = (changed.len() + before.len()) * 16 >= leaves;
        if refits_all {
            self.bvh.refit(&mut self.workspace);
        } else {
            self.bvh.refit_partial(before, changed);
        }
        // There beside the solver, here in the same thread.
        if optimizes {
            self.changes_since_optimized = 0;
            self.bvh.optimize_incremental(&mut self.workspace);
            self.bvh.refit_without_resolve(&mut self.workspace);
        }
        self.changed.swap(0, 1);
    }

    fn closest(&self, ray: &Ray) -> Option<f32> {
        parry::closest(&self.bvh, &self.boxes, ray)
    }
}
