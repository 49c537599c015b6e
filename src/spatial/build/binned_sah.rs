//! The binned surface area heuristic: where to cut a set of boxes in two.
//!
//! Source: Wald, *On fast Construction of SAH-based Bounding Volume Hierarchies*, 2007, §3: the centers are sorted into
//! equal bins along an axis, and of the cuts between bins the one is taken that minimises
//! `area(left) * count(left) + area(right) * count(right)`.

use bevy::math::{
    UVec3, Vec3A,
    bounding::{Aabb3d, BoundingVolume},
};

use super::{extents::Extents, tagged_box::BuildItem};
use crate::geometry::aabb::{EMPTY, union};

const MOST_BINS: usize = 16;

/// What maps centers to bins, all three axes at once.
#[derive(Clone, Copy, Debug)]
struct Bins {
    low: Vec3A,
    per_length: Vec3A,
    last: UVec3,
}

impl Bins {
    #[inline(always)]
    fn of(&self, item: &BuildItem) -> UVec3 {
        // A NaN, where the centers are infinitely far apart, becomes zero.
        let offset = (item.doubled_center() - self.low) * self.per_length;
        UVec3::new(offset.x as u32, offset.y as u32, offset.z as u32).min(self.last)
    }
}

/// A cut between two bins along an axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cut {
    bins: Bins,
    axis: usize,
    /// The first bin of the second part.
    bin: u32,
}

impl Cut {
    #[inline(always)]
    pub(super) fn is_left(&self, item: &BuildItem) -> bool {
        self.bins.of(item)[self.axis] < self.bin
    }
}

/// The cheapest of all cuts; `None` if all centers coincide.
pub(super) fn best_cut(items: &[BuildItem], extents: &Extents) -> Option<Cut> {
    // Few items need few bins: they would mostly be empty.
    let count = (4 + items.len() / 8).min(MOST_BINS);
    let bins = Bins {
        low: extents.centers.min,
        per_length: Vec3A::splat(count as f32) / (extents.centers.max - extents.centers.min),
        last: UVec3::splat(count as u32 - 1),
    };
    let mut filled = [[(EMPTY, 0_u32); MOST_BINS]; 3];
    for item in items {
        let bin = bins.of(item);
        let aabb = item.aabb();
        for axis in 0..3 {
            let (bounds, count) = &mut filled[axis][bin[axis] as usize];
            *bounds = union(bounds, &aabb);
            *count += 1;
        }
    }
    (0..3)
        .filter_map(|axis| {
            let (cost, bin) = cheapest(&filled[axis][..count])?;
            Some((cost, Cut { bins, axis, bin }))
        })
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, cut)| cut)
}

/// The cost of the cheapest cut with something on both sides, and the first bin of the second part. Of equal costs, as
/// where areas overflow or vanish, the one is taken that leaves more equal parts.
fn cheapest(bins: &[(Aabb3d, u32)]) -> Option<(f32, u32)> {
    let mut right_costs = [0.0; MOST_BINS];
    let mut right = (EMPTY, 0);
    for cut in (1..bins.len()).rev() {
        right = add(right, bins[cut]);
        right_costs[cut] = cost(right);
    }
    let all = right.1 + bins[0].1;
    let mut left = (EMPTY, 0);
    let mut best = None;
    for cut in 1..bins.len() {
        left = add(left, bins[cut - 1]);
        if left.1 == 0 || left.1 == all {
            continue;
        }
        // Finite also where an infinite side meets a flat one, which is NaN.
        let cost = (cost(left) + right_costs[cut]).min(f32::MAX);
        let difference = all.abs_diff(2 * left.1);
        if best.is_none_or(|(least, least_difference, _)| (cost, difference) < (least, least_difference)) {
            best = Some((cost, difference, cut as u32));
        }
    }
    best.map(|(cost, _, cut)| (cost, cut))
}

#[inline(always)]
fn add(a: (Aabb3d, u32), b: (Aabb3d, u32)) -> (Aabb3d, u32) {
    (union(&a.0, &b.0), a.1 + b.1)
}

#[inline(always)]
fn cost((aabb, count): (Aabb3d, u32)) -> f32 {
    aabb.visible_area() * count as f32
}
