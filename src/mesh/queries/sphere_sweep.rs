//! What a moving sphere touches first.

use bevy::math::{Vec3, Vec3A, primitives::Triangle3d};

use super::SurfacePoint;
use crate::{
    geometry::{
        intersection::simplex::closest_to_origin,
        ray::triangle::TriangleIntersection,
        support::unit,
        sweep::{SphereSweep, SweepIntersection},
        tolerance,
    },
    mesh::{MeshBvh, TriangleHit, TriangleMesh, bvh::unpack_slots, triangles::nearer},
    spatial::{
        Visit,
        lanes::Entering,
        sweep::{Sweep, grown, slack_reach},
        traverse::visit_in_order,
        wide::EVERY_MASK,
    },
};

/// Where a moving sphere first touches the surface of a mesh. In the local space of the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereContact {
    /// The point of the surface.
    pub point: Vec3,
    /// The unit vector from there to the centre of the sphere. Where the two are one, the normal of the triangle, on the
    /// side that the sphere comes from; zero if the triangle has no area.
    pub normal: Vec3,
    /// The triangle, the weights of its vertices, and as `t` the parameter of the contact.
    pub hit: TriangleHit,
}

impl MeshBvh {
    /// The first contact of the moving sphere with the surface, from either side. Of triangles at one parameter the one
    /// with the smallest number wins; of those that the sphere touches at its start, at
    /// [`t_min`](crate::geometry::ray::Ray::t_min), the one that is closest to its centre.
    ///
    /// As exact as [`SphereSweep`] is, at faces, edges and vertices alike. Triangles without area count as the segments or
    /// points that they are.
    pub fn sweep_sphere(&self, sweep: &SphereSweep) -> Option<SphereContact> {
        let mut search = Search::new(sweep);
        let approach = Entering::grown(sweep.ray(), slack_reach(sweep));
        visit_in_order(self.nodes(), 0, EVERY_MASK, search.limit(), approach, |leaf, _| {
            search.among(self.mesh(), unpack_slots(leaf));
            if search.is_at_start() {
                Visit::Stop
            } else {
                Visit::Shorten(search.limit())
            }
        });
        if search.is_at_start() {
            search.settle(self.closest_point(search.start(), f32::INFINITY));
        }
        search.found(self.mesh())
    }
}

impl TriangleMesh {
    /// As [`MeshBvh::sweep_sphere`].
    pub fn sweep_sphere(&self, sweep: &SphereSweep) -> Option<SphereContact> {
        let mut search = Search::new(sweep);
        search.among(self, self.slots());
        if search.is_at_start() {
            search.settle(self.closest_point(search.start(), f32::INFINITY));
        }
        search.found(self)
    }
}

struct Search<'a> {
    sweep: &'a SphereSweep,
    /// As far as it still matters.
    rest: SphereSweep,
    first: Option<TriangleHit>,
}

impl<'a> Search<'a> {
    fn new(sweep: &'a SphereSweep) -> Self {
        Self {
            sweep,
            rest: *sweep,
            first: None,
        }
    }

    /// The last parameter that still matters. A contact beyond the range of parameters is none.
    fn limit(&self) -> f32 {
        self.first
            .map_or(self.sweep.ray().t_max().min(f32::MAX), |first| first.t)
    }

    /// Whether nothing can come before the first contact.
    fn is_at_start(&self) -> bool {
        self.first.is_some_and(|first| first.t <= self.sweep.ray().t_min())
    }

    /// Where the centre starts.
    fn start(&self) -> Vec3A {
        let path = self.sweep.ray();
        path.at(path.t_min())
    }

    /// Takes the closest of the triangles that are in touch at the start.
    fn settle(&mut self, closest: Option<SurfacePoint>) {
        let t = self.sweep.ray().t_min();
        self.first = closest.map(|closest| TriangleHit { t, ..closest.hit });
    }

    /// Looks among the triangles in some slots.
    fn among(&mut self, mesh: &TriangleMesh, slots: impl Iterator<Item = u32>) {
        let reach = slack_reach(self.sweep);
        for slot in slots {
            let within_reach = grown(&mesh.triangle_box(slot), reach);
            if self.rest.ray().aabb_intersection_at(&within_reach).is_none() {
                continue;
            }
            let [a, b, c] = mesh.corners(slot).map(Vec3::from);
            let Some(t) = self.rest.intersection_at(&Triangle3d::new(a, b, c)) else {
                continue;
            };
            if t > self.limit() {
                continue;
            }
            let contact = mesh.hit(
                slot,
                TriangleIntersection {
                    t,
                    barycentrics: Vec3::ZERO,
                },
            );
            self.first = nearer(self.first, contact);
            // One more step of `f32`, so that contacts that are rounded to this parameter are still found: ties then do not
            // depend on the order.
            self.rest = self
                .sweep
                .with_t_max(self.limit().next_up().min(self.sweep.ray().t_max()));
        }
    }

    fn found(&self, mesh: &TriangleMesh) -> Option<SphereContact> {
        let path = self.sweep.ray();
        let TriangleHit { t, slot, .. } = self.first?;
        let direction = path.direction().as_dvec3();
        let center = path.origin().as_dvec3() + direction * f64::from(t);
        let closest = closest_to_origin(&mesh.exact_corners(slot).map(|corner| corner - center));
        let point = center + closest.point;
        let largest = center
            .abs()
            .max(point.abs())
            .max(path.origin().as_dvec3().abs())
            .max_element();
        let normal = if closest.point.length() > tolerance::CONTACT_NORMAL * largest {
            unit(-closest.point)
        } else {
            let normal = mesh.unit_normal(slot);
            if normal.dot(direction) > 0.0 { -normal } else { normal }
        };
        Some(SphereContact {
            point: point.as_vec3(),
            normal: normal.as_vec3(),
            hit: mesh.hit_at(slot, t, &closest),
        })
    }
}
