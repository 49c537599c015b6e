//! The cells themselves, for those who think in cells.

use std::ops::ControlFlow;

use bevy::math::{IVec3, bounding::Aabb3d};

use super::{
    UniformGrid,
    lattice::{CellRange, bit_of, brick_of, cell_of},
    level::{Level, bits},
};
use crate::spatial::LeafId;

/// A cell of one level of a [`UniformGrid`]. Means something until the grid chooses its cell size anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Cell {
    level: u8,
    coordinates: IVec3,
}

impl Cell {
    /// How many levels are finer.
    pub fn level(&self) -> u32 {
        self.level.into()
    }

    /// How many cells of its level are between this one and the origin, axis by axis.
    pub fn coordinates(&self) -> IVec3 {
        self.coordinates
    }
}

impl<K: Copy> UniformGrid<K> {
    /// Visits every cell that holds leaves, with its cube and the number of its leaves, in no promised order.
    pub fn visit_cells(&self, mut visit: impl FnMut(Cell, &Aabb3d, usize)) {
        self.visit_cells_among(
            |_| CellRange {
                min: IVec3::MIN,
                max: IVec3::MAX,
            },
            |cell, cube, len| {
                visit(cell, cube, len);
                ControlFlow::Continue(())
            },
        );
    }

    /// Visits the cells that hold leaves and whose cubes touch `region`, with the cube and the number of leaves, in no
    /// promised order.
    ///
    /// Leaves are in the cell that their centre is in: boxes that touch the region may be in other cells. Cubes are right
    /// up to rounding.
    pub fn cells_in_box(&self, region: &Aabb3d, visit: impl FnMut(Cell, &Aabb3d, usize) -> ControlFlow<()>) {
        self.visit_cells_among(
            |level| CellRange {
                min: level.lattice.cell_at(region.min),
                max: level.lattice.cell_at(region.max),
            },
            visit,
        );
    }

    fn visit_cells_among(
        &self,
        range: impl Fn(&Level) -> CellRange,
        mut visit: impl FnMut(Cell, &Aabb3d, usize) -> ControlFlow<()>,
    ) {
        for (number, level) in (0..).zip(&self.levels).filter(|(_, level)| level.len > 0) {
            for (brick, cells) in level.bricks_in(&range(level).clipped(&level.cells)) {
                for bit in bits(cells) {
                    let cell = Cell {
                        level: number,
                        coordinates: cell_of(brick.coordinates, bit),
                    };
                    let chain = self.buckets.chain(brick.heads[bit as usize]);
                    let len = chain.map(|bucket| bucket.len as usize).sum();
                    if visit(cell, &level.lattice.cube(cell.coordinates), len).is_break() {
                        return;
                    }
                }
            }
        }
    }

    /// The keys of the leaves whose centres are in a cell, in no promised order.
    pub fn keys_in_cell(&self, cell: Cell) -> impl Iterator<Item = K> {
        let level = self.levels.get(cell.level as usize);
        let head = level.and_then(|level| {
            // Elsewhere there are no leaves, and coordinates do not fit into the table.
            let cell = level.cells.contains(cell.coordinates).then_some(cell.coordinates)?;
            let brick = level.table.find(brick_of(cell))?;
            Some(level.bricks[brick as usize].heads[bit_of(cell) as usize])
        });
        let chain = head.into_iter().flat_map(|head| self.buckets.chain(head));
        chain.flat_map(|bucket| bucket.keys.iter().take(bucket.len.into()).copied())
    }

    /// The cell that a leaf is in, or `None` if there is no such leaf.
    pub fn cell_of_leaf(&self, id: LeafId) -> Option<Cell> {
        let bucket = self.buckets.get(self.leaves.place(id).ok()?.bucket());
        Some(Cell {
            level: bucket.level,
            coordinates: self.levels[bucket.level as usize].cell_in(bucket.slot),
        })
    }
}
