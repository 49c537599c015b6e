//! The way of a ray through a tree.

use std::{
    cell::{Cell, RefCell},
    collections::HashMap,
    ops::ControlFlow,
};

use bevy::math::bounding::Aabb3d;

use super::{KdTree, hierarchy::Hierarchy, leaf::Leaves, query::Query};
use crate::{
    geometry::{aabb::EMPTY, ray::Ray},
    spatial::{
        Trace, Visit,
        lanes::{Boxes, Entering},
        simd::{Simd, Task, dispatch},
        trace::Recorder,
        wide::{Child, NodeIndex, PackedChild},
    },
};

/// See [`SpatialQueries::trace_ray`](crate::spatial::SpatialQueries::trace_ray).
pub(super) fn trace_ray<K: Copy, L: Leaves<K>>(
    tree: &KdTree<K, L>,
    ray: &Ray,
    visit: impl FnMut(K, f32) -> Visit,
) -> Trace<K> {
    let way = RefCell::new(Way {
        hierarchy: &tree.hierarchy,
        leaves: &tree.leaves,
        tested: HashMap::new(),
        recorder: Recorder::new(ray),
    });
    let way = dispatch(Walk { way, ray, visit });
    way.into_inner().recorder.finish()
}

/// The way so far.
struct Way<'a, K, L> {
    hierarchy: &'a Hierarchy,
    leaves: &'a L,
    /// In which step each child was tested.
    tested: HashMap<u32, usize>,
    recorder: Recorder<K>,
}

impl<K: Copy, L: Leaves<K>> Way<'_, K, L> {
    fn tested(&self, child: Child) -> Option<usize> {
        self.tested.get(&PackedChild::pack(child).bits()).copied()
    }

    fn enter(&mut self, index: NodeIndex) {
        let parent = self.tested(Child::Node(index));
        let node = &self.hierarchy.nodes[index as usize];
        let boxes = node.lanes().map(|(aabb, child)| {
            let mut key = None;
            if let (Child::Leaf(leaf), false) = (child, L::ARE_BUCKETS) {
                self.leaves.visit_all(leaf, aabb, |found, _| key = Some(found));
            }
            (aabb, key)
        });
        let step = self.recorder.enter(parent, node.bounds(), boxes);
        let children = node.lanes().map(|(_, child)| (PackedChild::pack(child).bits(), step));
        self.tested.extend(children);
    }

    /// Notes that a bucket is entered, and returns the step.
    fn enter_bucket(&mut self, leaf: u32) -> usize {
        let aabb = self.hierarchy.aabb(leaf);
        let mut boxes = Vec::new();
        self.leaves
            .visit_all(leaf, aabb, |key, aabb| boxes.push((*aabb, Some(key))));
        self.recorder.enter(self.tested(Child::Leaf(leaf)), aabb, boxes)
    }
}

/// A ray that remembers the box that it has met last.
struct Noting {
    ray: Entering<false>,
    met: Cell<Aabb3d>,
}

impl Query for Noting {
    const MEETS_FEW: bool = Entering::MEETS_FEW;

    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, boxes: Boxes, limit: f32) -> (u32, S::F32s) {
        self.ray.meet(simd, boxes, limit)
    }

    fn refine(&self, aabb: impl FnOnce() -> Aabb3d, at: f32) -> Option<f32> {
        self.met.set(aabb());
        Some(at)
    }
}

struct Walk<'a, K, L, F> {
    way: RefCell<Way<'a, K, L>>,
    ray: &'a Ray,
    visit: F,
}

impl<'a, K, L, F> Task for Walk<'a, K, L, F>
where
    K: Copy,
    L: Leaves<K>,
    F: FnMut(K, f32) -> Visit,
{
    type Output = RefCell<Way<'a, K, L>>;

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) -> Self::Output {
        let query = Noting {
            ray: Entering::new(self.ray),
            met: Cell::new(EMPTY),
        };
        let Way { hierarchy, leaves, .. } = *self.way.borrow();
        hierarchy.visit_in_order(
            simd,
            &query,
            self.ray.t_max(),
            |node| self.way.borrow_mut().enter(node),
            |leaf| leaves.announce(leaf),
            |leaf, at, limit| {
                let tested = if L::ARE_BUCKETS {
                    Some(self.way.borrow_mut().enter_bucket(leaf))
                } else {
                    self.way.borrow().tested(Child::Leaf(leaf))
                };
                let aabb = || hierarchy.aabb(leaf);
                leaves.visit_met(simd, (leaf, at), aabb, &query, limit, |key, at, limit| {
                    let wish = (self.visit)(key, at);
                    if let Some(tested) = tested {
                        let mut way = self.way.borrow_mut();
                        way.recorder.visited((tested, query.met.get()), key, at, wish);
                    }
                    match wish {
                        Visit::Continue => {}
                        Visit::Shorten(to) => *limit = limit.min(to),
                        Visit::Stop => return ControlFlow::Break(()),
                    }
                    ControlFlow::Continue(())
                })
            },
        );
        self.way
    }
}
