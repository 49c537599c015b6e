//! How a mesh that was edited differs from the copy of it.

use bevy::math::Vec3;

use super::TriangleMesh;

/// How an edited mesh differs from what it was, from the least to the most.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum MeshEdit {
    /// In what a hit reports of it, if at all: in normals and texture coordinates.
    Attributes,
    /// In the places of its vertices; it has the same triangles between them.
    Positions,
    /// In its triangles.
    Topology,
}

impl TriangleMesh {
    /// How `edited`, which must be as [`from_mesh`](Self::from_mesh) returns it, differs from this mesh, whose slots may
    /// be in any order.
    pub(crate) fn edit_to(&self, edited: &Self) -> MeshEdit {
        if self.len() != edited.len() || self.vertex_count() != edited.vertex_count() {
            return MeshEdit::Topology;
        }
        let mut edit = MeshEdit::Attributes;
        for triangle in &self.triangles {
            // Where none was left out, a triangle is where its number says.
            let is_it = |slot: &usize| {
                edited
                    .triangles
                    .get(*slot)
                    .is_some_and(|new| new.number == triangle.number)
            };
            let slot = Some(triangle.number as usize).filter(is_it).or_else(|| {
                let slot = edited
                    .triangles
                    .binary_search_by_key(&triangle.number, |new| new.number);
                slot.ok()
            });
            let new = slot.map(|slot| &edited.triangles[slot]);
            let Some(new) = new.filter(|new| new.vertices == triangle.vertices) else {
                return MeshEdit::Topology;
            };
            if new.corners != triangle.corners {
                edit = MeshEdit::Positions;
            }
        }
        edit
    }

    /// The positions of the vertices by their numbers; zero for those that no triangle uses.
    pub(crate) fn positions(&self) -> Vec<Vec3> {
        let mut positions = vec![Vec3::ZERO; self.vertex_count()];
        for triangle in &self.triangles {
            for (&vertex, &corner) in triangle.vertices.iter().zip(&triangle.corners) {
                positions[vertex as usize] = corner;
            }
        }
        positions
    }

    /// Takes over what a hit reports of the vertices from an edited mesh that has as many.
    pub(crate) fn take_attributes_of(&mut self, edited: &Self) {
        debug_assert_eq!(self.vertex_count(), edited.vertex_count());
        self.vertices.copy_from_slice(&edited.vertices);
        (self.has_uvs, self.left_out) = (edited.has_uvs, edited.left_out);
    }

    /// The size of the copy, in bytes.
    pub fn memory(&self) -> usize {
        size_of_val(&*self.triangles) + size_of_val(&*self.vertices)
    }
}
