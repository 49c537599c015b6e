//! How queries go down a hierarchy of [`WideNode`]s: ordered by distance, or all that a region touches.

use std::ops::ControlFlow;

use bevy::math::bounding::Aabb3d;
use smallvec::SmallVec;

use super::{
    Region, Sweep, Visit,
    lanes::{Approach, Entering, LanePolytope, LaneRegion, Splat},
    region::{Outline, OutlineKind},
    simd::{LANES, Simd, Task, dispatch, prefetch},
    sweep::slack_reach,
    wide::{Child, EVERY_MASK, NodeIndex, PackedChild, WideNode},
};

/// What is done with the leaves that a descent comes to. A closure will do where nothing is to be done eight lanes at a
/// time.
pub(crate) trait VisitLeaf {
    /// Whether a leaf that is met in no order waits for its turn, for [`prefetch`](Self::prefetch) to have an effect.
    const WAITS: bool;

    /// Visits a leaf that is met at `at`.
    fn visit<S: Simd>(&mut self, simd: S, leaf: u32, at: f32) -> Visit;

    /// Brings close what a visit will read.
    fn prefetch(&self, leaf: u32);

    /// Is told of each node whose children are met in order, before they are. For who [writes down](super::trace) the way;
    /// nothing is compiled of it for others.
    #[inline(always)]
    fn enter(&mut self, _node: NodeIndex) {}
}

impl<F: FnMut(u32, f32) -> Visit> VisitLeaf for F {
    const WAITS: bool = false;

    #[inline(always)]
    fn visit<S: Simd>(&mut self, _simd: S, leaf: u32, at: f32) -> Visit {
        self(leaf, at)
    }

    #[inline(always)]
    fn prefetch(&self, _leaf: u32) {}
}

/// Visits the leaves with a bit of `mask` that are met at or before `limit`, near ones first, with where they are met.
#[inline]
pub(crate) fn visit_in_order(
    nodes: &[WideNode],
    root: NodeIndex,
    mask: u32,
    limit: f32,
    approach: impl Approach,
    visit: impl VisitLeaf,
) {
    dispatch(InOrder {
        nodes,
        root,
        mask,
        limit,
        approach,
        visit,
    });
}

/// The same within a task.
#[inline(always)]
pub(crate) fn visit_in_order_with<S: Simd>(
    simd: S,
    nodes: &[WideNode],
    root: NodeIndex,
    limit: f32,
    approach: impl Approach,
    visit: impl VisitLeaf,
) {
    InOrder {
        nodes,
        root,
        mask: EVERY_MASK,
        limit,
        approach,
        visit,
    }
    .run(simd);
}

struct InOrder<'a, A, V> {
    nodes: &'a [WideNode],
    root: NodeIndex,
    mask: u32,
    limit: f32,
    approach: A,
    visit: V,
}

/// Visits the leaves with a bit of `mask` whose boxes, which `aabb_of` tells, the moving shape touches, with the parameter
/// at which it first does.
#[inline]
pub(crate) fn visit_sweep(
    nodes: &[WideNode],
    root: NodeIndex,
    mask: u32,
    sweep: &impl Sweep,
    aabb_of: impl Fn(u32) -> Aabb3d,
    mut visit: impl FnMut(u32, f32) -> Visit,
) {
    // A contact beyond the range of parameters is none.
    let mut limit = sweep.ray().t_max().min(f32::MAX);
    let approach = Entering::grown(sweep.ray(), slack_reach(sweep));
    visit_in_order(nodes, root, mask, limit, approach, |leaf, _| {
        let Some(t) = sweep.intersection_at(&aabb_of(leaf)).filter(|&t| t <= limit) else {
            return Visit::Continue;
        };
        let wish = visit(leaf, t);
        if let Visit::Shorten(t) = wish {
            limit = limit.min(t);
        }
        wish
    });
}

/// A child and where it is met, which comes first and so decides the order: it is not negative, and the bits of such
/// numbers are ordered as they are.
type Waiting = u64;

impl<A: Approach, V: VisitLeaf> Task for InOrder<'_, A, V> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let mut stack = WaitingStack::new();
        let mut child = Child::Node(self.root);
        let mut at = 0.0;
        loop {
            match child {
                Child::Node(node) => {
                    self.visit.enter(node);
                    let node = &self.nodes[node as usize];
                    let (reached, met_at) = self.approach.meets(simd, node.into(), self.limit);
                    let mut met = reached & simd.with_any_bit(&node.masks, self.mask);
                    if met != 0 {
                        let met_at = simd.store(met_at);
                        let lane = met.trailing_zeros() as usize % LANES;
                        let mut nearest = wait(node, lane, &met_at);
                        met &= met - 1;
                        let first = stack.reserve(LANES);
                        while met != 0 {
                            let lane = met.trailing_zeros() as usize % LANES;
                            let mut other = wait(node, lane, &met_at);
                            met &= met - 1;
                            (nearest, other) = (nearest.min(other), nearest.max(other));
                            stack.push(other);
                            match node.child(lane) {
                                Child::Node(node) => prefetch(&self.nodes[node as usize]),
                                Child::Leaf(leaf) => self.visit.prefetch(leaf),
                            }
                        }
                        sort_far_to_near(stack.since(first));
                        (at, child) = unpack(nearest);
                        continue;
                    }
                }
                Child::Leaf(leaf) => match self.visit.visit(simd, leaf, at) {
                    Visit::Continue => {}
                    Visit::Shorten(limit) => self.limit = if limit < self.limit { limit } else { self.limit },
                    Visit::Stop => return,
                },
            }
            loop {
                let Some(waiting) = stack.pop() else { return };
                (at, child) = unpack(waiting);
                if at <= self.limit {
                    break;
                }
            }
        }
    }
}

/// What is still to be visited, the nearest last.
pub(super) struct WaitingStack {
    top: [Waiting; WaitingStack::ROOM],
    len: usize,
    /// What lies below, from a hierarchy that is deeper than any but an ill one.
    bottom: Vec<Waiting>,
}

impl WaitingStack {
    const ROOM: usize = 96;

    #[inline(always)]
    pub(super) fn new() -> Self {
        Self {
            top: [0; Self::ROOM],
            len: 0,
            bottom: Vec::new(),
        }
    }

    /// Makes room for so many, and returns where they will begin.
    #[inline(always)]
    pub(super) fn reserve(&mut self, count: usize) -> usize {
        if self.len + count > Self::ROOM {
            self.bottom.extend_from_slice(&self.top[..self.len]);
            self.len = 0;
        }
        self.len
    }

    #[inline(always)]
    pub(super) fn push(&mut self, waiting: Waiting) {
        self.top[self.len] = waiting;
        self.len += 1;
    }

    #[inline(always)]
    pub(super) fn since(&mut self, first: usize) -> &mut [Waiting] {
        &mut self.top[first..self.len]
    }

    #[inline(always)]
    pub(super) fn pop(&mut self) -> Option<Waiting> {
        if self.len == 0 {
            return self.bottom.pop();
        }
        self.len -= 1;
        Some(self.top[self.len])
    }
}

#[inline(always)]
fn wait(node: &WideNode, lane: usize, met_at: &[f32; LANES]) -> Waiting {
    Waiting::from(met_at[lane].to_bits()) << 32 | Waiting::from(node.children[lane].bits())
}

#[inline(always)]
fn unpack(waiting: Waiting) -> (f32, Child) {
    (
        f32::from_bits((waiting >> 32) as u32),
        PackedChild::from_bits(waiting as u32).unpack(),
    )
}

/// Sorts by insertion: there are seven at most, and mostly one or two.
#[inline(always)]
pub(super) fn sort_far_to_near(entries: &mut [Waiting]) {
    for i in 1..entries.len() {
        let entry = entries[i];
        let mut j = i;
        while j > 0 && entries[j - 1] < entry {
            entries[j] = entries[j - 1];
            j -= 1;
        }
        entries[j] = entry;
    }
}

/// Visits the leaves with a bit of `mask` that are met at or before `limit`, in no order, until a visit stops. They come
/// without where they are met.
#[inline]
pub(crate) fn visit_any(
    nodes: &[WideNode],
    root: NodeIndex,
    mask: u32,
    limit: f32,
    approach: impl Approach,
    visit: impl VisitLeaf,
) {
    dispatch(InAnyOrder {
        nodes,
        root,
        mask,
        limit,
        approach,
        visit,
    });
}

/// The same within a task.
#[inline(always)]
pub(crate) fn visit_any_with<S: Simd>(
    simd: S,
    nodes: &[WideNode],
    root: NodeIndex,
    limit: f32,
    approach: impl Approach,
    visit: impl VisitLeaf,
) {
    InAnyOrder {
        nodes,
        root,
        mask: EVERY_MASK,
        limit,
        approach,
        visit,
    }
    .run(simd);
}

struct InAnyOrder<'a, A, V> {
    nodes: &'a [WideNode],
    root: NodeIndex,
    mask: u32,
    limit: f32,
    approach: A,
    visit: V,
}

impl<A: Approach, V: VisitLeaf> Task for InAnyOrder<'_, A, V> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let mut stack: SmallVec<[PackedChild; 64]> = SmallVec::new();
        stack.push(PackedChild::pack(Child::Node(self.root)));
        while let Some(child) = stack.pop() {
            let node = match child.unpack() {
                Child::Node(node) => &self.nodes[node as usize],
                Child::Leaf(leaf) => {
                    if matches!(self.visit.visit(simd, leaf, 0.0), Visit::Stop) {
                        return;
                    }
                    continue;
                }
            };
            let (reached, _) = self.approach.meets(simd, node.into(), self.limit);
            let mut met = reached & simd.with_any_bit(&node.masks, self.mask);
            while met != 0 {
                let lane = met.trailing_zeros() as usize % LANES;
                met &= met - 1;
                match node.child(lane) {
                    Child::Node(child) => prefetch(&self.nodes[child as usize]),
                    Child::Leaf(leaf) if V::WAITS => self.visit.prefetch(leaf),
                    Child::Leaf(leaf) => {
                        if matches!(self.visit.visit(simd, leaf, 0.0), Visit::Stop) {
                            return;
                        }
                        continue;
                    }
                }
                stack.push(node.children[lane]);
            }
        }
    }
}

/// What a region query found.
pub(crate) enum Found {
    /// A leaf whose box touches the region.
    Leaf(u32),
    /// A node below which everything touches the region.
    Whole(NodeIndex),
}

/// Visits what has a bit of `mask` and touches the region.
#[inline]
pub(crate) fn visit_region(
    nodes: &[WideNode],
    root: NodeIndex,
    mask: u32,
    region: &impl Region,
    visit: impl FnMut(Found) -> ControlFlow<()>,
) {
    visit_outline(nodes, root, mask, &region.outline(), |aabb| region.touches(aabb), visit);
}

/// Visits what has a bit of `mask` and touches a region with this outline. Of leaves that may, `touches` decides, unless
/// the outline is the region itself.
#[inline]
pub(crate) fn visit_outline(
    nodes: &[WideNode],
    root: NodeIndex,
    mask: u32,
    outline: &Outline,
    touches: impl Fn(&Aabb3d) -> bool,
    visit: impl FnMut(Found) -> ControlFlow<()>,
) {
    // Where the lanes tell all that there is to know, nothing else is asked.
    let exact = |_: &Aabb3d| true;
    match &outline.0 {
        OutlineKind::Aabb(lanes) => in_region(nodes, root, mask, lanes, exact, visit),
        OutlineKind::Sphere(lanes) => in_region(nodes, root, mask, lanes, exact, visit),
        OutlineKind::HalfSpaces(planes) => in_region(nodes, root, mask, &planes[..], exact, visit),
        OutlineKind::Polytope { bounds, planes } => {
            let lanes = LanePolytope { bounds, planes };
            in_region(nodes, root, mask, &lanes, touches, visit);
        }
    }
}

#[inline]
fn in_region(
    nodes: &[WideNode],
    root: NodeIndex,
    mask: u32,
    lanes: &(impl LaneRegion + ?Sized),
    touches: impl Fn(&Aabb3d) -> bool,
    visit: impl FnMut(Found) -> ControlFlow<()>,
) {
    dispatch(InRegion {
        nodes,
        root,
        mask,
        lanes,
        touches,
        visit,
    });
}

struct InRegion<'a, R: ?Sized, T, F> {
    nodes: &'a [WideNode],
    root: NodeIndex,
    mask: u32,
    lanes: &'a R,
    /// Whether a leaf that the lanes let through touches the region.
    touches: T,
    visit: F,
}

impl<R, T, F> Task for InRegion<'_, R, T, F>
where
    R: LaneRegion + ?Sized,
    T: Fn(&Aabb3d) -> bool,
    F: FnMut(Found) -> ControlFlow<()>,
{
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let mut stack: SmallVec<[NodeIndex; 64]> = SmallVec::new();
        stack.push(self.root);
        while let Some(node) = stack.pop() {
            let node = &self.nodes[node as usize];
            let mut touching = self.lanes.may_touch(simd, node.into()) & simd.with_any_bit(&node.masks, self.mask);
            if touching == 0 {
                continue;
            }
            let contained = self.lanes.contains(simd, node.into());
            while touching != 0 {
                let lane = touching.trailing_zeros() as usize % LANES;
                touching &= touching - 1;
                let is_contained = contained >> lane & 1 != 0;
                let found = match node.child(lane) {
                    Child::Node(child) if is_contained => Found::Whole(child),
                    Child::Node(child) => {
                        prefetch(&self.nodes[child as usize]);
                        stack.push(child);
                        continue;
                    }
                    Child::Leaf(leaf) if is_contained || (self.touches)(&node.aabb(lane)) => Found::Leaf(leaf),
                    Child::Leaf(_) => continue,
                };
                if (self.visit)(found).is_break() {
                    return;
                }
            }
        }
    }
}

/// How much of a box is in a region whose own test is dear.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// Nothing, for certain.
    None,
    /// Anything, for all that is known.
    Some,
    /// All, for certain.
    All,
}

/// What a [descent](descend) does about a child.
pub(crate) enum Descent {
    /// Goes on, and down if the child is a node.
    Enter,
    /// Goes on without what is below.
    Skip,
    /// Ends.
    Stop,
}

/// Goes down a hierarchy, one box at a time, as `visit` says of each child that has a bit of `mask`: for regions that
/// eight lanes at once know nothing of.
pub(crate) fn descend(
    nodes: &[WideNode],
    root: NodeIndex,
    mask: u32,
    mut visit: impl FnMut(&Aabb3d, Child) -> Descent,
) {
    let mut stack: SmallVec<[NodeIndex; 64]> = SmallVec::new();
    stack.push(root);
    while let Some(node) = stack.pop() {
        let node = &nodes[node as usize];
        for lane in (0..LANES).filter(|&lane| node.masks[lane] & mask != 0) {
            let child = node.child(lane);
            match (visit(&node.aabb(lane), child), child) {
                (Descent::Enter, Child::Node(child)) => {
                    prefetch(&nodes[child as usize]);
                    stack.push(child);
                }
                (Descent::Enter | Descent::Skip, _) => {}
                (Descent::Stop, _) => return,
            }
        }
    }
}

/// Visits the leaves below a node that have a bit of `mask`.
pub(crate) fn visit_leaves(
    nodes: &[WideNode],
    root: NodeIndex,
    mask: u32,
    mut visit: impl FnMut(u32) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let mut stack: SmallVec<[NodeIndex; 64]> = SmallVec::new();
    stack.push(root);
    while let Some(node) = stack.pop() {
        let node = &nodes[node as usize];
        for lane in (0..LANES).filter(|&lane| node.masks[lane] & mask != 0) {
            match node.child(lane) {
                Child::Node(child) => {
                    prefetch(&nodes[child as usize]);
                    stack.push(child);
                }
                Child::Leaf(leaf) => visit(leaf)?,
            }
        }
    }
    ControlFlow::Continue(())
}

/// Visits each pair of leaves of two hierarchies whose boxes touch; within one hierarchy, if `other` is `None`, each pair
/// once.
#[inline]
pub(crate) fn visit_pairs(
    (nodes, root): (&[WideNode], NodeIndex),
    other: Option<(&[WideNode], NodeIndex)>,
    mask: u32,
    visit: impl FnMut(u32, u32) -> ControlFlow<()>,
) {
    dispatch(Pairs {
        nodes,
        root,
        other,
        mask,
        visit,
    });
}

struct Pairs<'a, F> {
    nodes: &'a [WideNode],
    root: NodeIndex,
    other: Option<(&'a [WideNode], NodeIndex)>,
    mask: u32,
    visit: F,
}

impl<F: FnMut(u32, u32) -> ControlFlow<()>> Task for Pairs<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        // Two nodes whose boxes touch, or twice the same: all pairs below the two.
        let mut stack: SmallVec<[(NodeIndex, NodeIndex); 128]> = SmallVec::new();
        let (others, same) = match self.other {
            Some((others, other_root)) => {
                stack.push((self.root, other_root));
                (others, false)
            }
            None => {
                stack.push((self.root, self.root));
                (self.nodes, true)
            }
        };
        while let Some((first, second)) = stack.pop() {
            let (a, b) = (&self.nodes[first as usize], &others[second as usize]);
            let within_one = same && first == second;
            let b_filter = simd.with_any_bit(&b.masks, self.mask);
            let mut a_lanes = simd.with_any_bit(&a.masks, self.mask);
            if !within_one {
                a_lanes &= Splat::of(simd, &b.bounds_with(simd)).touching(simd, a.into());
            }
            while a_lanes != 0 {
                let a_lane = a_lanes.trailing_zeros() as usize % LANES;
                a_lanes &= a_lanes - 1;
                let a_box = Splat::of_lane(simd, a.into(), a_lane);
                let mut b_lanes = a_box.touching(simd, b.into()) & b_filter;
                if within_one {
                    // Those that come after, and what is inside of the child itself.
                    b_lanes &= !0 << a_lane << 1;
                    if let Child::Node(child) = a.child(a_lane) {
                        prefetch(&self.nodes[child as usize]);
                        stack.push((child, child));
                    }
                }
                while b_lanes != 0 {
                    let b_lane = b_lanes.trailing_zeros() as usize % LANES;
                    b_lanes &= b_lanes - 1;
                    let visit = &mut self.visit;
                    let flow = match (a.child(a_lane), b.child(b_lane)) {
                        (Child::Node(a), Child::Node(b)) => {
                            stack.push((a, b));
                            ControlFlow::Continue(())
                        }
                        (Child::Leaf(a), Child::Leaf(b)) => visit(a, b),
                        (Child::Leaf(a), Child::Node(b)) => {
                            leaves_touching(simd, others, b, self.mask, &a_box, |b| visit(a, b))
                        }
                        (Child::Node(a), Child::Leaf(leaf)) => {
                            let b_box = Splat::of_lane(simd, b.into(), b_lane);
                            leaves_touching(simd, self.nodes, a, self.mask, &b_box, |a| visit(a, leaf))
                        }
                    };
                    if flow.is_break() {
                        return;
                    }
                }
            }
        }
    }
}

/// Visits the leaves below a node whose boxes touch a box.
#[inline(always)]
fn leaves_touching<S: Simd>(
    simd: S,
    nodes: &[WideNode],
    root: NodeIndex,
    mask: u32,
    aabb: &Splat<S>,
    mut visit: impl FnMut(u32) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let mut stack: SmallVec<[NodeIndex; 64]> = SmallVec::new();
    stack.push(root);
    while let Some(node) = stack.pop() {
        let node = &nodes[node as usize];
        let mut touching = aabb.touching(simd, node.into()) & simd.with_any_bit(&node.masks, mask);
        while touching != 0 {
            let lane = touching.trailing_zeros() as usize % LANES;
            touching &= touching - 1;
            match node.child(lane) {
                Child::Node(child) => stack.push(child),
                Child::Leaf(leaf) => visit(leaf)?,
            }
        }
    }
    ControlFlow::Continue(())
}
