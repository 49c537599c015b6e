//! The oracle: a list of boxes, and every query a loop over it.

use std::{cell::Cell, ops::ControlFlow};

use bevy::math::{Vec3A, bounding::Aabb3d};

use super::{
    LeafId, NoSuchLeaf, Region, SpatialQueries, SpatialUpdates, Sweep, Trace, UnsoundBox, UpdateError, Visit,
    leaves::Leaves,
    region::{distance_squared, limit_squared},
    trace::Recorder,
};
use crate::geometry::{
    aabb::{Aabb3dExt, union},
    ray::Ray,
};

/// A list of boxes with their keys, searched from end to end.
///
/// Too simple to be wrong: the other structures are tested against it. Pairs take O(n²).
#[derive(Clone, Debug)]
pub struct BruteForce<K> {
    leaves: Leaves<K, Aabb3d>,
}

impl<K> Default for BruteForce<K> {
    fn default() -> Self {
        Self {
            leaves: Leaves::default(),
        }
    }
}

impl<K: Copy> BruteForce<K> {
    /// No boxes.
    pub fn new() -> Self {
        Self::default()
    }

    fn boxes(&self) -> impl Iterator<Item = (K, Aabb3d)> + Clone + '_ {
        let live = (0..self.leaves.capacity() as u32).filter(|&index| self.leaves.is_live(index));
        live.map(|index| (self.leaves.key_at(index), self.leaves.place_at(index)))
    }

    /// Visits what `test` is true for, up to a limit that visits may lower.
    fn visit_within(
        &self,
        mut limit: f32,
        test: impl Fn(&Aabb3d) -> Option<f32>,
        mut visit: impl FnMut(K, f32) -> Visit,
    ) {
        for (key, aabb) in self.boxes() {
            let Some(at) = test(&aabb).filter(|&at| at <= limit) else {
                continue;
            };
            match visit(key, at) {
                Visit::Continue => {}
                Visit::Shorten(to) => limit = limit.min(to),
                Visit::Stop => return,
            }
        }
    }
}

impl<K: Copy> SpatialQueries<K> for BruteForce<K> {
    fn len(&self) -> usize {
        self.leaves.len()
    }

    fn bounds(&self) -> Option<Aabb3d> {
        self.boxes().map(|(_, aabb)| aabb).reduce(|a, b| union(&a, &b))
    }

    fn memory(&self) -> usize {
        self.leaves.memory()
    }

    fn visit_all(&self, mut visit: impl FnMut(K, &Aabb3d)) {
        self.boxes().for_each(|(key, aabb)| visit(key, &aabb));
    }

    fn visit_ray(&self, ray: &Ray, visit: impl FnMut(K, f32) -> Visit) {
        self.visit_within(ray.t_max(), |aabb| ray.aabb_intersection_at(aabb), visit);
    }

    fn trace_ray(&self, ray: &Ray, mut visit: impl FnMut(K, f32) -> Visit) -> Trace<K> {
        let mut recorder = Recorder::new(ray);
        if let Some(bounds) = self.bounds() {
            let all = recorder.enter(None, bounds, self.boxes().map(|(key, aabb)| (aabb, Some(key))));
            let tested = Cell::new(bounds);
            let test = |aabb: &Aabb3d| {
                tested.set(*aabb);
                ray.aabb_intersection_at(aabb)
            };
            self.visit_within(ray.t_max(), test, |key, at| {
                let wish = visit(key, at);
                recorder.visited((all, tested.get()), key, at, wish);
                wish
            });
        }
        recorder.finish()
    }

    fn visit_sweep<S: Sweep>(&self, sweep: &S, visit: impl FnMut(K, f32) -> Visit) {
        // A contact beyond the range of parameters is none.
        self.visit_within(
            sweep.ray().t_max().min(f32::MAX),
            |aabb| sweep.intersection_at(aabb),
            visit,
        );
    }

    fn visit_region<R: Region>(&self, region: &R, mut visit: impl FnMut(K) -> ControlFlow<()>) {
        for (key, aabb) in self.boxes() {
            if region.touches(&aabb) && visit(key).is_break() {
                return;
            }
        }
    }

    fn visit_near(&self, point: Vec3A, max_distance: f32, visit: impl FnMut(K, f32) -> Visit) {
        let test = |aabb: &Aabb3d| Some(distance_squared(point, aabb));
        self.visit_within(limit_squared(point, max_distance), test, visit);
    }

    fn visit_pairs(&self, mut visit: impl FnMut(K, K) -> ControlFlow<()>) {
        let mut boxes = self.boxes();
        while let Some((a, a_box)) = boxes.next() {
            for (b, b_box) in boxes.clone() {
                if a_box.touches(&b_box) && visit(a, b).is_break() {
                    return;
                }
            }
        }
    }
}

impl<K: Copy> SpatialUpdates<K> for BruteForce<K> {
    fn insert(&mut self, key: K, aabb: Aabb3d) -> Result<LeafId, UnsoundBox> {
        if !aabb.is_sound() {
            return Err(UnsoundBox(aabb));
        }
        Ok(self.leaves.add(key, aabb))
    }

    fn remove(&mut self, id: LeafId) -> Result<K, NoSuchLeaf> {
        self.leaves.remove(id).map(|(key, _)| key)
    }

    fn update(&mut self, id: LeafId, aabb: Aabb3d) -> Result<(), UpdateError> {
        self.leaves.place(id)?;
        if !aabb.is_sound() {
            return Err(UnsoundBox(aabb).into());
        }
        self.leaves.set_place_at(id.index, aabb);
        Ok(())
    }

    fn clear(&mut self) {
        self.leaves.clear();
    }

    fn key(&self, id: LeafId) -> Option<K> {
        self.leaves.key(id)
    }

    fn aabb(&self, id: LeafId) -> Option<Aabb3d> {
        self.leaves.place(id).ok()
    }
}
