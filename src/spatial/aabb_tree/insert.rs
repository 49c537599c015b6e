//! Linking a leaf into the tree, and taking it out.

use bevy::math::bounding::{Aabb3d, BoundingVolume};

use super::{
    AabbTree,
    node::{Node, NodeIndex, NodeKind},
};
use crate::geometry::aabb::union;

impl<K: Copy> AabbTree<K> {
    /// Gives a leaf a node with the box `aabb`, beside the best sibling.
    pub(super) fn link(&mut self, leaf: u32, aabb: Aabb3d) {
        let sibling = self.best_sibling(&aabb);
        let node = self.add_node(Node {
            aabb,
            kind: NodeKind::Leaf(leaf),
            parent: None,
        });
        self.leaves[leaf as usize].node = Some(node);
        let Some(sibling) = sibling else {
            self.root = Some(node);
            return;
        };

        // Put a new inner node where the sibling was, with both below it.
        let old_parent = self.nodes[sibling as usize].parent;
        let parent = self.add_node(Node {
            aabb: union(&aabb, &self.nodes[sibling as usize].aabb),
            kind: NodeKind::Inner([sibling, node]),
            parent: old_parent,
        });
        self.replace_child(old_parent, sibling, parent);
        self.nodes[sibling as usize].parent = Some(parent);
        self.nodes[node as usize].parent = Some(parent);
        self.refit_above(parent);
    }

    /// Takes the node of a leaf out of the tree.
    pub(super) fn unlink(&mut self, leaf: u32) {
        let node = self.leaves[leaf as usize]
            .node
            .take()
            .expect("only a leaf with a node is unlinked");
        self.free_nodes.push(node);
        let Some(parent) = self.nodes[node as usize].parent else {
            self.root = None;
            return;
        };

        // The sibling takes the place of the parent.
        let grandparent = self.nodes[parent as usize].parent;
        let sibling = self.sibling(parent, node);
        self.replace_child(grandparent, parent, sibling);
        self.nodes[sibling as usize].parent = grandparent;
        self.free_nodes.push(parent);
        self.refit_above(sibling);
    }

    /// The node beside which `aabb` costs least, or `None` in an empty tree.
    ///
    /// A greedy descent by the surface area heuristic (Catto, *Dynamic Bounding Volume Hierarchies*, GDC 2019): going
    /// down costs what every box on the way grows by, and stops where no child promises less than the node itself.
    fn best_sibling(&self, aabb: &Aabb3d) -> Option<NodeIndex> {
        let mut node = self.root?;
        let new_area = aabb.visible_area();
        // What the ancestors of `node` grow by, in area.
        let mut inherited = 0.0;
        loop {
            let here = &self.nodes[node as usize];
            let NodeKind::Inner(children) = here.kind else {
                return Some(node);
            };
            let area_here = union(&here.aabb, aabb).visible_area();
            let cost_here = area_here + inherited;
            inherited += area_here - here.aabb.visible_area();

            let [first, second] = children.map(|child| {
                let child = &self.nodes[child as usize];
                let joined = union(&child.aabb, aabb).visible_area();
                match child.kind {
                    NodeKind::Leaf(_) => joined + inherited,
                    // The least that any place below can cost.
                    NodeKind::Inner(_) => joined - child.aabb.visible_area() + new_area + inherited,
                }
            });
            if cost_here <= first && cost_here <= second {
                return Some(node);
            }
            node = children[usize::from(second < first)];
        }
    }

    /// Makes `new` the child of `parent` in place of `old`; without a parent, the root.
    pub(super) fn replace_child(&mut self, parent: Option<NodeIndex>, old: NodeIndex, new: NodeIndex) {
        match parent {
            None => self.root = Some(new),
            Some(parent) => {
                let NodeKind::Inner(children) = &mut self.nodes[parent as usize].kind else {
                    unreachable!("a parent is an inner node");
                };
                let slot = usize::from(children[1] == old);
                children[slot] = new;
            }
        }
    }

    /// The other child of `parent`.
    pub(super) fn sibling(&self, parent: NodeIndex, child: NodeIndex) -> NodeIndex {
        let NodeKind::Inner([first, second]) = self.nodes[parent as usize].kind else {
            unreachable!("a parent is an inner node");
        };
        if first == child { second } else { first }
    }

    fn add_node(&mut self, node: Node) -> NodeIndex {
        match self.free_nodes.pop() {
            Some(index) => {
                self.nodes[index as usize] = node;
                index
            }
            None => {
                self.nodes.push(node);
                (self.nodes.len() - 1) as NodeIndex
            }
        }
    }
}
