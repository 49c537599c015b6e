//! The way of a ray through a structure, step by step: what [`SpatialQueries::trace_ray`](super::SpatialQueries::trace_ray)
//! tells.
//!
//! It is written down by the very traversal that answers the query, so that it cannot differ from what that does.

use std::collections::HashMap;

use bevy::math::bounding::Aabb3d;

use super::{
    Visit,
    lanes::Entering,
    simd::Simd,
    traverse::{VisitLeaf, visit_in_order},
    wide::{Child, NodeIndex, PackedChild, WideNode},
};
use crate::geometry::ray::Ray;

/// The way of a ray through a structure with keys of type `K`. Empty if there is nothing in the structure.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace<K> {
    /// In the order in which they were taken.
    pub steps: Vec<TraceStep<K>>,
}

/// A step of a ray through a structure.
#[derive(Clone, Debug, PartialEq)]
pub enum TraceStep<K> {
    /// A node was entered, and all that is in it held against the ray.
    Node(TracedNode<K>),
    /// It was the turn of a box that the ray enters: its key was visited.
    Leaf(TracedLeaf<K>),
}

/// A node that a ray has entered: what is looked at in one go.
///
/// Of an [`AabbTree`](super::AabbTree), an [`Octree`](super::Octree) or a [`KdTree`](super::KdTree) that is a node, and of a
/// tree of points a bucket too; of a [`UniformGrid`](super::UniformGrid) a layer of bricks of cells, and within that what
/// is in a cell, eight boxes at a time; of [`BruteForce`](super::BruteForce) all there is.
#[derive(Clone, Debug, PartialEq)]
pub struct TracedNode<K> {
    /// The step in which its own box was tested; `None` for those that are entered untested.
    pub parent: Option<usize>,
    /// The number of nodes around this one.
    pub depth: usize,
    /// The box around what is in it; of a grid the layer or the cell, out of which boxes may reach.
    pub bounds: Aabb3d,
    /// What was tested: the boxes in it, and those of nodes within it.
    pub boxes: Vec<TestedBox<K>>,
}

/// A box that was held against a ray.
#[derive(Clone, Debug, PartialEq)]
pub struct TestedBox<K> {
    /// The box.
    pub aabb: Aabb3d,
    /// Its key; `None` if it is that of a node.
    pub key: Option<K>,
    /// The parameter at which the ray enters it; `None` if it does not, as far as it still mattered then.
    pub at: Option<f32>,
}

/// A box whose key was visited.
#[derive(Clone, Debug, PartialEq)]
pub struct TracedLeaf<K> {
    /// The step in which the box was tested.
    pub parent: usize,
    /// Its key.
    pub key: K,
    /// The box.
    pub aabb: Aabb3d,
    /// The parameter at which the ray enters it.
    pub at: f32,
    /// How far the ray still mattered after the visit.
    pub limit: f32,
}

impl<K> Default for Trace<K> {
    fn default() -> Self {
        Self { steps: Vec::new() }
    }
}

impl<K> Trace<K> {
    /// The nodes that were entered, in this order.
    pub fn nodes(&self) -> impl Iterator<Item = &TracedNode<K>> {
        self.steps.iter().filter_map(|step| match step {
            TraceStep::Node(node) => Some(node),
            TraceStep::Leaf(_) => None,
        })
    }

    /// The boxes whose keys were visited, in this order.
    pub fn leaves(&self) -> impl Iterator<Item = &TracedLeaf<K>> {
        self.steps.iter().filter_map(|step| match step {
            TraceStep::Node(_) => None,
            TraceStep::Leaf(leaf) => Some(leaf),
        })
    }

    /// How many boxes were held against the ray, those of nodes included.
    pub fn boxes_tested(&self) -> usize {
        self.nodes().map(|node| node.boxes.len()).sum()
    }

    /// The same way with other keys.
    pub fn map<L>(self, mut key: impl FnMut(K) -> L) -> Trace<L> {
        let steps = self.steps.into_iter().map(|step| match step {
            TraceStep::Node(node) => TraceStep::Node(TracedNode {
                parent: node.parent,
                depth: node.depth,
                bounds: node.bounds,
                boxes: (node.boxes.into_iter())
                    .map(|tested| TestedBox {
                        aabb: tested.aabb,
                        key: tested.key.map(&mut key),
                        at: tested.at,
                    })
                    .collect(),
            }),
            TraceStep::Leaf(leaf) => TraceStep::Leaf(TracedLeaf {
                parent: leaf.parent,
                key: key(leaf.key),
                aabb: leaf.aabb,
                at: leaf.at,
                limit: leaf.limit,
            }),
        });
        Trace { steps: steps.collect() }
    }
}

/// Writes down the way of a ray.
pub(crate) struct Recorder<K> {
    ray: Ray,
    /// How far it still matters.
    limit: f32,
    trace: Trace<K>,
}

impl<K> Recorder<K> {
    pub(crate) fn new(ray: &Ray) -> Self {
        Self {
            ray: *ray,
            limit: ray.t_max(),
            trace: Trace::default(),
        }
    }

    /// Notes that a node is entered, and returns the number of the step.
    pub(crate) fn enter(
        &mut self,
        parent: Option<usize>,
        bounds: Aabb3d,
        boxes: impl IntoIterator<Item = (Aabb3d, Option<K>)>,
    ) -> usize {
        let depth = match parent.and_then(|parent| self.trace.steps.get(parent)) {
            Some(TraceStep::Node(parent)) => parent.depth + 1,
            _ => 0,
        };
        let boxes = boxes.into_iter().map(|(aabb, key)| TestedBox {
            aabb,
            key,
            at: (self.ray.aabb_intersection_at(&aabb)).filter(|&at| at <= self.limit),
        });
        let boxes = boxes.collect();
        self.trace.steps.push(TraceStep::Node(TracedNode {
            parent,
            depth,
            bounds,
            boxes,
        }));
        self.trace.steps.len() - 1
    }

    /// Notes that a box has been visited which was tested in the step `parent`, where the ray enters it, and what the
    /// visitor wants of the rest.
    pub(crate) fn visited(&mut self, (parent, aabb): (usize, Aabb3d), key: K, at: f32, wish: Visit) {
        if let Visit::Shorten(limit) = wish
            && limit < self.limit
        {
            self.limit = limit;
        }
        self.trace.steps.push(TraceStep::Leaf(TracedLeaf {
            parent,
            key,
            aabb,
            at,
            limit: self.limit,
        }));
    }

    pub(crate) fn finish(self) -> Trace<K> {
        self.trace
    }
}

/// Visits the leaves of a hierarchy with a bit of `mask` whose boxes a ray enters, in the order of
/// [`visit_in_order`], and tells the way. Boxes without a bit of the mask count as not tested.
pub(crate) fn trace_in_order<K>(
    nodes: &[WideNode],
    root: NodeIndex,
    mask: u32,
    ray: &Ray,
    key_of: impl Fn(u32) -> K,
    visit: impl VisitLeaf,
) -> Trace<K> {
    let mut watched = Watched {
        nodes,
        mask,
        key_of,
        visit,
        tested: HashMap::new(),
        recorder: Recorder::new(ray),
    };
    visit_in_order(nodes, root, mask, ray.t_max(), Entering::new(ray), &mut watched);
    watched.recorder.finish()
}

/// Has leaves visited, and notes the way to them.
struct Watched<'a, K, F, V> {
    nodes: &'a [WideNode],
    mask: u32,
    key_of: F,
    visit: V,
    /// In which step each child was tested, with its box.
    tested: HashMap<u32, (usize, Aabb3d)>,
    recorder: Recorder<K>,
}

impl<K, F: Fn(u32) -> K, V: VisitLeaf> VisitLeaf for &mut Watched<'_, K, F, V> {
    const WAITS: bool = V::WAITS;

    fn enter(&mut self, node: NodeIndex) {
        let key = PackedChild::pack(Child::Node(node)).bits();
        let parent = self.tested.get(&key).map(|&(step, _)| step);
        let node = &self.nodes[node as usize];
        let lanes = || (node.lanes().zip(node.masks)).filter(|(_, mask)| mask & self.mask != 0);
        let boxes = lanes().map(|((aabb, child), _)| match child {
            Child::Node(_) => (aabb, None),
            Child::Leaf(leaf) => (aabb, Some((self.key_of)(leaf))),
        });
        let step = self.recorder.enter(parent, node.bounds(), boxes);
        let tested = lanes().map(|((aabb, child), _)| (PackedChild::pack(child).bits(), (step, aabb)));
        self.tested.extend(tested);
    }

    fn visit<S: Simd>(&mut self, simd: S, leaf: u32, at: f32) -> Visit {
        let wish = self.visit.visit(simd, leaf, at);
        if let Some(&tested) = self.tested.get(&PackedChild::pack(Child::Leaf(leaf)).bits()) {
            self.recorder.visited(tested, (self.key_of)(leaf), at, wish);
        }
        wish
    }

    fn prefetch(&self, leaf: u32) {
        self.visit.prefetch(leaf);
    }
}
