//! Rays against the hierarchy.

use std::ops::Deref;

use super::{MeshBvh, group_of, lanes_of, unpack_slots};
use crate::{
    geometry::ray::{
        Ray,
        triangle::{Backfaces, TriangleRay},
    },
    mesh::{
        packet::TrianglePacket,
        triangles::{Indexed, Storage, TriangleHit},
    },
    spatial::{
        Trace, Visit,
        lanes::Entering,
        simd::{LANES, Simd, prefetch},
        trace::trace_in_order,
        traverse::{VisitLeaf, visit_any, visit_in_order},
        wide::EVERY_MASK,
    },
};

impl MeshBvh {
    /// The nearest hit. Of triangles at one parameter the one with the smallest number wins.
    pub fn closest_hit(&self, ray: &Ray, backfaces: Backfaces) -> Option<TriangleHit> {
        match self.mesh.storage() {
            Storage::Packed(packets) => self.closest_of(&packets[..], ray, backfaces),
            Storage::Indexed(indexed) => self.closest_of(&Gathered(indexed, self.mesh.vertices()), ray, backfaces),
        }
    }

    /// The [`closest_hit`](Self::closest_hit), and the way to it. The key of a leaf is the numbers of its triangles, which
    /// are tested when it is visited. Slow: for those who want to look inside.
    pub fn trace_closest_hit(&self, ray: &Ray, backfaces: Backfaces) -> (Option<TriangleHit>, Trace<Vec<u32>>) {
        match self.mesh.storage() {
            Storage::Packed(packets) => self.trace_closest_of(&packets[..], ray, backfaces),
            Storage::Indexed(indexed) => {
                self.trace_closest_of(&Gathered(indexed, self.mesh.vertices()), ray, backfaces)
            }
        }
    }

    /// Whether there is any hit: stops at the first.
    pub fn any_hit(&self, ray: &Ray, backfaces: Backfaces) -> bool {
        match self.mesh.storage() {
            Storage::Packed(packets) => self.any_of(&packets[..], ray, backfaces),
            Storage::Indexed(indexed) => self.any_of(&Gathered(indexed, self.mesh.vertices()), ray, backfaces),
        }
    }

    #[inline]
    fn closest_of(&self, groups: &(impl Groups + ?Sized), ray: &Ray, backfaces: Backfaces) -> Option<TriangleHit> {
        let mut nearest = Nearest::none(ray);
        let visit = Closest {
            groups,
            ray: &TriangleRay::new(ray),
            backfaces,
            nearest: &mut nearest,
        };
        visit_in_order(&self.nodes, 0, EVERY_MASK, ray.t_max(), Entering::new(ray), visit);
        nearest.hit
    }

    fn trace_closest_of(
        &self,
        groups: &(impl Groups + ?Sized),
        ray: &Ray,
        backfaces: Backfaces,
    ) -> (Option<TriangleHit>, Trace<Vec<u32>>) {
        let mut nearest = Nearest::none(ray);
        let visit = Closest {
            groups,
            ray: &TriangleRay::new(ray),
            backfaces,
            nearest: &mut nearest,
        };
        let triangles = |leaf| unpack_slots(leaf).map(|slot| self.mesh.number(slot)).collect();
        let trace = trace_in_order(&self.nodes, 0, EVERY_MASK, ray, triangles, visit);
        (nearest.hit, trace)
    }

    #[inline]
    fn any_of(&self, groups: &(impl Groups + ?Sized), ray: &Ray, backfaces: Backfaces) -> bool {
        let mut found = false;
        let visit = Any {
            groups,
            ray: &TriangleRay::new(ray),
            backfaces,
            t_max: ray.t_max(),
            found: &mut found,
        };
        visit_any(&self.nodes, 0, EVERY_MASK, ray.t_max(), Entering::new(ray), visit);
        found
    }
}

/// Groups of triangles, as rays test them.
pub(super) trait Groups {
    /// What is handed out.
    type Packet<'a>: Deref<Target = TrianglePacket>
    where
        Self: 'a;

    fn get(&self, group: usize) -> Self::Packet<'_>;

    /// Asks for a group to be brought close.
    fn prefetch(&self, group: usize);
}

impl Groups for [TrianglePacket] {
    type Packet<'a> = &'a TrianglePacket;

    #[inline(always)]
    fn get(&self, group: usize) -> &TrianglePacket {
        &self[group]
    }

    #[inline(always)]
    fn prefetch(&self, group: usize) {
        prefetch(&self[group]);
    }
}

/// Triangles that are gathered from their vertices.
pub(super) struct Gathered<'a>(pub &'a Indexed, pub &'a [[u32; 3]]);

/// A packet of its own.
pub(super) struct Own(TrianglePacket);

impl Deref for Own {
    type Target = TrianglePacket;

    #[inline(always)]
    fn deref(&self) -> &TrianglePacket {
        &self.0
    }
}

impl Groups for Gathered<'_> {
    type Packet<'a>
        = Own
    where
        Self: 'a;

    #[inline(always)]
    fn get(&self, group: usize) -> Own {
        Own(self.0.gather(group, self.1))
    }

    #[inline(always)]
    fn prefetch(&self, group: usize) {
        prefetch(&self.0.groups[group]);
    }
}

/// Looks for the nearest hit.
pub(super) struct Closest<'a, G: ?Sized> {
    pub groups: &'a G,
    pub ray: &'a TriangleRay,
    pub backfaces: Backfaces,
    pub nearest: &'a mut Nearest,
}

/// The nearest hit so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearest {
    /// Where it is taken to be, or the end of the ray.
    pub limit: f32,
    pub hit: Option<TriangleHit>,
}

impl Nearest {
    pub fn none(ray: &Ray) -> Self {
        Self {
            limit: ray.t_max(),
            hit: None,
        }
    }

    /// Tests the triangles of a leaf, whose box the ray enters at `at`, which is no more than the limit.
    ///
    /// Rounding may put a hit before the box that it is in. It is then taken to be where the ray enters that, so that
    /// which hit is the nearest does not depend on the order in which leaves are visited: none that is nearer can have
    /// been passed over.
    #[inline(always)]
    pub fn test<S: Simd>(
        &mut self,
        simd: S,
        packet: &TrianglePacket,
        leaf: u32,
        at: f32,
        ray: &TriangleRay,
        backfaces: Backfaces,
    ) {
        debug_assert!(at <= self.limit);
        let mut lanes = packet.candidates(simd, ray, backfaces) & lanes_of(leaf);
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize % LANES;
            lanes &= lanes - 1;
            if let Some(hit) = packet.intersection(lane, ray, self.limit, backfaces) {
                let (met_at, triangle) = (if hit.t < at { at } else { hit.t }, packet.number(lane));
                if met_at < self.limit || self.hit.is_none_or(|nearest| triangle < nearest.triangle) {
                    self.limit = met_at;
                    self.hit = Some(TriangleHit {
                        t: hit.t,
                        triangle,
                        barycentrics: hit.barycentrics,
                        slot: (group_of(leaf) * LANES + lane) as u32,
                    });
                }
            }
        }
    }
}

impl<G: Groups + ?Sized> VisitLeaf for Closest<'_, G> {
    const WAITS: bool = true;

    #[inline(always)]
    fn visit<S: Simd>(&mut self, simd: S, leaf: u32, at: f32) -> Visit {
        let before = self.nearest.limit;
        let packet = self.groups.get(group_of(leaf));
        self.nearest.test(simd, &packet, leaf, at, self.ray, self.backfaces);
        if self.nearest.limit < before {
            Visit::Shorten(self.nearest.limit)
        } else {
            Visit::Continue
        }
    }

    #[inline(always)]
    fn prefetch(&self, leaf: u32) {
        self.groups.prefetch(group_of(leaf));
    }
}

/// Looks for any hit.
pub(super) struct Any<'a, G: ?Sized> {
    pub groups: &'a G,
    pub ray: &'a TriangleRay,
    pub backfaces: Backfaces,
    pub t_max: f32,
    pub found: &'a mut bool,
}

/// Whether a ray hits any triangle of a leaf.
#[inline(always)]
pub(super) fn is_hit<S: Simd>(
    simd: S,
    packet: &TrianglePacket,
    leaf: u32,
    ray: &TriangleRay,
    t_max: f32,
    backfaces: Backfaces,
) -> bool {
    let mut lanes = packet.candidates(simd, ray, backfaces) & lanes_of(leaf);
    while lanes != 0 {
        let lane = lanes.trailing_zeros() as usize % LANES;
        lanes &= lanes - 1;
        if packet.intersection(lane, ray, t_max, backfaces).is_some() {
            return true;
        }
    }
    false
}

impl<G: Groups + ?Sized> VisitLeaf for Any<'_, G> {
    const WAITS: bool = true;

    #[inline(always)]
    fn visit<S: Simd>(&mut self, simd: S, leaf: u32, _at: f32) -> Visit {
        let packet = self.groups.get(group_of(leaf));
        if is_hit(simd, &packet, leaf, self.ray, self.t_max, self.backfaces) {
            *self.found = true;
            return Visit::Stop;
        }
        Visit::Continue
    }

    #[inline(always)]
    fn prefetch(&self, leaf: u32) {
        self.groups.prefetch(group_of(leaf));
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::Vec3A;

    use super::*;
    use crate::{mesh::bvh::pack_leaf, spatial::simd::Portable};

    /// The number of the nearest of triangles at some depths, which are numbered in turn and whose boxes are entered where
    /// it says, visited in some order.
    fn nearest(triangles: &[(f32, f32)], order: impl Iterator<Item = usize>) -> Option<u32> {
        let ray = Ray::new(Vec3A::ZERO, Vec3A::Z, f32::INFINITY).expect("a ray");
        let mut nearest = Nearest::none(&ray);
        for number in order {
            let (depth, at) = triangles[number];
            if at <= nearest.limit {
                let corners = [Vec3A::NEG_X - Vec3A::Y, Vec3A::X - Vec3A::Y, Vec3A::Y];
                let corners = corners.map(|corner| corner + Vec3A::Z * depth);
                let packet = TrianglePacket::new([(corners, number as u32)].into_iter());
                let ray = &TriangleRay::new(&ray);
                nearest.test(Portable, &packet, pack_leaf(0, 1), at, ray, Backfaces::Include);
            }
        }
        nearest.hit.map(|hit| hit.triangle)
    }

    #[test]
    fn which_hit_is_the_nearest_does_not_depend_on_the_order_of_leaves() {
        for triangles in [
            // All inside of their boxes, two at one depth.
            [(3.0, 2.5), (2.0, 1.0), (2.0, 2.0)],
            // One before its box, which is entered behind the others, or among them.
            [(1.0, 5.0), (3.0, 3.0), (4.0, 3.5)],
            [(1.0, 3.5), (3.0, 3.0), (4.0, 2.0)],
            [(1.0, 3.0), (3.0, 3.0), (4.0, 2.0)],
        ] {
            let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
            let found = orders.map(|order| nearest(&triangles, order.into_iter()));
            assert!(
                found.iter().all(|&number| number == found[0]),
                "{triangles:?}: {found:?}"
            );
            assert!(found[0].is_some());
        }
    }
}
