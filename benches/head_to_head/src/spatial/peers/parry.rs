//! parry3d.

use std::cell::RefCell;

use bevy::math::{Vec3A, bounding::Aabb3d};
use bevy_sightline::geometry::ray::Ray;
use parry3d::{
    bounding_volume::Aabb,
    partitioning::{Bvh, BvhBuildStrategy, BvhNode, BvhWorkspace, TraversalAction},
    query,
};

use super::{Nearest, Slabs, corners};
use crate::spatial::{
    probes::{Probe, Relation},
    queries::{Found, NearQueries, PairQueries, RayQueries, RegionQueries, Scratch, distance_squared},
};

pub(crate) const BINNED: &str = "parry3d 0.31 binned";
pub(crate) const PLOC: &str = "parry3d 0.31 PLOC";

/// The tree, with the boxes of the leaves: a ray that meets a leaf is told its index only.
pub(crate) struct Parry {
    bvh: Bvh,
    boxes: Vec<Aabb3d>,
    workspace: RefCell<BvhWorkspace>,
}

impl Parry {
    pub fn build(boxes: &[Aabb3d], strategy: BvhBuildStrategy) -> Self {
        Self {
            bvh: build(boxes, strategy),
            boxes: boxes.to_vec(),
            workspace: RefCell::default(),
        }
    }

    pub fn memory(&self) -> usize {
        self.bvh.total_memory_size() + self.boxes.capacity() * size_of::<Aabb3d>()
    }
}

pub(crate) fn build(boxes: &[Aabb3d], strategy: BvhBuildStrategy) -> Bvh {
    let aabbs: Vec<Aabb> = boxes.iter().map(aabb).collect();
    Bvh::from_leaves(strategy, &aabbs)
}

impl RayQueries for Parry {
    fn closest(&self, ray: &Ray) -> Option<f32> {
        closest(&self.bvh, &self.boxes, ray)
    }

    fn any(&self, ray: &Ray) -> bool {
        let slabs = Slabs::new(ray);
        let mut found = false;
        self.bvh.traverse(|node| {
            if slabs.enter(mins(node), maxs(node)) == f32::INFINITY {
                TraversalAction::Prune
            } else if node.is_leaf() {
                found = true;
                TraversalAction::EarlyExit
            } else {
                TraversalAction::Continue
            }
        });
        found
    }

    fn all(&self, ray: &Ray) -> Found {
        let slabs = Slabs::new(ray);
        let mut found = Found::default();
        self.bvh.traverse(|node| {
            if slabs.enter(mins(node), maxs(node)) == f32::INFINITY {
                return TraversalAction::Prune;
            }
            node.leaf_data().into_iter().for_each(|key| found.add(key));
            TraversalAction::Continue
        });
        found
    }
}

/// The first of the boxes along a ray, each inside of its leaf.
pub(crate) fn closest(bvh: &Bvh, boxes: &[Aabb3d], ray: &Ray) -> Option<f32> {
    let slabs = Slabs::new(ray);
    let ray = query::Ray::new(ray.origin().to_array().into(), ray.direction().to_array().into());
    let hit = bvh.cast_ray(&ray, f32::MAX, |leaf, _| {
        let aabb = &boxes[leaf as usize];
        Some(slabs.enter(aabb.min, aabb.max))
    });
    hit.map(|(_, t)| t)
}

impl RegionQueries for Parry {
    fn find<P: Probe>(&self, probe: &P) -> Found {
        let mut found = Found::default();
        if let Some(region) = probe.as_aabb() {
            self.bvh.intersect_aabb(&aabb(region)).for_each(|key| found.add(key));
            return found;
        }
        self.bvh.traverse_indexed(None, |node, index| {
            let (min, max) = (mins(node), maxs(node));
            if let Some(key) = node.leaf_data() {
                if probe.touches(min, max) {
                    found.add(key);
                }
                return TraversalAction::Prune;
            }
            match probe.relation(min, max) {
                Relation::Apart => TraversalAction::Prune,
                Relation::Across => TraversalAction::Continue,
                Relation::Inside => {
                    self.bvh.traverse_indexed(Some(index), |node, _| {
                        node.leaf_data().into_iter().for_each(|key| found.add(key));
                        TraversalAction::Continue
                    });
                    TraversalAction::Prune
                }
            }
        });
        found
    }
}

impl PairQueries for Parry {
    fn pairs(&self) -> Found {
        let mut found = Found::default();
        let mut workspace = self.workspace.borrow_mut();
        self.bvh
            .traverse_bvtt_single_tree::<false>(&mut workspace, &mut |a, b| found.add_pair(a, b));
        found
    }
}

impl NearQueries for Parry {
    /// Its search for the best leaf, which is told the distance of the last of the best instead.
    fn nearest<const N: usize>(&self, point: Vec3A, _: &mut Scratch) -> [f32; N] {
        let nearest = RefCell::new(Nearest::<N>::new());
        self.bvh.find_best(
            f32::MAX,
            |node, _| distance_squared(point, mins(node), maxs(node)),
            |leaf, _| {
                let aabb = &self.boxes[leaf as usize];
                let mut nearest = nearest.borrow_mut();
                nearest.add(leaf, distance_squared(point, aabb.min, aabb.max));
                Some(nearest.limit())
            },
        );
        nearest.into_inner().distances_squared
    }
}

pub(crate) fn aabb(aabb: &Aabb3d) -> Aabb {
    let [min, max] = corners(aabb);
    Aabb::new(min.into(), max.into())
}

#[inline]
fn mins(node: &BvhNode) -> Vec3A {
    Vec3A::from_array(node.mins().to_array())
}

#[inline]
fn maxs(node: &BvhNode) -> Vec3A {
    Vec3A::from_array(node.maxs().to_array())
}
