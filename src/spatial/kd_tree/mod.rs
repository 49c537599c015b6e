//! A static k-d tree, over boxes or over points.
//!
//! Space is split in two by a plane across one axis, each half again, and so on (Bentley, *Multidimensional Binary
//! Search Trees Used for Associative Searching*, 1975): here with respect to the centres of the boxes, so that every box
//! is in one cell, and each cell keeps the box around its content, so that nothing is missed (Ooi, McDonell and
//! Sacks-Davis, *Spatial kd-Tree: An Indexing Mechanism for Spatial Databases*, 1987). Queries go by these boxes, which
//! are tighter than the cells between the planes. Three levels of splits, more or less, lie in one node of eight lanes.
//!
//! Over boxes a leaf is a lane. Over points it is a bucket of eight points, which are tested at once.
//!
//! # Why boxes are not cut by the planes
//!
//! A k-d tree for rays as Wald and Havran build it (*On building fast kd-Trees for Ray Tracing*, 2006) puts a box that a
//! plane cuts into both halves, and can stop at the first cell with a hit. Its leaves hold each box several times, and a
//! query has to remember which it has visited. Here every box is visited once by itself, the leaves below a cell are a
//! range of memory, and the limit that a hit sets turns cells away as well.

mod build;
mod hierarchy;
mod leaf;
mod nearest;
mod query;
mod trace;
mod traverse;
mod validate;

pub use leaf::{BoxLeaves, PointLeaves};
pub use validate::BrokenInvariant;

use std::marker::PhantomData;

use bevy::math::{Vec3A, bounding::Aabb3d};

use self::{
    build::{BoxItem, PointItem},
    hierarchy::Hierarchy,
    leaf::{Bucket, Leaves},
};
use super::{UnsoundBox, query::Descend};
use crate::geometry::aabb::Aabb3dExt;

/// Where cells are split.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SplitMethod {
    /// Where the surface area heuristic has its minimum (Goldsmith and Salmon 1987): the cost of a half is its surface
    /// area times the number of its boxes. For boxes of many sizes, or in clusters, that are asked more often than built.
    #[default]
    Sah,
    /// At the median of the centres along the widest axis (Friedman, Bentley and Finkel 1977). Built several times
    /// faster, and as good for points that are spread evenly.
    Median,
}

/// A static k-d tree of boxes, or of [points](PointKdTree), each with a key of type `K`. See the [module](self).
///
/// Built at once, and never changed. To the queries, a point is a box of no size. Holds up to 2³⁰ boxes.
#[derive(Clone, Debug)]
pub struct KdTree<K, L = BoxLeaves<K>> {
    hierarchy: Hierarchy,
    leaves: L,
    keys: PhantomData<K>,
}

/// A static k-d tree of points, each with a key of type `K`: built by [`from_points`](KdTree::from_points).
pub type PointKdTree<K> = KdTree<K, PointLeaves<K>>;

/// What cannot be in a tree.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("item {index}: {unsound}")]
pub struct RefusedItem {
    /// Its index among what the tree was to be built from.
    pub index: usize,
    /// Its box. That of a point has it for both its corners.
    pub unsound: UnsoundBox,
}

impl<K: Copy> KdTree<K> {
    /// Builds a tree over boxes.
    ///
    /// # Errors
    ///
    /// If a box is not [sound](Aabb3dExt::is_sound): the first such one is named, and nothing is built. To do without
    /// those, filter them out.
    pub fn new(boxes: impl IntoIterator<Item = (K, Aabb3d)>, method: SplitMethod) -> Result<Self, RefusedItem> {
        let (mut items, keys) = collect(boxes, |aabb| *aabb, BoxItem::new)?;
        let mut ordered = Vec::with_capacity(keys.len());
        let hierarchy = build::build(&mut items, method, |leaf| {
            ordered.extend(leaf.iter().map(|item| keys[item.index() as usize]));
        });
        let leaves = BoxLeaves { keys: ordered };
        Ok(Self::with(hierarchy, leaves))
    }
}

impl<K: Copy> PointKdTree<K> {
    /// Builds a tree over points.
    ///
    /// # Errors
    ///
    /// If a coordinate is NaN or infinite: the first such point is named, and nothing is built.
    pub fn from_points(points: impl IntoIterator<Item = (K, Vec3A)>, method: SplitMethod) -> Result<Self, RefusedItem> {
        let to_box = |&point: &Vec3A| Aabb3d { min: point, max: point };
        let (mut items, keys) = collect(points, to_box, |&point, index| PointItem::new(point, index))?;
        let mut buckets = Vec::with_capacity(items.len().div_ceil(build::BUCKET));
        let hierarchy = build::build(&mut items, method, |leaf| buckets.push(Bucket::new(leaf, &keys)));
        buckets.shrink_to_fit();
        let len = items.len();
        Ok(Self::with(hierarchy, PointLeaves { buckets, len }))
    }
}

/// The items to build from, with their indices, and the keys by these.
fn collect<K, T, I>(
    pairs: impl IntoIterator<Item = (K, T)>,
    to_box: impl Fn(&T) -> Aabb3d,
    to_item: impl Fn(&T, u32) -> I,
) -> Result<(Vec<I>, Vec<K>), RefusedItem> {
    let pairs = pairs.into_iter();
    let mut items = Vec::with_capacity(pairs.size_hint().0);
    let mut keys = Vec::with_capacity(pairs.size_hint().0);
    for (index, (key, value)) in pairs.enumerate() {
        let aabb = to_box(&value);
        if !aabb.is_sound() {
            let unsound = UnsoundBox(aabb);
            return Err(RefusedItem { index, unsound });
        }
        items.push(to_item(&value, index as u32));
        keys.push(key);
    }
    Ok((items, keys))
}

#[expect(private_bounds, reason = "the two kinds of leaves that there are implement it")]
impl<K: Copy, L: Leaves<K>> KdTree<K, L> {
    fn with(hierarchy: Hierarchy, leaves: L) -> Self {
        Self {
            hierarchy,
            leaves,
            keys: PhantomData,
        }
    }

    /// The number of levels of nodes; zero if the tree is empty.
    pub fn depth(&self) -> usize {
        self.hierarchy.depth()
    }

    /// The surface area cost: the expected number of boxes of cells that a random line through the bounds meets.
    ///
    /// The sum of the areas of all boxes over the area of the bounds (MacDonald and Booth 1990). Zero if the tree is
    /// empty or all its boxes are flat in two directions.
    pub fn sah_cost(&self) -> f32 {
        self.hierarchy.sah_cost()
    }

    /// Visits every cell, as for drawing: its level, with 0 for the whole, the box around its content, and how many boxes
    /// or points that is. A cell comes before those in it.
    pub fn visit_cells(&self, mut visit: impl FnMut(usize, &Aabb3d, usize)) {
        self.hierarchy.visit_cells(|level, aabb, child| {
            let leaves = self.hierarchy.leaves(child);
            visit(level, aabb, leaves.map(|leaf| self.leaves.count(leaf)).sum());
        });
    }

    /// The same without the number, and goes into a cell only where `visit` says so.
    pub fn descend_cells(&self, mut visit: impl FnMut(usize, &Aabb3d) -> Descend) {
        self.hierarchy.descend_cells(|level, aabb, _| visit(level, aabb));
    }
}
