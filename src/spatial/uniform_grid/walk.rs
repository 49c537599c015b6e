//! What rays and moving shapes meet, layer by layer.
//!
//! The 3D-DDA of Amanatides and Woo (*A Fast Voxel Traversal Algorithm for Ray Tracing*, Eurographics 1987), made thick:
//! boxes reach out of their cells. So a ray goes from layer to layer of bricks along the axis that it is most parallel to,
//! and in each layer looks at the rectangle of bricks from which boxes may reach to it; then in the same way through the
//! layers of cells of those bricks.

use std::ops::ControlFlow;

use bevy::math::{DVec3, IVec3, Vec3A};
use smallvec::SmallVec;

use super::{
    UniformGrid,
    brick::Brick,
    bucket::{Boxes, Bucket},
    lattice::{BRICK_CELLS, CellRange},
    level::{Level, bits},
};
use crate::{
    geometry::{
        ray::{Ray, aabb::SlabRay},
        tolerance,
    },
    spatial::{
        Sweep, Visit,
        simd::{LANES, Simd, Task, dispatch},
        sweep::{grown, slack_reach},
    },
};

/// How many times longer a layer takes than a brick that is only held against the ray.
const LAYER_COST: f64 = 6.0;

/// How many bricks are sorted along a ray at once.
const SORTED: usize = 64;

impl<K: Copy> UniformGrid<K> {
    /// Visits the keys of the boxes that a ray enters, and tells `watch` the way.
    pub(super) fn walk_ray(&self, ray: &Ray, watch: impl Watch<K>, mut visit: impl FnMut(K, f32) -> Visit) {
        self.walk(ray, None, watch, |key, _, _, t, limit| {
            (t <= limit).then(|| visit(key, t))
        });
    }

    pub(super) fn walk_sweep(&self, sweep: &impl Sweep, mut visit: impl FnMut(K, f32) -> Visit) {
        self.walk(
            sweep.ray(),
            Some(slack_reach(sweep)),
            (),
            |key, boxes, lane, _, limit| {
                let t = sweep
                    .intersection_at(&boxes.get(lane))
                    .filter(|&t| t <= limit && t.is_finite())?;
                Some(visit(key, t))
            },
        );
    }

    /// Has `visit` decide on every key whose box, grown by `reach`, the ray enters before the limit: with the box and its
    /// lane, the parameter at which the ray enters it, and the limit.
    #[inline(always)]
    fn walk(
        &self,
        ray: &Ray,
        reach: Option<Vec3A>,
        watch: impl Watch<K>,
        visit: impl FnMut(K, &Boxes, usize, f32, f32) -> Option<Visit>,
    ) {
        // Stopped or not, the walk is over.
        let _: ControlFlow<()> = dispatch(Walk {
            grid: self,
            ray,
            slabs: ray.slab_ray(),
            reach,
            limit: ray.t_max(),
            watch,
            visit,
        });
    }
}

/// Who is told of the way of a walk. Nothing is compiled of it for `()`, which wants to know nothing.
pub(super) trait Watch<K> {
    /// Bricks of a level are held against the ray: those in a range of bricks, or all.
    fn look_at_bricks(&mut self, level: &Level, among: Option<CellRange>);

    /// The boxes of a bucket are held against the ray.
    fn look_into(&mut self, level: &Level, brick: &Brick, bucket: &Bucket<K>);

    /// A box of the bucket has been visited, which the ray enters at `at`.
    fn visited(&mut self, bucket: &Bucket<K>, lane: usize, at: f32, wish: Visit);
}

impl<K> Watch<K> for () {
    #[inline(always)]
    fn look_at_bricks(&mut self, _level: &Level, _among: Option<CellRange>) {}

    #[inline(always)]
    fn look_into(&mut self, _level: &Level, _brick: &Brick, _bucket: &Bucket<K>) {}

    #[inline(always)]
    fn visited(&mut self, _bucket: &Bucket<K>, _lane: usize, _at: f32, _wish: Visit) {}
}

struct Walk<'a, K, W, V> {
    grid: &'a UniformGrid<K>,
    ray: &'a Ray,
    slabs: SlabRay,
    /// Of the moving shape; none of a ray.
    reach: Option<Vec3A>,
    limit: f32,
    watch: W,
    visit: V,
}

impl<K, W, V> Task for Walk<'_, K, W, V>
where
    K: Copy,
    W: Watch<K>,
    V: FnMut(K, &Boxes, usize, f32, f32) -> Option<Visit>,
{
    type Output = ControlFlow<()>;

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) -> ControlFlow<()> {
        for level in self.grid.occupied_levels() {
            if let Some(layers) = Layers::new(self.ray, self.reach, level) {
                self.walk_level(simd, level, &layers)?;
            }
        }
        ControlFlow::Continue(())
    }
}

impl<K, W, V> Walk<'_, K, W, V>
where
    K: Copy,
    W: Watch<K>,
    V: FnMut(K, &Boxes, usize, f32, f32) -> Option<Visit>,
{
    #[inline(always)]
    fn walk_level<S: Simd>(&mut self, simd: S, level: &Level, layers: &Layers) -> ControlFlow<()> {
        let all = layers.brick_layers();
        if layers.cost(all) > level.bricks.len() as f64 {
            return self.walk_bricks(simd, level, layers);
        }
        let mut met: SmallVec<[&Brick; 16]> = SmallVec::new();
        for at in 0..=all[1] - all[0] {
            let layer = layers.layer_along(all, at);
            let bricks = match layers.crossing(layer * BRICK_CELLS, BRICK_CELLS, self.limit) {
                Crossing::Cells(range) => range.bricks(),
                Crossing::Nothing => continue,
                Crossing::Beyond => break,
            };
            self.watch.look_at_bricks(level, Some(bricks));
            met.clear();
            for z in bricks.min.z..=bricks.max.z {
                for y in bricks.min.y..=bricks.max.y {
                    for x in bricks.min.x..=bricks.max.x {
                        let found = level.table.find(IVec3::new(x, y, z));
                        let found = found.map(|index| &level.bricks[index as usize]);
                        met.extend(found.filter(|brick| self.meets(brick)));
                    }
                }
            }
            self.walk_cells(simd, layers, layer, &met)?;
        }
        ControlFlow::Continue(())
    }

    /// Walks through bricks of one layer, by layers of cells.
    #[inline(always)]
    fn walk_cells<S: Simd>(&mut self, simd: S, layers: &Layers, layer: i32, bricks: &[&Brick]) -> ControlFlow<()> {
        if bricks.is_empty() {
            return ControlFlow::Continue(());
        }
        let first = layer * BRICK_CELLS;
        for at in 0..BRICK_CELLS {
            let layer = layers.layer_along([first, first + BRICK_CELLS - 1], at);
            let range = match layers.crossing(layer, 1, self.limit) {
                Crossing::Cells(range) => range,
                Crossing::Nothing => continue,
                Crossing::Beyond => break,
            };
            for brick in bricks {
                let cells = brick.occupied & range.bits_in(brick.coordinates);
                let grid = self.grid;
                for bucket in grid.buckets.in_cells(brick, cells) {
                    self.watch.look_into(layers.level, brick, bucket);
                    let (entries, met) = enter(simd, &self.slabs, &bucket.boxes, self.reach, self.limit);
                    self.decide(bucket, &entries, met & bucket.lanes())?;
                }
            }
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn decide(&mut self, bucket: &Bucket<K>, entries: &[f32; LANES], met: u32) -> ControlFlow<()> {
        for lane in bits(met.into()) {
            let lane = lane as usize;
            let wish = (self.visit)(bucket.keys[lane], &bucket.boxes, lane, entries[lane], self.limit);
            if let Some(wish) = wish {
                self.watch.visited(bucket, lane, entries[lane], wish);
            }
            match wish {
                None | Some(Visit::Continue) => {}
                Some(Visit::Shorten(to)) => self.limit = self.limit.min(to),
                Some(Visit::Stop) => return ControlFlow::Break(()),
            }
        }
        ControlFlow::Continue(())
    }

    /// Whether anything in the brick is met within the limit.
    #[inline(always)]
    fn meets(&self, brick: &Brick) -> bool {
        self.entry(brick).is_some()
    }

    #[inline(always)]
    fn entry(&self, brick: &Brick) -> Option<f32> {
        let entry = self
            .ray
            .aabb_intersection_at(&grown(&brick.bounds, self.reach.unwrap_or(Vec3A::ZERO)));
        entry.filter(|&t| t <= self.limit)
    }

    /// Holds the ray against all bricks, where those are fewer than what it crosses.
    #[inline(always)]
    fn walk_bricks<S: Simd>(&mut self, simd: S, level: &Level, layers: &Layers) -> ControlFlow<()> {
        self.watch.look_at_bricks(level, None);
        let mut sorted: SmallVec<[(f32, u32); SORTED]> = SmallVec::new();
        let mut rest = (0..).zip(&level.bricks).filter(|(_, brick)| brick.occupied != 0);
        loop {
            sorted.clear();
            while sorted.len() < SORTED {
                let Some((index, brick)) = rest.next() else {
                    break;
                };
                sorted.extend(self.entry(brick).map(|t| (t, index)));
            }
            if sorted.is_empty() {
                return ControlFlow::Continue(());
            }
            sorted.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
            for &(t, index) in &sorted {
                if t <= self.limit {
                    let brick = &level.bricks[index as usize];
                    self.walk_cells(simd, layers, brick.coordinates[layers.axis], &[brick])?;
                }
            }
        }
    }
}

/// The lanes whose boxes, grown by `reach`, the ray enters, and where: as [`Ray::aabb_intersection_at`] tells.
#[inline(always)]
fn enter<S: Simd>(simd: S, ray: &SlabRay, boxes: &Boxes, reach: Option<Vec3A>, limit: f32) -> ([f32; LANES], u32) {
    let (mut entries, mut exits) = (simd.splat(ray.t_min), simd.splat(ray.t_max));
    let grown = reach.map(|reach| (reach, slack(simd, boxes, reach)));
    for axis in 0..3 {
        let (origin, recip) = (simd.splat(ray.origin[axis]), simd.splat(ray.direction_recip[axis]));
        let (mut min, mut max) = (simd.load(&boxes.min[axis]), simd.load(&boxes.max[axis]));
        if let Some((reach, slack)) = grown {
            let reach = simd.add(simd.splat(reach[axis]), slack);
            (min, max) = (simd.sub(min, reach), simd.add(max, reach));
        }
        let (near, far) = if ray.forward[axis] { (min, max) } else { (max, min) };
        entries = simd.max(simd.mul(simd.sub(near, origin), recip), entries);
        exits = simd.min(simd.mul(simd.sub(far, origin), recip), exits);
    }
    // As `SlabRay::widen` has it.
    let entries = simd.max(
        simd.mul(entries, simd.splat(1.0 - tolerance::SLAB)),
        simd.splat(ray.t_min),
    );
    let exits = simd.mul(exits, simd.splat(1.0 + tolerance::SLAB));
    let met =
        simd.le(entries, exits) & simd.le(entries, simd.splat(limit)) & simd.lt(entries, simd.splat(f32::INFINITY));
    (simd.store(entries), met)
}

/// What counts as contact, as [`grown`] has it, lane by lane, and the rounding of growing by that.
#[inline(always)]
fn slack<S: Simd>(simd: S, boxes: &Boxes, reach: Vec3A) -> S::F32s {
    let zero = simd.splat(0.0);
    let mut largest = zero;
    for bounds in boxes.min.iter().chain(&boxes.max) {
        let bounds = simd.load(bounds);
        largest = simd.max(simd.max(bounds, simd.sub(zero, bounds)), largest);
    }
    let largest = simd.add(largest, simd.splat(reach.max_element()));
    simd.mul(largest, simd.splat(2.0 * tolerance::SWEEP_REACH))
}

/// The layers of a level that a ray crosses, across the axis that it is most parallel to.
///
/// In double precision, with slack for the rounding of the slab test, which has the last word.
struct Layers<'a> {
    level: &'a Level,
    origin: DVec3,
    direction: DVec3,
    /// How far boxes reach from their centres, and the moving shape from its own.
    reach: DVec3,
    axis: usize,
    /// The parameters between which the ray may meet anything in the level.
    interval: [f64; 2],
}

/// What a ray crosses of a layer.
enum Crossing {
    Cells(CellRange),
    Nothing,
    /// The layer is beyond the limit, as are all that come after it.
    Beyond,
}

/// What the slab test has as slack, and its rounding, as a fraction of the way from the start of the ray.
const SLACK: f64 = 2.0 * tolerance::SLAB as f64;

/// How far off the place is where one cell ends and the next begins, as a fraction of the coordinate.
const CELL_SLACK: f64 = 2.0 * f32::EPSILON as f64;

impl<'a> Layers<'a> {
    /// `None` if the ray misses the level.
    #[inline(always)]
    fn new(ray: &Ray, reach: Option<Vec3A>, level: &'a Level) -> Option<Self> {
        let axis = ray.direction().abs().to_array();
        let axis = (0..3).fold(0, |a, b| if axis[b] > axis[a] { b } else { a });
        let (mut bounds, mut boxes_reach) = (level.bounds, level.reach.as_dvec3());
        if let Some(reach) = reach {
            bounds = grown(&bounds, reach);
            // No box in the level is grown by more.
            let largest = bounds.min.abs().max(bounds.max.abs()).max_element();
            boxes_reach += reach.as_dvec3() + f64::from(largest) * f64::from(2.0 * tolerance::SWEEP_REACH);
        }
        ray.aabb_intersection_at(&bounds)?;
        let mut layers = Self {
            level,
            origin: ray.origin().as_dvec3(),
            direction: ray.direction().as_dvec3(),
            reach: boxes_reach,
            axis,
            interval: [ray.t_min().into(), ray.t_max().into()],
        };
        let [min, max] = [bounds.min.as_dvec3(), bounds.max.as_dvec3()];
        layers.interval = layers.between(min[axis], max[axis])?;
        Some(layers)
    }

    /// The parameters at which the ray may be between two places along the axis.
    #[inline(always)]
    fn between(&self, min: f64, max: f64) -> Option<[f64; 2]> {
        let (origin, direction) = (self.origin[self.axis], self.direction[self.axis]);
        let (a, b) = ((min - origin) / direction, (max - origin) / direction);
        let (near, far) = (a.min(b), a.max(b));
        // Parameters that underflow are off by less than the least normal number of single precision.
        let underflow = f64::from(f32::MIN_POSITIVE);
        let near = (near - near.abs() * SLACK).max(self.interval[0] * (1.0 - SLACK)) - underflow;
        let far = (far + far.abs() * SLACK).min(self.interval[1] * (1.0 + SLACK)) + underflow;
        (near <= far).then_some([near, far])
    }

    /// Where the ray may be along an axis between two parameters.
    #[inline(always)]
    fn span(&self, axis: usize, [near, far]: [f64; 2]) -> [f64; 2] {
        let direction = self.direction[axis];
        if direction == 0.0 {
            return [self.origin[axis]; 2];
        }
        let way = [near * direction, far * direction];
        let (least, most) = (way[0].min(way[1]), way[0].max(way[1]));
        [
            self.origin[axis] + (least - least.abs() * SLACK),
            self.origin[axis] + (most + most.abs() * SLACK),
        ]
    }

    /// The coordinates of the cells, along an axis, from which boxes may reach to the ray.
    #[inline(always)]
    fn cells(&self, axis: usize, interval: [f64; 2]) -> [i32; 2] {
        let [min, max] = self.span(axis, interval);
        let (lattice, all) = (&self.level.lattice, &self.level.cells);
        [
            lattice.coordinate_at(min - self.reach[axis]).max(all.min[axis]),
            lattice.coordinate_at(max + self.reach[axis]).min(all.max[axis]),
        ]
    }

    /// The first and the last layer of bricks.
    #[inline(always)]
    fn brick_layers(&self) -> [i32; 2] {
        self.cells(self.axis, self.interval)
            .map(|cell| cell.div_euclid(BRICK_CELLS))
    }

    /// The layer that is the `at`th along the ray, of those from the first to the last.
    #[inline(always)]
    fn layer_along(&self, [first, last]: [i32; 2], at: i32) -> i32 {
        if self.direction[self.axis] > 0.0 {
            first + at
        } else {
            last - at
        }
    }

    /// About how many bricks could be held against the ray in the time that a walk through these layers takes.
    #[inline(always)]
    fn cost(&self, [first, last]: [i32; 2]) -> f64 {
        let brick = f64::from(self.level.lattice.cell * BRICK_CELLS as f32);
        let across = (2.0 * self.reach / brick + 1.0).element_product();
        LAYER_COST * f64::from(last - first + 1) * across
    }

    /// The cells in `thickness` layers from which boxes may reach to the ray within the limit.
    #[inline(always)]
    fn crossing(&self, first: i32, thickness: i32, limit: f32) -> Crossing {
        let (axis, cell) = (self.axis, f64::from(self.level.lattice.cell));
        let last = first + thickness - 1;
        let slack = (f64::from(first.abs().max(last.abs())) + 1.0) * cell * CELL_SLACK + self.reach[axis];
        let (min, max) = (f64::from(first) * cell - slack, f64::from(last + 1) * cell + slack);
        let Some(interval) = self.between(min, max) else {
            return Crossing::Nothing;
        };
        if interval[0] > f64::from(limit) * (1.0 + SLACK) {
            return Crossing::Beyond;
        }
        let [mut least, mut most] = [IVec3::ZERO; 2];
        for other in 0..3 {
            [least[other], most[other]] = if other == axis {
                [first, last]
            } else {
                self.cells(other, interval)
            };
        }
        let range = CellRange { min: least, max: most };
        if range.is_empty() {
            Crossing::Nothing
        } else {
            Crossing::Cells(range)
        }
    }
}
