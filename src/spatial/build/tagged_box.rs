//! Boxes that carry two numbers, in 32 bytes.

use std::ops::Range;

use bevy::math::{Vec3A, Vec4, bounding::Aabb3d};

/// A box with two numbers, bit by bit in the fourth lanes of its corners: half a cache line, and never astride two.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct TaggedBox {
    min: Vec4,
    max: Vec4,
}

impl TaggedBox {
    #[inline(always)]
    pub(super) fn new(aabb: &Aabb3d, tags: [u32; 2]) -> Self {
        Self {
            min: aabb.min.extend(f32::from_bits(tags[0])),
            max: aabb.max.extend(f32::from_bits(tags[1])),
        }
    }

    /// The tags are cleared: as `f32` they are denormal, which slows arithmetic down.
    #[inline(always)]
    pub(super) fn aabb(&self) -> Aabb3d {
        Aabb3d {
            min: Vec3A::from_vec4(self.min.with_w(0.0)),
            max: Vec3A::from_vec4(self.max.with_w(0.0)),
        }
    }

    #[inline(always)]
    pub(super) fn tags(&self) -> [u32; 2] {
        [self.min.w.to_bits(), self.max.w.to_bits()]
    }

    /// The middle of the box, doubled; halved bounds would lose what is denormal. Infinite where it overflows.
    #[inline(always)]
    pub(super) fn doubled_center(&self) -> Vec3A {
        let aabb = self.aabb();
        aabb.min + aabb.max
    }

    /// The corners, the numbers among them.
    #[inline(always)]
    pub(super) fn rows(&self) -> [[f32; 4]; 2] {
        [self.min.to_array(), self.max.to_array()]
    }
}

/// A box to be placed in a hierarchy, with its mask, and the caller's index for it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BuildItem(pub(super) TaggedBox);

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
}

/// A node of a binary hierarchy: its box, the number of items below it, and where they are.
#[derive(Clone, Copy, Debug)]
pub(super) struct BinaryNode(pub(super) TaggedBox);

/// What is below a [`BinaryNode`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Below {
    /// Nodes at this index and the next.
    Nodes(usize),
    /// Items that were not told apart.
    Items(Range<usize>),
}

impl BinaryNode {
    const ITEMS: u32 = 1 << 31;
    pub(super) const EMPTY: Self = Self(TaggedBox {
        min: Vec4::new(f32::INFINITY, f32::INFINITY, f32::INFINITY, 0.0),
        max: Vec4::new(f32::NEG_INFINITY, f32::NEG_INFINITY, f32::NEG_INFINITY, 0.0),
    });

    /// A node above `count` items, with children at `first` and the next index.
    #[inline(always)]
    pub(super) fn inner(aabb: &Aabb3d, first: u32, count: u32) -> Self {
        Self(TaggedBox::new(aabb, [first, count]))
    }

    /// A node of `count` items from `first` on.
    #[inline(always)]
    pub(super) fn of_items(aabb: &Aabb3d, first: u32, count: u32) -> Self {
        Self(TaggedBox::new(aabb, [first | Self::ITEMS, count]))
    }

    #[inline(always)]
    pub(super) fn aabb(&self) -> Aabb3d {
        self.0.aabb()
    }

    /// The number of items.
    #[inline(always)]
    pub(super) fn count(&self) -> usize {
        self.0.tags()[1] as usize
    }

    #[inline(always)]
    pub(super) fn below(&self) -> Below {
        let [first, count] = self.0.tags();
        if first & Self::ITEMS == 0 {
            Below::Nodes(first as usize)
        } else {
            let first = (first & !Self::ITEMS) as usize;
            Below::Items(first..first + count as usize)
        }
    }
}
