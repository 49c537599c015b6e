//! What may be inside of half-spaces, the nearest first, by whoever judges what is worth to be looked at.

use bevy::math::bounding::Aabb3d;

use super::{AabbTree, half_spaces::HalfSpaces};
use crate::spatial::{
    lanes::Boxes,
    simd::{LANES, Simd, Task, dispatch, prefetch},
    wide::{Child, NodeIndex},
};

/// Who judges.
pub(crate) trait Judge<K> {
    /// Where a box is, for this judge.
    type Place: Copy;

    /// The places of eight boxes.
    fn places<S: Simd>(&self, simd: S, boxes: Boxes) -> [Self::Place; LANES];

    /// The greater, the sooner a place is visited.
    fn nearness(place: &Self::Place) -> f32;

    /// Whether what is in a place is looked at. Asked when its turn comes: after all that is done with what is nearer.
    fn is_open<S: Simd>(&mut self, simd: S, place: &Self::Place) -> bool;

    /// Is given a box that is open; `is_inside` of all half-spaces by more than rounding.
    fn visit<S: Simd>(&mut self, simd: S, key: K, aabb: &Aabb3d, place: &Self::Place, is_inside: bool);

    /// Is told that so many boxes are in places that are not open.
    fn pass_over(&mut self, count: usize);
}

/// Something that waits for its turn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Waiting<P> {
    place: P,
    child: Child,
    /// The lane of its node, for a leaf.
    lane: u8,
    node: NodeIndex,
    cut_by: u8,
}

impl<K: Copy> AabbTree<K> {
    /// Visits what has a bit of `mask` and may be inside of half-spaces, node by node from the nearest to the farthest,
    /// as far as the judge opens what is there.
    pub(crate) fn judge<J: Judge<K>>(
        &self,
        half_spaces: &HalfSpaces,
        mask: u32,
        judge: &mut J,
        stack: &mut Vec<Waiting<J::Place>>,
    ) {
        dispatch(Descend {
            tree: self,
            half_spaces,
            mask,
            judge,
            stack,
        });
    }
}

struct Descend<'a, K, J: Judge<K>> {
    tree: &'a AabbTree<K>,
    half_spaces: &'a HalfSpaces,
    mask: u32,
    judge: &'a mut J,
    stack: &'a mut Vec<Waiting<J::Place>>,
}

impl<K: Copy, J: Judge<K>> Descend<'_, K, J> {
    /// Has the children of a node wait, the nearest last.
    #[inline(always)]
    fn push_children<S: Simd>(&mut self, simd: S, index: NodeIndex, cut_by: u8) {
        let node = &self.tree.nodes[index as usize];
        let boxes: Boxes = node.into();
        let lanes = simd.with_any_bit(&node.masks, self.mask);
        let (mut lanes, cut) = self.half_spaces.sort_out(simd, boxes, lanes, cut_by);
        if lanes == 0 {
            return;
        }
        let places = self.judge.places(simd, boxes);
        let begin = self.stack.len();
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize % LANES;
            lanes &= lanes - 1;
            let waiting = Waiting {
                place: places[lane],
                child: node.child(lane),
                lane: lane as u8,
                node: index,
                cut_by: HalfSpaces::cut_by(&cut, lane),
            };
            let nearness = J::nearness(&waiting.place);
            self.stack.push(waiting);
            let mut at = self.stack.len() - 1;
            while at > begin && J::nearness(&self.stack[at - 1].place) > nearness {
                self.stack[at] = self.stack[at - 1];
                at -= 1;
            }
            self.stack[at] = waiting;
        }
        if let Some(Waiting {
            child: Child::Node(next),
            ..
        }) = self.stack.last()
        {
            prefetch(&self.tree.nodes[*next as usize]);
        }
    }
}

impl<K: Copy, J: Judge<K>> Task for Descend<'_, K, J> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        self.stack.clear();
        if let Some(root) = self.tree.root {
            let all = self.half_spaces.all();
            self.push_children(simd, root, all);
        }
        while let Some(next) = self.stack.pop() {
            let is_open = self.judge.is_open(simd, &next.place);
            match next.child {
                Child::Node(node) if is_open => self.push_children(simd, node, next.cut_by),
                Child::Node(node) => self.judge.pass_over(self.tree.links[node as usize].count as usize),
                Child::Leaf(leaf) if is_open => {
                    let aabb = self.tree.nodes[next.node as usize].aabb(next.lane as usize);
                    let key = self.tree.leaves.key_at(leaf);
                    self.judge.visit(simd, key, &aabb, &next.place, next.cut_by == 0);
                }
                Child::Leaf(_) => self.judge.pass_over(1),
            }
        }
    }
}
