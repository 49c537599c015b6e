//! What tells a mesh from another.

use bevy::math::Vec3;

use crate::mesh::TriangleMesh;

/// A checksum of the triangles in the order of their numbers, whatever the order of the slots.
pub(super) fn fingerprint(mesh: &TriangleMesh) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    let mut block = Vec::with_capacity(BLOCK);
    for number in 0..mesh.vertices().len() as u32 {
        let Some(corners) = mesh.corners_of(number) else {
            continue;
        };
        block.extend_from_slice(&number.to_le_bytes());
        for coordinate in corners.iter().flat_map(Vec3::to_array) {
            block.extend_from_slice(&coordinate.to_le_bytes());
        }
        if block.len() > BLOCK - TRIANGLE {
            hasher.update(&block);
            block.clear();
        }
    }
    hasher.update(&block);
    hasher.finalize()
}

/// The bytes of a triangle, and of how many are hashed at once.
const TRIANGLE: usize = 40;
const BLOCK: usize = 100 * TRIANGLE;
