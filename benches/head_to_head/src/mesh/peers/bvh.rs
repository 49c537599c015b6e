//! bvh: its flat tree. Its own test of triangles sees one side only, so that it gets that of obvhs.

use bevy_sightline::geometry::ray::Ray;
use bvh::{
    aabb::{Aabb, Bounded},
    bounding_hierarchy::BHShape,
    bvh::Bvh,
    flat_bvh::FlatBvh,
};
use obvhs::rt_triangle::RtTriangle;

use super::obvhs::source;
use crate::{
    mesh::{Hit, MeshRays, models::Model},
    spatial::peers::{Slabs, bvh::vector, obvhs::converted},
};

pub(crate) struct Flat {
    nodes: FlatBvh<f32, 3>,
    triangles: Vec<RtTriangle>,
}

impl Flat {
    pub fn build(model: &Model) -> Self {
        let mut shapes: Vec<Shape> = model
            .all_corners()
            .map(|[a, b, c]| Shape {
                min: a.min(b).min(c).to_array(),
                max: a.max(b).max(c).to_array(),
                node: 0,
            })
            .collect();
        Self {
            nodes: Bvh::build(&mut shapes).flatten(),
            triangles: source(model).iter().map(Into::into).collect(),
        }
    }

    /// Goes through the tree; `first` ends it with the first hit.
    #[inline]
    fn traverse(&self, ray: &Ray, first: bool) -> Option<Hit> {
        let slabs = Slabs::new(ray);
        let mut ray = converted(ray);
        let mut closest = None;
        let mut index = 0;
        while let Some(node) = self.nodes.get(index) {
            let (entry, exit) = (node.entry_index, node.exit_index as usize);
            index = exit;
            if entry == u32::MAX {
                let t = self.triangles[node.shape_index as usize].intersect(&ray);
                if t < ray.tmax {
                    ray.tmax = t;
                    closest = Some((t, node.shape_index));
                    if first {
                        return closest;
                    }
                }
            } else if slabs.enter(vector(&node.aabb.min), vector(&node.aabb.max)) < ray.tmax {
                index = entry as usize;
            }
        }
        closest
    }
}

impl MeshRays for Flat {
    fn closest(&self, ray: &Ray) -> Option<Hit> {
        self.traverse(ray, false)
    }

    fn any(&self, ray: &Ray) -> bool {
        self.traverse(ray, true).is_some()
    }
}

/// A triangle as its builder wants it.
struct Shape {
    min: [f32; 3],
    max: [f32; 3],
    node: usize,
}

impl Bounded<f32, 3> for Shape {
    fn aabb(&self) -> Aabb<f32, 3> {
        Aabb::with_bounds(self.min.into(), self.max.into())
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
