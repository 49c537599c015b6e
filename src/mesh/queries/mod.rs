//! What can be asked of the triangles of a mesh besides the nearest hit of one ray.
//!
//! | question | answer |
//! |---|---|
//! | all that a ray hits | [`MeshBvh::all_hits`], [`MeshBvh::visit_hits`] |
//! | many rays at once | [`MeshBvh::closest_hits`], [`MeshBvh::any_hits`] |
//! | the point of the surface closest to a point | [`MeshBvh::closest_point`] |
//! | the triangles that touch a box, sphere, frustum, hull | [`MeshBvh::visit_touching`] |
//! | what a moving sphere touches first | [`MeshBvh::sweep_sphere`] |
//!
//! Everything is in the local space of the mesh. A [`TriangleMesh`] has the same methods, but for the batches, and the
//! same answers to the last bit: it asks every triangle, in O(n), where the hierarchy asks those that matter.
//!
//! [`MeshBvh`]: super::MeshBvh
//! [`MeshBvh::all_hits`]: super::MeshBvh::all_hits
//! [`MeshBvh::visit_hits`]: super::MeshBvh::visit_hits
//! [`MeshBvh::closest_hits`]: super::MeshBvh::closest_hits
//! [`MeshBvh::any_hits`]: super::MeshBvh::any_hits
//! [`MeshBvh::closest_point`]: super::MeshBvh::closest_point
//! [`MeshBvh::visit_touching`]: super::MeshBvh::visit_touching
//! [`MeshBvh::sweep_sphere`]: super::MeshBvh::sweep_sphere
//! [`TriangleMesh`]: super::TriangleMesh

mod all_hits;
mod batch;
mod closest_point;
mod parts;
mod sphere_sweep;
mod touching;

pub use closest_point::SurfacePoint;
pub use sphere_sweep::SphereContact;
pub use touching::TriangleRegion;

use bevy::math::{DVec3, Vec3, Vec3A};

use super::triangles::TriangleMesh;
use crate::geometry::{intersection::simplex::Closest, ray::triangle::TriangleIntersection, support::unit};

use super::TriangleHit;

impl TriangleMesh {
    fn exact_corners(&self, slot: u32) -> [DVec3; 3] {
        self.corners(slot).map(Vec3A::as_dvec3)
    }

    /// The unit normal of a triangle, by its winding; zero if it has no area.
    fn unit_normal(&self, slot: u32) -> DVec3 {
        let [a, b, c] = self.exact_corners(slot);
        unit((b - a).cross(c - a))
    }

    /// A point of a triangle as a hit at the parameter `t`.
    fn hit_at(&self, slot: u32, t: f32, closest: &Closest) -> TriangleHit {
        let [u, v, w, _] = closest.weights.map(|weight| weight as f32);
        let barycentrics = Vec3::new(u, v, w);
        self.hit(slot, TriangleIntersection { t, barycentrics })
    }
}
