//! Binary hierarchies to wide ones.

use std::ops::Range;

use smallvec::SmallVec;

use super::{
    plan::{Plan, Shares},
    progress::{Cancelled, Stage},
    tagged_box::{BinaryNode, BuildItem},
};
use crate::spatial::{
    simd,
    wide::{Child, LANES, NodeIndex, WideNode},
};

/// Writes wide nodes, and the items in the order of their leaves.
pub(super) struct Collapse<'a, L, N> {
    pub plan: &'a Plan,
    pub tree: &'a [BinaryNode],
    pub rings: &'a [u32],
    pub unordered: &'a [BuildItem],
    pub leaf_size: u32,
    pub items: &'a mut Vec<BuildItem>,
    pub nodes: &'a mut Vec<WideNode>,
    pub leaf: L,
    pub node: N,
    /// Of as many steps as there are items.
    pub stage: &'a Stage<'a>,
}

/// Progress is told where so many items and more are done, up to sixteen times as many.
const STEP: u32 = 1 << 10;

/// What becomes the children of a wide node.
type Parts = SmallVec<[BinaryNode; LANES]>;

impl<L, N> Collapse<'_, L, N>
where
    L: FnMut(&[BuildItem], usize, NodeIndex, usize) -> u32,
    N: FnMut(NodeIndex, Option<(NodeIndex, usize)>, Range<usize>),
{
    /// Writes everything, over nodes and items that are empty.
    pub(super) fn run(mut self, root: &BinaryNode) -> Result<(), Cancelled> {
        (self.node)(0, None, 0..root.count() as usize);
        self.nodes.push(WideNode::EMPTY);
        self.fill(0, root)?;
        Ok(())
    }

    /// Gives a node its children and all that is below them, and returns the mask of all that. Never deeper than the
    /// binary hierarchy.
    fn fill(&mut self, node: NodeIndex, above: &BinaryNode) -> Result<u32, Cancelled> {
        let mut parts = Parts::new();
        if above.count() <= self.leaf_size {
            parts.push(*above);
        } else {
            self.share(above, LANES, true, &mut parts);
        }

        let mut next_child = self.nodes.len() as NodeIndex;
        let mut first = self.items.len();
        for (lane, part) in parts.iter().enumerate() {
            let below = first..first + part.count() as usize;
            first = below.end;
            if part.count() > self.leaf_size {
                self.prefetch(part);
                (self.node)(self.nodes.len() as NodeIndex, Some((node, lane)), below);
                self.nodes.push(WideNode::EMPTY);
            }
        }

        let mut all = 0;
        for (lane, part) in parts.iter().enumerate() {
            let (mask, child) = if part.count() > self.leaf_size {
                let child = next_child;
                next_child += 1;
                (self.fill(child, part)?, Child::Node(child))
            } else {
                let first = self.items.len();
                self.gather(part);
                let items = &self.items[first..];
                let mask = items.iter().fold(0, |mask, item| mask | item.mask());
                (mask, Child::Leaf((self.leaf)(items, first, node, lane)))
            };
            self.nodes[node as usize].set(lane, &part.aabb(), mask, child);
            all |= mask;
        }
        if (STEP..16 * STEP).contains(&above.count()) {
            self.stage.advance(above.count() as usize / 4)?;
        }
        Ok(all)
    }

    /// Appends all items below a node.
    fn gather(&mut self, node: &BinaryNode) {
        if self.plan.is_bag(node) {
            let items = ring(self.rings, node).map(|item| self.unordered[item]);
            self.items.extend(items);
        } else {
            let first = node.first() as usize;
            self.gather(&self.tree[first]);
            self.gather(&self.tree[first + 1]);
        }
    }

    /// Appends what a node becomes in so many lanes.
    fn share(&self, node: &BinaryNode, lanes: usize, is_wide: bool, parts: &mut Parts) {
        match self.plan.shares(node, self.tree, lanes, is_wide) {
            Shares::Whole => parts.push(*node),
            Shares::Items => {
                for item in ring(self.rings, node) {
                    parts.push(BinaryNode::new(&self.unordered[item].aabb(), item as u32, 1));
                }
            }
            Shares::Children(lanes) => {
                let first = node.first() as usize;
                self.share(&self.tree[first], lanes[0], false, parts);
                self.share(&self.tree[first + 1], lanes[1], false, parts);
            }
        }
    }

    /// Asks for what is read when a node is filled.
    #[inline(always)]
    fn prefetch(&self, node: &BinaryNode) {
        let first = node.first() as usize;
        if self.plan.is_bag(node) {
            simd::prefetch(&self.rings[first]);
            // Most of the others follow.
            for item in self.unordered[first..].iter().take(LANES).step_by(2) {
                simd::prefetch(item);
            }
        } else {
            simd::prefetch(&self.tree[first]);
            simd::prefetch(&self.tree[first + 1]);
            simd::prefetch(self.plan.costs_of_inner(node));
        }
    }
}

/// The items of a bag.
#[inline(always)]
fn ring<'a>(rings: &'a [u32], bag: &BinaryNode) -> impl Iterator<Item = usize> + 'a {
    let mut next = bag.first();
    (0..bag.count()).map(move |_| {
        let item = next as usize;
        next = rings[item];
        item
    })
}
