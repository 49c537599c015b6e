//! Binary hierarchies to wide ones.

use std::ops::Range;

use bevy::math::bounding::BoundingVolume;
use smallvec::SmallVec;

use super::tagged_box::{Below, BinaryNode, BuildItem};
use crate::spatial::wide::{Child, LANES, NodeIndex, WideNode};

/// Writes wide nodes, and the items in the order of their leaves.
pub(super) struct Collapse<'a, L, N> {
    /// The root first.
    pub tree: &'a [BinaryNode],
    pub unordered: &'a [BuildItem],
    pub leaf_size: usize,
    pub items: &'a mut Vec<BuildItem>,
    pub nodes: &'a mut Vec<WideNode>,
    pub leaf: L,
    pub node: N,
}

/// What becomes the children of a wide node.
type Parts = SmallVec<[BinaryNode; LANES]>;

impl<L, N> Collapse<'_, L, N>
where
    L: FnMut(&[BuildItem], usize, NodeIndex, usize) -> u32,
    N: FnMut(NodeIndex, Option<(NodeIndex, usize)>, Range<usize>),
{
    /// Writes everything, over nodes and items that are empty.
    pub(super) fn run(mut self) {
        let root = self.tree[0];
        self.nodes.push(WideNode::EMPTY);
        (self.node)(0, None, 0..root.count());
        self.fill(0, root);
    }

    /// Gives a node its children and all that is below them, and returns the mask of all that.
    fn fill(&mut self, node: NodeIndex, above: BinaryNode) -> u32 {
        let parts = if above.count() <= self.leaf_size {
            SmallVec::from_slice(&[above])
        } else {
            self.open(above)
        };
        // Siblings stand side by side.
        let mut next_child = self.nodes.len() as NodeIndex;
        let mut first = self.items.len();
        for (lane, part) in parts.iter().enumerate() {
            if part.count() > self.leaf_size {
                (self.node)(
                    self.nodes.len() as NodeIndex,
                    Some((node, lane)),
                    first..first + part.count(),
                );
                self.nodes.push(WideNode::EMPTY);
            }
            first += part.count();
        }
        let mut all = 0;
        for (lane, part) in parts.into_iter().enumerate() {
            let (mask, child) = if part.count() <= self.leaf_size {
                let first = self.items.len();
                let mask = self.take(part);
                (mask, Child::Leaf((self.leaf)(&self.items[first..], first, node, lane)))
            } else {
                let child = next_child;
                next_child += 1;
                (self.fill(child, part), Child::Node(child))
            };
            self.nodes[node as usize].set(lane, &part.aabb(), mask, child);
            all |= mask;
        }
        all
    }

    /// The parts that become the children of one wide node: always the one with the largest area is opened, but what
    /// fits into a node of its own stays whole, unless there is room for all of it here. Opened halfway it would leave
    /// nodes of two or three children at the bottom of the hierarchy, where most of the nodes are.
    fn open(&self, above: BinaryNode) -> Parts {
        let mut parts: Parts = SmallVec::from_slice(&[above]);
        let capacity = LANES * self.leaf_size;
        let enough = if above.count() > capacity {
            capacity
        } else {
            self.leaf_size
        };
        while parts.len() < LANES
            && let Some(part) = largest(&parts, |count| count > enough)
        {
            self.open_at(part, &mut parts);
        }
        while let room = LANES - parts.len()
            && let Some(part) = largest(&parts, |count| count > self.leaf_size && count - 1 <= room)
        {
            self.open_at(part, &mut parts);
        }
        parts
    }

    /// Replaces a part by its children.
    #[inline(always)]
    fn open_at(&self, part: usize, parts: &mut Parts) {
        match parts[part].below() {
            Below::Nodes(first) => {
                parts[part] = self.tree[first];
                parts.push(self.tree[first + 1]);
            }
            Below::Items(items) => {
                parts.swap_remove(part);
                parts.extend(items.map(|item| BinaryNode::of_items(&self.unordered[item].aabb(), item as u32, 1)));
            }
        }
    }

    /// Puts all that is below a node next in the order, and returns its mask.
    fn take(&mut self, above: BinaryNode) -> u32 {
        match above.below() {
            Below::Nodes(first) => self.take(self.tree[first]) | self.take(self.tree[first + 1]),
            Below::Items(items) => {
                let items = &self.unordered[items];
                self.items.extend_from_slice(items);
                items.iter().fold(0, |mask, item| mask | item.mask())
            }
        }
    }
}

/// The part with the largest area among those with a suitable number of items.
#[inline(always)]
fn largest(parts: &Parts, suits: impl Fn(usize) -> bool) -> Option<usize> {
    (0..parts.len())
        .filter(|&part| suits(parts[part].count()))
        .max_by(|&a, &b| {
            let area = |part: usize| parts[part].aabb().visible_area();
            area(a).total_cmp(&area(b))
        })
}
