//! Hierarchies from the root down, by splitting the items in two again and again.

use std::ops::Range;

use smallvec::{SmallVec, smallvec};

use super::{
    binned_sah,
    extents::Extents,
    progress::{Cancelled, Stage},
    tagged_box::{BinaryNode, BuildItem},
    workers::{Errand, Workers},
};

/// From this depth on all splits are halves: no input makes a hierarchy deeper than this and the logarithm of the number
/// of items.
pub(super) const DEPTH_LIMIT: u32 = 64;

/// Ranges of more items than this are split side by side, and the others built side by side.
const GRAIN: usize = 1 << 14;

/// How often progress is told, in items.
const STEP: usize = 1 << 12;

/// How a range of items, of which there are at least two, is split: where the second part begins, after reordering.
/// `None`, or a part without members, stands for halves.
pub(super) type Split = fn(&mut [BuildItem], &Extents) -> Option<usize>;

/// What is the same for all of a build from the root down.
#[derive(Clone, Copy)]
pub(super) struct TopDown<'a> {
    pub split: Split,
    pub bag_size: u32,
    pub workers: &'a dyn Workers,
    /// Of as many steps as there are items.
    pub stage: &'a Stage<'a>,
}

impl TopDown<'_> {
    /// Builds a hierarchy over items, which are reordered, and returns its root. Writes the other nodes over `tree`,
    /// parents first, and the rings of its bags over `rings`.
    pub(super) fn build(
        &self,
        items: &mut [BuildItem],
        tree: &mut Vec<BinaryNode>,
        rings: &mut Vec<u32>,
    ) -> Result<BinaryNode, Cancelled> {
        tree.clear();
        rings.clear();
        rings.resize(items.len(), 0);
        let all = Part {
            items,
            rings,
            start: 0,
            depth: 0,
        };
        if self.workers.count() > 1 && all.items.len() > 2 * GRAIN {
            self.build_side_by_side(all, tree)
        } else {
            self.build_part(all, tree)
        }
    }

    /// Builds what is below a part, with the first of its nodes behind those that are in `tree`.
    fn build_part(&self, part: Part, tree: &mut Vec<BinaryNode>) -> Result<BinaryNode, Cancelled> {
        let mut root = BinaryNode::FAR;
        let mut done = 0;
        let mut waiting: SmallVec<[(Range<usize>, Option<usize>, u32); 128]> =
            smallvec![(0..part.items.len(), None, part.depth)];
        while let Some((range, node, depth)) = waiting.pop() {
            let count = range.len();
            let items = &mut part.items[range.clone()];
            let extents = Extents::of(items);
            let first = if count <= self.bag_size as usize {
                let start = part.start + range.start;
                ring(&mut part.rings[range], start as u32);
                done += count;
                if done >= STEP {
                    self.stage.advance(done)?;
                    done = 0;
                }
                start
            } else {
                if count > STEP {
                    self.stage.advance(0)?;
                }
                let middle = self.middle(items, &extents, depth);
                let children = tree.len();
                tree.extend([BinaryNode::FAR; 2]);
                waiting.push((range.start + middle..range.end, Some(children + 1), depth + 1));
                waiting.push((range.start..range.start + middle, Some(children), depth + 1));
                children
            };
            *node.map_or(&mut root, |node| &mut tree[node]) =
                BinaryNode::new(&extents.bounds, first as u32, count as u32);
        }
        self.stage.advance(done)?;
        Ok(root)
    }

    /// Splits items, and returns where the second part begins.
    fn middle(&self, items: &mut [BuildItem], extents: &Extents, depth: u32) -> usize {
        let count = items.len();
        Some(items)
            .filter(|_| depth < DEPTH_LIMIT)
            .and_then(|items| (self.split)(items, extents))
            .filter(|middle| (1..count).contains(middle))
            .unwrap_or(count / 2)
    }

    /// The same as [`Self::build_part`], level by level until parts are small.
    fn build_side_by_side(&self, all: Part, tree: &mut Vec<BinaryNode>) -> Result<BinaryNode, Cancelled> {
        let mut top = vec![Top::Waiting];
        let mut level = vec![(0, all)];
        while !level.is_empty() {
            let mut outcomes: Vec<Result<Top, Cancelled>> = Vec::new();
            outcomes.resize_with(level.len(), || Ok(Top::Waiting));
            let mut errands: Vec<Errand<'_>> = Vec::with_capacity(level.len());
            for ((_, part), outcome) in level.iter_mut().zip(&mut outcomes) {
                let part = part.reborrow();
                errands.push(Box::new(move || *outcome = self.settle(part)));
            }
            self.workers.run(errands);

            let mut next = Vec::new();
            for ((place, part), outcome) in level.into_iter().zip(outcomes) {
                let mut outcome = outcome?;
                if let Top::Inner { middle, children, .. } = &mut outcome {
                    *children = top.len();
                    let (left, right) = part.split_at(*middle);
                    next.extend([(top.len(), left), (top.len() + 1, right)]);
                    top.extend([Top::Waiting, Top::Waiting]);
                }
                top[place] = outcome;
            }
            level = next;
        }
        Ok(assemble(&mut top, 0, self.bag_size, tree))
    }

    /// Splits a large part, and builds a small one.
    fn settle(&self, part: Part) -> Result<Top, Cancelled> {
        if part.items.len() <= GRAIN {
            let mut tree = Vec::new();
            let root = self.build_part(part, &mut tree)?;
            return Ok(Top::Built { root, tree });
        }
        self.stage.advance(0)?;
        let extents = Extents::of(part.items);
        self.stage.advance(0)?;
        let middle = self.middle(part.items, &extents, part.depth);
        let node = BinaryNode::new(&extents.bounds, 0, part.items.len() as u32);
        Ok(Top::Inner {
            node,
            middle,
            children: 0,
        })
    }
}

/// A range of the items that has no nodes yet.
struct Part<'a> {
    items: &'a mut [BuildItem],
    rings: &'a mut [u32],
    /// The index of its first item.
    start: usize,
    depth: u32,
}

impl<'a> Part<'a> {
    fn reborrow(&mut self) -> Part<'_> {
        Part {
            items: self.items,
            rings: self.rings,
            ..*self
        }
    }

    fn split_at(self, middle: usize) -> (Part<'a>, Part<'a>) {
        let (items, more_items) = self.items.split_at_mut(middle);
        let (rings, more_rings) = self.rings.split_at_mut(middle);
        let (start, depth) = (self.start, self.depth + 1);
        let left = Part {
            items,
            rings,
            start,
            depth,
        };
        let right = Part {
            items: more_items,
            rings: more_rings,
            start: start + middle,
            depth,
        };
        (left, right)
    }
}

/// A node of the levels that are split side by side.
enum Top {
    Waiting,
    Inner {
        node: BinaryNode,
        middle: usize,
        /// Of two that follow each other.
        children: usize,
    },
    Built {
        root: BinaryNode,
        tree: Vec<BinaryNode>,
    },
}

/// Appends everything below a node in the order in which one thread comes by it.
fn assemble(top: &mut [Top], place: usize, bag_size: u32, tree: &mut Vec<BinaryNode>) -> BinaryNode {
    let at = tree.len();
    match std::mem::replace(&mut top[place], Top::Waiting) {
        Top::Inner { node, children, .. } => {
            tree.extend([BinaryNode::FAR; 2]);
            for child in 0..2 {
                tree[at + child] = assemble(top, children + child, bag_size, tree);
            }
            node.with_first(at as u32)
        }
        Top::Built { root, tree: below } => {
            let moved = |node: BinaryNode| node.moved_by(at as u32, bag_size);
            tree.extend(below.into_iter().map(moved));
            moved(root)
        }
        Top::Waiting => unreachable!("every part was settled"),
    }
}

/// Writes the ring of a bag whose items begin at `start`.
fn ring(ring: &mut [u32], start: u32) {
    let last = ring.len() - 1;
    for (next, link) in (start + 1..).zip(&mut *ring) {
        *link = next;
    }
    ring[last] = start;
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
