//! obvhs, with the whole tree built anew in every frame by its fastest builder.

use bevy::math::bounding::Aabb3d;
use bevy_sightline::geometry::ray::Ray;
use obvhs::{
    aabb::Aabb,
    bvh2::Bvh2,
    ploc::{PlocBuilder, PlocSearchDistance, SortPrecision},
    ray::RayHit,
};

use super::{
    Slabs,
    obvhs::{aabb, aabbs, converted},
};
use crate::spatial::{motion::Move, updates::Upkeep};

pub(crate) const NAME: &str = "obvhs 0.4 rebuilt";

pub(crate) struct Rebuilt {
    bvh: Bvh2,
    boxes: Vec<Aabb3d>,
    aabbs: Vec<Aabb>,
    builder: PlocBuilder,
}

impl Rebuilt {
    pub fn build(boxes: &[Aabb3d]) -> Self {
        let mut rebuilt = Self {
            bvh: Bvh2::zeroed(boxes.len()),
            boxes: boxes.to_vec(),
            aabbs: aabbs(boxes),
            builder: PlocBuilder::with_capacity(boxes.len()),
        };
        rebuilt.frame(&[]);
        rebuilt
    }
}

impl Upkeep for Rebuilt {
    fn frame(&mut self, moves: &[Move]) {
        for (key, new) in moves {
            self.boxes[*key as usize] = *new;
            self.aabbs[*key as usize] = aabb(new);
        }
        let mut indices = std::mem::take(&mut self.bvh.primitive_indices);
        indices.clear();
        indices.extend(0..self.boxes.len() as u32);
        self.builder.build_with_bvh(
            &mut self.bvh,
            PlocSearchDistance::Minimum,
            &self.aabbs,
            indices,
            SortPrecision::U64,
            0,
        );
    }

    fn closest(&self, ray: &Ray) -> Option<f32> {
        closest(&self.bvh, &self.boxes, ray)
    }
}

/// The first of the boxes along a ray, each inside of its leaf.
pub(super) fn closest(bvh: &Bvh2, boxes: &[Aabb3d], ray: &Ray) -> Option<f32> {
    let slabs = Slabs::new(ray);
    let mut hit = RayHit::none();
    let found = bvh.ray_traverse(converted(ray), &mut hit, |_, index| {
        let aabb = &boxes[bvh.primitive_indices[index] as usize];
        slabs.enter(aabb.min, aabb.max)
    });
    found.then_some(hit.t)
}
