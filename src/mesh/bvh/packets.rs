//! Packets of rays against the hierarchy.

use super::{
    MeshBvh, group_of,
    rays::{Any, Closest, Gathered, Groups, Nearest, is_hit},
};
use crate::{
    geometry::ray::{
        Ray,
        triangle::{Backfaces, TriangleRay},
    },
    mesh::triangles::{Storage, TriangleHit},
    spatial::{
        lanes::Entering,
        packet::{NO_RAY, PerRay, RAYS, VisitRays, go_together, visit_together},
        simd::{LANES, Simd},
        traverse::{visit_any_with, visit_in_order_with},
        wide::{NodeIndex, WideNode},
    },
};

impl MeshBvh {
    /// The [`closest_hit`](Self::closest_hit) of each ray.
    pub(in crate::mesh) fn closest_hits_of(
        &self,
        rays: &[Ray],
        backfaces: Backfaces,
        hits: &mut [Option<TriangleHit>],
    ) {
        for (rays, hits) in rays.chunks(RAYS).zip(hits.chunks_mut(RAYS)) {
            if !go_together(rays) {
                for (ray, hit) in rays.iter().zip(hits) {
                    *hit = self.closest_hit(ray, backfaces);
                }
                continue;
            }
            match self.mesh.storage() {
                Storage::Packed(packets) => self.closest_together(&packets[..], rays, backfaces, hits),
                Storage::Indexed(indexed) => {
                    self.closest_together(&Gathered(indexed, self.mesh.vertices()), rays, backfaces, hits);
                }
            }
        }
    }

    /// Of each ray whether there is [`any_hit`](Self::any_hit).
    pub(in crate::mesh) fn any_hits_of(&self, rays: &[Ray], backfaces: Backfaces, found: &mut [bool]) {
        for (rays, found) in rays.chunks(RAYS).zip(found.chunks_mut(RAYS)) {
            if !go_together(rays) {
                for (ray, found) in rays.iter().zip(found) {
                    *found = self.any_hit(ray, backfaces);
                }
                continue;
            }
            match self.mesh.storage() {
                Storage::Packed(packets) => self.any_together(&packets[..], rays, backfaces, found),
                Storage::Indexed(indexed) => {
                    self.any_together(&Gathered(indexed, self.mesh.vertices()), rays, backfaces, found);
                }
            }
        }
    }

    fn closest_together(
        &self,
        groups: &(impl Groups + ?Sized),
        rays: &[Ray],
        backfaces: Backfaces,
        hits: &mut [Option<TriangleHit>],
    ) {
        hits.fill(None);
        let visit = ClosestOfEach {
            nodes: &self.nodes,
            groups,
            rays,
            triangle_rays: &triangle_rays(rays),
            backfaces,
            hits,
        };
        visit_together(&self.nodes, rays, visit);
    }

    fn any_together(&self, groups: &(impl Groups + ?Sized), rays: &[Ray], backfaces: Backfaces, found: &mut [bool]) {
        found.fill(false);
        let visit = AnyOfEach {
            nodes: &self.nodes,
            groups,
            rays,
            triangle_rays: &triangle_rays(rays),
            backfaces,
            found,
        };
        visit_together(&self.nodes, rays, visit);
    }
}

/// Those of all rays, of which there is at least one, and then any.
#[inline]
fn triangle_rays(rays: &[Ray]) -> [TriangleRay; RAYS] {
    let mut triangle_rays = [TriangleRay::new(&rays[0]); RAYS];
    for (triangle_ray, ray) in triangle_rays.iter_mut().zip(rays) {
        *triangle_ray = TriangleRay::new(ray);
    }
    triangle_rays
}

/// Looks for the nearest hit of each ray.
struct ClosestOfEach<'a, G: ?Sized> {
    nodes: &'a [WideNode],
    groups: &'a G,
    rays: &'a [Ray],
    triangle_rays: &'a [TriangleRay; RAYS],
    backfaces: Backfaces,
    hits: &'a mut [Option<TriangleHit>],
}

impl<G: Groups + ?Sized> VisitRays for ClosestOfEach<'_, G> {
    #[inline(always)]
    fn visit<S: Simd>(&mut self, simd: S, leaf: u32, mut rays: u32, at: &PerRay<f32>, limits: &mut PerRay<f32>) {
        let packet = self.groups.get(group_of(leaf));
        while rays != 0 {
            let ray = rays.trailing_zeros() as usize % RAYS;
            rays &= rays - 1;
            let limit = &mut limits[ray / LANES][ray % LANES];
            let mut nearest = Nearest {
                limit: *limit,
                hit: self.hits[ray],
            };
            let at = at[ray / LANES][ray % LANES];
            nearest.test(simd, &packet, leaf, at, &self.triangle_rays[ray], self.backfaces);
            *limit = nearest.limit;
            self.hits[ray] = nearest.hit;
        }
    }

    #[inline(always)]
    fn visit_below<S: Simd>(&mut self, simd: S, node: NodeIndex, ray: usize, limit: &mut f32) {
        let mut nearest = Nearest {
            limit: *limit,
            hit: self.hits[ray],
        };
        let visit = Closest {
            groups: self.groups,
            ray: &self.triangle_rays[ray],
            backfaces: self.backfaces,
            nearest: &mut nearest,
        };
        visit_in_order_with(simd, self.nodes, node, *limit, Entering::new(&self.rays[ray]), visit);
        *limit = nearest.limit;
        self.hits[ray] = nearest.hit;
    }

    #[inline(always)]
    fn prefetch(&self, leaf: u32) {
        self.groups.prefetch(group_of(leaf));
    }
}

/// Looks for any hit of each ray.
struct AnyOfEach<'a, G: ?Sized> {
    nodes: &'a [WideNode],
    groups: &'a G,
    rays: &'a [Ray],
    triangle_rays: &'a [TriangleRay; RAYS],
    backfaces: Backfaces,
    found: &'a mut [bool],
}

impl<G: Groups + ?Sized> VisitRays for AnyOfEach<'_, G> {
    #[inline(always)]
    fn visit<S: Simd>(&mut self, simd: S, leaf: u32, mut rays: u32, _at: &PerRay<f32>, limits: &mut PerRay<f32>) {
        let packet = self.groups.get(group_of(leaf));
        while rays != 0 {
            let ray = rays.trailing_zeros() as usize % RAYS;
            rays &= rays - 1;
            let limit = &mut limits[ray / LANES][ray % LANES];
            if is_hit(simd, &packet, leaf, &self.triangle_rays[ray], *limit, self.backfaces) {
                self.found[ray] = true;
                *limit = NO_RAY;
            }
        }
    }

    #[inline(always)]
    fn visit_below<S: Simd>(&mut self, simd: S, node: NodeIndex, ray: usize, limit: &mut f32) {
        let visit = Any {
            groups: self.groups,
            ray: &self.triangle_rays[ray],
            backfaces: self.backfaces,
            t_max: *limit,
            found: &mut self.found[ray],
        };
        visit_any_with(simd, self.nodes, node, *limit, Entering::new(&self.rays[ray]), visit);
        if self.found[ray] {
            *limit = NO_RAY;
        }
    }

    #[inline(always)]
    fn prefetch(&self, leaf: u32) {
        self.groups.prefetch(group_of(leaf));
    }
}
