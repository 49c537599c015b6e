//! Boxes that carry two numbers, in 32 bytes.

use bevy::math::{Vec3A, Vec4, bounding::Aabb3d};

/// A box with two numbers, bit by bit in the fourth lanes of its corners: half a cache line, and never astride two.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
struct TaggedBox {
    min: Vec4,
    max: Vec4,
}

impl TaggedBox {
    #[inline(always)]
    fn new(aabb: &Aabb3d, tags: [u32; 2]) -> Self {
        Self {
            min: aabb.min.extend(f32::from_bits(tags[0])),
            max: aabb.max.extend(f32::from_bits(tags[1])),
        }
    }

    /// The numbers are left out: as `f32` they are denormal, which slows arithmetic down.
    #[inline(always)]
    fn aabb(&self) -> Aabb3d {
        Aabb3d {
            min: Vec3A::from_vec4(self.min.with_w(0.0)),
            max: Vec3A::from_vec4(self.max.with_w(0.0)),
        }
    }

    #[inline(always)]
    fn tags(&self) -> [u32; 2] {
        [self.min.w.to_bits(), self.max.w.to_bits()]
    }
}

/// A box to be placed in a hierarchy, with its mask, and the caller's index for it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BuildItem(TaggedBox);

impl BuildItem {
    #[inline(always)]
    pub(crate) fn new(aabb: &Aabb3d, mask: u32, index: u32) -> Self {
        Self(TaggedBox::new(aabb, [index, mask]))
    }

    #[inline(always)]
    pub(crate) fn aabb(&self) -> Aabb3d {
        self.0.aabb()
    }

    #[inline(always)]
    pub(crate) fn index(&self) -> u32 {
        self.0.tags()[0]
    }

    #[inline(always)]
    pub(crate) fn mask(&self) -> u32 {
        self.0.tags()[1]
    }

    /// The middle of the box, doubled. Infinite where it overflows.
    #[inline(always)]
    pub(super) fn doubled_center(&self) -> Vec3A {
        let aabb = self.aabb();
        aabb.min + aabb.max
    }
}

/// A node of a binary hierarchy.
///
/// Up to a number of items, which the bag size of the [build](super::Builder::build) is, they are not told apart: then the node is a bag,
/// whose items form a ring, from each of which a table leads to the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct BinaryNode(TaggedBox);

impl BinaryNode {
    /// The box that is farthest from all others.
    pub(super) const FAR: Self = Self(TaggedBox {
        min: Vec4::splat(-f32::MAX),
        max: Vec4::splat(f32::MAX),
    });

    /// A node without items.
    pub(super) const NOTHING: Self = Self(TaggedBox {
        min: Vec4::ZERO,
        max: Vec4::ZERO,
    });

    /// A node above `count` items: a bag with `first` in it, or a node with children at `first` and the next index.
    #[inline(always)]
    pub(super) fn new(aabb: &Aabb3d, first: u32, count: u32) -> Self {
        Self(TaggedBox::new(aabb, [first, count]))
    }

    /// The node around `a` and `b`, with the given `first`.
    #[inline(always)]
    pub(super) fn around(a: &Self, b: &Self, first: u32, count: u32) -> Self {
        Self(TaggedBox {
            min: a.0.min.min(b.0.min).with_w(f32::from_bits(first)),
            max: a.0.max.max(b.0.max).with_w(f32::from_bits(count)),
        })
    }

    /// The same node with another `first`.
    #[inline(always)]
    pub(super) fn with_first(&self, first: u32) -> Self {
        Self(TaggedBox {
            min: self.0.min.with_w(f32::from_bits(first)),
            max: self.0.max,
        })
    }

    /// The same node where its children are so much farther on; of a bag the items stay.
    #[inline(always)]
    pub(super) fn moved_by(&self, nodes: u32, bag_size: u32) -> Self {
        if self.count() > bag_size {
            self.with_first(self.first() + nodes)
        } else {
            *self
        }
    }

    #[inline(always)]
    pub(super) fn aabb(&self) -> Aabb3d {
        self.0.aabb()
    }

    /// The number of items.
    #[inline(always)]
    pub(super) fn count(&self) -> u32 {
        self.0.tags()[1]
    }

    #[inline(always)]
    pub(super) fn first(&self) -> u32 {
        self.0.tags()[0]
    }

    /// The corners, each with one of the numbers behind.
    #[inline(always)]
    pub(super) fn corners(&self) -> [&[f32; 4]; 2] {
        [self.0.min.as_ref(), self.0.max.as_ref()]
    }
}
