//! obvhs: its binary tree and its compressed wide one.

use std::time::Duration;

use bevy::math::{Vec3A, bounding::Aabb3d};
use bevy_sightline::geometry::ray::Ray;
use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, builder::build_bvh2, node::Bvh2Node},
    cwbvh::{CwBvh, builder::build_cwbvh},
    fast_stack,
    faststack::FastStack,
    ray::RayHit,
};

use super::Nearest;
use crate::spatial::{
    probes::{Probe, Relation},
    queries::{Found, NearQueries, PairQueries, RayQueries, RegionQueries, Scratch, distance_squared},
};

pub(crate) const BINARY: &str = "obvhs 0.4 Bvh2";
pub(crate) const WIDE: &str = "obvhs 0.4 CwBvh";

/// The parameters of the trees that are queried: the slowest build, for the fastest queries. A leaf of the binary tree is
/// its box, so that one to a leaf is best there; in the wide one, three are.
const fn params(max_prims_per_leaf: u32) -> BvhBuildParams {
    BvhBuildParams {
        pre_split: false,
        max_prims_per_leaf,
        ..BvhBuildParams::very_slow_build()
    }
}

/// The binary tree, one box to a leaf.
pub(crate) struct Binary {
    bvh: Bvh2,
}

impl Binary {
    pub fn build(boxes: &[Aabb3d]) -> Self {
        Self::build_with(boxes, params(1))
    }

    pub fn build_with(boxes: &[Aabb3d], params: BvhBuildParams) -> Self {
        let mut bvh = build(boxes, params);
        // They come in the order in which they were made, which is not that of queries.
        bvh.reorder_in_stack_traversal_order();
        Self { bvh }
    }

    pub fn memory(&self) -> usize {
        self.bvh.nodes.capacity() * size_of::<Bvh2Node>()
            + (self.bvh.primitive_indices.capacity() + self.bvh.parents.capacity()) * size_of::<u32>()
    }

    fn key(&self, leaf: &Bvh2Node) -> u32 {
        self.bvh.primitive_indices[leaf.first_index as usize]
    }

    #[inline]
    fn traverse(&self, ray: &Ray, mut visit: impl FnMut(&Bvh2Node, &mut obvhs::ray::Ray) -> bool) -> f32 {
        let mut hit = RayHit::none();
        fast_stack!(u32, (96, 192), self.bvh.max_depth, stack, {
            self.bvh
                .ray_traverse_dynamic(&mut stack, converted(ray), &mut hit, |leaf, ray, _| visit(leaf, ray));
        });
        hit.t
    }
}

/// The binary tree as it is built.
pub(crate) fn build(boxes: &[Aabb3d], params: BvhBuildParams) -> Bvh2 {
    build_bvh2(&aabbs(boxes), params, &mut Duration::default())
}

impl RayQueries for Binary {
    fn closest(&self, ray: &Ray) -> Option<f32> {
        let mut closest = f32::INFINITY;
        self.traverse(ray, |leaf, ray| {
            let t = leaf.aabb().intersect_ray(ray).max(0.0);
            if t < ray.tmax {
                ray.tmax = t;
                closest = t;
            }
            true
        });
        closest.is_finite().then_some(closest)
    }

    fn any(&self, ray: &Ray) -> bool {
        let mut found = false;
        self.traverse(ray, |_, _| {
            found = true;
            false
        });
        found
    }

    fn all(&self, ray: &Ray) -> Found {
        let mut found = Found::default();
        self.traverse(ray, |leaf, _| {
            found.add(self.key(leaf));
            true
        });
        found
    }
}

impl RegionQueries for Binary {
    /// As `Bvh2::aabb_traverse` does it, and no test below what is inside.
    fn find<P: Probe>(&self, probe: &P) -> Found {
        const WITHOUT_TEST: u32 = 1 << 31;
        let mut found = Found::default();
        fast_stack!(u32, (96, 192), self.bvh.max_depth, stack, {
            stack.push(self.bvh.nodes[0].first_index);
            while let Some(index) = stack.pop() {
                let without_test = index & WITHOUT_TEST;
                let first = (index & !WITHOUT_TEST) as usize;
                for node in &self.bvh.nodes[first..first + 2] {
                    let (min, max) = bounds(node.aabb());
                    if without_test != 0 {
                        if node.is_leaf() {
                            found.add(self.key(node));
                        } else {
                            stack.push(node.first_index | WITHOUT_TEST);
                        }
                    } else if node.is_leaf() {
                        if probe.touches(min, max) {
                            found.add(self.key(node));
                        }
                    } else {
                        match probe.relation(min, max) {
                            Relation::Apart => {}
                            Relation::Across => stack.push(node.first_index),
                            Relation::Inside => stack.push(node.first_index | WITHOUT_TEST),
                        }
                    }
                }
            }
        });
        found
    }
}

impl PairQueries for Binary {
    /// One query for each box, as in the broad phase of avian3d.
    fn pairs(&self) -> Found {
        let mut found = Found::default();
        for leaf in self.bvh.nodes.iter().filter(|node| node.is_leaf()) {
            let key = self.key(leaf);
            self.bvh.aabb_traverse(*leaf.aabb(), |bvh, other| {
                let other = self.key(&bvh.nodes[other as usize]);
                if key < other {
                    found.add_pair(key, other);
                }
                true
            });
        }
        found
    }
}

impl NearQueries for Binary {
    /// Depth first, the nearer child before the other, as avian3d does it for the nearest one.
    fn nearest<const N: usize>(&self, point: Vec3A, _: &mut Scratch) -> [f32; N] {
        let mut nearest = Nearest::<N>::new();
        let distance = |node: &Bvh2Node| {
            let (min, max) = bounds(node.aabb());
            distance_squared(point, min, max)
        };
        fast_stack!((u32, f32), (96, 192), self.bvh.max_depth, stack, {
            stack.push((self.bvh.nodes[0].first_index, 0.0));
            while let Some((first, at)) = stack.pop() {
                if at >= nearest.limit() {
                    continue;
                }
                let [near, far] = [first, first + 1].map(|index| &self.bvh.nodes[index as usize]);
                let (near, far) = ((near, distance(near)), (far, distance(far)));
                let (near, far) = if near.1 <= far.1 { (near, far) } else { (far, near) };
                for (node, at) in [far, near] {
                    if node.is_leaf() {
                        nearest.add(self.key(node), at);
                    } else if at < nearest.limit() {
                        stack.push((node.first_index, at));
                    }
                }
            }
        });
        nearest.distances_squared
    }
}

/// The compressed tree of nodes of eight, with the boxes in its order.
pub(crate) struct Wide {
    bvh: CwBvh,
    boxes: Vec<Aabb>,
}

impl Wide {
    pub fn build(boxes: &[Aabb3d]) -> Self {
        let aabbs = aabbs(boxes);
        let bvh = build_cwbvh(&aabbs, params(3), &mut Duration::default());
        let boxes = bvh
            .primitive_indices
            .iter()
            .map(|&index| aabbs[index as usize])
            .collect();
        Self { bvh, boxes }
    }

    pub fn memory(&self) -> usize {
        self.bvh.nodes.capacity() * size_of::<obvhs::cwbvh::node::CwBvhNode>()
            + self.bvh.primitive_indices.capacity() * size_of::<u32>()
            + self.boxes.capacity() * size_of::<Aabb>()
    }
}

impl RayQueries for Wide {
    fn closest(&self, ray: &Ray) -> Option<f32> {
        let mut hit = RayHit::none();
        let found = self.bvh.ray_traverse(converted(ray), &mut hit, |ray, index| {
            self.boxes[index].intersect_ray(ray).max(0.0)
        });
        found.then_some(hit.t)
    }

    fn any(&self, ray: &Ray) -> bool {
        !(self.bvh).ray_traverse_miss(converted(ray), |ray, index| self.boxes[index].intersect_ray(ray))
    }

    fn all(&self, ray: &Ray) -> Found {
        let mut found = Found::default();
        self.bvh.ray_traverse_anyhit(converted(ray), |ray, index| {
            if self.boxes[index].intersect_ray(ray) < f32::INFINITY {
                found.add(self.bvh.primitive_indices[index]);
            }
        });
        found
    }
}

pub(crate) fn aabbs(boxes: &[Aabb3d]) -> Vec<Aabb> {
    boxes.iter().map(aabb).collect()
}

pub(crate) fn aabb(aabb: &Aabb3d) -> Aabb {
    Aabb::new(aabb.min.to_array().into(), aabb.max.to_array().into())
}

pub(crate) fn converted(ray: &Ray) -> obvhs::ray::Ray {
    let (origin, direction) = (ray.origin().to_array(), ray.direction().to_array());
    obvhs::ray::Ray::new(origin.into(), direction.into(), 0.0, ray.t_max())
}

/// The corners of a box, in the glam of bevy.
#[inline]
fn bounds(aabb: &Aabb) -> (Vec3A, Vec3A) {
    (vector(aabb.min), vector(aabb.max))
}

/// Another version of glam has the same registers.
#[cfg(target_arch = "x86_64")]
#[inline]
fn vector(vector: impl Into<std::arch::x86_64::__m128>) -> Vec3A {
    Vec3A::from(vector.into())
}

#[cfg(not(target_arch = "x86_64"))]
#[inline]
fn vector(vector: impl Into<[f32; 3]>) -> Vec3A {
    Vec3A::from(vector.into())
}
