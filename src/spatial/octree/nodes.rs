//! The nodes, as those see them who draw them, or who load and unload by them.

use bevy::math::{Vec3A, bounding::Aabb3d};
use smallvec::{SmallVec, smallvec};

use super::{
    super::{
        query::Descend,
        wide::{Child, NodeIndex},
    },
    Octree,
    cell::{ALL, Kind},
};
use crate::geometry::aabb::union;

/// A node of an [`Octree`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OctreeNode {
    /// The binary logarithm of the side of the cell. A node may be many levels below the one that it is in.
    pub level: i32,
    /// The cube that the centres of all boxes below are in. Cells are whole multiples of their side from the origin, only
    /// the one that is on both sides of it lies around it.
    pub cell: Aabb3d,
    /// The smallest box around all boxes below. It may reach out of the cell by half of its side.
    pub bounds: Aabb3d,
    /// The number of boxes in this node and all below.
    pub count: usize,
    index: NodeIndex,
}

impl<K: Copy> Octree<K> {
    /// Visits the nodes, each before those within it.
    ///
    /// A box is in the node of the smallest cell that there is for it, or above where there is room: a node has no
    /// children of a single box. Where a cell has many boxes as large as itself, they are spread over further nodes,
    /// which are not visited, and belong to that cell.
    pub fn visit_nodes(&self, mut visit: impl FnMut(&OctreeNode) -> Descend) {
        let mut stack: SmallVec<[NodeIndex; 128]> = self.root.into_iter().collect();
        while let Some(index) = stack.pop() {
            if self.is_own_cell(index) {
                match visit(&self.node(index)) {
                    Descend::Into => {}
                    Descend::Past => continue,
                    Descend::Stop => return,
                }
            }
            stack.extend(self.children(index));
        }
    }

    /// Visits the nodes that stand for one level: those of its cells, and of smaller cells where a node of its cell is
    /// missing, for want of boxes.
    ///
    /// Boxes in cells of higher levels are in none of these: [`visit_own`](Self::visit_own) finds them.
    pub fn visit_level(&self, level: i32, mut visit: impl FnMut(&OctreeNode)) {
        self.visit_nodes(|node| {
            if node.level > level {
                return Descend::Into;
            }
            visit(node);
            Descend::Past
        });
    }

    /// Visits the boxes in a node and in all within it.
    pub fn visit_below(&self, node: &OctreeNode, visit: impl FnMut(K, &Aabb3d)) {
        self.visit_boxes(node.index, |_| true, visit);
    }

    /// Visits the boxes in a node that are in no node within it.
    pub fn visit_own(&self, node: &OctreeNode, visit: impl FnMut(K, &Aabb3d)) {
        self.visit_boxes(node.index, |child| !self.is_own_cell(child), visit);
    }

    /// The number of nodes on the longest way down from the root, or zero if there are no boxes.
    pub fn depth(&self) -> usize {
        let mut depth = 0;
        let mut stack: SmallVec<[(NodeIndex, usize); 128]> = self.root.map(|root| (root, 1)).into_iter().collect();
        while let Some((index, above)) = stack.pop() {
            depth = depth.max(above);
            stack.extend(self.children(index).map(|child| (child, above + 1)));
        }
        depth
    }

    /// The number of nodes, those that [`visit_nodes`](Self::visit_nodes) does not visit included.
    pub fn node_count(&self) -> usize {
        self.nodes.len() - self.free.len()
    }

    fn visit_boxes(&self, index: NodeIndex, descend: impl Fn(NodeIndex) -> bool, mut visit: impl FnMut(K, &Aabb3d)) {
        let mut stack: SmallVec<[NodeIndex; 128]> = smallvec![index];
        while let Some(index) = stack.pop() {
            for (aabb, child) in self.nodes[index as usize].lanes() {
                match child {
                    Child::Leaf(leaf) => visit(self.leaves.key_at(leaf), &aabb),
                    Child::Node(child) if descend(child) => stack.push(child),
                    Child::Node(_) => {}
                }
            }
        }
    }

    fn children(&self, index: NodeIndex) -> impl Iterator<Item = NodeIndex> + '_ {
        self.nodes[index as usize].lanes().filter_map(|(_, child)| match child {
            Child::Leaf(_) => None,
            Child::Node(child) => Some(child),
        })
    }

    /// Whether a node is not one of several for one cell.
    fn is_own_cell(&self, index: NodeIndex) -> bool {
        let cell = &self.cells[index as usize];
        let is_root = self.root == Some(index);
        is_root || (cell.kind == Kind::Cell && cell.level != self.cells[cell.parent.node() as usize].level)
    }

    fn node(&self, index: NodeIndex) -> OctreeNode {
        let cell = &self.cells[index as usize];
        let bounds = self.nodes[index as usize].bounds();
        let (level, around) = if cell.level == ALL {
            self.cell_around_origin(index)
        } else {
            (cell.level.into(), cell.bounds())
        };
        OctreeNode {
            level,
            cell: around,
            bounds,
            count: cell.count as usize,
            index,
        }
    }

    /// The smallest cube around the origin that contains all cells of the children of a node, and all its boxes.
    fn cell_around_origin(&self, index: NodeIndex) -> (i32, Aabb3d) {
        let mut around = self.nodes[index as usize].bounds();
        for child in self
            .children(index)
            .filter(|&child| self.cells[child as usize].level < ALL)
        {
            around = union(&around, &self.cells[child as usize].bounds());
        }
        let reach = around.min.abs().max(around.max.abs()).max_element();
        let level = f64::from(reach.max(f32::MIN_POSITIVE)).log2().ceil() as i32;
        let reach = Vec3A::splat((2f64.powi(level) as f32).min(f32::MAX));
        let cube = Aabb3d {
            min: -reach,
            max: reach,
        };
        (level + 1, cube)
    }
}
