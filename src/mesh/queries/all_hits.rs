//! All hits of a ray.

use crate::{
    geometry::ray::{
        Ray,
        triangle::{Backfaces, TriangleRay},
    },
    mesh::{MeshBvh, TriangleHit, TriangleMesh, bvh::unpack_slots},
    spatial::{Visit, lanes::Entering, traverse::visit_in_order, wide::EVERY_MASK},
};

impl MeshBvh {
    /// All hits of the ray, written over `hits`: nearest first, and of those at one parameter the triangle with the
    /// smaller number.
    ///
    /// Allocates only where `hits` has to grow.
    pub fn all_hits(&self, ray: &Ray, backfaces: Backfaces, hits: &mut Vec<TriangleHit>) {
        collect_sorted(hits, |visit| self.visit_hits(ray, backfaces, visit));
    }

    /// Visits the hits of the ray, roughly from near to far, in no promised order.
    ///
    /// A hit exactly where the ray was [shortened](Visit::Shorten) to is still visited.
    pub fn visit_hits(&self, ray: &Ray, backfaces: Backfaces, visit: impl FnMut(&TriangleHit) -> Visit) {
        let mut hits = Hits::new(ray, backfaces, visit);
        visit_in_order(
            self.nodes(),
            0,
            EVERY_MASK,
            ray.t_max(),
            Entering::new(ray),
            |leaf, _| hits.of(self.mesh(), unpack_slots(leaf)),
        );
    }
}

impl TriangleMesh {
    /// As [`MeshBvh::all_hits`].
    pub fn all_hits(&self, ray: &Ray, backfaces: Backfaces, hits: &mut Vec<TriangleHit>) {
        collect_sorted(hits, |visit| self.visit_hits(ray, backfaces, visit));
    }

    /// As [`MeshBvh::visit_hits`].
    pub fn visit_hits(&self, ray: &Ray, backfaces: Backfaces, visit: impl FnMut(&TriangleHit) -> Visit) {
        Hits::new(ray, backfaces, visit).of(self, self.slots());
    }
}

/// A ray on its way through a mesh.
struct Hits<F> {
    ray: TriangleRay,
    backfaces: Backfaces,
    limit: f32,
    visit: F,
}

impl<F: FnMut(&TriangleHit) -> Visit> Hits<F> {
    fn new(ray: &Ray, backfaces: Backfaces, visit: F) -> Self {
        Self {
            ray: TriangleRay::new(ray),
            backfaces,
            limit: ray.t_max(),
            visit,
        }
    }

    /// Visits the hits on the triangles in some slots.
    fn of(&mut self, mesh: &TriangleMesh, slots: impl Iterator<Item = u32>) -> Visit {
        for slot in slots {
            let met = self
                .ray
                .triangle_intersection(mesh.corners(slot), self.limit, self.backfaces);
            let Some(hit) = met else { continue };
            match (self.visit)(&mesh.hit(slot, hit)) {
                Visit::Continue => {}
                Visit::Shorten(t) => self.limit = self.limit.min(t),
                Visit::Stop => return Visit::Stop,
            }
        }
        Visit::Shorten(self.limit)
    }
}

fn collect_sorted(hits: &mut Vec<TriangleHit>, visit_all: impl FnOnce(&mut dyn FnMut(&TriangleHit) -> Visit)) {
    hits.clear();
    visit_all(&mut |hit| {
        hits.push(*hit);
        Visit::Continue
    });
    // Not -0.0, which is where 0.0 is.
    let key = |hit: &TriangleHit| hit.t + 0.0;
    hits.sort_unstable_by(|a, b| key(a).total_cmp(&key(b)).then(a.triangle.cmp(&b.triangle)));
}
