//! The binned surface area heuristic: where to cut a set of boxes in two.
//!
//! Source: Wald, *On fast Construction of SAH-based Bounding Volume Hierarchies*, 2007, §3: the centroids are sorted
//! into equal bins along an axis, and of the cuts between bins the one is taken that minimises
//! `area(left) * count(left) + area(right) * count(right)`.

use bevy::math::{
    Vec3A,
    bounding::{Aabb3d, BoundingVolume},
};

use crate::geometry::aabb::{EMPTY, union};

const BINS: usize = 16;

/// A box to be placed in a hierarchy, and the caller's index for it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BuildItem {
    pub aabb: Aabb3d,
    pub index: u32,
}

/// The box around all items.
pub(crate) fn bounds(items: &[BuildItem]) -> Aabb3d {
    items.iter().fold(EMPTY, |bounds, item| union(&bounds, &item.aabb))
}

/// Reorders `items`, of which there are at least two, and returns where the second part begins: both have members.
pub(crate) fn partition(items: &mut [BuildItem]) -> usize {
    debug_assert!(items.len() >= 2);
    let (mut low, mut high) = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
    for item in items.iter() {
        let centroid = centroid(item);
        low = low.min(centroid);
        high = high.max(centroid);
    }
    let extent = high - low;
    let bin_per_length = Vec3A::splat(BINS as f32) / extent;
    let bin_of = |item: &BuildItem, axis: usize| {
        let offset = (centroid(item)[axis] - low[axis]) * bin_per_length[axis];
        (offset as usize).min(BINS - 1)
    };

    let best = (0..3)
        .filter(|&axis| extent[axis] > 0.0 && extent[axis].is_finite() && bin_per_length[axis].is_finite())
        .map(|axis| {
            let (cost, cut) = best_cut(items, |item| bin_of(item, axis));
            (cost, axis, cut)
        })
        .min_by(|a, b| a.0.total_cmp(&b.0));

    match best {
        Some((_, axis, cut)) => partition_in_place(items, |item| bin_of(item, axis) < cut),
        // All centroids coincide, or are too far apart to tell: any halves are as good as any others.
        None => items.len() / 2,
    }
}

/// The middle of the box; halved first, so that it does not overflow.
fn centroid(item: &BuildItem) -> Vec3A {
    item.aabb.min * 0.5 + item.aabb.max * 0.5
}

/// The cheapest cut along one axis: its cost, and the first bin of the second part. The outermost bins hold the
/// extreme centroids, so that both parts of every cut that separates them have members.
fn best_cut(items: &[BuildItem], bin_of: impl Fn(&BuildItem) -> usize) -> (f32, usize) {
    let mut bins = [(EMPTY, 0_u32); BINS];
    for item in items {
        let (aabb, count) = &mut bins[bin_of(item)];
        *aabb = union(aabb, &item.aabb);
        *count += 1;
    }

    let mut right_costs = [0.0; BINS];
    let mut right = (EMPTY, 0);
    for cut in (1..BINS).rev() {
        right = add(right, bins[cut]);
        right_costs[cut] = cost(right);
    }
    let mut left = (EMPTY, 0);
    let mut best = (f32::INFINITY, BINS / 2);
    for cut in 1..BINS {
        left = add(left, bins[cut - 1]);
        let cost = cost(left) + right_costs[cut];
        // Also takes the first cut when all costs overflow.
        if cost < best.0 || cut == 1 {
            best = (cost, cut);
        }
    }
    best
}

fn add(a: (Aabb3d, u32), b: (Aabb3d, u32)) -> (Aabb3d, u32) {
    (union(&a.0, &b.0), a.1 + b.1)
}

fn cost((aabb, count): (Aabb3d, u32)) -> f32 {
    if count == 0 {
        0.0
    } else {
        aabb.visible_area() * count as f32
    }
}

/// Moves the items for which `is_left` holds to the front and returns their number.
fn partition_in_place(items: &mut [BuildItem], is_left: impl Fn(&BuildItem) -> bool) -> usize {
    let mut left = 0;
    for i in 0..items.len() {
        if is_left(&items[i]) {
            items.swap(left, i);
            left += 1;
        }
    }
    // One part may be empty after all where the bins round: both must have members.
    left.clamp(1, items.len() - 1)
}
