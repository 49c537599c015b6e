//! The way of a ray through a grid.

use bevy::math::{Vec3A, bounding::Aabb3d};

use super::{
    brick::Brick,
    bucket::Bucket,
    lattice::{BRICK_CELLS, CellRange, Lattice, cell_of},
    level::Level,
    walk::Watch,
};
use crate::{
    geometry::ray::Ray,
    spatial::{Trace, Visit, trace::Recorder},
};

/// The way so far.
pub(super) struct Way<K> {
    recorder: Recorder<K>,
    /// The steps in which the bricks were tested, and the boxes of the last bucket.
    bricks: usize,
    bucket: usize,
}

impl<K> Way<K> {
    pub fn new(ray: &Ray) -> Self {
        Self {
            recorder: Recorder::new(ray),
            bricks: 0,
            bucket: 0,
        }
    }

    pub fn finish(self) -> Trace<K> {
        self.recorder.finish()
    }
}

impl<K: Copy> Watch<K> for &mut Way<K> {
    fn look_at_bricks(&mut self, level: &Level, among: Option<CellRange>) {
        let bounds = among.map_or(level.bounds, |among| around(&level.lattice, &among));
        let there = (level.bricks.iter()).filter(|brick| brick.occupied != 0);
        let there = there.filter(|brick| among.is_none_or(|among| among.contains(brick.coordinates)));
        let boxes = there.map(|brick| (brick.bounds, None));
        self.bricks = self.recorder.enter(None, bounds, boxes);
    }

    fn look_into(&mut self, level: &Level, brick: &Brick, bucket: &Bucket<K>) {
        let cell = cell_of(brick.coordinates, bucket.slot.bit() as u32);
        let boxes = (0..bucket.len as usize).map(|lane| (bucket.boxes.get(lane), Some(bucket.keys[lane])));
        self.bucket = (self.recorder).enter(Some(self.bricks), level.lattice.cube(cell), boxes);
    }

    fn visited(&mut self, bucket: &Bucket<K>, lane: usize, at: f32, wish: Visit) {
        let tested = (self.bucket, bucket.boxes.get(lane));
        self.recorder.visited(tested, bucket.keys[lane], at, wish);
    }
}

/// The box of a range of bricks.
fn around(lattice: &Lattice, bricks: &CellRange) -> Aabb3d {
    let brick = lattice.cell * BRICK_CELLS as f32;
    Aabb3d {
        min: bricks.min.as_vec3a() * brick,
        max: (bricks.max.as_vec3a() + Vec3A::ONE) * brick,
    }
}
