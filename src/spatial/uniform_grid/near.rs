//! What is near a point.

use std::ops::ControlFlow;

use bevy::math::{
    Vec3A,
    bounding::{Aabb3d, BoundingSphere},
};

use super::{
    UniformGrid,
    brick::Brick,
    lattice::CellRange,
    level::{Level, bits},
    regions::around_ball,
};
use crate::spatial::{
    Visit,
    region::{distance_squared, limit_squared},
    simd::{Simd, Task, dispatch},
};

impl<K: Copy> UniformGrid<K> {
    /// Visits every key whose box is no farther from `point` than `radius`, with that distance squared, in no promised
    /// order: the same boxes as [`visit_near`](crate::spatial::SpatialQueries::visit_near), without its order, and
    /// faster.
    pub fn neighbours_within(&self, point: Vec3A, radius: f32, visit: impl FnMut(K, f32)) {
        dispatch(Neighbours {
            grid: self,
            point,
            limit: limit_squared(point, radius),
            visit,
        });
    }

    pub(super) fn search_near(&self, point: Vec3A, max_distance: f32, visit: impl FnMut(K, f32) -> Visit) {
        // Stopped or not, the search is over.
        let _: ControlFlow<()> = dispatch(Near {
            grid: self,
            point,
            limit: limit_squared(point, max_distance),
            visit,
        });
    }
}

/// A box around all boxes whose distance from the point, squared and rounded, is at most `limit`; `None` if there are
/// none.
fn around(point: Vec3A, limit: f32) -> Option<Aabb3d> {
    (limit >= 0.0).then(|| around_ball(&BoundingSphere::new(point, limit.sqrt())))
}

struct Neighbours<'a, K, V> {
    grid: &'a UniformGrid<K>,
    point: Vec3A,
    limit: f32,
    visit: V,
}

impl<K: Copy, V: FnMut(K, f32)> Task for Neighbours<'_, K, V> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let Some(around) = around(self.point, self.limit) else {
            return;
        };
        let point = as_box(self.point);
        let limit = simd.splat(self.limit);
        let grid = self.grid;
        for level in grid.occupied_levels() {
            for (brick, cells) in level.bricks_in(&level.cells_touching(&around)) {
                if distance_squared(self.point, &brick.bounds) > self.limit {
                    continue;
                }
                for bucket in grid.buckets.in_cells(brick, cells) {
                    let distances = bucket.boxes.distances_squared(simd, &point);
                    let found = simd.le(distances, limit) & bucket.lanes();
                    if found != 0 {
                        let distances = simd.store(distances);
                        for lane in bits(found.into()) {
                            (self.visit)(bucket.keys[lane as usize], distances[lane as usize]);
                        }
                    }
                }
            }
        }
    }
}

fn as_box(point: Vec3A) -> Aabb3d {
    Aabb3d { min: point, max: point }
}

struct Near<'a, K, V> {
    grid: &'a UniformGrid<K>,
    point: Vec3A,
    limit: f32,
    visit: V,
}

impl<K: Copy, V: FnMut(K, f32) -> Visit> Task for Near<'_, K, V> {
    type Output = ControlFlow<()>;

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) -> ControlFlow<()> {
        if !self.point.is_nan() {
            for level in self.grid.occupied_levels() {
                self.search_level(simd, level)?;
            }
        }
        ControlFlow::Continue(())
    }
}

impl<K: Copy, V: FnMut(K, f32) -> Visit> Near<'_, K, V> {
    /// Visits shells of cells around the point, until all cells within the limit are visited.
    ///
    /// The cells within the limit become fewer as that is lowered. Those of them that are between the corners of two
    /// shells are in one of the shells, so that one range tells what was visited.
    #[inline(always)]
    fn search_level<S: Simd>(&mut self, simd: S, level: &Level) -> ControlFlow<()> {
        // Within the range of all cells, so that every shell has some.
        let start = level
            .lattice
            .reaching(self.point, self.point, level.reach)
            .moved_into(&level.cells);
        let (mut visited, mut growth) = (CellRange::EMPTY, 0);
        loop {
            let Some(around) = around(self.point, self.limit) else {
                return ControlFlow::Continue(());
            };
            let whole = level.cells_touching(&around);
            if whole.is_empty() || whole.is_within(&visited) {
                return ControlFlow::Continue(());
            }
            let shell = start.grown(growth).clipped(&whole);
            let mut found = false;
            for (brick, cells) in level.bricks_in(&shell) {
                let cells = cells & !visited.bits_in(brick.coordinates);
                if cells != 0 && distance_squared(self.point, &brick.bounds) <= self.limit {
                    found = true;
                    self.visit_cells(simd, brick, cells)?;
                }
            }
            visited = visited.joined(&shell);
            // Ever faster, and through empty space still faster, for the end may be a million cells away.
            growth += 1 + if found { growth / 2 } else { growth };
        }
    }

    #[inline(always)]
    fn visit_cells<S: Simd>(&mut self, simd: S, brick: &Brick, cells: u64) -> ControlFlow<()> {
        let (grid, point) = (self.grid, as_box(self.point));
        for bucket in grid.buckets.in_cells(brick, cells) {
            let distances = bucket.boxes.distances_squared(simd, &point);
            let found = simd.le(distances, simd.splat(self.limit)) & bucket.lanes();
            let distances = simd.store(distances);
            for lane in bits(found.into()) {
                let distance = distances[lane as usize];
                if distance <= self.limit {
                    match (self.visit)(bucket.keys[lane as usize], distance) {
                        Visit::Continue => {}
                        Visit::Shorten(to) => self.limit = self.limit.min(to),
                        Visit::Stop => return ControlFlow::Break(()),
                    }
                }
            }
        }
        ControlFlow::Continue(())
    }
}
