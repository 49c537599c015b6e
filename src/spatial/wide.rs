//! Nodes of eight children, as all hierarchies of this crate have them, and how a ray goes down through them.
//!
//! The boxes of the children lie in the node, lane by lane: one visit loads one stretch of memory and tests eight boxes
//! at once (Wald, Benthin and Boulos, *Getting Rid of Packets*, 2008). What a leaf is, is for the owner to say.

use std::ops::Range;

use bevy::math::{
    Vec3A,
    bounding::{Aabb3d, BoundingVolume},
};
use smallvec::{SmallVec, smallvec};

use super::{
    RayVisit,
    binned_sah::{self, BuildItem},
};
use crate::geometry::{
    aabb::{EMPTY, union},
    ray::{Ray, aabb::SlabRay},
};

/// The number of children that a node can have.
pub(crate) const LANES: usize = 8;

/// An index into the nodes of a hierarchy.
pub(crate) type NodeIndex = u32;

/// What is below a lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Child {
    Node(NodeIndex),
    /// A number below 2³¹ that means something to the owner.
    Leaf(u32),
}

/// A [`Child`] in four bytes: the highest bit tells leaves from nodes.
#[derive(Clone, Copy, Debug, Default)]
struct PackedChild(u32);

impl PackedChild {
    const LEAF: u32 = 1 << 31;

    fn pack(child: Child) -> Self {
        match child {
            Child::Node(index) => Self(index),
            Child::Leaf(leaf) => Self(leaf | Self::LEAF),
        }
    }

    fn unpack(self) -> Child {
        if self.0 & Self::LEAF == 0 {
            Child::Node(self.0)
        } else {
            Child::Leaf(self.0 & !Self::LEAF)
        }
    }
}

/// Up to eight children with their boxes; those that are not there have empty boxes, which nothing meets.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(crate) struct WideNode {
    /// The bounds of all lanes, axis by axis.
    min: [[f32; LANES]; 3],
    max: [[f32; LANES]; 3],
    children: [PackedChild; LANES],
    len: u32,
}

impl WideNode {
    pub(crate) const EMPTY: Self = Self {
        min: [[f32::INFINITY; LANES]; 3],
        max: [[f32::NEG_INFINITY; LANES]; 3],
        children: [PackedChild(0); LANES],
        len: 0,
    };

    /// The number of children: they are in the first lanes.
    pub(crate) fn len(&self) -> usize {
        self.len as usize
    }

    pub(crate) fn is_full(&self) -> bool {
        self.len() == LANES
    }

    /// All children with their boxes.
    pub(crate) fn lanes(&self) -> impl Iterator<Item = (Aabb3d, Child)> + '_ {
        (0..self.len()).map(|lane| (self.aabb(lane), self.child(lane)))
    }

    pub(crate) fn child(&self, lane: usize) -> Child {
        self.children[lane].unpack()
    }

    pub(crate) fn aabb(&self, lane: usize) -> Aabb3d {
        let at = |bounds: &[[f32; LANES]; 3]| Vec3A::new(bounds[0][lane], bounds[1][lane], bounds[2][lane]);
        Aabb3d {
            min: at(&self.min),
            max: at(&self.max),
        }
    }

    /// The box around all children.
    pub(crate) fn bounds(&self) -> Aabb3d {
        self.lanes().fold(EMPTY, |bounds, (aabb, _)| union(&bounds, &aabb))
    }

    pub(crate) fn set_aabb(&mut self, lane: usize, aabb: &Aabb3d) {
        for axis in 0..3 {
            self.min[axis][lane] = aabb.min[axis];
            self.max[axis][lane] = aabb.max[axis];
        }
    }

    pub(crate) fn set(&mut self, lane: usize, aabb: &Aabb3d, child: Child) {
        self.set_aabb(lane, aabb);
        self.children[lane] = PackedChild::pack(child);
    }

    /// Adds a child to a node that is not full, and returns its lane.
    pub(crate) fn push(&mut self, aabb: &Aabb3d, child: Child) -> usize {
        let lane = self.len();
        self.set(lane, aabb, child);
        self.len += 1;
        lane
    }

    /// Removes a child. The last one takes its lane.
    pub(crate) fn swap_remove(&mut self, lane: usize) {
        let last = self.len() - 1;
        self.set(lane, &self.aabb(last), self.child(last));
        self.set(last, &EMPTY, Child::Node(0));
        self.len -= 1;
    }

    /// The lanes whose boxes touch `aabb`.
    #[inline]
    pub(crate) fn touching(&self, aabb: &Aabb3d) -> impl Iterator<Item = usize> + use<> {
        let mut touching = [true; LANES];
        for axis in 0..3 {
            let (min, max) = (aabb.min[axis], aabb.max[axis]);
            for (lane, touching) in touching.iter_mut().enumerate() {
                *touching &= self.min[axis][lane] <= max && self.max[axis][lane] >= min;
            }
        }
        (0..self.len()).filter(move |&lane| touching[lane])
    }

    /// The parameters at which the ray enters the boxes, infinite for those that it misses.
    #[inline]
    fn entered(&self, ray: &SlabRay) -> [f32; LANES] {
        let (mut enter, mut leave) = ([ray.t_min; LANES], [ray.t_max; LANES]);
        for axis in 0..3 {
            let (near, far) = if ray.forward[axis] {
                (&self.min[axis], &self.max[axis])
            } else {
                (&self.max[axis], &self.min[axis])
            };
            let (origin, recip) = (ray.origin[axis], ray.direction_recip[axis]);
            for lane in 0..LANES {
                let near = (near[lane] - origin) * recip;
                let far = (far[lane] - origin) * recip;
                // A NaN compares false and changes nothing: see `Ray::aabb_intersection_at`, which this equals.
                enter[lane] = if near > enter[lane] { near } else { enter[lane] };
                leave[lane] = if far < leave[lane] { far } else { leave[lane] };
            }
        }
        for lane in 0..LANES {
            let (near, far) = ray.widen(enter[lane], leave[lane]);
            let hit = near <= far && near <= ray.t_max;
            enter[lane] = if hit { near } else { f32::INFINITY };
        }
        enter
    }
}

/// Visits the leaves whose boxes the ray enters, near ones first, with the parameter at which it does.
#[inline]
pub(crate) fn visit_ray(nodes: &[WideNode], root: NodeIndex, ray: &Ray, mut visit: impl FnMut(u32, f32) -> RayVisit) {
    let mut ray = ray.slab_ray();
    let mut stack: SmallVec<[(f32, PackedChild); 96]> = SmallVec::new();
    stack.push((ray.t_min, PackedChild(root)));
    while let Some((enter, child)) = stack.pop() {
        if enter > ray.t_max {
            continue;
        }
        match child.unpack() {
            Child::Leaf(leaf) => match visit(leaf, enter) {
                RayVisit::Continue => {}
                RayVisit::Shorten(t) => ray.t_max = ray.t_max.min(t),
                RayVisit::Stop => return,
            },
            Child::Node(node) => {
                let node = &nodes[node as usize];
                let first = stack.len();
                let entered = node.entered(&ray).into_iter().zip(node.children);
                stack.extend(entered.filter(|(enter, _)| *enter < f32::INFINITY));
                sort_far_to_near(&mut stack[first..]);
            }
        }
    }
}

/// Sorts by insertion: there are eight at most, and mostly two or three.
fn sort_far_to_near(entries: &mut [(f32, PackedChild)]) {
    for i in 1..entries.len() {
        let mut j = i;
        while j > 0 && entries[j - 1].0 < entries[j].0 {
            entries.swap(j - 1, j);
            j -= 1;
        }
    }
}

/// Builds a hierarchy over `items` top down, with at most `leaf_size` of them in a leaf, and returns its nodes: the
/// root first, the children of a node side by side; none if there are no items.
///
/// Of the parts of a node, the one with the largest area is cut, by the [binned surface area heuristic](binned_sah),
/// until there are eight. `leaf` gets each range of items, as reordered, that has become a leaf, with where it begins
/// and the node and the lane that it is in, and gives the number for it.
pub(crate) fn build(
    items: &mut [BuildItem],
    leaf_size: usize,
    mut leaf: impl FnMut(&[BuildItem], usize, NodeIndex, usize) -> u32,
) -> Vec<WideNode> {
    if items.is_empty() {
        return Vec::new();
    }
    let mut nodes = vec![WideNode::EMPTY];
    let mut waiting = vec![(0..items.len(), 0)];
    while let Some((range, node)) = waiting.pop() {
        for (lane, (range, aabb)) in cut(items, range, leaf_size).into_iter().enumerate() {
            let child = if range.len() <= leaf_size {
                Child::Leaf(leaf(&items[range.clone()], range.start, node, lane))
            } else {
                let child = nodes.len() as NodeIndex;
                nodes.push(WideNode::EMPTY);
                waiting.push((range, child));
                Child::Node(child)
            };
            nodes[node as usize].push(&aabb, child);
        }
    }
    nodes
}

/// Cuts a range of items into the parts that become the children of a node, with their boxes.
///
/// What fits into one node is kept whole until the last: a cut too early would leave nodes of two or three children at
/// the bottom of the hierarchy, where most of the nodes are.
fn cut(items: &mut [BuildItem], range: Range<usize>, leaf_size: usize) -> Parts {
    let capacity = LANES * leaf_size;
    let fits_one_node = range.len() <= capacity;
    let bounds = binned_sah::bounds(&items[range.clone()]);
    let mut parts: Parts = smallvec![(range, bounds)];

    let enough = if fits_one_node { leaf_size } else { capacity };
    while parts.len() < LANES {
        let Some(part) = largest(&parts, |len| len > enough) else {
            break;
        };
        let (range, _) = parts.swap_remove(part);
        let middle = range.start + binned_sah::partition(&mut items[range.clone()]);
        for half in [range.start..middle, middle..range.end] {
            let bounds = binned_sah::bounds(&items[half.clone()]);
            parts.push((half, bounds));
        }
    }

    // Items that find room in the lanes that are left need no node of their own.
    loop {
        let free = LANES - parts.len();
        let Some(part) = largest(&parts, |len| len > leaf_size && len - 1 <= free) else {
            break;
        };
        let (range, _) = parts.swap_remove(part);
        parts.extend(range.map(|index| (index..index + 1, items[index].aabb)));
    }
    parts
}

type Parts = SmallVec<[(Range<usize>, Aabb3d); LANES]>;

/// The part with the largest area among those with a suitable number of items.
fn largest(parts: &Parts, suits: impl Fn(usize) -> bool) -> Option<usize> {
    (0..parts.len())
        .filter(|&part| suits(parts[part].0.len()))
        .max_by(|&a, &b| parts[a].1.visible_area().total_cmp(&parts[b].1.visible_area()))
}
