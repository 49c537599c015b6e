//! Rays against the hierarchy.

use super::{MeshBvh, lanes_of, packet_of};
use crate::{
    geometry::ray::{
        Ray,
        triangle::{Backfaces, TriangleRay},
    },
    mesh::{
        packet::TrianglePacket,
        triangles::{TriangleHit, nearer},
    },
    spatial::{
        Visit,
        lanes::Entering,
        simd::{LANES, Simd, prefetch},
        traverse::{VisitLeaf, visit_any, visit_in_order},
        wide::EVERY_MASK,
    },
};

impl MeshBvh {
    /// The nearest hit. Of triangles at one parameter the one with the smallest number wins.
    pub fn closest_hit(&self, ray: &Ray, backfaces: Backfaces) -> Option<TriangleHit> {
        let mut hit = None;
        let visit = Closest {
            packets: self.mesh.packets(),
            ray: &TriangleRay::new(ray),
            backfaces,
            t_max: ray.t_max(),
            hit: &mut hit,
        };
        visit_in_order(&self.nodes, 0, EVERY_MASK, ray.t_max(), &Entering::new(ray), visit);
        hit
    }

    /// Whether there is any hit: stops at the first.
    pub fn any_hit(&self, ray: &Ray, backfaces: Backfaces) -> bool {
        let mut found = false;
        let visit = Any {
            packets: self.mesh.packets(),
            ray: &TriangleRay::new(ray),
            backfaces,
            t_max: ray.t_max(),
            found: &mut found,
        };
        visit_any(&self.nodes, 0, EVERY_MASK, ray.t_max(), &Entering::new(ray), visit);
        found
    }
}

/// Looks for the nearest hit.
struct Closest<'a> {
    packets: &'a [TrianglePacket],
    ray: &'a TriangleRay,
    backfaces: Backfaces,
    /// The parameter of the hit, or the end of the ray.
    t_max: f32,
    hit: &'a mut Option<TriangleHit>,
}

impl VisitLeaf for Closest<'_> {
    const WAITS: bool = true;

    #[inline(always)]
    fn visit<S: Simd>(&mut self, simd: S, leaf: u32, _at: f32) -> Visit {
        let packet = &self.packets[packet_of(leaf)];
        let mut lanes = packet.candidates(simd, self.ray, self.backfaces) & lanes_of(leaf);
        let before = self.t_max;
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize % LANES;
            lanes &= lanes - 1;
            if let Some(hit) = packet.intersection(lane, self.ray, self.t_max, self.backfaces) {
                let hit = TriangleHit {
                    t: hit.t,
                    triangle: packet.number(lane),
                    barycentrics: hit.barycentrics,
                    slot: (packet_of(leaf) * LANES + lane) as u32,
                };
                *self.hit = nearer(*self.hit, hit);
                self.t_max = hit.t;
            }
        }
        if self.t_max < before {
            Visit::Shorten(self.t_max)
        } else {
            Visit::Continue
        }
    }

    #[inline(always)]
    fn prefetch(&self, leaf: u32) {
        prefetch(&self.packets[packet_of(leaf)]);
    }
}

/// Looks for any hit.
struct Any<'a> {
    packets: &'a [TrianglePacket],
    ray: &'a TriangleRay,
    backfaces: Backfaces,
    t_max: f32,
    found: &'a mut bool,
}

impl VisitLeaf for Any<'_> {
    const WAITS: bool = true;

    #[inline(always)]
    fn visit<S: Simd>(&mut self, simd: S, leaf: u32, _at: f32) -> Visit {
        let packet = &self.packets[packet_of(leaf)];
        let mut lanes = packet.candidates(simd, self.ray, self.backfaces) & lanes_of(leaf);
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize % LANES;
            lanes &= lanes - 1;
            if packet
                .intersection(lane, self.ray, self.t_max, self.backfaces)
                .is_some()
            {
                *self.found = true;
                return Visit::Stop;
            }
        }
        Visit::Continue
    }

    #[inline(always)]
    fn prefetch(&self, leaf: u32) {
        prefetch(&self.packets[packet_of(leaf)]);
    }
}
