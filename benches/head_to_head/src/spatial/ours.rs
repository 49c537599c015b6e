//! Our structures, as the benchmarks fill and move them.

use bevy::math::bounding::Aabb3d;
use bevy_sightline::{
    geometry::ray::Ray,
    spatial::{
        AabbTree, BuildStrategy, KdTree, LeafId, PointKdTree, SpatialQueries, SpatialUpdates, UniformGrid,
        kd_tree::SplitMethod,
    },
};

use super::{motion::Move, queries::RayQueries, updates::Upkeep};

/// The structure that is raced where no other is named.
pub(crate) type Tree = AabbTree<u32>;

/// The tree of the boxes, whose keys are their indices.
pub(crate) fn tree(boxes: &[Aabb3d]) -> Tree {
    fill(Tree::new(), boxes).0
}

/// The tree of the boxes, built at leisure.
pub(crate) fn best_tree(boxes: &[Aabb3d]) -> Tree {
    let mut tree = tree(boxes);
    tree.rebuild_with(BuildStrategy::Reinsertion);
    tree
}

/// The tree of the boxes, kept up.
pub(crate) fn moving_tree(boxes: &[Aabb3d]) -> Moving<Tree> {
    Moving::new(Tree::new(), boxes, |tree| {
        tree.optimize();
    })
}

/// The grid of the boxes.
pub(crate) fn grid(boxes: &[Aabb3d]) -> UniformGrid<u32> {
    fill(UniformGrid::default(), boxes).0
}

/// The k-d tree of the boxes.
pub(crate) fn kd_tree(boxes: &[Aabb3d]) -> KdTree<u32> {
    KdTree::new((0..).zip(boxes.iter().copied()), SplitMethod::default()).expect("sound boxes")
}

/// The k-d tree of the minima of the boxes, which are points.
pub(crate) fn point_tree(points: &[Aabb3d]) -> PointKdTree<u32> {
    let points = points.iter().map(|point| point.min);
    PointKdTree::from_points((0..).zip(points), SplitMethod::default()).expect("finite points")
}

/// Adds the boxes, and gives the leaf of each.
fn fill<T: SpatialUpdates<u32>>(mut structure: T, boxes: &[Aabb3d]) -> (T, Vec<LeafId>) {
    let leaves = structure.insert_many((0..).zip(boxes.iter().copied()));
    let leaves = leaves.into_iter().map(|leaf| leaf.expect("a sound box")).collect();
    (structure, leaves)
}

/// Has a structure inside.
pub(crate) trait Holds {
    type Structure: SpatialQueries<u32>;

    fn structure(&self) -> &Self::Structure;
}

/// A structure of boxes that move.
pub(crate) struct Moving<T> {
    structure: T,
    leaves: Vec<LeafId>,
    updates: Vec<(LeafId, Aabb3d)>,
    /// What is done once a frame.
    optimize: fn(&mut T),
}

impl<T: SpatialUpdates<u32>> Moving<T> {
    pub fn new(empty: T, boxes: &[Aabb3d], optimize: fn(&mut T)) -> Self {
        let (structure, leaves) = fill(empty, boxes);
        Self {
            structure,
            leaves,
            updates: Vec::new(),
            optimize,
        }
    }
}

impl<T: SpatialUpdates<u32>> Holds for Moving<T> {
    type Structure = T;

    fn structure(&self) -> &T {
        &self.structure
    }
}

impl<T: SpatialUpdates<u32>> Upkeep for Moving<T> {
    fn prepare(&mut self, moves: &[Move]) {
        let update = |&(key, aabb): &Move| (self.leaves[key as usize], aabb);
        self.updates = moves.iter().map(update).collect();
    }

    fn frame(&mut self, _: &[Move]) {
        let refused = self.structure.update_many(&self.updates);
        assert!(refused.is_empty(), "all boxes are sound, and none was removed");
        (self.optimize)(&mut self.structure);
    }

    fn closest(&self, ray: &Ray) -> Option<f32> {
        RayQueries::closest(&self.structure, ray)
    }
}

/// A structure that is never changed: built anew when boxes move.
pub(crate) struct Static<T> {
    structure: T,
    boxes: Vec<Aabb3d>,
    build: fn(&[Aabb3d]) -> T,
}

impl<T> Static<T> {
    pub fn new(boxes: &[Aabb3d], build: fn(&[Aabb3d]) -> T) -> Self {
        Self {
            structure: build(boxes),
            boxes: boxes.to_vec(),
            build,
        }
    }
}

impl<T: SpatialQueries<u32>> Holds for Static<T> {
    type Structure = T;

    fn structure(&self) -> &T {
        &self.structure
    }
}

impl<T: SpatialQueries<u32>> Upkeep for Static<T> {
    fn frame(&mut self, moves: &[Move]) {
        for &(key, aabb) in moves {
            self.boxes[key as usize] = aabb;
        }
        self.structure = (self.build)(&self.boxes);
    }

    fn closest(&self, ray: &Ray) -> Option<f32> {
        RayQueries::closest(&self.structure, ray)
    }
}
