//! The point of a surface that is closest to a point.

use bevy::math::{DVec3, Vec3, Vec3A};

use crate::{
    geometry::{
        intersection::simplex::{Closest, closest_to_origin},
        rounding, tolerance,
    },
    mesh::{MeshBvh, TriangleHit, TriangleMesh, bvh::unpack_slots},
    spatial::{Visit, lanes::Growing, region::distance_squared, traverse::visit_in_order, wide::EVERY_MASK},
};

/// A point of the surface of a mesh, close to another point. In the local space of the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The point of the surface.
    pub point: Vec3,
    /// How far it is from the point that was asked for.
    pub distance: f32,
    /// The unit normal of the triangle, by its winding; zero if it has no area.
    pub normal: Vec3,
    /// The triangle and the weights of its vertices, to look up what a hit can be looked up for; `t` is the distance.
    ///
    /// A weight is exactly zero where the point is on an edge; two are at a vertex.
    pub hit: TriangleHit,
}

impl MeshBvh {
    /// The point of the surface that is closest to `point`, and no farther than `max_distance`, which may be infinite. Of
    /// triangles at one distance the one with the smallest number wins.
    ///
    /// Triangles without area count as the segments or points that they are. Distances are compared in double precision,
    /// before they are rounded. Nothing is within a negative distance, nor close to a point that is not finite.
    pub fn closest_point(&self, point: impl Into<Vec3A>, max_distance: f32) -> Option<SurfacePoint> {
        let center = point.into();
        let mut search = Search::new(center, max_distance)?;
        let limit = search.reach_squared();
        visit_in_order(self.nodes(), 0, EVERY_MASK, limit, Growing { center }, |leaf, _| {
            search.among(self.mesh(), unpack_slots(leaf));
            Visit::Shorten(search.reach_squared())
        });
        search.found(self.mesh())
    }
}

impl TriangleMesh {
    /// As [`MeshBvh::closest_point`].
    pub fn closest_point(&self, point: impl Into<Vec3A>, max_distance: f32) -> Option<SurfacePoint> {
        let mut search = Search::new(point.into(), max_distance)?;
        search.among(self, self.slots());
        search.found(self)
    }
}

struct Search {
    center: Vec3A,
    point: DVec3,
    /// The square of how far to look.
    limit: f64,
    best: Option<Candidate>,
}

struct Candidate {
    slot: u32,
    triangle: u32,
    /// With the point as the origin.
    closest: Closest,
}

impl Search {
    /// `None` if nothing can be found.
    fn new(center: Vec3A, max_distance: f32) -> Option<Self> {
        (max_distance >= 0.0 && center.is_finite()).then(|| Self {
            center,
            point: center.as_dvec3(),
            limit: f64::from(max_distance).powi(2),
            best: None,
        })
    }

    /// Looks among the triangles in some slots.
    fn among(&mut self, mesh: &TriangleMesh, slots: impl Iterator<Item = u32>) {
        let mut reach = self.reach_squared();
        for slot in slots {
            if distance_squared(self.center, &mesh.triangle_box(slot)) > reach {
                continue;
            }
            let relative = mesh.exact_corners(slot).map(|corner| corner - self.point);
            let closest = closest_to_origin(&relative);
            let squared = closest.point.length_squared();
            let triangle = mesh.number(slot);
            let is_tie = || self.best.as_ref().is_some_and(|best| best.triangle < triangle);
            if squared > self.limit || squared == self.limit && is_tie() {
                continue;
            }
            self.limit = squared;
            reach = self.reach_squared();
            self.best = Some(Candidate {
                slot,
                triangle,
                closest,
            });
        }
    }

    /// The square of how far a box may be, as it is rounded, that has something within the limit.
    fn reach_squared(&self) -> f32 {
        let underflow = f64::from(tolerance::SQUARE_UNDERFLOW).powi(2);
        rounding::up(self.limit * (1.0 + f64::from(tolerance::REGION_PLANE)) + underflow)
    }

    fn found(&self, mesh: &TriangleMesh) -> Option<SurfacePoint> {
        let Candidate { slot, closest, .. } = self.best.as_ref()?;
        let distance = closest.point.length() as f32;
        Some(SurfacePoint {
            point: (self.point + closest.point).as_vec3(),
            distance,
            normal: mesh.unit_normal(*slot).as_vec3(),
            hit: mesh.hit_at(*slot, distance, closest),
        })
    }
}
