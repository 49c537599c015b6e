//! Where the corners of triangles are kept.
//!
//! In groups of up to eight, which rays test at once: the triangle in lane `l` of group `g` is in slot `8g + l`.

use std::sync::Arc;

use bevy::math::{Vec3, Vec3A};

use crate::{
    mesh::packet::{NONE, TrianglePacket},
    spatial::simd::LANES,
};

/// Where the corners of triangles are kept.
#[derive(Clone, Debug)]
pub(in crate::mesh) enum Storage {
    /// Group by group, as rays test them.
    Packed(Vec<TrianglePacket>),
    /// By vertex: in less than half the memory, to be gathered for every test.
    Indexed(Indexed),
}

/// The vertices of triangles, and the triangles by their numbers.
#[derive(Clone, Debug)]
pub(in crate::mesh) struct Indexed {
    pub groups: Vec<Group>,
    pub positions: Arc<Vec<Vec3>>,
}

/// The numbers of up to eight triangles, in the first lanes.
#[derive(Clone, Copy, Debug)]
pub(in crate::mesh) struct Group([u32; LANES]);

impl Group {
    /// A group of up to eight triangles.
    pub fn new(numbers: impl Iterator<Item = u32>) -> Self {
        let mut group = Self([NONE; LANES]);
        group
            .0
            .iter_mut()
            .zip(numbers)
            .for_each(|(lane, number)| *lane = number);
        group
    }

    pub fn len(&self) -> usize {
        self.0.iter().filter(|&&number| number != NONE).count()
    }

    /// The numbers of the triangles.
    #[inline]
    pub fn numbers(&self) -> impl Iterator<Item = u32> + use<> {
        self.0.into_iter().take_while(|&number| number != NONE)
    }
}

impl Storage {
    /// Triangles in the order of their numbers.
    pub fn indexed(numbers: &[u32], positions: Arc<Vec<Vec3>>) -> Self {
        let groups = numbers.chunks(LANES).map(|chunk| Group::new(chunk.iter().copied()));
        Self::Indexed(Indexed {
            groups: groups.collect(),
            positions,
        })
    }

    pub fn group_count(&self) -> usize {
        match self {
            Self::Packed(packets) => packets.len(),
            Self::Indexed(indexed) => indexed.groups.len(),
        }
    }

    /// The number of triangles in a group.
    #[inline]
    pub fn len_of(&self, group: usize) -> usize {
        match self {
            Self::Packed(packets) => packets[group].len(),
            Self::Indexed(indexed) => indexed.groups[group].len(),
        }
    }

    /// The number of the triangle in a slot.
    #[inline]
    pub fn number(&self, slot: u32) -> u32 {
        let (group, lane) = place(slot);
        match self {
            Self::Packed(packets) => packets[group].number(lane),
            Self::Indexed(indexed) => indexed.groups[group].0[lane],
        }
    }

    /// The corners of the triangle in a slot; `vertices` are those of all triangles, by number.
    #[inline]
    pub fn corners(&self, slot: u32, vertices: &[[u32; 3]]) -> [Vec3A; 3] {
        let (group, lane) = place(slot);
        match self {
            Self::Packed(packets) => packets[group].corners(lane),
            Self::Indexed(indexed) => indexed.corners(indexed.groups[group].0[lane], vertices),
        }
    }

    /// The bytes of memory that it takes.
    pub fn memory(&self) -> usize {
        match self {
            Self::Packed(packets) => packets.capacity() * size_of::<TrianglePacket>(),
            Self::Indexed(Indexed { groups, positions }) => {
                groups.capacity() * size_of::<Group>() + positions.capacity() * size_of::<Vec3>()
            }
        }
    }
}

impl Indexed {
    #[inline(always)]
    fn corners(&self, number: u32, vertices: &[[u32; 3]]) -> [Vec3A; 3] {
        vertices[number as usize].map(|vertex| Vec3A::from(self.positions[vertex as usize]))
    }

    /// The triangles of a group, as rays test them.
    #[inline(always)]
    pub fn gather(&self, group: usize, vertices: &[[u32; 3]]) -> TrianglePacket {
        let numbers = self.groups[group].numbers();
        TrianglePacket::new(numbers.map(|number| (self.corners(number, vertices), number)))
    }
}

#[inline(always)]
fn place(slot: u32) -> (usize, usize) {
    (slot as usize / LANES, slot as usize % LANES)
}
