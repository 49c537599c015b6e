//! Making a binary hierarchy better by moving its nodes.
//!
//! Source: Meister and Bittner, *Parallel Reinsertion for Bounding Volume Hierarchy Optimization*, 2018: for each of many
//! nodes, the place is found where the areas of all nodes together would be least if it were there. Of these moves the
//! best are done first, and none that touches a node which a better one has touched. The batches become smaller, so that
//! the largest nodes are tried most often (as the crate `obvhs` has it).

use smallvec::SmallVec;

use super::{
    plan::area,
    progress::{Cancelled, Stage},
    tagged_box::BinaryNode,
    workers::{Errand, Workers},
};

/// In the i-th batch, one node in `2 i + 1` is tried: those with the largest areas.
const BATCHES: usize = 16;

/// So many places are looked at for a node, at most. Measured: most need 15, and with 50 trees are no worse; it matters
/// where everything overlaps.
const PLACES: u32 = 200;

/// No move makes a hierarchy deeper than so many times half the logarithm of the number of its nodes: where boxes lie
/// in each other, chains would cost least.
const DEPTH_LIMIT: u32 = 5;

/// So many nodes are tried in one go.
const PORTION: usize = 1 << 12;
/// How often progress is told, in nodes.
const STEP: usize = 1 << 8;

/// The root has no parent.
const NONE: u32 = u32::MAX;

/// The steps that a stage takes for a hierarchy of so many nodes.
pub(super) fn steps(nodes: usize) -> usize {
    (0..BATCHES).map(|batch| nodes / (2 * batch + 1)).sum()
}

/// Moves nodes about, and keeps its buffers.
#[derive(Clone, Debug, Default)]
pub(super) struct Reinsertion {
    /// By pair, the node that it is below.
    parents: Vec<u32>,
    /// By pair, the levels below it.
    heights: Vec<u8>,
    /// By node, whether a move of this batch has changed it.
    touched: Vec<bool>,
    candidates: Vec<Candidate>,
}

#[derive(Clone, Copy, Debug)]
struct Candidate {
    area: f32,
    node: u32,
}

/// A node that is to become the sibling of another.
#[derive(Clone, Copy, Debug)]
struct Move {
    /// By how much the areas become less.
    gain: f32,
    node: u32,
    to: u32,
}

impl Reinsertion {
    pub(super) fn memory(&self) -> usize {
        self.parents.capacity() * size_of::<u32>()
            + self.heights.capacity()
            + self.touched.capacity()
            + self.candidates.capacity() * size_of::<Candidate>()
    }

    /// Gives the memory back.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// Optimises a hierarchy whose nodes come after their parents, and leaves them so.
    pub(super) fn run(
        &mut self,
        root: &mut BinaryNode,
        tree: &mut Vec<BinaryNode>,
        bag_size: u32,
        workers: &dyn Workers,
        stage: &Stage,
    ) -> Result<(), Cancelled> {
        if tree.len() <= 2 {
            return Ok(());
        }
        // With a place of its own, the root is a node like others.
        let root_index = tree.len() as u32;
        tree.extend([*root, BinaryNode::NOTHING]);
        self.link(tree, bag_size);
        let most_levels = DEPTH_LIMIT * tree.len().ilog2() / 2;

        for batch in 0..BATCHES {
            let count = (root_index as usize / (2 * batch + 1)).max(1);
            self.choose(&tree[..root_index as usize], count);
            let mut moves = self.find_moves(tree, root_index, bag_size, workers, stage)?;
            moves.sort_unstable_by(|a, b| b.gain.total_cmp(&a.gain).then(a.node.cmp(&b.node)));
            self.touched.clear();
            self.touched.resize(tree.len(), false);
            for to_do in moves {
                self.try_move(tree, bag_size, most_levels, to_do);
            }
        }

        tree.truncate(root_index as usize + 1);
        *root = tree.pop().expect("the root was put there");
        let mut ordered = Vec::with_capacity(tree.len());
        *root = parents_first(tree, *root, bag_size, &mut ordered);
        *tree = ordered;
        stage.advance(0)
    }

    /// Notes what is above and below each pair. Children come after their parents, but for the root, which is last.
    fn link(&mut self, tree: &[BinaryNode], bag_size: u32) {
        let pairs = tree.len() / 2;
        self.parents.clear();
        self.parents.resize(pairs, NONE);
        self.heights.clear();
        self.heights.resize(pairs, 0);
        for (index, node) in (0..).zip(tree) {
            if node.count() > bag_size {
                self.parents[node.first() as usize / 2] = index;
            }
        }
        for pair in (0..pairs).rev() {
            self.heights[pair] = self.height_of_pair(tree, bag_size, pair);
        }
        self.heights[pairs - 1] = self.height_of_pair(tree, bag_size, pairs - 1);
    }

    #[inline(always)]
    fn height_of_pair(&self, tree: &[BinaryNode], bag_size: u32, pair: usize) -> u8 {
        let [a, b] = [&tree[2 * pair], &tree[2 * pair + 1]];
        self.height(a, bag_size).max(self.height(b, bag_size)).saturating_add(1)
    }

    /// The levels below a node.
    #[inline(always)]
    fn height(&self, node: &BinaryNode, bag_size: u32) -> u8 {
        if node.count() > bag_size {
            self.heights[node.first() as usize / 2]
        } else {
            0
        }
    }

    /// Takes so many nodes, those with the largest areas, as candidates.
    fn choose(&mut self, tree: &[BinaryNode], count: usize) {
        self.candidates.clear();
        self.candidates
            .extend((0..).zip(tree).map(|(node, aabb)| Candidate { area: area(aabb), node }));
        if count < self.candidates.len() {
            let larger = |a: &Candidate, b: &Candidate| b.area.total_cmp(&a.area).then(a.node.cmp(&b.node));
            self.candidates.select_nth_unstable_by(count, larger);
            self.candidates.truncate(count);
        }
    }

    /// The best moves of all candidates that have one which makes the hierarchy better.
    fn find_moves(
        &self,
        tree: &[BinaryNode],
        root: u32,
        bag_size: u32,
        workers: &dyn Workers,
        stage: &Stage,
    ) -> Result<Vec<Move>, Cancelled> {
        let search = Search {
            tree,
            parents: &self.parents,
            root,
            bag_size,
        };
        let portions = self.candidates.chunks(PORTION);
        let mut found: Vec<Result<Vec<Move>, Cancelled>> = vec![Ok(Vec::new()); portions.len()];
        let mut errands: Vec<Errand<'_>> = Vec::with_capacity(found.len());
        for (candidates, found) in portions.zip(&mut found) {
            errands.push(Box::new(move || *found = search.best_moves(candidates, stage)));
        }
        workers.run(errands);
        let mut moves = Vec::new();
        for found in found {
            moves.append(&mut found?);
        }
        Ok(moves)
    }

    /// Does a move, unless a better one was in its way or the hierarchy would become too deep.
    fn try_move(&mut self, tree: &mut [BinaryNode], bag_size: u32, most_levels: u32, Move { node, to, .. }: Move) {
        let parent_of = |node: u32| self.parents[node as usize / 2];
        let (sibling, parent) = (node ^ 1, parent_of(node));
        let changed = [node, sibling, parent, to, parent_of(to)];
        if changed.iter().any(|&node| self.touched[node as usize]) {
            return;
        }
        // What has no more items than a bag would pass for one.
        let count = |node: u32| tree[node as usize].count();
        let grandparent = parent_of(parent);
        if count(node) + count(to) <= bag_size || (grandparent != NONE && count(grandparent) - count(node) <= bag_size)
        {
            return;
        }
        let height = |node: u32| u32::from(self.height(&tree[node as usize], bag_size));
        // Another move may have put the new place below the node itself.
        let mut levels_above = 0;
        let mut above = to;
        while above != NONE {
            if above == node {
                return;
            }
            levels_above += 1;
            above = parent_of(above);
        }
        if levels_above + 1 + height(node).max(height(to)) > most_levels {
            return;
        }
        for node in changed {
            self.touched[node as usize] = true;
        }

        // The sibling takes the place of the parent, and the pair that it leaves goes below the new place.
        let [sibling, parent, to] = [sibling, parent, to].map(|index| index as usize);
        let (sibling_node, to_node) = (tree[sibling], tree[to]);
        self.put(tree, bag_size, parent, sibling_node);
        self.put(tree, bag_size, sibling, to_node);
        let node = node as usize;
        let above = BinaryNode::around(
            &tree[node],
            &to_node,
            (node & !1) as u32,
            tree[node].count() + to_node.count(),
        );
        self.put(tree, bag_size, to, above);
        self.refit(tree, bag_size, parent);
        self.refit(tree, bag_size, node);
    }

    /// Writes a node, and tells its children where it is.
    fn put(&mut self, tree: &mut [BinaryNode], bag_size: u32, index: usize, node: BinaryNode) {
        tree[index] = node;
        if node.count() > bag_size {
            self.parents[node.first() as usize / 2] = index as u32;
        }
    }

    /// Brings all that is above a node in step with it.
    fn refit(&mut self, tree: &mut [BinaryNode], bag_size: u32, node: usize) {
        let mut pair = node / 2;
        loop {
            self.heights[pair] = self.height_of_pair(tree, bag_size, pair);
            let above = self.parents[pair];
            if above == NONE {
                return;
            }
            let [a, b] = [tree[2 * pair], tree[2 * pair + 1]];
            tree[above as usize] = BinaryNode::around(&a, &b, 2 * pair as u32, a.count() + b.count());
            pair = above as usize / 2;
        }
    }
}

/// What a search reads, on any number of threads.
#[derive(Clone, Copy)]
struct Search<'a> {
    tree: &'a [BinaryNode],
    parents: &'a [u32],
    root: u32,
    bag_size: u32,
}

impl Search<'_> {
    fn best_moves(&self, candidates: &[Candidate], stage: &Stage) -> Result<Vec<Move>, Cancelled> {
        let mut moves = Vec::new();
        for some in candidates.chunks(STEP) {
            moves.extend(some.iter().filter_map(|candidate| self.best_move(candidate.node)));
            stage.advance(some.len())?;
        }
        Ok(moves)
    }

    /// Where a node should be. Goes up from it; at each ancestor, what is on the other side is searched from the top
    /// down, as long as a place there could be better than the best.
    fn best_move(&self, node: u32) -> Option<Move> {
        let moved = &self.tree[node as usize];
        let moved_area = area(moved);
        let mut best = Move {
            gain: 0.0,
            node,
            to: NONE,
        };
        let mut places = PLACES;
        let mut waiting: SmallVec<[(f32, u32); 64]> = SmallVec::new();
        // What is gained by taking the node away, as far as the ancestors are that lose it.
        let mut gain = area(&self.tree[self.parents[node as usize / 2] as usize]);
        let mut left_behind: Option<BinaryNode> = None;
        let mut child = node;
        while child != self.root && places > 0 {
            let other_side = child ^ 1;
            waiting.push((gain, other_side));
            while let Some((gain, place)) = waiting.pop() {
                if gain - moved_area <= best.gain || places == 0 {
                    continue;
                }
                places -= 1;
                let target = &self.tree[place as usize];
                let gain_here = gain - area(&BinaryNode::around(target, moved, 0, 0));
                if gain_here > best.gain && place != node ^ 1 {
                    (best.gain, best.to) = (gain_here, place);
                }
                let gain_below = gain_here + area(target);
                if target.count() > self.bag_size && gain_below - moved_area > best.gain {
                    waiting.push((gain_below, target.first()));
                    waiting.push((gain_below, target.first() + 1));
                }
            }
            child = self.parents[child as usize / 2];
            let other_side = &self.tree[other_side as usize];
            left_behind = Some(match left_behind {
                // The parent goes, and with it all of its area.
                None => *other_side,
                Some(before) => {
                    let after = BinaryNode::around(&before, other_side, 0, 0);
                    gain += area(&self.tree[child as usize]) - area(&after);
                    after
                }
            });
        }
        (best.to != NONE).then_some(best)
    }
}

/// Appends all that is below a node, parents first and pair by pair, and returns the node with its new children.
fn parents_first(tree: &[BinaryNode], node: BinaryNode, bag_size: u32, ordered: &mut Vec<BinaryNode>) -> BinaryNode {
    if node.count() <= bag_size {
        return node;
    }
    let (from, to) = (node.first() as usize, ordered.len());
    ordered.extend_from_slice(&tree[from..from + 2]);
    for child in 0..2 {
        ordered[to + child] = parents_first(tree, tree[from + child], bag_size, ordered);
    }
    node.with_first(to as u32)
}
