//! How triangles follow their vertices.

use std::sync::Arc;

use bevy::math::{Vec3, Vec3A, bounding::Aabb3d};

use super::{TriangleMesh, storage::Storage};
use crate::{
    geometry::aabb::EMPTY,
    mesh::packet::TrianglePacket,
    spatial::simd::{Portable, Simd},
};

impl TriangleMesh {
    /// Moves vertex `i` to `positions[i]`, and with it the corners of the triangles.
    ///
    /// # Panics
    ///
    /// As [`MeshBvh::refit`](crate::mesh::MeshBvh::refit).
    pub fn move_vertices(&mut self, positions: &[Vec3]) {
        let groups = 0..self.storage.group_count();
        let mut moving = self.moving(positions);
        for group in groups {
            moving.move_group(Portable, group);
        }
        moving.finish();
    }

    /// Moves vertex `i` to `positions[i]`: each group of triangles as it is asked for.
    pub(in crate::mesh) fn moving<'a>(&'a mut self, positions: &'a [Vec3]) -> MovingTriangles<'a> {
        MovingTriangles {
            storage: &mut self.storage,
            vertices: &self.fixed.vertices,
            positions: &positions[..self.fixed.vertex_count],
            aabb: &mut self.aabb,
            moved: EMPTY,
            finite: Vec3A::ZERO,
        }
    }
}

/// Triangles whose vertices are moved, group by group.
pub(in crate::mesh) struct MovingTriangles<'a> {
    storage: &'a mut Storage,
    vertices: &'a [[u32; 3]],
    positions: &'a [Vec3],
    /// The box of the mesh; that around what has moved comes there in the end.
    aabb: &'a mut Aabb3d,
    moved: Aabb3d,
    /// Zero, or NaN after a position that is not finite.
    finite: Vec3A,
}

impl MovingTriangles<'_> {
    /// Moves the triangles of a group, and returns the box around their boxes.
    #[inline(always)]
    pub fn move_group<S: Simd>(&mut self, simd: S, group: usize) -> Aabb3d {
        let (mut moved, mut finite) = (self.moved, self.finite);
        let corners_of = |number: u32| {
            self.vertices[number as usize].map(|vertex| {
                let position = Vec3A::from(self.positions[vertex as usize]);
                moved.min = moved.min.min(position);
                moved.max = moved.max.max(position);
                finite += position * 0.0;
                Vec3::from(position)
            })
        };
        let bounds = match self.storage {
            Storage::Packed(packets) => {
                packets[group].move_corners(corners_of);
                packets[group].bounds(simd)
            }
            Storage::Indexed(indexed) => {
                let mut corners_of = corners_of;
                let numbers = indexed.groups[group].numbers();
                let triangles = numbers.map(|number| (corners_of(number).map(Vec3A::from), number));
                TrianglePacket::new(triangles).bounds(simd)
            }
        };
        (self.moved, self.finite) = (moved, finite);
        bounds
    }

    /// Ends the move, when every group was moved.
    pub fn finish(self) {
        assert!(self.finite == Vec3A::ZERO, "positions must be finite");
        *self.aabb = self.moved;
        if let Storage::Indexed(indexed) = self.storage {
            match Arc::get_mut(&mut indexed.positions) {
                Some(own) => own.copy_from_slice(self.positions),
                None => indexed.positions = Arc::new(self.positions.to_vec()),
            }
        }
    }
}
