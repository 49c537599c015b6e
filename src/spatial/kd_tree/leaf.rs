//! What the leaves of a tree are: one box each, or a bucket of up to eight points.

use std::ops::ControlFlow;

use bevy::math::{Vec3A, bounding::Aabb3d};

use super::{
    build::{Item, PointItem},
    query::Query,
};
use crate::spatial::{
    Region,
    lanes::{Bounds, Boxes, LaneRegion, Splat, lanes_of},
    region::Outline,
    simd::{LANES, Simd, prefetch},
};

/// The leaves of a tree, by their numbers. Boxes of leaves come from the tree.
pub(crate) trait Leaves<K> {
    /// Whether a leaf holds several, which are tested when it is visited.
    const ARE_BUCKETS: bool;

    /// How many boxes or points there are.
    fn len(&self) -> usize;

    /// How many there are in a leaf.
    fn count(&self, leaf: u32) -> usize;

    /// The bytes of memory in use.
    fn memory(&self) -> usize;

    /// Brings close what a visit of the leaf will read.
    fn announce(&self, leaf: u32);

    /// Visits everything in the leaf.
    fn visit_all(&self, leaf: u32, aabb: Aabb3d, visit: impl FnMut(K, &Aabb3d));

    /// Visits what the query meets in a leaf that it meets, as far as to `limit`, which `visit` may lower.
    fn visit_met<S: Simd>(
        &self,
        simd: S,
        leaf: (u32, f32),
        aabb: impl Fn() -> Aabb3d,
        query: &impl Query,
        limit: &mut f32,
        visit: impl FnMut(K, f32, &mut f32) -> ControlFlow<()>,
    ) -> ControlFlow<()>;

    /// Visits what touches the region in a leaf that may; all of it if there is no box.
    fn visit_touching<S: Simd>(
        &self,
        simd: S,
        leaf: (u32, Option<Aabb3d>),
        outline: &Outline,
        region: &impl Region,
        visit: impl FnMut(K) -> ControlFlow<()>,
    ) -> ControlFlow<()>;

    /// Visits the pairs that touch of one in each of two leaves whose boxes do; within a leaf, if both are the same.
    fn visit_pairs<S: Simd>(
        &self,
        simd: S,
        leaves: [u32; 2],
        visit: impl FnMut(K, K) -> ControlFlow<()>,
    ) -> ControlFlow<()>;
}

/// One box in each leaf: the tree has it.
#[derive(Clone, Debug)]
pub struct BoxLeaves<K> {
    pub(super) keys: Vec<K>,
}

impl<K: Copy> Leaves<K> for BoxLeaves<K> {
    const ARE_BUCKETS: bool = false;

    fn len(&self) -> usize {
        self.keys.len()
    }

    fn count(&self, _leaf: u32) -> usize {
        1
    }

    fn memory(&self) -> usize {
        self.keys.capacity() * size_of::<K>()
    }

    #[inline(always)]
    fn announce(&self, leaf: u32) {
        prefetch(&self.keys[leaf as usize]);
    }

    fn visit_all(&self, leaf: u32, aabb: Aabb3d, mut visit: impl FnMut(K, &Aabb3d)) {
        visit(self.keys[leaf as usize], &aabb);
    }

    #[inline(always)]
    fn visit_met<S: Simd>(
        &self,
        _simd: S,
        (leaf, at): (u32, f32),
        aabb: impl Fn() -> Aabb3d,
        query: &impl Query,
        limit: &mut f32,
        mut visit: impl FnMut(K, f32, &mut f32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        match query.refine(aabb, at) {
            Some(at) if at <= *limit => visit(self.keys[leaf as usize], at, limit),
            _ => ControlFlow::Continue(()),
        }
    }

    #[inline(always)]
    fn visit_touching<S: Simd>(
        &self,
        _simd: S,
        (leaf, aabb): (u32, Option<Aabb3d>),
        outline: &Outline,
        region: &impl Region,
        mut visit: impl FnMut(K) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        if aabb.is_none_or(|aabb| outline.is_exact() || region.touches(&aabb)) {
            visit(self.keys[leaf as usize])?;
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn visit_pairs<S: Simd>(
        &self,
        _simd: S,
        [a, b]: [u32; 2],
        mut visit: impl FnMut(K, K) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        if a != b {
            visit(self.keys[a as usize], self.keys[b as usize])?;
        }
        ControlFlow::Continue(())
    }
}

/// A bucket of points in each leaf.
#[derive(Clone, Debug)]
pub struct PointLeaves<K> {
    pub(super) buckets: Vec<Bucket<K>>,
    pub(super) len: usize,
}

/// Up to eight points with their keys, in the first lanes. The others are NaN.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Bucket<K> {
    pub(super) points: Bounds,
    pub(super) keys: [K; LANES],
}

impl<K: Copy> Bucket<K> {
    /// The items, of which there are one to eight; their keys are among `keys`.
    pub(super) fn new(items: &[PointItem], keys: &[K]) -> Self {
        let mut bucket = Self {
            points: [[f32::NAN; LANES]; 3],
            keys: [keys[items[0].index() as usize]; LANES],
        };
        for (lane, item) in items.iter().enumerate() {
            let point = item.centroid().to_array();
            for (coordinates, coordinate) in bucket.points.iter_mut().zip(point) {
                coordinates[lane] = coordinate;
            }
            bucket.keys[lane] = keys[item.index() as usize];
        }
        bucket
    }

    pub(super) fn len(&self) -> usize {
        self.points[0].iter().filter(|x| !x.is_nan()).count()
    }

    #[inline(always)]
    fn boxes(&self) -> Boxes<'_> {
        Boxes {
            min: &self.points,
            max: &self.points,
        }
    }

    #[inline]
    pub(super) fn aabb(&self, lane: usize) -> Aabb3d {
        let [x, y, z] = self.points;
        let point = Vec3A::new(x[lane], y[lane], z[lane]);
        Aabb3d { min: point, max: point }
    }
}

impl<K> PointLeaves<K> {
    #[inline(always)]
    fn bucket(&self, leaf: u32) -> &Bucket<K> {
        &self.buckets[leaf as usize]
    }
}

impl<K: Copy> Leaves<K> for PointLeaves<K> {
    const ARE_BUCKETS: bool = true;

    fn len(&self) -> usize {
        self.len
    }

    fn count(&self, leaf: u32) -> usize {
        self.bucket(leaf).len()
    }

    fn memory(&self) -> usize {
        self.buckets.capacity() * size_of::<Bucket<K>>()
    }

    #[inline(always)]
    fn announce(&self, leaf: u32) {
        prefetch(self.bucket(leaf));
    }

    fn visit_all(&self, leaf: u32, _aabb: Aabb3d, mut visit: impl FnMut(K, &Aabb3d)) {
        let bucket = self.bucket(leaf);
        for lane in 0..bucket.len() {
            visit(bucket.keys[lane], &bucket.aabb(lane));
        }
    }

    #[inline(always)]
    fn visit_met<S: Simd>(
        &self,
        simd: S,
        (leaf, _at): (u32, f32),
        _aabb: impl Fn() -> Aabb3d,
        query: &impl Query,
        limit: &mut f32,
        mut visit: impl FnMut(K, f32, &mut f32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let bucket = self.bucket(leaf);
        let (lanes, ats) = query.meet(simd, bucket.boxes(), *limit);
        let ats = simd.store(ats);
        for lane in lanes_of(lanes) {
            match query.refine(|| bucket.aabb(lane), ats[lane]) {
                Some(at) if at <= *limit => visit(bucket.keys[lane], at, limit)?,
                _ => {}
            }
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn visit_touching<S: Simd>(
        &self,
        simd: S,
        (leaf, aabb): (u32, Option<Aabb3d>),
        outline: &Outline,
        region: &impl Region,
        mut visit: impl FnMut(K) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let bucket = self.bucket(leaf);
        let certain = aabb.is_none();
        let lanes = if certain {
            bucket.boxes().present(simd)
        } else {
            outline.0.may_touch(simd, bucket.boxes())
        };
        for lane in lanes_of(lanes) {
            if certain || outline.is_exact() || region.touches(&bucket.aabb(lane)) {
                visit(bucket.keys[lane])?;
            }
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn visit_pairs<S: Simd>(
        &self,
        simd: S,
        [a, b]: [u32; 2],
        mut visit: impl FnMut(K, K) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let (bucket_a, bucket_b) = (self.bucket(a), self.bucket(b));
        for lane in lanes_of(bucket_a.boxes().present(simd)) {
            let others = if a == b { u32::MAX << (lane + 1) } else { u32::MAX };
            let touching = Splat::of_lane(simd, bucket_a.boxes(), lane).touching(simd, bucket_b.boxes()) & others;
            for other in lanes_of(touching) {
                visit(bucket_a.keys[lane], bucket_b.keys[other])?;
            }
        }
        ControlFlow::Continue(())
    }
}
