//! obvhs: its binary tree and its compressed wide one, with its triangles for fast tests in the order of the leaves, as
//! its examples have them.
//!
//! Its compressed triangles round the sides to half precision, and so are others.

use std::time::Duration;

use bevy::math::Vec3;
use bevy_sightline::geometry::ray::Ray;
use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, builder::build_bvh2_from_tris},
    cwbvh::{CwBvh, builder::build_cwbvh_from_tris},
    ray::RayHit,
    rt_triangle::RtTriangle,
    triangle::Triangle,
};

use crate::{
    mesh::{Hit, MeshRays, models::Model, refit::Refit},
    spatial::peers::obvhs::converted,
};

/// The slowest build of all, for the fastest rays; and without its splits, which do not pay everywhere.
pub(crate) const BEST_BINARY: [(&str, BvhBuildParams); 2] = [
    ("obvhs 0.4 Bvh2", BvhBuildParams::very_slow_build()),
    ("obvhs 0.4 Bvh2, unsplit", UNSPLIT),
];

pub(crate) const BEST_WIDE: [(&str, BvhBuildParams); 2] = [
    ("obvhs 0.4 CwBvh", BvhBuildParams::very_slow_build()),
    ("obvhs 0.4 CwBvh, unsplit", UNSPLIT),
];

pub(crate) const UNSPLIT: BvhBuildParams = BvhBuildParams {
    pre_split: false,
    ..BvhBuildParams::very_slow_build()
};

/// A tree with its triangles.
pub(crate) struct Tree<B> {
    bvh: B,
    triangles: Vec<RtTriangle>,
}

pub(crate) type Binary = Tree<Bvh2>;
pub(crate) type Wide = Tree<CwBvh>;

/// What is built from.
pub(crate) fn source(model: &Model) -> Vec<Triangle> {
    model.all_corners().map(triangle).collect()
}

fn triangle(corners: [Vec3; 3]) -> Triangle {
    let [v0, v1, v2] = corners.map(|corner| corner.to_array().into());
    Triangle { v0, v1, v2 }
}

impl Binary {
    pub fn build(model: &Model, params: BvhBuildParams) -> Self {
        Self::build_from(&source(model), params)
    }

    pub fn build_from(source: &[Triangle], params: BvhBuildParams) -> Self {
        let bvh = build_bvh2_from_tris(source, params, &mut Duration::default());
        let triangles = ordered(source, &bvh.primitive_indices);
        Self { bvh, triangles }
    }

    /// With its nodes in the order of queries, not in that in which they were made.
    pub fn reordered(mut self) -> Self {
        self.bvh.reorder_in_stack_traversal_order();
        self
    }
}

impl Wide {
    pub fn build(model: &Model, params: BvhBuildParams) -> Self {
        Self::build_from(&source(model), params)
    }

    pub fn build_from(source: &[Triangle], params: BvhBuildParams) -> Self {
        let bvh = build_cwbvh_from_tris(source, params, &mut Duration::default());
        let triangles = ordered(source, &bvh.primitive_indices);
        Self { bvh, triangles }
    }
}

fn ordered(triangles: &[Triangle], order: &[u32]) -> Vec<RtTriangle> {
    order.iter().map(|&index| (&triangles[index as usize]).into()).collect()
}

impl MeshRays for Binary {
    fn closest(&self, ray: &Ray) -> Option<Hit> {
        let mut hit = RayHit::none();
        let test = |ray: &obvhs::ray::Ray, index: usize| self.triangles[index].intersect(ray);
        let found = self.bvh.ray_traverse(converted(ray), &mut hit, test);
        found.then(|| (hit.t, self.bvh.primitive_indices[hit.primitive_id as usize]))
    }

    fn any(&self, ray: &Ray) -> bool {
        let test = |ray: &obvhs::ray::Ray, index: usize| self.triangles[index].intersect(ray);
        !self.bvh.ray_traverse_miss(converted(ray), test)
    }
}

impl MeshRays for Wide {
    fn closest(&self, ray: &Ray) -> Option<Hit> {
        let mut hit = RayHit::none();
        let test = |ray: &obvhs::ray::Ray, index: usize| self.triangles[index].intersect(ray);
        let found = self.bvh.ray_traverse(converted(ray), &mut hit, test);
        found.then(|| (hit.t, self.bvh.primitive_indices[hit.primitive_id as usize]))
    }

    fn any(&self, ray: &Ray) -> bool {
        let test = |ray: &obvhs::ray::Ray, index: usize| self.triangles[index].intersect(ray);
        !self.bvh.ray_traverse_miss(converted(ray), test)
    }
}

/// A binary tree whose vertices move; the wide one cannot be refitted.
pub(crate) struct Refitted {
    tree: Binary,
    vertices: Vec<[u32; 3]>,
}

impl Refitted {
    pub fn build(model: &Model) -> Self {
        Self {
            tree: Binary::build(model, UNSPLIT).reordered(),
            vertices: model.triangles.clone(),
        }
    }
}

impl MeshRays for Refitted {
    fn closest(&self, ray: &Ray) -> Option<Hit> {
        self.tree.closest(ray)
    }

    fn any(&self, ray: &Ray) -> bool {
        self.tree.any(ray)
    }
}

impl Refit for Refitted {
    fn refit(&mut self, positions: &[Vec3]) {
        let Tree { bvh, triangles } = &mut self.tree;
        for node in bvh.nodes.iter_mut().filter(|node| node.is_leaf()) {
            let mut aabb = Aabb::empty();
            let slots = node.first_index as usize..(node.first_index + node.prim_count) as usize;
            let numbers = &bvh.primitive_indices[slots.clone()];
            for (stored, &number) in triangles[slots].iter_mut().zip(numbers) {
                let vertices = self.vertices[number as usize];
                let moved = triangle(vertices.map(|vertex| positions[vertex as usize]));
                aabb = aabb.union(&moved.aabb());
                *stored = (&moved).into();
            }
            node.set_aabb(aabb);
        }
        bvh.refit_all();
    }
}
