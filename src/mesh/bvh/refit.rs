//! How a hierarchy follows vertices that move.

use bevy::math::Vec3;

use super::{MeshBvh, group_of};
use crate::{
    mesh::triangles::{MeshEdit, MovingTriangles, TriangleMesh},
    spatial::{
        simd::{Simd, Task, dispatch},
        wide::{Child, WideNode},
    },
};

impl MeshBvh {
    /// Moves the vertices of the mesh, vertex `i` to `positions[i]`, and fits every box to what is below it, in O(n). The
    /// answers are those of a hierarchy built anew; the farther the vertices have moved, the longer they take.
    ///
    /// # Panics
    ///
    /// If there are fewer positions than [vertices](crate::mesh::TriangleMesh::vertex_count), or if one that is used is
    /// NaN or infinite.
    pub fn refit(&mut self, positions: &[Vec3]) {
        let triangles = self.mesh.moving(positions);
        dispatch(Refit {
            nodes: &mut self.nodes,
            triangles,
        });
    }

    /// Takes over the vertices of an edited mesh, which has the same triangles in any order of slots.
    pub(crate) fn take_vertices_of(&mut self, edited: &TriangleMesh, edit: MeshEdit) {
        debug_assert!(edit < MeshEdit::Topology);
        self.mesh.take_attributes_of(edited);
        if edit == MeshEdit::Positions {
            self.refit(&edited.positions());
        }
    }
}

struct Refit<'a> {
    nodes: &'a mut [WideNode],
    triangles: MovingTriangles<'a>,
}

impl Task for Refit<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        // Children come after their parents.
        for index in (0..self.nodes.len()).rev() {
            for lane in 0..self.nodes[index].len() {
                let bounds = match self.nodes[index].child(lane) {
                    Child::Node(child) => self.nodes[child as usize].bounds_with(simd),
                    Child::Leaf(leaf) => self.triangles.move_group(simd, group_of(leaf)),
                };
                self.nodes[index].set_aabb(lane, &bounds);
            }
        }
        self.triangles.finish();
    }
}
