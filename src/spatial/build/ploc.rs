//! Hierarchies from the leaves up.
//!
//! Source: Meister and Bittner, *Parallel Locally-Ordered Clustering for Bounding Volume Hierarchy Construction*, 2018:
//! every item is a cluster. Round by round, each looks for its nearest along a space-filling curve, which is the one with
//! the least area around both, and those that are nearest to each other merge. What is merged takes the place of the
//! first on the curve.

use std::{hint::select_unpredictable, ops::Range};

use super::{
    nearest::{self, EVERY_TWO, Key, MARGIN, NO_KEY, Search, WINDOW},
    progress::{Cancelled, Stage},
    tagged_box::{BinaryNode, BuildItem},
    workers::{Errand, Workers},
};
use crate::spatial::simd::{self, Simd, Task};

/// When a round merges less than one in so many, then the next merges every two neighbours, whatever their distance: there
/// are chains of clusters each of which is nearest to the next, and only the last two of which merge. So there are
/// O(log n) rounds, and as many levels.
const STALL: usize = 16;

/// The first rounds are for so many items at a time, whose clusters stay in the cache of a core meanwhile.
const BLOCK: usize = 4096;
/// So many items are clustered side by side with others.
const PART: usize = 16 * BLOCK;
/// A block is done with when one cluster in so many is left.
const LEFT_OF_BLOCK: usize = 8;

/// Builds hierarchies by clustering, and keeps its buffers.
#[derive(Clone, Debug, Default)]
pub(super) struct Ploc {
    /// In the order of the curve.
    clusters: Vec<BinaryNode>,
    /// The least key of each, and behind them a few that no cluster has.
    keys: Vec<Key>,
}

impl Ploc {
    pub(super) fn memory(&self) -> usize {
        self.clusters.capacity() * size_of::<BinaryNode>() + self.keys.capacity() * size_of::<Key>()
    }

    /// Builds a hierarchy over items that are in the order of a curve, and returns its root. Writes the other nodes over
    /// `tree`, children first, and the rings of its bags over `rings`. The stage has as many steps as there are items.
    pub(super) fn build(
        &mut self,
        items: &[BuildItem],
        bag_size: u32,
        tree: &mut Vec<BinaryNode>,
        rings: &mut Vec<u32>,
        workers: &dyn Workers,
        stage: &Stage,
    ) -> Result<BinaryNode, Cancelled> {
        tree.clear();
        rings.clear();
        rings.extend(0..items.len() as u32);
        self.clusters.clear();
        let mut left = items;
        if workers.count() > 1 && items.len() > PART {
            self.build_parts(items, bag_size, tree, rings, workers, stage)?;
            left = &[];
        }
        let mut cluster = |items| {
            simd::dispatch(Clustering {
                items,
                clusters: &mut self.clusters,
                keys: &mut self.keys,
                merged: Merged {
                    tree,
                    rings,
                    start: 0,
                    bag_size,
                },
                stage,
            })
        };
        cluster(left)?;
        cluster(&[])?;
        Ok(self.clusters[0])
    }

    /// Clusters block by block, many blocks side by side.
    fn build_parts(
        &mut self,
        items: &[BuildItem],
        bag_size: u32,
        tree: &mut Vec<BinaryNode>,
        rings: &mut [u32],
        workers: &dyn Workers,
        stage: &Stage,
    ) -> Result<(), Cancelled> {
        let mut parts: Vec<Part> = Vec::new();
        parts.resize_with(items.len().div_ceil(PART), Part::default);
        let mut errands: Vec<Errand<'_>> = Vec::with_capacity(parts.len());
        for ((place, part), (items, rings)) in (0..)
            .step_by(PART)
            .zip(&mut parts)
            .zip(items.chunks(PART).zip(rings.chunks_mut(PART)))
        {
            errands.push(Box::new(move || {
                part.is_cancelled = simd::dispatch(Clustering {
                    items,
                    clusters: &mut part.clusters,
                    keys: &mut part.keys,
                    merged: Merged {
                        tree: &mut part.tree,
                        rings,
                        start: place,
                        bag_size,
                    },
                    stage,
                })
                .is_err();
                part.keys = Vec::new();
            }));
        }
        workers.run(errands);
        for part in parts {
            if part.is_cancelled {
                return Err(Cancelled);
            }
            let nodes = tree.len() as u32;
            let moved = |node: BinaryNode| node.moved_by(nodes, bag_size);
            tree.extend(part.tree.into_iter().map(moved));
            self.clusters.extend(part.clusters.into_iter().map(moved));
        }
        Ok(())
    }
}

/// What many blocks become.
#[derive(Default)]
struct Part {
    clusters: Vec<BinaryNode>,
    keys: Vec<Key>,
    tree: Vec<BinaryNode>,
    is_cancelled: bool,
}

/// Reduces blocks of items; without items, the clusters that there are to one.
struct Clustering<'a> {
    items: &'a [BuildItem],
    clusters: &'a mut Vec<BinaryNode>,
    keys: &'a mut Vec<Key>,
    merged: Merged<'a>,
    stage: &'a Stage<'a>,
}

impl Task for Clustering<'_> {
    type Output = Result<(), Cancelled>;

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) -> Self::Output {
        let mut place = self.merged.start;
        for block in self.items.chunks(BLOCK) {
            self.stage.advance(block.len())?;
            let first = self.clusters.len();
            for item in block {
                self.clusters.push(BinaryNode::new(&item.aabb(), place, 1));
                place += 1;
            }
            self.reduce(simd, first, block.len() / LEFT_OF_BLOCK)?;
        }
        if self.items.is_empty() {
            self.reduce(simd, 0, 1)?;
        }
        Ok(())
    }
}

impl Clustering<'_> {
    /// Merges the clusters from the `first` on, round by round, until so many are left, or one.
    #[inline(always)]
    fn reduce<S: Simd>(&mut self, simd: S, first: usize, left: usize) -> Result<(), Cancelled> {
        let mut stalls = false;
        while self.clusters.len() - first > left.max(1) {
            let before = self.clusters.len() - first;
            let kept = self.round(simd, first, stalls);
            self.clusters.truncate(first + kept);
            stalls = before - kept < before / STALL;
            self.stage.advance(0)?;
        }
        Ok(())
    }

    /// Merges all from the `first` on that are nearest to each other, or every two, and returns how many are left.
    #[inline(always)]
    fn round<S: Simd>(&mut self, simd: S, first: usize, every_two: bool) -> usize {
        let clusters = &mut self.clusters[first..];
        let count = clusters.len();
        if self.keys.len() < count + MARGIN {
            self.keys.resize(count + MARGIN, NO_KEY);
        }
        let mut search = Search::new();
        let (mut done, mut kept) = (0, 0);
        for start in (0..count).step_by(WINDOW) {
            let end = count.min(start + WINDOW);
            if every_two {
                self.keys[start..end].fill(EVERY_TWO);
            } else {
                search.run(simd, clusters, start, self.keys);
            }
            let known = if end == count {
                self.keys[count..count + MARGIN].fill(NO_KEY);
                count
            } else {
                // The nearest of the last ones may be in the next window.
                end - MARGIN
            };
            kept = self.merged.merge(clusters, self.keys, done..known, kept);
            done = known;
        }
        kept
    }
}

/// What has merged.
struct Merged<'a> {
    tree: &'a mut Vec<BinaryNode>,
    rings: &'a mut [u32],
    /// The place of the first of these rings.
    start: u32,
    bag_size: u32,
}

impl Merged<'_> {
    /// Merges those of a range whose nearest follows, moves what is left to `kept` and behind, and returns where that
    /// ends. Whether a cluster merges cannot be foretold, so there is no branch on it.
    #[inline(always)]
    fn merge(&mut self, clusters: &mut [BinaryNode], keys: &[Key], range: Range<usize>, mut kept: usize) -> usize {
        for place in range {
            let key = keys[place];
            let other = nearest::other(place, key);
            let is_mutual = keys.get(other).is_some_and(|others| others.to_bits() == key.to_bits());
            let merges = is_mutual & (other > place);
            let a = clusters[place];
            let b = clusters[select_unpredictable(merges, other, place)];
            let count = a.count() + select_unpredictable(merges, b.count(), 0);
            let first = if count > self.bag_size {
                let first = self.tree.len();
                self.tree.extend_from_slice(&[a, b]);
                self.tree.truncate(first + 2 * usize::from(merges));
                select_unpredictable(merges, first as u32, a.first())
            } else {
                // Where a member of each of two rings leads on to where the other did, they are one. One with itself
                // stays as it is.
                let (a_item, b_item) = (a.first() - self.start, b.first() - self.start);
                self.rings.swap(a_item as usize, b_item as usize);
                a.first()
            };
            clusters[kept] = BinaryNode::around(&a, &b, first, count);
            kept += usize::from(merges | !is_mutual);
        }
        kept
    }
}
