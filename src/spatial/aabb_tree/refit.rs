//! Mending the boxes above a change, and the shape with them.

use bevy::math::bounding::{Aabb3d, BoundingVolume};

use super::{
    AabbTree,
    node::{NodeIndex, NodeKind},
};
use crate::geometry::aabb::union;

impl<K: Copy> AabbTree<K> {
    /// Fits all ancestors of `node` to their children and rotates them where that makes them smaller; stops where
    /// nothing changes any more.
    pub(super) fn refit_above(&mut self, node: NodeIndex) {
        let mut next = self.nodes[node as usize].parent;
        while let Some(node) = next {
            let NodeKind::Inner([first, second]) = self.nodes[node as usize].kind else {
                unreachable!("a parent is an inner node");
            };
            let fitted = union(self.aabb_of(first), self.aabb_of(second));
            let changed = fitted != *self.aabb_of(node);
            self.nodes[node as usize].aabb = fitted;
            let rotated = self.rotate(node, first, second) || self.rotate(node, second, first);
            if !changed && !rotated {
                return;
            }
            next = self.nodes[node as usize].parent;
        }
    }

    /// Swaps `uncle` with that child of `inner` that makes `inner` smallest, if one does; both are children of `node`.
    ///
    /// Source: Kopta et al., *Fast, Effective BVH Updates for Animated Scenes*, 2012, §3.
    fn rotate(&mut self, node: NodeIndex, uncle: NodeIndex, inner: NodeIndex) -> bool {
        let NodeKind::Inner([left, right]) = self.nodes[inner as usize].kind else {
            return false;
        };
        let joined_with = |child| union(self.aabb_of(uncle), self.aabb_of(child));
        // The uncle replaces one child and joins the other.
        let (replaces_left, replaces_right) = (joined_with(right), joined_with(left));
        let (nephew, fitted) = if replaces_left.visible_area() < replaces_right.visible_area() {
            (left, replaces_left)
        } else {
            (right, replaces_right)
        };
        // `>=` would swap back and forth, and a NaN from overflown areas must not swap either.
        if fitted.visible_area() < self.aabb_of(inner).visible_area() {
            self.replace_child(Some(inner), nephew, uncle);
            self.replace_child(Some(node), uncle, nephew);
            self.nodes[uncle as usize].parent = Some(inner);
            self.nodes[nephew as usize].parent = Some(node);
            self.nodes[inner as usize].aabb = fitted;
            return true;
        }
        false
    }

    pub(super) fn aabb_of(&self, node: NodeIndex) -> &Aabb3d {
        &self.nodes[node as usize].aabb
    }
}
