//! Rays against the hierarchy.

use std::ops::Deref;

use super::{MeshBvh, group_of, lanes_of};
use crate::{
    geometry::ray::{
        Ray,
        triangle::{Backfaces, TriangleRay},
    },
    mesh::{
        packet::TrianglePacket,
        triangles::{Indexed, Storage, TriangleHit, nearer},
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
        match self.mesh.storage() {
            Storage::Packed(packets) => self.closest_of(&packets[..], ray, backfaces),
            Storage::Indexed(indexed) => self.closest_of(&Gathered(indexed, self.mesh.vertices()), ray, backfaces),
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
        let mut hit = None;
        let visit = Closest {
            groups,
            ray: &TriangleRay::new(ray),
            backfaces,
            t_max: ray.t_max(),
            hit: &mut hit,
        };
        visit_in_order(&self.nodes, 0, EVERY_MASK, ray.t_max(), Entering::new(ray), visit);
        hit
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
trait Groups {
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
struct Gathered<'a>(&'a Indexed, &'a [[u32; 3]]);

/// A packet of its own.
struct Own(TrianglePacket);

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
struct Closest<'a, G: ?Sized> {
    groups: &'a G,
    ray: &'a TriangleRay,
    backfaces: Backfaces,
    /// The parameter of the hit, or the end of the ray.
    t_max: f32,
    hit: &'a mut Option<TriangleHit>,
}

impl<G: Groups + ?Sized> VisitLeaf for Closest<'_, G> {
    const WAITS: bool = true;

    #[inline(always)]
    fn visit<S: Simd>(&mut self, simd: S, leaf: u32, _at: f32) -> Visit {
        let packet = self.groups.get(group_of(leaf));
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
                    slot: (group_of(leaf) * LANES + lane) as u32,
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
        self.groups.prefetch(group_of(leaf));
    }
}

/// Looks for any hit.
struct Any<'a, G: ?Sized> {
    groups: &'a G,
    ray: &'a TriangleRay,
    backfaces: Backfaces,
    t_max: f32,
    found: &'a mut bool,
}

impl<G: Groups + ?Sized> VisitLeaf for Any<'_, G> {
    const WAITS: bool = true;

    #[inline(always)]
    fn visit<S: Simd>(&mut self, simd: S, leaf: u32, _at: f32) -> Visit {
        let packet = self.groups.get(group_of(leaf));
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
        self.groups.prefetch(group_of(leaf));
    }
}
