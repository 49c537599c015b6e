//! What tells a mesh from another.

use bevy::math::Vec3;

use crate::mesh::TriangleMesh;

/// Which slot holds the triangle with a number.
pub(super) struct SlotsByNumber(Vec<u32>);

const NO_SLOT: u32 = u32::MAX;

impl SlotsByNumber {
    pub(super) fn of(mesh: &TriangleMesh) -> Self {
        let numbers = mesh.slots().map(|slot| mesh.number(slot));
        let mut slots = vec![NO_SLOT; numbers.max().map_or(0, |last| last as usize + 1)];
        for slot in mesh.slots() {
            slots[mesh.number(slot) as usize] = slot;
        }
        Self(slots)
    }

    /// The slot of the triangle with this number, the first time that it is asked for.
    pub(super) fn take(&mut self, number: u32) -> Option<u32> {
        let slot = std::mem::replace(self.0.get_mut(number as usize)?, NO_SLOT);
        (slot != NO_SLOT).then_some(slot)
    }

    /// A checksum of the triangles in the order of their numbers, whatever the order of the slots.
    pub(super) fn fingerprint(&self, mesh: &TriangleMesh) -> u32 {
        let mut hasher = crc32fast::Hasher::new();
        let mut block = Vec::with_capacity(BLOCK);
        for (number, &slot) in (0_u32..).zip(&self.0).filter(|(_, slot)| **slot != NO_SLOT) {
            block.extend_from_slice(&number.to_le_bytes());
            for corner in mesh.corners(slot).map(Vec3::from) {
                for coordinate in corner.to_array() {
                    block.extend_from_slice(&coordinate.to_le_bytes());
                }
            }
            if block.len() > BLOCK - TRIANGLE {
                hasher.update(&block);
                block.clear();
            }
        }
        hasher.update(&block);
        hasher.finalize()
    }
}

/// The bytes of a triangle, and of how many are hashed at once.
const TRIANGLE: usize = 40;
const BLOCK: usize = 100 * TRIANGLE;
