//! The queries.

use std::ops::ControlFlow;

use bevy::math::bounding::{Aabb3d, BoundingSphere, IntersectsVolume};
use smallvec::SmallVec;

use super::AabbTree;
use crate::{
    geometry::ray::Ray,
    spatial::{
        RayVisit, SpatialQueries,
        wide::{self, Child, NodeIndex},
    },
};

impl<K: Copy> SpatialQueries<K> for AabbTree<K> {
    fn len(&self) -> usize {
        self.leaves.len() - self.free_leaves.len()
    }

    fn bounds(&self) -> Option<Aabb3d> {
        self.root.map(|root| self.nodes[root as usize].bounds())
    }

    fn visit_ray(&self, ray: &Ray, mut visit: impl FnMut(K, f32) -> RayVisit) {
        if let Some(root) = self.root {
            wide::visit_ray(&self.nodes, root, ray, |leaf, enter| {
                visit(self.keys[leaf as usize], enter)
            });
        }
    }

    fn visit_aabb(&self, aabb: &Aabb3d, visit: impl FnMut(K) -> ControlFlow<()>) {
        self.visit_touching(|stored| stored.intersects(aabb), visit);
    }

    fn visit_sphere(&self, sphere: &BoundingSphere, visit: impl FnMut(K) -> ControlFlow<()>) {
        self.visit_touching(|stored| stored.intersects(sphere), visit);
    }
}

impl<K: Copy> AabbTree<K> {
    /// Visits every key whose box `touches`, which must hold for every box around a box for which it holds.
    fn visit_touching(&self, touches: impl Fn(&Aabb3d) -> bool, mut visit: impl FnMut(K) -> ControlFlow<()>) {
        let mut stack: SmallVec<[NodeIndex; 64]> = self.root.into_iter().collect();
        while let Some(node) = stack.pop() {
            for (_, child) in self.nodes[node as usize].lanes().filter(|(aabb, _)| touches(aabb)) {
                match child {
                    Child::Node(node) => stack.push(node),
                    Child::Leaf(leaf) => {
                        if visit(self.keys[leaf as usize]).is_break() {
                            return;
                        }
                    }
                }
            }
        }
    }

    /// All nodes that are in the tree, parents before children.
    pub(super) fn linked_nodes(&self) -> impl Iterator<Item = NodeIndex> + '_ {
        let mut stack: Vec<NodeIndex> = self.root.into_iter().collect();
        std::iter::from_fn(move || {
            let node = stack.pop()?;
            stack.extend(self.nodes[node as usize].lanes().filter_map(|(_, child)| match child {
                Child::Node(node) => Some(node),
                Child::Leaf(_) => None,
            }));
            Some(node)
        })
    }
}
