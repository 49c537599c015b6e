//! What the trees over points and over boxes share: nodes in depth-first order, and the ways through them.

use std::ops::{ControlFlow, Range};

use bevy::math::bounding::{Aabb3d, BoundingVolume};
use smallvec::{SmallVec, smallvec};

use super::query::Query;
use crate::spatial::{
    lanes::{LaneRegion, Splat, lanes_of},
    query::Descend,
    region::OutlineKind,
    simd::{LANES, Simd, prefetch},
    wide::{Child, NodeIndex, WideNode},
};

/// Nodes of eight lanes. The root is the first, every node lies before what is below it, and the leaves are numbered
/// as they come on a walk through all lanes: those below any lane are a range.
#[derive(Clone, Debug)]
pub(super) struct Hierarchy {
    pub(super) nodes: Vec<WideNode>,
    /// Where each leaf is.
    pub(super) slots: Vec<Slot>,
}

/// A lane of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Slot {
    pub(super) node: NodeIndex,
    pub(super) lane: u32,
}

/// A node on the way down.
#[derive(Clone, Copy)]
struct Frame {
    node: NodeIndex,
    /// The lanes that are met, and have not been visited.
    waiting: u32,
    /// Where they are met; infinite for the others.
    ats: [f32; LANES],
}

/// The index of the root.
pub(super) const ROOT: NodeIndex = 0;

/// Room for seven lanes at each of the levels that a tree mostly has.
type Stack<T> = SmallVec<[T; 96]>;

impl Hierarchy {
    pub(super) fn bounds(&self) -> Option<Aabb3d> {
        self.nodes.first().map(WideNode::bounds)
    }

    #[inline(always)]
    fn node(&self, index: NodeIndex) -> &WideNode {
        &self.nodes[index as usize]
    }

    pub(super) fn memory(&self) -> usize {
        self.nodes.capacity() * size_of::<WideNode>() + self.slots.capacity() * size_of::<Slot>()
    }

    /// The box of a leaf.
    #[inline]
    pub(super) fn aabb(&self, leaf: u32) -> Aabb3d {
        let Slot { node, lane } = self.slots[leaf as usize];
        self.node(node).aabb(lane as usize)
    }

    /// The leaves below a child.
    pub(super) fn leaves(&self, child: Child) -> Range<u32> {
        let (mut first, mut last) = (child, child);
        let first = loop {
            match first {
                Child::Leaf(leaf) => break leaf,
                Child::Node(node) => first = self.node(node).child(0),
            }
        };
        let last = loop {
            match last {
                Child::Leaf(leaf) => break leaf,
                Child::Node(node) => last = self.node(node).child(self.node(node).len() - 1),
            }
        };
        first..last + 1
    }

    /// Visits every cell with its level, the root first: its box, and what is in it.
    pub(super) fn visit_cells(&self, mut visit: impl FnMut(usize, &Aabb3d, Child)) {
        self.descend_cells(|level, aabb, child| {
            visit(level, aabb, child);
            Descend::Into
        });
    }

    /// The same, and goes below a cell only where `visit` says so.
    pub(super) fn descend_cells(&self, mut visit: impl FnMut(usize, &Aabb3d, Child) -> Descend) {
        let mut stack: Vec<(usize, Aabb3d, Child)> = Vec::new();
        stack.extend(self.bounds().map(|bounds| (0, bounds, Child::Node(ROOT))));
        while let Some((level, aabb, child)) = stack.pop() {
            match visit(level, &aabb, child) {
                Descend::Into => {}
                Descend::Past => continue,
                Descend::Stop => return,
            }
            if let Child::Node(node) = child {
                let first = stack.len();
                stack.extend(self.node(node).lanes().map(|(aabb, child)| (level + 1, aabb, child)));
                stack[first..].reverse();
            }
        }
    }

    /// The number of nodes on the longest way down.
    pub(super) fn depth(&self) -> usize {
        let mut depth = 0;
        self.visit_cells(|level, _, child| {
            if let Child::Node(_) = child {
                depth = depth.max(level + 1);
            }
        });
        depth
    }

    /// See [`KdTree::sah_cost`](super::KdTree::sah_cost).
    pub(super) fn sah_cost(&self) -> f32 {
        let area = |aabb: &Aabb3d| f64::from(aabb.visible_area());
        let total: f64 = (self.nodes.iter().flat_map(WideNode::lanes))
            .map(|(aabb, _)| area(&aabb))
            .sum();
        let whole = self.bounds().map_or(0.0, |bounds| area(&bounds));
        if whole > 0.0 { (total / whole) as f32 } else { 0.0 }
    }

    /// Visits the leaves whose boxes a query meets, nearest first, as far as to `limit`, which `leaf` may lower.
    ///
    /// `leaf` gets the leaf and where it is met; `announce` gets it some time before. `enter` gets each node before what
    /// is in it.
    #[inline(always)]
    pub(super) fn visit_in_order<S: Simd, Q: Query>(
        &self,
        simd: S,
        query: &Q,
        limit: f32,
        enter: impl FnMut(NodeIndex),
        announce: impl Fn(u32),
        leaf: impl FnMut(u32, f32, &mut f32) -> ControlFlow<()>,
    ) {
        if self.nodes.is_empty() {
            return;
        }
        if Q::MEETS_FEW {
            self.visit_sorted(simd, query, limit, enter, announce, leaf);
        } else {
            self.visit_chosen(simd, query, limit, enter, announce, leaf);
        }
    }

    /// [`visit_in_order`](Self::visit_in_order) with the lanes sorted when their node is visited: the faster way where
    /// few of them are met.
    #[inline(always)]
    fn visit_sorted<S: Simd>(
        &self,
        simd: S,
        query: &impl Query,
        mut limit: f32,
        mut enter: impl FnMut(NodeIndex),
        announce: impl Fn(u32),
        mut leaf: impl FnMut(u32, f32, &mut f32) -> ControlFlow<()>,
    ) {
        let mut stack: Stack<(f32, Child)> = smallvec![(0.0, Child::Node(ROOT))];
        while let Some((at, child)) = stack.pop() {
            if at > limit {
                continue;
            }
            match child {
                Child::Leaf(index) => {
                    if leaf(index, at, &mut limit).is_break() {
                        return;
                    }
                }
                Child::Node(index) => {
                    enter(index);
                    let node = self.node(index);
                    let (lanes, ats) = query.meet(simd, node.into(), limit);
                    let ats = simd.store(ats);
                    let first = stack.len();
                    for lane in lanes_of(lanes) {
                        let child = node.child(lane);
                        match child {
                            Child::Node(index) => prefetch(self.node(index)),
                            Child::Leaf(index) => announce(index),
                        }
                        stack.push((ats[lane], child));
                    }
                    sort_far_to_near(&mut stack[first..]);
                }
            }
        }
    }

    /// [`visit_in_order`](Self::visit_in_order) with the next lane chosen when it is its turn: the faster way where most
    /// are met, and most of those are out of reach when their turn has come.
    #[inline(always)]
    fn visit_chosen<S: Simd>(
        &self,
        simd: S,
        query: &impl Query,
        mut limit: f32,
        mut enter: impl FnMut(NodeIndex),
        announce: impl Fn(u32),
        mut leaf: impl FnMut(u32, f32, &mut f32) -> ControlFlow<()>,
    ) {
        let infinity = simd.splat(f32::INFINITY);
        let mut frames: SmallVec<[Frame; 16]> = SmallVec::new();
        let mut next = ROOT;
        loop {
            enter(next);
            let node = self.node(next);
            let (waiting, ats) = query.meet(simd, node.into(), limit);
            let ats = simd.store(simd.select(waiting, ats, infinity));
            for lane in lanes_of(waiting) {
                match node.child(lane) {
                    // While everything is in reach, on the way to the first leaf, most of it will not be visited.
                    Child::Node(_) if limit == f32::INFINITY => {}
                    Child::Node(index) => prefetch(self.node(index)),
                    Child::Leaf(index) => announce(index),
                }
            }
            frames.push(Frame {
                node: next,
                waiting,
                ats,
            });
            next = loop {
                let Some(frame) = frames.last_mut() else { return };
                let ats = simd.load(&frame.ats);
                let nearest = simd.min_lane(ats);
                let lanes = simd.le(ats, simd.splat(nearest)) & frame.waiting;
                if lanes == 0 || nearest > limit {
                    frames.pop();
                    continue;
                }
                let lane = lanes.trailing_zeros() as usize % LANES;
                frame.ats[lane] = f32::INFINITY;
                frame.waiting &= !(1 << lane);
                match self.node(frame.node).child(lane) {
                    Child::Node(index) => break index,
                    Child::Leaf(index) => {
                        if leaf(index, nearest, &mut limit).is_break() {
                            return;
                        }
                    }
                }
            };
        }
    }

    /// Visits the leaves whose boxes may touch a region, in no order.
    ///
    /// `leaf` gets the leaf, and its box unless it is known that all of it touches the region.
    #[inline(always)]
    pub(super) fn visit_touching<S: Simd>(
        &self,
        simd: S,
        outline: &OutlineKind,
        mut leaf: impl FnMut(u32, Option<Aabb3d>) -> ControlFlow<()>,
    ) {
        if self.nodes.is_empty() {
            return;
        }
        let mut stack: Stack<NodeIndex> = smallvec![ROOT];
        while let Some(index) = stack.pop() {
            let node = self.node(index);
            let touching = outline.may_touch(simd, node.into());
            if touching == 0 {
                continue;
            }
            let contained = outline.contains(simd, node.into());
            for lane in lanes_of(touching) {
                let child = node.child(lane);
                let flow = if contained & 1 << lane != 0 {
                    self.leaves(child).try_for_each(|index| leaf(index, None))
                } else {
                    match child {
                        Child::Leaf(index) => leaf(index, Some(node.aabb(lane))),
                        Child::Node(index) => {
                            prefetch(self.node(index));
                            stack.push(index);
                            ControlFlow::Continue(())
                        }
                    }
                };
                if flow.is_break() {
                    return;
                }
            }
        }
    }

    /// Visits the pairs of leaves whose boxes touch, each once; a leaf with itself too.
    #[inline(always)]
    pub(super) fn visit_pairs<S: Simd>(&self, simd: S, mut visit: impl FnMut(u32, u32) -> ControlFlow<()>) {
        if self.nodes.is_empty() {
            return;
        }
        let mut stack: SmallVec<[(Child, Child); 256]> = smallvec![(Child::Node(ROOT), Child::Node(ROOT))];
        while let Some(pair) = stack.pop() {
            match pair {
                (Child::Leaf(a), Child::Leaf(b)) => {
                    if visit(a, b).is_break() {
                        return;
                    }
                }
                (Child::Leaf(a), Child::Node(b)) | (Child::Node(b), Child::Leaf(a)) => {
                    let node = self.node(b);
                    let touching = Splat::of(simd, &self.aabb(a)).touching(simd, node.into());
                    stack.extend(lanes_of(touching).map(|lane| (Child::Leaf(a), node.child(lane))));
                }
                (Child::Node(a), Child::Node(b)) => {
                    let (node_a, node_b) = (self.node(a), self.node(b));
                    for (lane, (aabb, child)) in node_a.lanes().enumerate() {
                        let others = if a == b { u32::MAX << lane } else { u32::MAX };
                        let touching = Splat::of(simd, &aabb).touching(simd, node_b.into()) & others;
                        stack.extend(lanes_of(touching).map(|lane| (child, node_b.child(lane))));
                    }
                }
            }
        }
    }
}

/// Sorts by insertion: there are eight at most, and mostly two or three.
#[inline(always)]
fn sort_far_to_near<T: Copy>(entries: &mut [(f32, T)]) {
    for sorted in 1..entries.len() {
        let new = entries[sorted];
        let mut place = sorted;
        while place > 0 && entries[place - 1].0 < new.0 {
            entries[place] = entries[place - 1];
            place -= 1;
        }
        entries[place] = new;
    }
}
