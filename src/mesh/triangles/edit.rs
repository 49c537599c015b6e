//! How a mesh that was edited differs from the copy of it.

use std::borrow::Cow;

use bevy::math::Vec3;

use super::{Storage, TriangleMesh};
use crate::spatial::simd::LANES;

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
    /// How `edited` differs from this mesh. The slots of both may be in any order.
    pub(crate) fn edit_to(&self, edited: &Self) -> MeshEdit {
        if self.len() != edited.len() || self.vertex_count() != edited.vertex_count() {
            return MeshEdit::Topology;
        }
        let mut edit = MeshEdit::Attributes;
        for slot in self.slots() {
            let number = self.number(slot);
            // Mostly none was left out, and the triangles of an edited mesh are in order.
            let is_it = |&slot: &u32| edited.holds(slot) && edited.number(slot) == number;
            let Some(new) = Some(number).filter(is_it).or_else(|| edited.slot_of(number)) else {
                return MeshEdit::Topology;
            };
            if edited.fixed.vertices[number as usize] != self.fixed.vertices[number as usize] {
                return MeshEdit::Topology;
            }
            if edited.corners(new) != self.corners(slot) {
                edit = MeshEdit::Positions;
            }
        }
        edit
    }

    /// The positions of the vertices by their numbers; of those that no triangle uses, anything.
    pub(crate) fn positions(&self) -> Cow<'_, [Vec3]> {
        if let Storage::Indexed(indexed) = self.storage() {
            return Cow::Borrowed(&indexed.positions);
        }
        let mut positions = vec![Vec3::ZERO; self.vertex_count()];
        for slot in self.slots() {
            let vertices = self.fixed.vertices[self.number(slot) as usize];
            for (vertex, corner) in vertices.into_iter().zip(self.corners(slot)) {
                positions[vertex as usize] = corner.into();
            }
        }
        Cow::Owned(positions)
    }

    /// Takes over what a hit reports of the vertices from an edited mesh that has the same triangles.
    pub(crate) fn take_attributes_of(&mut self, edited: &Self) {
        self.fixed = edited.fixed.clone();
    }

    fn holds(&self, slot: u32) -> bool {
        let (group, lane) = (slot as usize / LANES, slot as usize % LANES);
        group < self.storage.group_count() && lane < self.storage.len_of(group)
    }
}
