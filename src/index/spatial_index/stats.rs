//! The index in figures.

use bevy::reflect::Reflect;

use super::{Entry, SpatialIndex, Tenant};
use crate::{
    index::surface::PlacedSurface,
    spatial::{SpatialQueries, UniformGrid},
};

/// How large the index is and how good, as of now; see [`SpatialIndex::stats`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[non_exhaustive]
pub struct SpatialIndexStats {
    /// The entities in the index.
    pub entities: usize,
    /// The entities that are left out because of bad data.
    pub refused: usize,
    /// The nodes of the tree.
    pub nodes: usize,
    /// The number of nodes on the longest way from the root to a leaf.
    pub depth: usize,
    /// The number of boxes that a random ray through the bounds is expected to meet: see
    /// [`AabbTree::sah_cost`](crate::spatial::AabbTree::sah_cost).
    pub sah_cost: f32,
    /// The bytes that the tree has allocated.
    pub tree_memory: usize,
    /// The bytes that the grid has allocated; zero if none is kept.
    pub grid_memory: usize,
    /// The length of the edges of the smallest cells of the grid, if one is kept.
    pub cell_size: Option<f32>,
    /// The bytes of what is known of each entity besides, without the meshes.
    pub table_memory: usize,
}

impl SpatialIndex {
    /// Counts and measures the index, in O(n).
    pub fn stats(&self) -> SpatialIndexStats {
        let mut nodes = 0;
        self.tree.visit_nodes(|_, _| nodes += 1);
        SpatialIndexStats {
            entities: self.len(),
            refused: self.refused.len(),
            nodes,
            depth: self.tree.depth(),
            sah_cost: self.tree.sah_cost(),
            tree_memory: self.tree.memory(),
            grid_memory: self.grid.as_ref().map_or(0, SpatialQueries::memory),
            cell_size: self.grid.as_ref().map(UniformGrid::cell_size),
            table_memory: (self.slot_of.capacity() + self.free_slots.capacity()) * size_of::<u32>()
                + self.tenants.capacity() * size_of::<Tenant>()
                + self.entries.capacity() * size_of::<Entry>()
                + self.surfaces.capacity() * size_of::<Option<PlacedSurface>>(),
        }
    }
}
