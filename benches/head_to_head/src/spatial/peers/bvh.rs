//! bvh: its flat tree, which is a loop without a stack.

use bevy::math::{Vec3A, bounding::Aabb3d};
use bevy_sightline::geometry::ray::Ray;
use bvh::{
    aabb::{Aabb, Bounded},
    bounding_hierarchy::BHShape,
    bvh::Bvh,
    flat_bvh::{FlatBvh, FlatNode},
};

use super::{Nearest, Slabs, corners};
use crate::spatial::{
    probes::{Probe, Relation},
    queries::{Found, NearQueries, RayQueries, RegionQueries, Scratch, distance_squared},
};

pub(crate) const NAME: &str = "bvh 0.13 flat";

pub(crate) struct Flat {
    nodes: FlatBvh<f32, 3>,
    boxes: Vec<Aabb3d>,
}

impl Flat {
    pub fn build(boxes: &[Aabb3d]) -> Self {
        let mut shapes: Vec<Shape> = boxes.iter().map(Shape::new).collect();
        Self {
            nodes: Bvh::build(&mut shapes).flatten(),
            boxes: boxes.to_vec(),
        }
    }

    pub fn memory(&self) -> usize {
        self.nodes.capacity() * size_of::<FlatNode<f32, 3>>() + self.boxes.capacity() * size_of::<Aabb3d>()
    }

    /// Goes through the nodes that `enters` is true for, and the leaves below them.
    #[inline]
    fn traverse(&self, mut enters: impl FnMut(Vec3A, Vec3A) -> bool, mut visit: impl FnMut(u32, &Aabb3d) -> bool) {
        let mut index = 0;
        while let Some(node) = self.nodes.get(index) {
            let (entry, exit) = (node.entry_index, node.exit_index as usize);
            index = if entry == u32::MAX {
                if visit(node.shape_index, &self.boxes[node.shape_index as usize]) {
                    return;
                }
                exit
            } else if enters(vector(&node.aabb.min), vector(&node.aabb.max)) {
                entry as usize
            } else {
                exit
            };
        }
    }
}

impl RayQueries for Flat {
    fn closest(&self, ray: &Ray) -> Option<f32> {
        let slabs = Slabs::new(ray);
        let closest = std::cell::Cell::new(f32::INFINITY);
        self.traverse(
            |min, max| slabs.enter(min, max) < closest.get(),
            |_, aabb| {
                closest.set(closest.get().min(slabs.enter(aabb.min, aabb.max)));
                false
            },
        );
        closest.get().is_finite().then_some(closest.get())
    }

    fn any(&self, ray: &Ray) -> bool {
        let slabs = Slabs::new(ray);
        let mut found = false;
        self.traverse(
            |min, max| slabs.enter(min, max) < f32::INFINITY,
            |_, aabb| {
                found = slabs.enter(aabb.min, aabb.max) < f32::INFINITY;
                found
            },
        );
        found
    }

    fn all(&self, ray: &Ray) -> Found {
        let slabs = Slabs::new(ray);
        let mut found = Found::default();
        self.traverse(
            |min, max| slabs.enter(min, max) < f32::INFINITY,
            |key, aabb| {
                if slabs.enter(aabb.min, aabb.max) < f32::INFINITY {
                    found.add(key);
                }
                false
            },
        );
        found
    }
}

impl RegionQueries for Flat {
    fn find<P: Probe>(&self, probe: &P) -> Found {
        let mut found = Found::default();
        self.traverse(
            |min, max| probe.relation(min, max) != Relation::Apart,
            |key, aabb| {
                if probe.touches(aabb.min, aabb.max) {
                    found.add(key);
                }
                false
            },
        );
        found
    }
}

impl NearQueries for Flat {
    fn nearest<const N: usize>(&self, point: Vec3A, _: &mut Scratch) -> [f32; N] {
        let nearest = std::cell::RefCell::new(Nearest::<N>::new());
        self.traverse(
            |min, max| distance_squared(point, min, max) < nearest.borrow().limit(),
            |key, aabb| {
                nearest
                    .borrow_mut()
                    .add(key, distance_squared(point, aabb.min, aabb.max));
                false
            },
        );
        nearest.into_inner().distances_squared
    }
}

/// A box as its builder wants it.
struct Shape {
    aabb: Aabb<f32, 3>,
    node: usize,
}

impl Shape {
    fn new(aabb: &Aabb3d) -> Self {
        let [min, max] = corners(aabb).map(Into::into);
        Self {
            aabb: Aabb::with_bounds(min, max),
            node: 0,
        }
    }
}

impl Bounded<f32, 3> for Shape {
    fn aabb(&self) -> Aabb<f32, 3> {
        self.aabb
    }
}

impl BHShape<f32, 3> for Shape {
    fn set_bh_node_index(&mut self, index: usize) {
        self.node = index;
    }

    fn bh_node_index(&self) -> usize {
        self.node
    }
}

/// A vector of the crate as one of ours.
#[inline]
pub(crate) fn vector(point: &(impl std::ops::Index<usize, Output = f32> + ?Sized)) -> Vec3A {
    Vec3A::new(point[0], point[1], point[2])
}
