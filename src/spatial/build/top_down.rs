//! Hierarchies from the root down, by splitting the items in two again and again.

use std::ops::Range;

use bevy::math::bounding::Aabb3d;

use super::{
    binned_sah,
    tagged_box::{BinaryNode, BuildItem},
};
use crate::{
    geometry::aabb::{EMPTY, union},
    spatial::wide::LANES,
};

/// From this depth on all splits are halves: no input makes a hierarchy deeper than this and the logarithm of the number
/// of items.
const DEPTH_LIMIT: u32 = 64;

/// How a range of items, of which there are at least two, is split: where the second part begins, after reordering.
/// `None`, or a part without members, stands for halves.
pub(super) type Split = fn(&mut [BuildItem], &Extents) -> Option<usize>;

/// Where items are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extents {
    pub bounds: Aabb3d,
    /// The bounds of the [doubled centers](super::tagged_box::TaggedBox::doubled_center).
    pub centers: Aabb3d,
}

impl Extents {
    pub(super) const EMPTY: Self = Self {
        bounds: EMPTY,
        centers: EMPTY,
    };

    #[inline(always)]
    pub(super) fn with(&self, item: &BuildItem) -> Self {
        let center = item.0.doubled_center();
        let center = Aabb3d {
            min: center,
            max: center,
        };
        Self {
            bounds: union(&self.bounds, &item.aabb()),
            centers: union(&self.centers, &center),
        }
    }

    pub(super) fn of(items: &[BuildItem]) -> Self {
        items.iter().fold(Self::EMPTY, |extents, item| extents.with(item))
    }

    /// The axis along which the centers are farthest apart; `None` if they coincide.
    fn longest_axis(&self) -> Option<usize> {
        let size = self.centers.max - self.centers.min;
        let axis = size.max_position();
        (size[axis] > 0.0).then_some(axis)
    }
}

/// Replaces `tree` by a hierarchy over the items, which are reordered; the root first.
pub(super) fn build(split: Split, items: &mut [BuildItem], leaf_size: usize, tree: &mut Vec<BinaryNode>) {
    // Eight leaves of one item fill a node, in whatever order.
    let enough = if leaf_size == 1 { LANES } else { leaf_size };
    tree.clear();
    tree.push(BinaryNode::EMPTY);
    let mut waiting: Vec<(Range<usize>, usize, u32)> = vec![(0..items.len(), 0, 0)];
    while let Some((range, node, depth)) = waiting.pop() {
        let (first, count) = (range.start, range.len());
        let items = &mut items[range.clone()];
        let extents = Extents::of(items);
        if count <= enough {
            tree[node] = BinaryNode::of_items(&extents.bounds, first as u32, count as u32);
            continue;
        }
        let middle = Some(items)
            .filter(|_| depth < DEPTH_LIMIT)
            .and_then(|items| split(items, &extents))
            .filter(|middle| (1..count).contains(middle))
            .unwrap_or(count / 2);
        let left = tree.len();
        tree[node] = BinaryNode::inner(&extents.bounds, left as u32, count as u32);
        tree.extend([BinaryNode::EMPTY; 2]);
        waiting.push((first + middle..range.end, left + 1, depth + 1));
        waiting.push((first..first + middle, left, depth + 1));
    }
}

/// Splits at the middle of the longest axis (Ericson, *Real-Time Collision Detection*, 2005, §6.2.1).
pub(super) fn at_middle(items: &mut [BuildItem], extents: &Extents) -> Option<usize> {
    let axis = extents.longest_axis()?;
    let middle = extents.centers.min[axis] * 0.5 + extents.centers.max[axis] * 0.5;
    Some(partition(items, |item| item.0.doubled_center()[axis] < middle))
}

/// Splits the items, sorted along the longest axis, in half (Ericson, *Real-Time Collision Detection*, 2005, §6.2.1).
pub(super) fn at_median(items: &mut [BuildItem], extents: &Extents) -> Option<usize> {
    let axis = extents.longest_axis()?;
    let half = items.len() / 2;
    let along = |item: &BuildItem| item.0.doubled_center()[axis];
    items.select_nth_unstable_by(half, |a, b| along(a).total_cmp(&along(b)));
    Some(half)
}

/// Splits where the surface area heuristic says.
pub(super) fn at_least_cost(items: &mut [BuildItem], extents: &Extents) -> Option<usize> {
    let cut = binned_sah::best_cut(items, extents)?;
    Some(partition(items, |item| cut.is_left(item)))
}

/// Moves the items for which `is_left` holds to the front and returns their number.
fn partition(items: &mut [BuildItem], is_left: impl Fn(&BuildItem) -> bool) -> usize {
    let mut left = 0;
    for i in 0..items.len() {
        let goes_left = is_left(&items[i]);
        items.swap(left, i);
        left += usize::from(goes_left);
    }
    left
}
