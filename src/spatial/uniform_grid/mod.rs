//! A hierarchical grid in an unbounded world.
//!
//! Boxes of like size share a level, and each box is in exactly one cell of its level: the one that its centre is in
//! (Ericson, *Real-Time Collision Detection*, 2005, §7.2.1, hierarchical grids; Ulrich, *Loose Octrees*, 2000). A query
//! looks at the cells around its region, as far as the largest box of the level reaches. So nothing is found twice, a
//! huge box fills one cell of a coarse level, and an update that stays in its cell stores the box.
//!
//! Cells come in bricks of 4 × 4 × 4, which a hash table finds by their exact coordinates. The content of a cell is in
//! buckets of eight boxes, tested at once. No query walks more cells than there are bricks: regions and rays that cross
//! more than that go through the bricks instead.
//!
//! | operation | time |
//! |---|---|
//! | insert, remove, update | O(1), amortised over the choice of the cell size |
//! | region, neighbours | O(cells that the region meets + leaves in them) |
//! | ray, sweep | O(cells along the way + leaves in them) |
//! | touching pairs | O(n + pairs of leaves in neighbouring cells) |
//!
//! That is for leaves of like size and density. Where some cells are crowded, as with all leaves at one point, queries
//! there are linear; where the density varies over orders of magnitude, a tree is better.

mod brick;
mod bucket;
mod cells;
mod lattice;
mod level;
mod near;
mod pairs;
mod rebuild;
mod regions;
mod trace;
mod tune;
mod update;
mod validate;
mod walk;

pub use cells::Cell;
pub use validate::BrokenInvariant;

use std::ops::ControlFlow;

use bevy::{
    math::{Vec3A, bounding::Aabb3d},
    reflect::Reflect,
};

use super::{
    LeafId, NoSuchLeaf, Region, SpatialQueries, SpatialUpdates, Sweep, Trace, UnsoundBox, UpdateError, Visit,
    leaves::Leaves,
};
use crate::geometry::{
    aabb::{EMPTY, union},
    ray::Ray,
};
use bucket::{Buckets, Place};
use level::Level;
use rebuild::Scratch;
use trace::Way;
use tune::Tuning;

/// How large the smallest cells of a [`UniformGrid`] are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Reflect)]
pub enum CellSize {
    /// As the grid finds best: from the median size of the leaves, or coarser where they are sparse; chosen again when
    /// that has changed much.
    #[default]
    Auto,
    /// Always this, in units of the space of the leaves; beyond 2^±100, that.
    Fixed(f32),
}

impl GridSettings {
    /// Whether a grid can be made of them: a size that is given must be positive and finite.
    pub fn is_sound(&self) -> bool {
        match self.cell_size {
            CellSize::Auto => true,
            CellSize::Fixed(cell) => cell > 0.0 && cell.is_finite(),
        }
    }
}

/// What is up to the owner of a [`UniformGrid`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Reflect)]
pub struct GridSettings {
    /// The size of the smallest cells. Leaves larger than that are in coarser levels.
    pub cell_size: CellSize,
}

/// A hierarchical grid of axis-aligned boxes, each with a key of type `K`. See the [module](self).
///
/// Holds up to 2²⁹ leaves.
#[derive(Clone, Debug)]
pub struct UniformGrid<K> {
    settings: GridSettings,
    /// The place of each leaf: keys are in the buckets.
    leaves: Leaves<(), Place>,
    buckets: Buckets<K>,
    /// From the finest to the coarsest.
    levels: Vec<Level>,
    /// Which levels hold leaves, bit by bit.
    occupied: u128,
    tuning: Tuning,
    /// Kept while most leaves leave their cells again and again.
    scratch: Scratch<K>,
}

impl<K: Copy> Default for UniformGrid<K> {
    fn default() -> Self {
        Self::new(GridSettings::default())
    }
}

impl<K: Copy> UniformGrid<K> {
    /// No boxes.
    ///
    /// # Panics
    ///
    /// If a fixed cell size is not positive and finite.
    pub fn new(settings: GridSettings) -> Self {
        assert!(
            settings.is_sound(),
            "the cell size must be positive and finite: {settings:?}"
        );
        Self {
            settings,
            leaves: Leaves::default(),
            buckets: Buckets::default(),
            levels: Vec::new(),
            occupied: 0,
            tuning: Tuning::new(settings.cell_size),
            scratch: Scratch::default(),
        }
    }

    /// As it was made with.
    pub fn settings(&self) -> GridSettings {
        self.settings
    }

    /// The levels that hold leaves, from the finest to the coarsest.
    #[inline(always)]
    fn occupied_levels(&self) -> impl Iterator<Item = &Level> + Clone {
        let numbers = (0..self.levels.len()).filter(|&number| self.occupied >> number & 1 == 1);
        numbers.map(|number| &self.levels[number])
    }

    #[inline(always)]
    fn key_of(&self, place: Place) -> K {
        self.buckets.get(place.bucket()).keys[place.lane()]
    }
}

impl<K: Copy> SpatialQueries<K> for UniformGrid<K> {
    fn len(&self) -> usize {
        self.leaves.len()
    }

    fn bounds(&self) -> Option<Aabb3d> {
        let bounds = self
            .occupied_levels()
            .fold(EMPTY, |bounds, level| union(&bounds, &level.bounds));
        (!self.is_empty()).then_some(bounds)
    }

    fn memory(&self) -> usize {
        self.leaves.memory()
            + self.buckets.memory()
            + self.levels.capacity() * size_of::<Level>()
            + self.levels.iter().map(Level::memory).sum::<usize>()
            + self.scratch.memory()
    }

    fn visit_all(&self, mut visit: impl FnMut(K, &Aabb3d)) {
        for bucket in &self.buckets.buckets {
            for lane in 0..bucket.len as usize {
                visit(bucket.keys[lane], &bucket.boxes.get(lane));
            }
        }
    }

    fn visit_ray(&self, ray: &Ray, visit: impl FnMut(K, f32) -> Visit) {
        self.walk_ray(ray, (), visit);
    }

    fn trace_ray(&self, ray: &Ray, visit: impl FnMut(K, f32) -> Visit) -> Trace<K> {
        let mut way = Way::new(ray);
        self.walk_ray(ray, &mut way, visit);
        way.finish()
    }

    fn visit_sweep<S: Sweep>(&self, sweep: &S, visit: impl FnMut(K, f32) -> Visit) {
        self.walk_sweep(sweep, visit);
    }

    fn visit_region<R: Region>(&self, region: &R, visit: impl FnMut(K) -> ControlFlow<()>) {
        self.search_region(region, visit);
    }

    fn visit_near(&self, point: Vec3A, max_distance: f32, visit: impl FnMut(K, f32) -> Visit) {
        self.search_near(point, max_distance, visit);
    }

    fn visit_pairs(&self, mut visit: impl FnMut(K, K) -> ControlFlow<()>) {
        self.search_pairs(pairs::Touching, |a, b, _| visit(a, b));
    }
}

impl<K: Copy> SpatialUpdates<K> for UniformGrid<K> {
    fn insert(&mut self, key: K, aabb: Aabb3d) -> Result<LeafId, UnsoundBox> {
        self.add(key, aabb)
    }

    fn insert_many(&mut self, leaves: impl IntoIterator<Item = (K, Aabb3d)>) -> Vec<Result<LeafId, UnsoundBox>> {
        self.add_many(leaves)
    }

    fn remove(&mut self, id: LeafId) -> Result<K, NoSuchLeaf> {
        self.take(id)
    }

    fn update(&mut self, id: LeafId, aabb: Aabb3d) -> Result<(), UpdateError> {
        self.replace(id, &aabb)
    }

    fn update_many(&mut self, updates: &[(LeafId, Aabb3d)]) -> Vec<(LeafId, UpdateError)> {
        self.replace_many(updates)
    }

    fn clear(&mut self) {
        self.leaves.clear();
        self.clear_cells();
    }

    fn key(&self, id: LeafId) -> Option<K> {
        self.leaves.place(id).ok().map(|place| self.key_of(place))
    }

    fn aabb(&self, id: LeafId) -> Option<Aabb3d> {
        let place = self.leaves.place(id).ok()?;
        Some(self.buckets.get(place.bucket()).boxes.get(place.lane()))
    }
}
