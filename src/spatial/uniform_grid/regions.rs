//! What touches a region.

use std::ops::ControlFlow;

use bevy::math::bounding::{Aabb3d, BoundingSphere};

use super::{UniformGrid, bucket::Boxes, level::bits};
use crate::{
    geometry::{aabb::EVERYTHING, tolerance},
    spatial::{
        Region, SpatialQueries,
        region::{Outline, OutlineKind, Plane, contact_slack, with_slack},
        simd::{Simd, Task, dispatch},
    },
};

impl<K: Copy> UniformGrid<K> {
    pub(super) fn search_region<R: Region>(&self, region: &R, visit: impl FnMut(K) -> ControlFlow<()>) {
        let outline = region.outline();
        match &outline.0 {
            OutlineKind::Aabb(aabb) => self.search(&outline, *aabb, *aabb, visit),
            OutlineKind::Sphere(sphere) => self.search(&outline, around_ball(sphere), *sphere, visit),
            OutlineKind::HalfSpaces(planes) => self.search(&outline, EVERYTHING, &planes[..], visit),
            OutlineKind::Polytope { bounds, .. } => {
                // Grown by what any box here would have to be grown by.
                let all = self.bounds().unwrap_or(*bounds);
                let bounds = with_slack(bounds, contact_slack(&all));
                let test = InPolytope {
                    region,
                    outline: &outline,
                    bounds: &bounds,
                };
                self.search(&outline, bounds, test, visit);
            }
        }
    }

    fn search(&self, outline: &Outline, bounds: Aabb3d, test: impl BoxTest, visit: impl FnMut(K) -> ControlFlow<()>) {
        // Stopped or not, the search is over.
        let _: ControlFlow<()> = dispatch(Search {
            grid: self,
            outline,
            bounds,
            test,
            visit,
        });
    }
}

/// A box around all that touches a ball: those squares of distances that are lost to rounding included.
pub(super) fn around_ball(ball: &BoundingSphere) -> Aabb3d {
    let (center, radius) = (ball.center, ball.radius());
    if radius * radius == f32::INFINITY {
        return EVERYTHING;
    }
    let reach = radius * (1.0 + tolerance::REGION_PLANE) + tolerance::SQUARE_UNDERFLOW;
    Aabb3d {
        min: center - reach,
        max: center + reach,
    }
}

/// A region, held against eight boxes at once.
trait BoxTest {
    /// The lanes whose boxes touch the region. Those that are not in use may be among them.
    fn touching<S: Simd>(&self, simd: S, boxes: &Boxes, lanes: u32) -> u32;
}

impl BoxTest for Aabb3d {
    #[inline(always)]
    fn touching<S: Simd>(&self, simd: S, boxes: &Boxes, _: u32) -> u32 {
        boxes.touching(simd, self)
    }
}

impl BoxTest for BoundingSphere {
    #[inline(always)]
    fn touching<S: Simd>(&self, simd: S, boxes: &Boxes, _: u32) -> u32 {
        let center = Aabb3d {
            min: self.center,
            max: self.center,
        };
        let distances = boxes.distances_squared(simd, &center);
        simd.le(distances, simd.splat(self.radius() * self.radius()))
    }
}

impl BoxTest for &[Plane] {
    /// In the order of operations of `Plane::admits`.
    #[inline(always)]
    fn touching<S: Simd>(&self, simd: S, boxes: &Boxes, lanes: u32) -> u32 {
        let mut admitted = lanes;
        for plane in *self {
            let mut sum = simd.splat(0.0);
            for axis in 0..3 {
                let farthest = if plane.normal[axis] >= 0.0 {
                    &boxes.max[axis]
                } else {
                    &boxes.min[axis]
                };
                let along = simd.mul(simd.splat(plane.normal[axis]), simd.load(farthest));
                sum = simd.add(sum, along);
            }
            admitted &= !simd.lt(simd.add(sum, simd.splat(plane.d)), simd.splat(0.0));
        }
        admitted
    }
}

/// A region that is held against boxes one by one, where its outline does not decide.
struct InPolytope<'a, R> {
    region: &'a R,
    outline: &'a Outline,
    bounds: &'a Aabb3d,
}

impl<R: Region> BoxTest for InPolytope<'_, R> {
    #[inline(always)]
    fn touching<S: Simd>(&self, simd: S, boxes: &Boxes, lanes: u32) -> u32 {
        let near = boxes.touching(simd, self.bounds) & lanes;
        let touches =
            |aabb: &Aabb3d| self.outline.may_touch(aabb) && (self.outline.contains(aabb) || self.region.touches(aabb));
        bits(near.into()).fold(0, |found, lane| {
            found | u32::from(touches(&boxes.get(lane as usize))) << lane
        })
    }
}

struct Search<'a, K, T, V> {
    grid: &'a UniformGrid<K>,
    outline: &'a Outline,
    bounds: Aabb3d,
    test: T,
    visit: V,
}

impl<K: Copy, T: BoxTest, V: FnMut(K) -> ControlFlow<()>> Task for Search<'_, K, T, V> {
    type Output = ControlFlow<()>;

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) -> ControlFlow<()> {
        let grid = self.grid;
        for level in grid.occupied_levels() {
            for (brick, cells) in level.bricks_in(&level.cells_touching(&self.bounds)) {
                // Where not all cells are in question, something is in the way, and the brick is not inside.
                let is_whole = cells == brick.occupied;
                if is_whole && !self.outline.may_touch(&brick.bounds) {
                    continue;
                }
                let is_inside = is_whole && self.outline.contains(&brick.bounds);
                for bucket in grid.buckets.in_cells(brick, cells) {
                    let mut found = bucket.lanes();
                    if !is_inside {
                        found &= self.test.touching(simd, &bucket.boxes, found);
                    }
                    for lane in bits(found.into()) {
                        (self.visit)(bucket.keys[lane as usize])?;
                    }
                }
            }
        }
        ControlFlow::Continue(())
    }
}
