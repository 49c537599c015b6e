//! The triangles that are partly in a region whose own test is dear.

use bevy::math::{Vec3A, bounding::Aabb3d};

use crate::{
    mesh::{MeshBvh, TriangleMesh, bvh::unpack_slots},
    spatial::{
        traverse::{Descent, descend},
        wide::{Child, EVERY_MASK},
    },
};

impl MeshBvh {
    /// Goes down the hierarchy as `visit_box` says of each box, and asks `visit_triangle` about the corners of each
    /// triangle where it enters a leaf, until that stops it.
    pub(crate) fn descend(
        &self,
        mut visit_box: impl FnMut(&Aabb3d) -> Descent,
        mut visit_triangle: impl FnMut([Vec3A; 3]) -> Descent,
    ) {
        let mesh = self.mesh();
        descend(self.nodes(), 0, EVERY_MASK, |aabb, child| {
            match (visit_box(aabb), child) {
                (Descent::Enter, Child::Leaf(leaf)) => {
                    let stops = |slot| matches!(visit_triangle(mesh.corners(slot)), Descent::Stop);
                    if unpack_slots(leaf).any(stops) {
                        return Descent::Stop;
                    }
                    Descent::Skip
                }
                (descent, _) => descent,
            }
        });
    }
}

impl TriangleMesh {
    /// The same of every triangle.
    pub(crate) fn descend(
        &self,
        mut visit_box: impl FnMut(&Aabb3d) -> Descent,
        mut visit_triangle: impl FnMut([Vec3A; 3]) -> Descent,
    ) {
        if matches!(visit_box(&self.aabb()), Descent::Enter) {
            let stops = |slot| matches!(visit_triangle(self.corners(slot)), Descent::Stop);
            let _ = self.slots().any(stops);
        }
    }
}
