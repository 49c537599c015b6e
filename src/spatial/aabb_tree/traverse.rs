//! The queries.

use std::ops::ControlFlow;

use bevy::math::bounding::{Aabb3d, BoundingSphere, IntersectsVolume};
use smallvec::SmallVec;

use super::{
    AabbTree,
    node::{NodeIndex, NodeKind},
};
use crate::{
    geometry::ray::Ray,
    spatial::{RayVisit, SpatialQueries},
};

/// Nodes that wait for their visit: on the stack, unless the tree is uncommonly deep.
type Stack<T> = SmallVec<[T; 64]>;

impl<K: Copy> SpatialQueries<K> for AabbTree<K> {
    fn len(&self) -> usize {
        self.leaves.len() - self.free_leaves.len()
    }

    fn bounds(&self) -> Option<Aabb3d> {
        self.root.map(|root| *self.aabb_of(root))
    }

    fn visit_ray(&self, ray: &Ray, mut visit: impl FnMut(K, f32) -> RayVisit) {
        let mut rest = *ray;
        let mut stack: Stack<(NodeIndex, f32)> = SmallVec::new();
        let entered = |rest: &Ray, node| rest.aabb_intersection_at(self.aabb_of(node));
        stack.extend(self.root.and_then(|root| Some((root, entered(&rest, root)?))));
        while let Some((node, enter)) = stack.pop() {
            if enter > rest.t_max() {
                continue;
            }
            match self.nodes[node as usize].kind {
                NodeKind::Inner([first, second]) => match (entered(&rest, first), entered(&rest, second)) {
                    (Some(a), Some(b)) if a <= b => stack.extend([(second, b), (first, a)]),
                    (Some(a), Some(b)) => stack.extend([(first, a), (second, b)]),
                    (Some(a), None) => stack.push((first, a)),
                    (None, Some(b)) => stack.push((second, b)),
                    (None, None) => {}
                },
                NodeKind::Leaf(leaf) => {
                    let leaf = &self.leaves[leaf as usize];
                    let Some(enter) = rest.aabb_intersection_at(&leaf.aabb) else {
                        continue;
                    };
                    match visit(leaf.key, enter) {
                        RayVisit::Continue => {}
                        RayVisit::Shorten(t) => rest = rest.with_t_max(t.min(rest.t_max())),
                        RayVisit::Stop => return,
                    }
                }
            }
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
        let mut stack: Stack<NodeIndex> = self.root.into_iter().collect();
        while let Some(node) = stack.pop() {
            let node = &self.nodes[node as usize];
            if !touches(&node.aabb) {
                continue;
            }
            match node.kind {
                NodeKind::Inner(children) => stack.extend(children),
                NodeKind::Leaf(leaf) => {
                    let leaf = &self.leaves[leaf as usize];
                    if touches(&leaf.aabb) && visit(leaf.key).is_break() {
                        return;
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
            if let NodeKind::Inner(children) = self.nodes[node as usize].kind {
                stack.extend(children);
            }
            Some(node)
        })
    }
}
