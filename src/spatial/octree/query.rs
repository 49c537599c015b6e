//! The queries of the octree.

use std::ops::ControlFlow;

use bevy::math::{Vec3A, bounding::Aabb3d};

use super::{
    super::{
        Region, SpatialQueries, Sweep, Trace, Visit,
        lanes::{Entering, Growing},
        region::limit_squared,
        trace::trace_in_order,
        traverse::{self, Found},
        wide::{Child, EVERY_MASK, NodeIndex, WideNode},
    },
    Octree,
    cell::Cell,
};
use crate::geometry::ray::Ray;

impl<K: Copy> SpatialQueries<K> for Octree<K> {
    fn len(&self) -> usize {
        self.leaves.len()
    }

    fn bounds(&self) -> Option<Aabb3d> {
        self.root.map(|root| self.nodes[root as usize].bounds())
    }

    fn memory(&self) -> usize {
        self.nodes.capacity() * size_of::<WideNode>()
            + self.cells.capacity() * size_of::<Cell>()
            + (self.free.capacity() + self.stale.capacity()) * size_of::<NodeIndex>()
            + self.leavers.capacity() * size_of::<(u32, Aabb3d)>()
            + self.leaves.memory()
    }

    fn visit_all(&self, mut visit: impl FnMut(K, &Aabb3d)) {
        for node in &self.nodes {
            for (aabb, child) in node.lanes() {
                if let Child::Leaf(leaf) = child {
                    visit(self.leaves.key_at(leaf), &aabb);
                }
            }
        }
    }

    fn visit_ray(&self, ray: &Ray, mut visit: impl FnMut(K, f32) -> Visit) {
        let Some(root) = self.root else {
            return;
        };
        let visit = |leaf, t| visit(self.leaves.key_at(leaf), t);
        traverse::visit_in_order(&self.nodes, root, EVERY_MASK, ray.t_max(), Entering::new(ray), visit);
    }

    fn trace_ray(&self, ray: &Ray, mut visit: impl FnMut(K, f32) -> Visit) -> Trace<K> {
        let key_of = |leaf| self.leaves.key_at(leaf);
        self.root.map_or_else(Trace::default, |root| {
            trace_in_order(&self.nodes, root, EVERY_MASK, ray, key_of, |leaf, t| {
                visit(key_of(leaf), t)
            })
        })
    }

    fn visit_sweep<S: Sweep>(&self, sweep: &S, mut visit: impl FnMut(K, f32) -> Visit) {
        let Some(root) = self.root else {
            return;
        };
        let aabb_of = |leaf| self.aabb_at(self.leaves.place_at(leaf));
        let visit = |leaf, t| visit(self.leaves.key_at(leaf), t);
        traverse::visit_sweep(&self.nodes, root, EVERY_MASK, sweep, aabb_of, visit);
    }

    fn visit_region<R: Region>(&self, region: &R, mut visit: impl FnMut(K) -> ControlFlow<()>) {
        let Some(root) = self.root else {
            return;
        };
        let mut visit = |leaf| visit(self.leaves.key_at(leaf));
        traverse::visit_region(&self.nodes, root, EVERY_MASK, region, |found| match found {
            Found::Whole(node) => traverse::visit_leaves(&self.nodes, node, EVERY_MASK, &mut visit),
            Found::Leaf(leaf) => visit(leaf),
        });
    }

    fn visit_near(&self, point: Vec3A, max_distance: f32, mut visit: impl FnMut(K, f32) -> Visit) {
        let Some(root) = self.root else {
            return;
        };
        let visit = |leaf, distance_squared| visit(self.leaves.key_at(leaf), distance_squared);
        let limit = limit_squared(point, max_distance);
        traverse::visit_in_order(&self.nodes, root, EVERY_MASK, limit, Growing { center: point }, visit);
    }

    fn visit_pairs(&self, mut visit: impl FnMut(K, K) -> ControlFlow<()>) {
        let Some(root) = self.root else {
            return;
        };
        let visit = |a, b| visit(self.leaves.key_at(a), self.leaves.key_at(b));
        traverse::visit_pairs((&self.nodes, root), None, EVERY_MASK, visit);
    }
}
