//! How queries go down a hierarchy of [`WideNode`]s: ordered by distance, or all that a region touches.

use std::ops::ControlFlow;

use bevy::math::{
    Vec3A,
    bounding::{Aabb3d, BoundingSphere},
};
use smallvec::SmallVec;

use super::{
    Visit,
    region::{Outline, OutlineKind, Plane},
    simd::{LANES, Simd, Task, dispatch, prefetch},
    wide::{Child, NodeIndex, PackedChild, WideNode},
};
use crate::geometry::{ray::Ray, ray::aabb::SlabRay, tolerance};

/// Something that comes closer to boxes the farther it goes: a ray, or a sphere that grows.
pub(crate) trait Approach {
    /// The lanes whose boxes are met at or before `limit`, and where each is met: not negative.
    fn meets<S: Simd>(&self, simd: S, node: &WideNode, limit: f32) -> (u32, S::F32s);
}

/// A ray that meets a box where it enters it, exactly as [`Ray::aabb_intersection_at`] tells; with boxes that are first
/// grown by a reach if `GROWN`.
pub(crate) struct Entering<const GROWN: bool> {
    ray: SlabRay,
    reach: [f32; 3],
}

impl Entering<false> {
    pub(crate) fn new(ray: &Ray) -> Self {
        Self {
            ray: slab_ray(ray),
            reach: [0.0; 3],
        }
    }
}

impl Entering<true> {
    /// For boxes that are [grown](super::sweep::grown) by `reach`.
    pub(crate) fn grown(ray: &Ray, reach: Vec3A) -> Self {
        Self {
            ray: slab_ray(ray),
            reach: reach.to_array(),
        }
    }
}

fn slab_ray(ray: &Ray) -> SlabRay {
    let mut ray = ray.slab_ray();
    // Not -0.0: parameters are compared by their bits.
    ray.t_min += 0.0;
    ray
}

impl<const GROWN: bool> Approach for Entering<GROWN> {
    #[inline(always)]
    fn meets<S: Simd>(&self, simd: S, node: &WideNode, limit: f32) -> (u32, S::F32s) {
        let ray = &self.ray;
        let t_min = simd.splat(ray.t_min);
        let (mut enter, mut leave) = (t_min, simd.splat(limit));
        for axis in 0..3 {
            let (mut min, mut max) = (simd.load(&node.min[axis]), simd.load(&node.max[axis]));
            if GROWN {
                let (reach, epsilon) = (simd.splat(self.reach[axis]), simd.splat(f32::EPSILON));
                let zero = simd.splat(0.0);
                min = simd.sub(min, reach);
                min = simd.sub(min, simd.mul(simd.max(min, simd.sub(zero, min)), epsilon));
                max = simd.add(max, reach);
                max = simd.add(max, simd.mul(simd.max(max, simd.sub(zero, max)), epsilon));
            }
            let (near, far) = if ray.forward[axis] { (min, max) } else { (max, min) };
            let (origin, recip) = (simd.splat(ray.origin[axis]), simd.splat(ray.direction_recip[axis]));
            // A NaN changes nothing: see `Ray::aabb_intersection_at`, which this equals.
            enter = simd.max(simd.mul(simd.sub(near, origin), recip), enter);
            leave = simd.min(simd.mul(simd.sub(far, origin), recip), leave);
        }
        enter = simd.max(simd.mul(enter, simd.splat(1.0 - tolerance::SLAB)), t_min);
        leave = simd.mul(leave, simd.splat(1.0 + tolerance::SLAB));
        let reached = simd.le(enter, leave) & simd.le(enter, simd.splat(limit.min(f32::MAX)));
        (reached, enter)
    }
}

/// A sphere that grows around a point and meets a box at the square of its distance, as
/// [`distance_squared`](super::region::distance_squared) tells.
pub(crate) struct Growing {
    pub center: Vec3A,
}

impl Approach for Growing {
    #[inline(always)]
    fn meets<S: Simd>(&self, simd: S, node: &WideNode, limit: f32) -> (u32, S::F32s) {
        let distances = distances_squared(simd, node, self.center);
        (simd.le(distances, simd.splat(limit)), distances)
    }
}

#[inline(always)]
fn distances_squared<S: Simd>(simd: S, node: &WideNode, point: Vec3A) -> S::F32s {
    let zero = simd.splat(0.0);
    let mut sum = zero;
    for axis in 0..3 {
        let at = simd.splat(point[axis]);
        let below = simd.sub(simd.load(&node.min[axis]), at);
        let above = simd.sub(at, simd.load(&node.max[axis]));
        let offset = simd.max(zero, simd.max(below, above));
        sum = simd.add(sum, simd.mul(offset, offset));
    }
    sum
}

/// Visits the leaves with a bit of `mask` that are met at or before `limit`, near ones first, with where they are met.
#[inline]
pub(crate) fn visit_in_order(
    nodes: &[WideNode],
    root: NodeIndex,
    mask: u32,
    limit: f32,
    approach: impl Approach,
    visit: impl FnMut(u32, f32) -> Visit,
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

struct InOrder<'a, A, F> {
    nodes: &'a [WideNode],
    root: NodeIndex,
    mask: u32,
    limit: f32,
    approach: A,
    visit: F,
}

/// A child and where it is met, which comes first and so decides the order: it is not negative, and the bits of such
/// numbers are ordered as they are.
type Waiting = u64;

impl<A: Approach, F: FnMut(u32, f32) -> Visit> Task for InOrder<'_, A, F> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let mut stack: SmallVec<[Waiting; 96]> = SmallVec::new();
        let mut child = Child::Node(self.root);
        let mut at = 0.0;
        loop {
            match child {
                Child::Node(node) => {
                    let node = &self.nodes[node as usize];
                    let (reached, met_at) = self.approach.meets(simd, node, self.limit);
                    let mut met = reached & simd.with_any_bit(&node.masks, self.mask);
                    if met != 0 {
                        let met_at = simd.store(met_at);
                        let lane = met.trailing_zeros() as usize % LANES;
                        let mut nearest = wait(node, lane, &met_at);
                        met &= met - 1;
                        let first = stack.len();
                        while met != 0 {
                            let lane = met.trailing_zeros() as usize % LANES;
                            let mut other = wait(node, lane, &met_at);
                            met &= met - 1;
                            (nearest, other) = (nearest.min(other), nearest.max(other));
                            stack.push(other);
                            if let Child::Node(node) = node.child(lane) {
                                prefetch(&self.nodes[node as usize]);
                            }
                        }
                        sort_far_to_near(&mut stack[first..]);
                        (at, child) = unpack(nearest);
                        continue;
                    }
                }
                Child::Leaf(leaf) => match (self.visit)(leaf, at) {
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
fn sort_far_to_near(entries: &mut [Waiting]) {
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

/// A region, held against eight boxes at once: the same answers as its [`Outline`] gives one by one.
trait LaneRegion {
    /// The lanes whose boxes may have something inside that touches the region.
    fn may_touch<S: Simd>(&self, simd: S, node: &WideNode) -> u32;

    /// The lanes in whose boxes everything touches the region.
    fn contains<S: Simd>(&self, simd: S, node: &WideNode) -> u32;
}

impl LaneRegion for Aabb3d {
    #[inline(always)]
    fn may_touch<S: Simd>(&self, simd: S, node: &WideNode) -> u32 {
        let mut lanes = u32::MAX;
        for axis in 0..3 {
            lanes &= simd.le(simd.load(&node.min[axis]), simd.splat(self.max[axis]));
            lanes &= simd.le(simd.splat(self.min[axis]), simd.load(&node.max[axis]));
        }
        lanes
    }

    #[inline(always)]
    fn contains<S: Simd>(&self, simd: S, node: &WideNode) -> u32 {
        let mut lanes = u32::MAX;
        for axis in 0..3 {
            lanes &= simd.le(simd.splat(self.min[axis]), simd.load(&node.min[axis]));
            lanes &= simd.le(simd.load(&node.max[axis]), simd.splat(self.max[axis]));
        }
        lanes
    }
}

impl LaneRegion for BoundingSphere {
    #[inline(always)]
    fn may_touch<S: Simd>(&self, simd: S, node: &WideNode) -> u32 {
        let distances = distances_squared(simd, node, self.center);
        simd.le(distances, simd.splat(self.radius() * self.radius()))
    }

    #[inline(always)]
    fn contains<S: Simd>(&self, simd: S, node: &WideNode) -> u32 {
        let mut sum = simd.splat(0.0);
        for axis in 0..3 {
            let center = simd.splat(self.center[axis]);
            let below = simd.sub(center, simd.load(&node.min[axis]));
            let above = simd.sub(simd.load(&node.max[axis]), center);
            let farthest = simd.max(below, above);
            sum = simd.add(sum, simd.mul(farthest, farthest));
        }
        let reach = self.radius() * self.radius() * (1.0 - tolerance::REGION_PLANE);
        simd.le(sum, simd.splat(reach))
    }
}

impl LaneRegion for [Plane] {
    #[inline(always)]
    fn may_touch<S: Simd>(&self, simd: S, node: &WideNode) -> u32 {
        let mut excluded = 0;
        for plane in self {
            excluded |= simd.lt(signed_distances::<S, true>(simd, plane, node), simd.splat(0.0));
        }
        !excluded
    }

    #[inline(always)]
    fn contains<S: Simd>(&self, simd: S, node: &WideNode) -> u32 {
        let mut lanes = u32::MAX;
        for plane in self {
            lanes &= simd.le(simd.splat(0.0), signed_distances::<S, false>(simd, plane, node));
        }
        lanes
    }
}

/// The signed distances of the corners that are farthest along the normal, or of those that are farthest against it.
#[inline(always)]
fn signed_distances<S: Simd, const ALONG: bool>(simd: S, plane: &Plane, node: &WideNode) -> S::F32s {
    let corner = |axis: usize| {
        if (plane.normal[axis] >= 0.0) == ALONG {
            &node.max[axis]
        } else {
            &node.min[axis]
        }
    };
    let (x, y, z) = (corner(0), corner(1), corner(2));
    let x = simd.mul(simd.splat(plane.normal.x), simd.load(x));
    let y = simd.mul(simd.splat(plane.normal.y), simd.load(y));
    let z = simd.mul(simd.splat(plane.normal.z), simd.load(z));
    simd.add(simd.add(simd.add(x, y), z), simd.splat(plane.d))
}

/// What the bounds and the planes of a polytope have in common.
struct LanePolytope<'a> {
    bounds: &'a Aabb3d,
    planes: &'a [Plane],
}

impl LaneRegion for LanePolytope<'_> {
    #[inline(always)]
    fn may_touch<S: Simd>(&self, simd: S, node: &WideNode) -> u32 {
        let mut lanes = self.bounds.may_touch(simd, node);
        for plane in self.planes {
            if lanes & 0xff == 0 {
                break;
            }
            let distances = signed_distances::<S, true>(simd, plane, node);
            let rounding = roundings(simd, plane, node);
            lanes &= !simd.lt(simd.add(distances, rounding), simd.splat(0.0));
        }
        lanes
    }

    #[inline(always)]
    fn contains<S: Simd>(&self, simd: S, node: &WideNode) -> u32 {
        let mut lanes = self.bounds.contains(simd, node);
        for plane in self.planes {
            if lanes & 0xff == 0 {
                break;
            }
            let distances = signed_distances::<S, false>(simd, plane, node);
            lanes &= simd.le(roundings(simd, plane, node), distances);
        }
        lanes
    }
}

/// How far off the signed distances may be.
#[inline(always)]
fn roundings<S: Simd>(simd: S, plane: &Plane, node: &WideNode) -> S::F32s {
    let zero = simd.splat(0.0);
    let mut sum = simd.splat(plane.d.abs());
    for axis in 0..3 {
        let (min, max) = (simd.load(&node.min[axis]), simd.load(&node.max[axis]));
        let magnitude = simd.max(simd.max(min, simd.sub(zero, min)), simd.max(max, simd.sub(zero, max)));
        sum = simd.add(sum, simd.mul(simd.splat(plane.normal[axis].abs()), magnitude));
    }
    simd.mul(sum, simd.splat(tolerance::REGION_PLANE))
}

/// What a region query found.
pub(crate) enum Found {
    /// A leaf in a lane of a node, whose box is the given one where the region is larger than what was tested, and must
    /// still be held against it.
    Leaf { leaf: u32, to_test: Option<Aabb3d> },
    /// A node below which everything touches the region.
    Whole(NodeIndex),
}

/// Visits what has a bit of `mask` and may touch the region with this outline.
#[inline]
pub(crate) fn visit_region(
    nodes: &[WideNode],
    root: NodeIndex,
    mask: u32,
    outline: &Outline,
    visit: impl FnMut(Found) -> ControlFlow<()>,
) {
    match &outline.0 {
        OutlineKind::Aabb(aabb) => dispatch(InRegion::<_, _, true> {
            nodes,
            root,
            mask,
            region: aabb,
            visit,
        }),
        OutlineKind::Sphere(sphere) => dispatch(InRegion::<_, _, true> {
            nodes,
            root,
            mask,
            region: sphere,
            visit,
        }),
        OutlineKind::HalfSpaces(planes) => dispatch(InRegion::<_, _, true> {
            nodes,
            root,
            mask,
            region: &planes[..],
            visit,
        }),
        OutlineKind::Polytope { bounds, planes } => dispatch(InRegion::<_, _, false> {
            nodes,
            root,
            mask,
            region: &LanePolytope { bounds, planes },
            visit,
        }),
    }
}

/// `EXACT` if the lanes of the region tell all that there is to know.
struct InRegion<'a, R: ?Sized, F, const EXACT: bool> {
    nodes: &'a [WideNode],
    root: NodeIndex,
    mask: u32,
    region: &'a R,
    visit: F,
}

impl<R: LaneRegion + ?Sized, F: FnMut(Found) -> ControlFlow<()>, const EXACT: bool> Task for InRegion<'_, R, F, EXACT> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let mut stack: SmallVec<[NodeIndex; 64]> = SmallVec::new();
        stack.push(self.root);
        while let Some(node) = stack.pop() {
            let node = &self.nodes[node as usize];
            let mut touching = self.region.may_touch(simd, node) & simd.with_any_bit(&node.masks, self.mask);
            if touching == 0 {
                continue;
            }
            let contained = self.region.contains(simd, node);
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
                    Child::Leaf(leaf) => Found::Leaf {
                        leaf,
                        to_test: (!EXACT && !is_contained).then(|| node.aabb(lane)),
                    },
                };
                if (self.visit)(found).is_break() {
                    return;
                }
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
            let filter = simd.with_any_bit(&b.masks, self.mask);
            let mut a_lanes = simd.with_any_bit(&a.masks, self.mask);
            while a_lanes != 0 {
                let lane = a_lanes.trailing_zeros() as usize % LANES;
                a_lanes &= a_lanes - 1;
                let a_box = a.aabb(lane);
                let mut touching = a_box.may_touch(simd, b) & filter;
                if within_one {
                    // Those that come after, and what is inside of the child itself.
                    touching &= !0 << lane << 1;
                    if let Child::Node(child) = a.child(lane) {
                        stack.push((child, child));
                    }
                }
                while touching != 0 {
                    let other_lane = touching.trailing_zeros() as usize % LANES;
                    touching &= touching - 1;
                    match (a.child(lane), b.child(other_lane)) {
                        (Child::Node(a), Child::Node(b)) => stack.push((a, b)),
                        (Child::Leaf(a), Child::Leaf(b)) => {
                            if (self.visit)(a, b).is_break() {
                                return;
                            }
                        }
                        (Child::Leaf(a), Child::Node(b)) => {
                            let visit = &mut self.visit;
                            if leaf_pairs(simd, others, b, self.mask, &a_box, |b| visit(a, b)).is_break() {
                                return;
                            }
                        }
                        (Child::Node(a), Child::Leaf(b_leaf)) => {
                            let visit = &mut self.visit;
                            let b_box = b.aabb(other_lane);
                            if leaf_pairs(simd, self.nodes, a, self.mask, &b_box, |a| visit(a, b_leaf)).is_break() {
                                return;
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Visits the leaves below a node whose boxes touch `aabb`.
#[inline(always)]
fn leaf_pairs<S: Simd>(
    simd: S,
    nodes: &[WideNode],
    root: NodeIndex,
    mask: u32,
    aabb: &Aabb3d,
    mut visit: impl FnMut(u32) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let mut stack: SmallVec<[NodeIndex; 64]> = SmallVec::new();
    stack.push(root);
    while let Some(node) = stack.pop() {
        let node = &nodes[node as usize];
        let mut touching = aabb.may_touch(simd, node) & simd.with_any_bit(&node.masks, mask);
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
