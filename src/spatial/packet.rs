//! Rays that go down a hierarchy together.
//!
//! A node is visited once for all rays of a packet: one test of its eight children bounds where any of the rays may meet
//! them, by intervals of origins and directions (Reshetov, Soupikov and Hurley, *Multi-Level Ray Tracing Algorithm*,
//! 2005), and then one test of the box for each eight rays tells which do (Wald, Slusallek, Benthin and Wagner,
//! *Interactive Rendering with Coherent Ray Tracing*, 2001). Where but few are left of a packet, each of them goes on by
//! itself, and if the rays soon go different ways, all of them do. What a ray is told of a leaf is exactly what it would be told alone.

use std::mem::swap;

use super::{
    lanes::Boxes,
    simd::{LANES, Simd, Task, dispatch, prefetch},
    traverse::{WaitingStack, sort_far_to_near},
    wide::{Child, NodeIndex, WideNode},
};
use crate::geometry::{ray::Ray, tolerance};

/// So many times eight rays are a packet.
const OCTETS: usize = 2;

/// The most rays of a packet.
pub(crate) const RAYS: usize = OCTETS * LANES;

/// A value for each ray of a packet.
pub(crate) type PerRay<T> = [[T; LANES]; OCTETS];

/// After so many visits it is decided whether to go on together: if half of the rays met what was visited, on average.
const TRIAL: u32 = 4;

/// When so few rays of a packet meet a node, each goes on by itself.
const FEW: u32 = 1;

/// The limit of a ray that meets nothing any more, or is not there.
pub(crate) const NO_RAY: f32 = -1.0;

/// What is done with what a packet comes to.
pub(crate) trait VisitRays {
    /// Visits a leaf that rays meet, bit by bit, each where `at` says. May lower the limits of these rays.
    fn visit<S: Simd>(&mut self, simd: S, leaf: u32, rays: u32, at: &PerRay<f32>, limits: &mut PerRay<f32>);

    /// Visits everything below a node with one ray, also what it has visited before.
    fn visit_below<S: Simd>(&mut self, simd: S, node: NodeIndex, ray: usize, limit: &mut f32);

    /// Brings close what a visit will read.
    fn prefetch(&self, leaf: u32);
}

/// Whether rays run in the same direction along each axis, so that they may be taken [together](visit_together); not if
/// there are but few.
#[inline]
pub(crate) fn go_together(rays: &[Ray]) -> bool {
    rays.len() > FEW as usize && rays.windows(2).all(|pair| pair[0].backward() == pair[1].backward())
}

/// Up to [`RAYS`] rays that [go together](go_together), eight by eight.
struct Packet<S: Simd> {
    origin: [[S::F32s; 3]; OCTETS],
    direction_recip: [[S::F32s; 3]; OCTETS],
    t_min: [S::F32s; OCTETS],
    beam: Beam,
}

impl<S: Simd> Packet<S> {
    /// The rays, at least one, and where each of them ends.
    #[inline(always)]
    fn new(simd: S, rays: &[Ray]) -> (Self, PerRay<f32>) {
        let zero = simd.splat(0.0);
        let mut packet = Self {
            origin: [[zero; 3]; OCTETS],
            direction_recip: [[zero; 3]; OCTETS],
            t_min: [zero; OCTETS],
            beam: Beam::new(rays),
        };
        let mut limits = [[NO_RAY; LANES]; OCTETS];
        for (octet, limits) in limits.iter_mut().enumerate() {
            let (mut origins, mut directions) = ([[0.0; 4]; LANES], [[0.0; 4]; LANES]);
            for lane in 0..LANES {
                let index = octet * LANES + lane;
                // The last lanes repeat the first ray.
                let (ray, limit) = match rays.get(index) {
                    Some(ray) => (ray, ray.t_max()),
                    None => (&rays[0], NO_RAY),
                };
                origins[lane] = ray.origin().extend(ray.t_min()).to_array();
                directions[lane] = ray.direction_recip().extend(limit).to_array();
            }
            let [x, y, z, t_min] = simd.transpose(origins.each_ref());
            packet.origin[octet] = [x, y, z];
            // Not -0.0: parameters are compared by their bits.
            packet.t_min[octet] = simd.add(t_min, zero);
            let [x, y, z, limit] = simd.transpose(directions.each_ref());
            packet.direction_recip[octet] = [x, y, z];
            *limits = simd.store(limit);
        }
        (packet, limits)
    }

    /// The rays that meet the box of a lane up to their limits, bit by bit, and where each of them does.
    #[inline(always)]
    fn meeting(&self, simd: S, node: &WideNode, lane: usize, limits: &PerRay<f32>) -> (u32, PerRay<f32>) {
        let (mut near, mut far) = ([0.0; 3], [0.0; 3]);
        for axis in 0..3 {
            let (min, max) = (node.min[axis][lane], node.max[axis][lane]);
            (near[axis], far[axis]) = if self.beam.is_backward(axis) {
                (max, min)
            } else {
                (min, max)
            };
        }
        let faces = Faces { near, far };
        let (mut rays, mut met_at) = (0, [[0.0; LANES]; OCTETS]);
        for octet in 0..OCTETS {
            let (met, at) = self.meets(simd, octet, &faces, simd.load(&limits[octet]));
            rays |= met << (octet * LANES);
            met_at[octet] = simd.store(at);
        }
        (rays, met_at)
    }

    /// The rays of an octet that meet a box up to their limits, and where, as [`Entering`](super::lanes::Entering) tells.
    #[inline(always)]
    fn meets(&self, simd: S, octet: usize, faces: &Faces, limit: S::F32s) -> (u32, S::F32s) {
        let t_min = self.t_min[octet];
        let (mut enter, mut leave) = (t_min, limit);
        for axis in 0..3 {
            let (origin, recip) = (self.origin[octet][axis], self.direction_recip[octet][axis]);
            let (near, far) = (simd.splat(faces.near[axis]), simd.splat(faces.far[axis]));
            enter = simd.max(simd.mul(simd.sub(near, origin), recip), enter);
            leave = simd.min(simd.mul(simd.sub(far, origin), recip), leave);
        }
        enter = simd.max(simd.mul(enter, simd.splat(1.0 - tolerance::SLAB)), t_min);
        leave = simd.mul(leave, simd.splat(1.0 + tolerance::SLAB));
        let within = simd.le(enter, simd.min(limit, simd.splat(f32::MAX)));
        (simd.le(enter, leave) & within, enter)
    }
}

/// The faces of a box through which a ray enters and leaves.
struct Faces {
    near: [f32; 3],
    far: [f32; 3],
}

/// What contains all rays of a packet.
///
/// Bounds are computed as for one ray, from the coordinates that make them the least or the greatest. Rounding is
/// monotonic, so that no ray meets a box before the bound, or one that the beam does not meet.
struct Beam {
    /// The axes along which all rays enter through the maximum, bit by bit.
    backward: u32,
    /// Of the origins, the coordinates that are nearest to what lies ahead, and those that are farthest.
    nearest_origin: [f32; 3],
    farthest_origin: [f32; 3],
    /// The reciprocals of the directions that are nearest to zero and farthest from it, which may be infinite.
    least_recip: [f32; 3],
    greatest_recip: [f32; 3],
    t_min: f32,
}

impl Beam {
    /// Around rays that go together, at least one.
    #[inline(always)]
    fn new(rays: &[Ray]) -> Self {
        let (mut low, mut high) = (rays[0].origin(), rays[0].origin());
        let (mut least, mut greatest) = (rays[0].direction_recip(), rays[0].direction_recip());
        let mut t_min = rays[0].t_min();
        for ray in &rays[1..] {
            (low, high) = (low.min(ray.origin()), high.max(ray.origin()));
            let recip = ray.direction_recip();
            (least, greatest) = (least.min(recip), greatest.max(recip));
            t_min = t_min.min(ray.t_min());
        }
        let mut beam = Self {
            backward: rays[0].backward(),
            nearest_origin: high.to_array(),
            farthest_origin: low.to_array(),
            least_recip: least.to_array(),
            greatest_recip: greatest.to_array(),
            t_min: t_min + 0.0,
        };
        for axis in 0..3 {
            if beam.is_backward(axis) {
                swap(&mut beam.nearest_origin[axis], &mut beam.farthest_origin[axis]);
                swap(&mut beam.least_recip[axis], &mut beam.greatest_recip[axis]);
            }
        }
        beam
    }

    #[inline(always)]
    fn is_backward(&self, axis: usize) -> bool {
        self.backward >> axis & 1 != 0
    }

    /// The lanes whose boxes any of the rays may meet up to `limit`, and no more than where the first does.
    #[inline(always)]
    fn meets<S: Simd>(&self, simd: S, boxes: Boxes, limit: f32) -> (u32, S::F32s) {
        let t_min = simd.splat(self.t_min);
        let (mut enter, mut leave) = (t_min, simd.splat(limit));
        for axis in 0..3 {
            let (min, max) = (&boxes.min[axis], &boxes.max[axis]);
            let (near, far) = if self.is_backward(axis) { (max, min) } else { (min, max) };
            let near = simd.sub(simd.load(near), simd.splat(self.nearest_origin[axis]));
            let far = simd.sub(simd.load(far), simd.splat(self.farthest_origin[axis]));
            let (least, greatest) = (
                simd.splat(self.least_recip[axis]),
                simd.splat(self.greatest_recip[axis]),
            );
            // Where a ray runs in the plane of the face and parallel to it, its product is NaN, which bounds nothing: it
            // comes second, so that neither do both.
            enter = simd.max(simd.min(simd.mul(near, least), simd.mul(near, greatest)), enter);
            leave = simd.min(simd.max(simd.mul(far, least), simd.mul(far, greatest)), leave);
        }
        enter = simd.max(simd.mul(enter, simd.splat(1.0 - tolerance::SLAB)), t_min);
        leave = simd.mul(leave, simd.splat(1.0 + tolerance::SLAB));
        let reached = simd.le(enter, leave) & simd.le(enter, simd.splat(limit.min(f32::MAX)));
        (reached, enter)
    }
}

/// Visits the leaves that rays which [go together](go_together) meet, near ones first as far as the rays agree on that.
/// There may be up to [`RAYS`].
#[inline]
pub(crate) fn visit_together(nodes: &[WideNode], rays: &[Ray], visit: impl VisitRays) {
    debug_assert!(rays.len() <= RAYS && go_together(rays));
    dispatch(Together { nodes, rays, visit });
}

struct Together<'a, V> {
    nodes: &'a [WideNode],
    rays: &'a [Ray],
    visit: V,
}

impl<V: VisitRays> Task for Together<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let nodes = self.nodes;
        let (packet, mut limits) = Packet::new(simd, self.rays);
        let mut farthest = greatest(simd, &limits);
        let mut stack = WaitingStack::new();
        let (mut node, mut visits, mut met_together) = (0, 0, 0);
        loop {
            self.wait_below(simd, node, &packet, farthest, &mut stack);
            loop {
                let Some(waiting) = stack.pop() else { return };
                let (at, place) = (f32::from_bits((waiting >> 32) as u32), waiting as u32);
                if at > farthest {
                    continue;
                }
                let (parent, lane) = (&nodes[(place >> 3) as usize], place as usize % LANES);
                let (rays, met_at) = packet.meeting(simd, parent, lane, &limits);
                if visits < TRIAL {
                    visits += 1;
                    met_together += rays.count_ones();
                    if visits == TRIAL && 2 * met_together < TRIAL * self.rays.len() as u32 {
                        let all = u32::MAX >> (u32::BITS - self.rays.len() as u32);
                        return self.go_alone(simd, 0, all, &mut limits);
                    }
                }
                match parent.child(lane) {
                    _ if rays == 0 => continue,
                    Child::Leaf(leaf) => self.visit.visit(simd, leaf, rays, &met_at, &mut limits),
                    Child::Node(child) if rays.count_ones() <= FEW => self.go_alone(simd, child, rays, &mut limits),
                    Child::Node(child) => {
                        node = child;
                        break;
                    }
                }
                farthest = greatest(simd, &limits);
            }
        }
    }
}

impl<V: VisitRays> Together<'_, V> {
    /// Has the children of a node that any of the rays may meet wait, the nearest last.
    #[inline(always)]
    fn wait_below<S: Simd>(
        &self,
        simd: S,
        node: NodeIndex,
        packet: &Packet<S>,
        farthest: f32,
        stack: &mut WaitingStack,
    ) {
        let parent = &self.nodes[node as usize];
        let (mut met, met_at) = packet.beam.meets(simd, parent.into(), farthest);
        let met_at = simd.store(met_at);
        let first = stack.reserve(LANES);
        while met != 0 {
            let lane = met.trailing_zeros() as usize % LANES;
            met &= met - 1;
            // A child waits by its place in the node, where its box is too.
            let place = node << 3 | lane as u32;
            stack.push(u64::from(met_at[lane].to_bits()) << 32 | u64::from(place));
            match parent.child(lane) {
                Child::Node(child) => prefetch(&self.nodes[child as usize]),
                Child::Leaf(leaf) => self.visit.prefetch(leaf),
            }
        }
        sort_far_to_near(stack.since(first));
    }

    /// Sends rays on below a node, one after the other.
    #[inline(always)]
    fn go_alone<S: Simd>(&mut self, simd: S, node: NodeIndex, mut rays: u32, limits: &mut PerRay<f32>) {
        while rays != 0 {
            let ray = rays.trailing_zeros() as usize % RAYS;
            rays &= rays - 1;
            self.visit
                .visit_below(simd, node, ray, &mut limits[ray / LANES][ray % LANES]);
        }
    }
}

/// The greatest of all.
#[inline(always)]
fn greatest<S: Simd>(simd: S, values: &PerRay<f32>) -> f32 {
    let mut greatest = simd.load(&values[0]);
    for octet in &values[1..] {
        greatest = simd.max(greatest, simd.load(octet));
    }
    -simd.min_lane(simd.sub(simd.splat(0.0), greatest))
}

#[cfg(test)]
mod tests;
