//! The oracle: a list of boxes, and every query a loop over it.

use std::ops::ControlFlow;

use bevy::math::bounding::{Aabb3d, BoundingSphere, IntersectsVolume};

use super::{RayVisit, SpatialQueries, UnsoundBox};
use crate::geometry::{
    aabb::{Aabb3dExt, union},
    ray::Ray,
};

/// A list of boxes with their keys, searched from end to end.
///
/// Too simple to be wrong: the other structures are tested against it.
#[derive(Clone, Debug, Default)]
pub struct BruteForce<K> {
    boxes: Vec<(K, Aabb3d)>,
}

impl<K: Copy + Eq> BruteForce<K> {
    /// No boxes.
    pub fn new() -> Self {
        Self { boxes: Vec::new() }
    }

    /// Stores `aabb` under `key`, in place of the box that was there.
    ///
    /// # Errors
    ///
    /// If the box is not [sound](Aabb3dExt::is_sound); the old one stays.
    pub fn set(&mut self, key: K, aabb: Aabb3d) -> Result<(), UnsoundBox> {
        if !aabb.is_sound() {
            return Err(UnsoundBox(aabb));
        }
        match self.boxes.iter_mut().find(|(k, _)| *k == key) {
            Some((_, old)) => *old = aabb,
            None => self.boxes.push((key, aabb)),
        }
        Ok(())
    }

    /// Removes and returns the box under `key`.
    pub fn remove(&mut self, key: K) -> Option<Aabb3d> {
        let index = self.boxes.iter().position(|(k, _)| *k == key)?;
        Some(self.boxes.swap_remove(index).1)
    }

    fn visit(&self, touches: impl Fn(&Aabb3d) -> bool, mut visit: impl FnMut(K) -> ControlFlow<()>) {
        for (key, aabb) in &self.boxes {
            if touches(aabb) && visit(*key).is_break() {
                return;
            }
        }
    }
}

impl<K: Copy + Eq> SpatialQueries<K> for BruteForce<K> {
    fn len(&self) -> usize {
        self.boxes.len()
    }

    fn bounds(&self) -> Option<Aabb3d> {
        self.boxes.iter().map(|(_, aabb)| *aabb).reduce(|a, b| union(&a, &b))
    }

    fn visit_ray(&self, ray: &Ray, mut visit: impl FnMut(K, f32) -> RayVisit) {
        let mut rest = *ray;
        for (key, aabb) in &self.boxes {
            let Some(enter) = rest.aabb_intersection_at(aabb) else {
                continue;
            };
            match visit(*key, enter) {
                RayVisit::Continue => {}
                RayVisit::Shorten(t) => rest = rest.with_t_max(t.min(rest.t_max())),
                RayVisit::Stop => return,
            }
        }
    }

    fn visit_aabb(&self, aabb: &Aabb3d, visit: impl FnMut(K) -> ControlFlow<()>) {
        self.visit(|stored| stored.intersects(aabb), visit);
    }

    fn visit_sphere(&self, sphere: &BoundingSphere, visit: impl FnMut(K) -> ControlFlow<()>) {
        self.visit(|stored| stored.intersects(sphere), visit);
    }
}
