//! Cells and bricks of cells: where in the grid a point is.

use bevy::math::{IVec3, Vec3A, bounding::Aabb3d};

/// The cells of a brick along one axis, as a power of two.
const BRICK_BITS: i32 = 2;

/// The cells of a brick along one axis: 64 in all, a bit of a `u64` each.
pub(super) const BRICK_CELLS: i32 = 1 << BRICK_BITS;

/// No leaf is in a cell with a coordinate beyond this, up to rounding.
///
/// Coordinates of bricks then fit into 21 bits each, and all three into one key.
pub(super) const FARTHEST_CELL: f32 = (1 << 21) as f32;

/// The cells of one level, without end in all directions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lattice {
    /// The length of the edges of a cell.
    pub cell: f32,
    recip: f32,
}

impl Lattice {
    pub fn new(cell: f32) -> Self {
        Self {
            cell,
            recip: cell.recip(),
        }
    }

    /// The cell that a point is in. Monotone on each axis, which is all that correctness rests on: where exactly a cell
    /// ends, rounding decides.
    #[inline(always)]
    pub fn cell_at(&self, point: Vec3A) -> IVec3 {
        let [x, y, z] = (point * self.recip).to_array();
        IVec3::new(floor(x), floor(y), floor(z))
    }

    /// The coordinate, along one axis, of the cell that a point is in.
    #[inline(always)]
    pub fn coordinate_at(&self, position: f64) -> i32 {
        floor(position as f32 * self.recip)
    }

    /// The cells in which the centres of boxes may be that have a point between `min` and `max`, if no box reaches
    /// farther than `reach` from its centre.
    #[inline(always)]
    pub fn reaching(&self, min: Vec3A, max: Vec3A, reach: Vec3A) -> CellRange {
        // Rounded to nearest, a bound never passes a centre that the exact one does not pass. An infinite minus an
        // infinite one excludes nothing.
        let (min, max) = (
            (min - reach).max(Vec3A::NEG_INFINITY),
            (max + reach).min(Vec3A::INFINITY),
        );
        CellRange {
            min: self.cell_at(min),
            max: self.cell_at(max),
        }
    }

    /// The nominal cube of a cell.
    pub fn cube(&self, cell: IVec3) -> Aabb3d {
        let min = cell.as_vec3a() * self.cell;
        Aabb3d {
            min,
            max: min + Vec3A::splat(self.cell),
        }
    }
}

/// The greatest integer that is not greater. Saturates; zero for NaN.
#[inline(always)]
fn floor(x: f32) -> i32 {
    let toward_zero = x as i32;
    toward_zero.saturating_sub(i32::from(x < toward_zero as f32))
}

/// The brick that a cell is in.
#[inline(always)]
pub(super) fn brick_of(cell: IVec3) -> IVec3 {
    IVec3::new(cell.x >> BRICK_BITS, cell.y >> BRICK_BITS, cell.z >> BRICK_BITS)
}

/// The number of a cell within its brick.
#[inline(always)]
pub(super) fn bit_of(cell: IVec3) -> u32 {
    let [x, y, z] = cell.to_array().map(|x| (x & (BRICK_CELLS - 1)) as u32);
    x | y << BRICK_BITS | z << (2 * BRICK_BITS)
}

/// The cell with this number in a brick.
#[inline]
pub(super) fn cell_of(brick: IVec3, bit: u32) -> IVec3 {
    let within = [bit, bit >> BRICK_BITS, bit >> (2 * BRICK_BITS)].map(|x| x as i32 & (BRICK_CELLS - 1));
    brick * BRICK_CELLS + IVec3::from_array(within)
}

/// The cells from one corner to the opposite one, both included; none if out of order on an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct CellRange {
    pub min: IVec3,
    pub max: IVec3,
}

impl CellRange {
    pub const EMPTY: Self = Self {
        min: IVec3::MAX,
        max: IVec3::MIN,
    };

    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    #[inline(always)]
    pub fn contains(&self, cell: IVec3) -> bool {
        cell.cmpge(self.min).all() && cell.cmple(self.max).all()
    }

    #[inline(always)]
    pub fn clipped(&self, to: &Self) -> Self {
        Self {
            min: self.min.max(to.min),
            max: self.max.min(to.max),
        }
    }

    #[inline(always)]
    pub fn is_within(&self, other: &Self) -> bool {
        self.min.cmpge(other.min).all() && self.max.cmple(other.max).all()
    }

    /// With both corners in `to`, as close to where they are as possible.
    #[inline(always)]
    pub fn moved_into(&self, to: &Self) -> Self {
        Self {
            min: self.min.max(to.min).min(to.max),
            max: self.max.max(to.min).min(to.max),
        }
    }

    #[inline(always)]
    pub fn grown(&self, cells: i32) -> Self {
        let cells = IVec3::splat(cells);
        Self {
            min: self.min.saturating_sub(cells),
            max: self.max.saturating_add(cells),
        }
    }

    /// The smallest range around both.
    #[inline(always)]
    pub fn joined(&self, other: &Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    #[inline(always)]
    pub fn with(&self, cell: IVec3) -> Self {
        Self {
            min: self.min.min(cell),
            max: self.max.max(cell),
        }
    }

    /// The bricks that the cells are in.
    #[inline(always)]
    pub fn bricks(&self) -> Self {
        Self {
            min: brick_of(self.min),
            max: brick_of(self.max),
        }
    }

    /// The number of cells or bricks, of ranges of leaves.
    #[inline(always)]
    pub fn count(&self) -> u64 {
        if self.is_empty() {
            return 0;
        }
        let [x, y, z] = (self.max - self.min).to_array().map(|size| size as u64 + 1);
        (x * y).saturating_mul(z)
    }

    /// The cells of a brick that are in the range, bit by bit.
    #[inline(always)]
    pub fn bits_in(&self, brick: IVec3) -> u64 {
        let first = brick * BRICK_CELLS;
        let (min, max) = (self.min.saturating_sub(first), self.max.saturating_sub(first));
        let axis = |axis: usize| bits_between(min[axis], max[axis]);
        along_x(axis(0)) & along_y(axis(1)) & along_z(axis(2))
    }
}

/// The bits from `min` to `max`, of four.
#[inline(always)]
fn bits_between(min: i32, max: i32) -> usize {
    let (min, max) = (min.clamp(0, BRICK_CELLS), max.clamp(-1, BRICK_CELLS - 1));
    // The bits below the end, without those below the start.
    ((1 << (max + 1)) - 1) & !((1 << min) - 1)
}

/// The cells of a brick whose place along the axis is among the four bits.
#[inline(always)]
fn along_x(bits: usize) -> u64 {
    bits as u64 * 0x1111_1111_1111_1111
}

#[inline(always)]
fn along_y(bits: usize) -> u64 {
    const ROWS: [u64; 16] = spread(4);
    ROWS[bits] * 0x0001_0001_0001_0001
}

#[inline(always)]
fn along_z(bits: usize) -> u64 {
    const SLICES: [u64; 16] = spread(16);
    SLICES[bits]
}

/// Every number of four bits, with each bit repeated.
const fn spread(times: u32) -> [u64; 16] {
    let mut spread = [0; 16];
    let mut bits = 0;
    while bits < 16 {
        let mut bit = 0;
        while bit < 4 {
            if bits >> bit & 1 == 1 {
                spread[bits] |= ((1 << times) - 1) << (times * bit);
            }
            bit += 1;
        }
        bits += 1;
    }
    spread
}

/// The smallest power of two that is not below `x`, which must be positive, normal, and not above 2¹²⁶.
pub(super) fn power_of_two_from(x: f32) -> f32 {
    f32::from_bits((x.to_bits() + ((1 << 23) - 1)) & !((1 << 23) - 1))
}
