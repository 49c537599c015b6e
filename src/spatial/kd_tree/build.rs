//! Building: where cells are split, and how three or so splits become one node.

use std::ops::Range;

use bevy::math::{
    Vec3A, Vec4,
    bounding::{Aabb3d, BoundingVolume},
};
use smallvec::{SmallVec, smallvec};

use super::{
    SplitMethod,
    hierarchy::{Hierarchy, Slot},
};
use crate::{
    geometry::aabb::{EMPTY, union},
    spatial::wide::{Child, EVERY_MASK, LANES, NodeIndex, WideNode},
};

/// How many points share a leaf.
pub(super) const BUCKET: usize = LANES;

/// Something to be put into a cell: few bytes, for they are moved often.
pub(super) trait Item: Copy {
    /// How many of them may share a leaf.
    const LEAF_SIZE: usize;

    fn aabb(&self) -> Aabb3d;
    fn centroid(&self) -> Vec3A;
}

/// A box, with its index in the fourth coordinate of its minimum.
#[derive(Clone, Copy)]
pub(super) struct BoxItem {
    min: Vec4,
    max: Vec4,
}

impl BoxItem {
    pub(super) fn new(aabb: &Aabb3d, index: u32) -> Self {
        Self {
            min: aabb.min.extend(f32::from_bits(index)),
            max: aabb.max.extend(0.0),
        }
    }

    pub(super) fn index(&self) -> u32 {
        self.min.w.to_bits()
    }
}

impl Item for BoxItem {
    const LEAF_SIZE: usize = 1;

    #[inline]
    fn aabb(&self) -> Aabb3d {
        Aabb3d {
            min: Vec3A::from_vec4(self.min),
            max: Vec3A::from_vec4(self.max),
        }
    }

    #[inline]
    fn centroid(&self) -> Vec3A {
        let Aabb3d { min, max } = self.aabb();
        min * 0.5 + max * 0.5
    }
}

/// A point, with its index in the fourth coordinate.
#[derive(Clone, Copy)]
pub(super) struct PointItem(Vec4);

impl PointItem {
    pub(super) fn new(point: Vec3A, index: u32) -> Self {
        Self(point.extend(f32::from_bits(index)))
    }

    pub(super) fn index(&self) -> u32 {
        self.0.w.to_bits()
    }
}

impl Item for PointItem {
    const LEAF_SIZE: usize = BUCKET;

    #[inline]
    fn aabb(&self) -> Aabb3d {
        let point = self.centroid();
        Aabb3d { min: point, max: point }
    }

    #[inline]
    fn centroid(&self) -> Vec3A {
        Vec3A::from_vec4(self.0)
    }
}

/// Builds a tree over `items`, reordered: the root first, every node before what is below it, and all that is below
/// any lane side by side. `leaf` gets the items of each leaf, from the first to the last.
pub(super) fn build<I: Item>(items: &mut [I], method: SplitMethod, leaf: impl FnMut(&[I])) -> Hierarchy {
    // Splits by area can be lopsided: when there were twice as many on the way as it takes, medians take over.
    let splits_by_area = match method {
        SplitMethod::Sah => 2 * (items.len().max(2).ilog2() + 1),
        SplitMethod::Median => 0,
    };
    let mut builder = Builder {
        hierarchy: Hierarchy {
            nodes: Vec::with_capacity(items.len() / (4 * I::LEAF_SIZE) + 1),
            slots: Vec::with_capacity(items.len().div_ceil(I::LEAF_SIZE)),
        },
        leaf,
    };
    if !items.is_empty() {
        let whole = Part::new(items, 0..items.len(), splits_by_area);
        builder.add_node(items, whole);
    }
    let mut hierarchy = builder.hierarchy;
    hierarchy.nodes.shrink_to_fit();
    hierarchy.slots.shrink_to_fit();
    hierarchy
}

struct Builder<F> {
    hierarchy: Hierarchy,
    leaf: F,
}

impl<F> Builder<F> {
    fn add_node<I: Item>(&mut self, items: &mut [I], whole: Part) -> NodeIndex
    where
        F: FnMut(&[I]),
    {
        let index = self.hierarchy.nodes.len() as NodeIndex;
        self.hierarchy.nodes.push(WideNode::EMPTY);
        for (lane, part) in cut(items, whole).into_iter().enumerate() {
            let bounds = part.bounds;
            let child = if part.range.len() <= I::LEAF_SIZE {
                (self.leaf)(&items[part.range]);
                let slots = &mut self.hierarchy.slots;
                slots.push(Slot {
                    node: index,
                    lane: lane as u32,
                });
                Child::Leaf((slots.len() - 1) as u32)
            } else {
                Child::Node(self.add_node(items, part))
            };
            self.hierarchy.nodes[index as usize].set(lane, &bounds, EVERY_MASK, child);
        }
        index
    }
}

/// A cell to be.
struct Part {
    range: Range<usize>,
    /// The box around all items.
    bounds: Aabb3d,
    /// The box around their centres.
    centroids: Aabb3d,
    /// How many more splits on the way down may be by area.
    splits_by_area: u32,
}

impl Part {
    fn new<I: Item>(items: &[I], range: Range<usize>, splits_by_area: u32) -> Self {
        let (mut bounds, mut centroids) = (EMPTY, EMPTY);
        for item in &items[range.clone()] {
            let centroid = item.centroid();
            bounds = union(&bounds, &item.aabb());
            centroids.min = centroids.min.min(centroid);
            centroids.max = centroids.max.max(centroid);
        }
        Self {
            range,
            bounds,
            centroids,
            splits_by_area,
        }
    }

    /// Reorders the items, of which there are at least two, and returns the two halves: both have members.
    fn split<I: Item>(&self, items: &mut [I]) -> [Self; 2] {
        let own = &mut items[self.range.clone()];
        let by_area = (self.splits_by_area > 0).then(|| split_by_area(own, &self.centroids));
        let middle = by_area
            .flatten()
            .unwrap_or_else(|| split_at_median(own, &self.centroids));
        let middle = self.range.start + middle;
        let splits_by_area = self.splits_by_area.saturating_sub(1);
        [self.range.start..middle, middle..self.range.end].map(|half| Self::new(items, half, splits_by_area))
    }
}

/// Splits a cell into those that become the lanes of its node, in the order of their items.
///
/// The largest is split until there are eight. What fits into one node stays whole until the last: a split too early
/// would leave nodes of two or three lanes at the bottom of the tree, where most of the nodes are.
fn cut<I: Item>(items: &mut [I], whole: Part) -> SmallVec<[Part; LANES]> {
    let node_size = LANES * I::LEAF_SIZE;
    let enough = if whole.range.len() <= node_size {
        I::LEAF_SIZE
    } else {
        node_size
    };
    let mut parts: SmallVec<[Part; LANES]> = smallvec![whole];
    while parts.len() < LANES {
        let Some(largest) = largest(&parts, |len| len > enough) else {
            break;
        };
        let halves = parts.remove(largest).split(items);
        parts.insert_many(largest, halves);
    }
    // Leaves that find room in the lanes that are left need no node of their own.
    while let Some(place) = largest(&parts, |len| {
        len > I::LEAF_SIZE && parts.len() - 1 + len.div_ceil(I::LEAF_SIZE) <= LANES
    }) {
        let Part { range, .. } = parts.remove(place);
        let leaves = range.clone().step_by(I::LEAF_SIZE);
        let leaves = leaves.map(|start| Part::new(items, start..range.end.min(start + I::LEAF_SIZE), 0));
        parts.insert_many(place, leaves);
    }
    parts
}

/// The part with the largest area among those with a suitable number of items; of those with none, that of most items.
fn largest(parts: &[Part], suits: impl Fn(usize) -> bool) -> Option<usize> {
    let size = |part: &Part| (part.bounds.visible_area(), part.range.len());
    (0..parts.len())
        .filter(|&part| suits(parts[part].range.len()))
        .max_by(|&a, &b| {
            let (a, b) = (size(&parts[a]), size(&parts[b]));
            a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
        })
}

/// Splits at the median of the widest axis, moved so that the leaves of the first half are full.
fn split_at_median<I: Item>(items: &mut [I], centroids: &Aabb3d) -> usize {
    let middle = (items.len() / 2).next_multiple_of(I::LEAF_SIZE);
    // One comparison for each axis, for the compiler to know which.
    match (centroids.max - centroids.min).max_position() {
        0 => items.select_nth_unstable_by(middle, |a, b| a.centroid().x.total_cmp(&b.centroid().x)),
        1 => items.select_nth_unstable_by(middle, |a, b| a.centroid().y.total_cmp(&b.centroid().y)),
        _ => items.select_nth_unstable_by(middle, |a, b| a.centroid().z.total_cmp(&b.centroid().z)),
    };
    middle
}

const BINS: usize = 16;

/// Splits where the surface area heuristic has its minimum; `None` if the centroids are too close together to tell.
///
/// Source: Wald, *On fast Construction of SAH-based Bounding Volume Hierarchies*, 2007, §3: the centroids are sorted
/// into equal bins along each axis, and of the planes between bins the one is taken that minimises
/// `area(left) * count(left) + area(right) * count(right)`.
fn split_by_area<I: Item>(items: &mut [I], centroids: &Aabb3d) -> Option<usize> {
    let scale = Vec3A::splat(BINS as f32) / (centroids.max - centroids.min);
    let scale = Vec3A::select(scale.is_finite_mask(), scale, Vec3A::ZERO);
    let bins_of = |item: &I| ((item.centroid() - centroids.min) * scale).min(Vec3A::splat(BINS as f32 - 1.0));

    let mut bins = [[(EMPTY, 0usize); BINS]; 3];
    for item in items.iter() {
        let aabb = item.aabb();
        let places = bins_of(item);
        for (axis, bins) in bins.iter_mut().enumerate() {
            let (bounds, count) = &mut bins[places[axis] as usize];
            *bounds = union(bounds, &aabb);
            *count += 1;
        }
    }
    let best = (0..3)
        .filter_map(|axis| cheapest_plane(&bins[axis]).map(|(cost, bin)| (cost, axis, bin)))
        .min_by(|a, b| a.0.total_cmp(&b.0))?;
    let (_, axis, bin) = best;
    Some(partition(items, |item| (bins_of(item)[axis] as usize) < bin))
}

/// The cost of the best plane between bins that have members on both sides, and the first bin behind it.
fn cheapest_plane(bins: &[(Aabb3d, usize); BINS]) -> Option<(f32, usize)> {
    let cost = |(bounds, count): &(Aabb3d, usize)| bounds.visible_area() * *count as f32;
    let add = |a: &(Aabb3d, usize), b: &(Aabb3d, usize)| (union(&a.0, &b.0), a.1 + b.1);
    let mut behind = [(EMPTY, 0); BINS];
    behind[BINS - 1] = bins[BINS - 1];
    for bin in (0..BINS - 1).rev() {
        behind[bin] = add(&bins[bin], &behind[bin + 1]);
    }
    let mut before = bins[0];
    let mut cheapest = None;
    for bin in 1..BINS {
        if before.1 > 0 && behind[bin].1 > 0 {
            let cost = cost(&before) + cost(&behind[bin]);
            if cheapest.is_none_or(|(least, _)| cost < least) {
                cheapest = Some((cost, bin));
            }
        }
        before = add(&before, &bins[bin]);
    }
    cheapest
}

/// Moves the items that are `first` before the others, and returns where those begin.
fn partition<I>(items: &mut [I], first: impl Fn(&I) -> bool) -> usize {
    let (mut low, mut high) = (0, items.len());
    while low < high {
        if first(&items[low]) {
            low += 1;
        } else {
            high -= 1;
            items.swap(low, high);
        }
    }
    low
}
