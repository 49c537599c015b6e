//! Hierarchies from the root down, by splitting the items in two again and again.

use std::ops::Range;

use smallvec::{SmallVec, smallvec};

use super::{
    binned_sah,
    extents::Extents,
    tagged_box::{BinaryNode, BuildItem},
};

/// From this depth on all splits are halves: no input makes a hierarchy deeper than this and the logarithm of the number
/// of items.
const DEPTH_LIMIT: u32 = 64;

/// How a range of items, of which there are at least two, is split: where the second part begins, after reordering.
/// `None`, or a part without members, stands for halves.
pub(super) type Split = fn(&mut [BuildItem], &Extents) -> Option<usize>;

/// Builds a hierarchy over items, which are reordered, and returns its root. Writes the other nodes over `tree`, parents
/// first, and the rings of its bags over `rings`.
pub(super) fn build(
    split: Split,
    items: &mut [BuildItem],
    bag_size: u32,
    tree: &mut Vec<BinaryNode>,
    rings: &mut Vec<u32>,
) -> BinaryNode {
    tree.clear();
    rings.clear();
    let mut root = BinaryNode::FAR;
    let mut waiting: SmallVec<[(Range<usize>, Option<usize>, u32); 128]> = smallvec![(0..items.len(), None, 0)];
    while let Some((range, node, depth)) = waiting.pop() {
        let (start, count) = (range.start, range.len());
        let items = &mut items[range.clone()];
        let extents = Extents::of(items);
        let first = if count <= bag_size as usize {
            rings.extend(start as u32 + 1..range.end as u32);
            rings.push(start as u32);
            start
        } else {
            let middle = Some(items)
                .filter(|_| depth < DEPTH_LIMIT)
                .and_then(|items| split(items, &extents))
                .filter(|middle| (1..count).contains(middle))
                .unwrap_or(count / 2);
            let children = tree.len();
            tree.extend([BinaryNode::FAR; 2]);
            waiting.push((start + middle..range.end, Some(children + 1), depth + 1));
            waiting.push((start..start + middle, Some(children), depth + 1));
            children
        };
        *node.map_or(&mut root, |node| &mut tree[node]) = BinaryNode::new(&extents.bounds, first as u32, count as u32);
    }
    root
}

/// Splits at the middle of the longest axis (Ericson, *Real-Time Collision Detection*, 2005, §6.2.1).
pub(super) fn at_middle(items: &mut [BuildItem], extents: &Extents) -> Option<usize> {
    let axis = extents.longest_axis()?;
    let middle = extents.centers.min[axis] * 0.5 + extents.centers.max[axis] * 0.5;
    Some(partition(items, |item| item.doubled_center()[axis] < middle))
}

/// Splits the items, sorted along the longest axis, in half (Ericson, *Real-Time Collision Detection*, 2005, §6.2.1).
pub(super) fn at_median(items: &mut [BuildItem], extents: &Extents) -> Option<usize> {
    let axis = extents.longest_axis()?;
    let half = items.len() / 2;
    let along = |item: &BuildItem| item.doubled_center()[axis];
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
