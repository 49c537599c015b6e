//! What must hold between any two frames.

use super::{Key, SpatialIndex, Tenant};
use crate::spatial::{SpatialQueries, SpatialUpdates, UniformGrid, aabb_tree, uniform_grid};

/// An invariant of the index that does not hold: a bug in this crate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BrokenIndex {
    /// The tree is not whole.
    #[error(transparent)]
    Tree(#[from] aabb_tree::BrokenInvariant),
    /// The grid is not whole.
    #[error(transparent)]
    Grid(#[from] uniform_grid::BrokenInvariant),
    /// A structure does not hold what is indexed, or holds something else.
    #[error("the index and its structures do not hold the same entities at the same places")]
    Lost,
}

impl SpatialIndex {
    /// Checks that the structures are whole, and hold the indexed entities and no others, in O(n log n).
    ///
    /// # Errors
    ///
    /// The first invariant that does not hold, which is a bug in this crate.
    pub fn validate(&self) -> Result<(), BrokenIndex> {
        self.tree.validate()?;
        self.grid.as_ref().map_or(Ok(()), UniformGrid::validate)?;
        let tenants = self.tenants.iter().zip(0..).filter(|(tenant, _)| !tenant.is_gone());
        let mut live = 0;
        for (
            &Tenant {
                entity, leaf, in_grid, ..
            },
            slot,
        ) in tenants
        {
            live += 1;
            let key = Some(Key { entity, slot });
            let agrees = match (&self.grid, in_grid) {
                (Some(grid), Some(leaf_in_grid)) => {
                    grid.key(leaf_in_grid) == key && grid.aabb(leaf_in_grid) == self.tree.aabb(leaf)
                }
                (grid, in_grid) => grid.is_none() && in_grid.is_none(),
            };
            if self.slot(entity) != Some(slot) || self.tree.key(leaf) != key || !agrees {
                return Err(BrokenIndex::Lost);
            }
        }
        let none_lost = live + self.free_slots.len() == self.tenants.len();
        let none_else = live == self.tree.len() && self.grid.as_ref().is_none_or(|grid| live == grid.len());
        if none_lost && none_else {
            Ok(())
        } else {
            Err(BrokenIndex::Lost)
        }
    }
}
