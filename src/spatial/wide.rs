//! Nodes of eight children, as all hierarchies of this crate have them.
//!
//! The boxes of the children lie in the node, lane by lane: one visit loads one stretch of memory and tests eight boxes
//! at once (Wald, Benthin and Boulos, *Getting Rid of Packets*, 2008). What a leaf is, is for the owner to say.

use bevy::math::{Vec3A, bounding::Aabb3d};

pub(crate) use super::simd::LANES;
use super::simd::Simd;
use crate::geometry::aabb::{EMPTY, union};

/// An index into the nodes of a hierarchy.
pub(crate) type NodeIndex = u32;

/// What is below a lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Child {
    Node(NodeIndex),
    /// A number below 2³¹ - 1 that means something to the owner.
    Leaf(u32),
}

/// A [`Child`], or none, in four bytes: the highest bit tells leaves from nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub(crate) struct PackedChild(u32);

impl PackedChild {
    const LEAF: u32 = 1 << 31;
    const NONE: Self = Self(u32::MAX);

    #[inline(always)]
    pub(crate) fn bits(self) -> u32 {
        self.0
    }

    #[inline(always)]
    pub(crate) fn from_bits(bits: u32) -> Self {
        Self(bits)
    }

    #[inline(always)]
    pub(crate) fn pack(child: Child) -> Self {
        match child {
            Child::Node(index) => Self(index),
            Child::Leaf(leaf) => Self(leaf | Self::LEAF),
        }
    }

    #[inline(always)]
    pub(crate) fn unpack(self) -> Child {
        if self.0 & Self::LEAF == 0 {
            Child::Node(self.0)
        } else {
            Child::Leaf(self.0 & !Self::LEAF)
        }
    }
}

impl PackedChild {
    /// The node, if it is one.
    #[inline(always)]
    pub(crate) fn node(self) -> Option<NodeIndex> {
        (self.0 & Self::LEAF == 0).then_some(self.0)
    }

    /// The leaf, if it is one.
    #[inline(always)]
    pub(crate) fn leaf(self) -> Option<u32> {
        (self.0 & Self::LEAF != 0 && self != Self::NONE).then_some(self.0 & !Self::LEAF)
    }
}

/// Up to eight children with their boxes and their masks, in the first lanes; the others have empty boxes and no mask,
/// which nothing meets. Four cache lines.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct WideNode {
    /// The bounds of all lanes, axis by axis.
    pub min: [[f32; LANES]; 3],
    pub max: [[f32; LANES]; 3],
    pub children: [PackedChild; LANES],
    /// What a leaf is in, bit by bit, and of a node all that is below it.
    pub masks: [u32; LANES],
}

/// The mask of what every query is to find.
pub(crate) const EVERY_MASK: u32 = u32::MAX;

impl WideNode {
    pub(crate) const EMPTY: Self = Self {
        min: [[f32::INFINITY; LANES]; 3],
        max: [[f32::NEG_INFINITY; LANES]; 3],
        children: [PackedChild::NONE; LANES],
        masks: [0; LANES],
    };

    /// The number of children: they are in the first lanes.
    #[inline]
    pub(crate) fn len(&self) -> usize {
        self.children
            .iter()
            .filter(|&&child| child != PackedChild::NONE)
            .count()
    }

    #[inline]
    pub(crate) fn is_full(&self) -> bool {
        self.children[LANES - 1] != PackedChild::NONE
    }

    /// All children with their boxes.
    pub(crate) fn lanes(&self) -> impl Iterator<Item = (Aabb3d, Child)> + '_ {
        (0..self.len()).map(|lane| (self.aabb(lane), self.child(lane)))
    }

    #[inline]
    pub(crate) fn child(&self, lane: usize) -> Child {
        self.children[lane].unpack()
    }

    #[inline]
    pub(crate) fn aabb(&self, lane: usize) -> Aabb3d {
        let at = |bounds: &[[f32; LANES]; 3]| Vec3A::new(bounds[0][lane], bounds[1][lane], bounds[2][lane]);
        Aabb3d {
            min: at(&self.min),
            max: at(&self.max),
        }
    }

    /// The box around all children.
    #[inline]
    pub(crate) fn bounds(&self) -> Aabb3d {
        (0..LANES).fold(EMPTY, |bounds, lane| union(&bounds, &self.aabb(lane)))
    }

    /// The box around all children.
    #[inline(always)]
    pub(crate) fn bounds_with<S: Simd>(&self, simd: S) -> Aabb3d {
        let zero = simd.splat(0.0);
        let (mut min, mut max) = ([0.0; 3], [0.0; 3]);
        for axis in 0..3 {
            min[axis] = simd.min_lane(simd.load(&self.min[axis]));
            // The greatest is the least of the negated, negated.
            max[axis] = -simd.min_lane(simd.sub(zero, simd.load(&self.max[axis])));
        }
        Aabb3d {
            min: min.into(),
            max: max.into(),
        }
    }

    /// All masks of the children together.
    #[inline]
    pub(crate) fn mask(&self) -> u32 {
        self.masks.iter().fold(0, |all, mask| all | mask)
    }

    #[inline]
    pub(crate) fn set_aabb(&mut self, lane: usize, aabb: &Aabb3d) {
        for axis in 0..3 {
            self.min[axis][lane] = aabb.min[axis];
            self.max[axis][lane] = aabb.max[axis];
        }
    }

    #[inline]
    pub(crate) fn set(&mut self, lane: usize, aabb: &Aabb3d, mask: u32, child: Child) {
        self.set_aabb(lane, aabb);
        self.masks[lane] = mask;
        self.children[lane] = PackedChild::pack(child);
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

    /// Adds a child to a node that is not full, and returns its lane.
    pub(crate) fn push(&mut self, aabb: &Aabb3d, mask: u32, child: Child) -> usize {
        let lane = self.len();
        self.set(lane, aabb, mask, child);
        lane
    }

    /// Removes a child. The last one takes its lane.
    pub(crate) fn swap_remove(&mut self, lane: usize) {
        let last = self.len() - 1;
        self.set(lane, &self.aabb(last), self.masks[last], self.child(last));
        self.set_aabb(last, &EMPTY);
        self.masks[last] = 0;
        self.children[last] = PackedChild::NONE;
    }
}
