//! The cells of the octree: which there are, and which a box belongs to.
//!
//! Cells are cubes whose side is a power of two, at whole multiples of it from the origin; on the far side of the
//! origin mirrored. So they are the same wherever the first box was, and none depends on another: the bits of a
//! coordinate tell its cell on every level, without rounding, from the smallest `f32` to the largest. Only the cells on
//! both sides of the origin have no such cell in common: what they have is all of space, the cell of level [`ALL`].

use bevy::math::{DVec3, Vec3, Vec3A, bounding::Aabb3d};

use super::super::wide::LANES;
use crate::geometry::rounding;

/// The binary logarithm of the side of a cell.
pub(super) type Level = i16;

/// The cell that is all of space.
pub(super) const ALL: Level = 129;

/// The cells that are one point.
pub(super) const POINT: Level = -150;

/// Where a box belongs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    pub center: Vec3,
    /// The level of the smallest cells that are no smaller than the box on any axis.
    pub size: Level,
}

impl Spot {
    #[inline]
    pub(super) fn of(aabb: &Aabb3d) -> Self {
        let (min, max) = (aabb.min * 0.5, aabb.max * 0.5);
        // The sum with zero turns -0 into 0, which has another sign bit.
        Self {
            center: (min + max + Vec3A::ZERO).into(),
            size: size_level((max - min).max_element()),
        }
    }
}

/// The level of the smallest cells whose side is at least twice this.
#[inline]
fn size_level(half_side: f32) -> Level {
    if half_side == 0.0 {
        return POINT;
    }
    let bits = half_side.to_bits();
    (bits >> 23) as Level - 126 + Level::from(bits & MANTISSA != 0)
}

const MANTISSA: u32 = (1 << 23) - 1;

/// The level of the smallest cell that contains both points.
#[inline]
pub(super) fn common_level(a: Vec3, b: Vec3) -> Level {
    let along = |a: f32, b: f32| {
        let (a, b) = (a.to_bits(), b.to_bits());
        let differing = a ^ b;
        let exponent = ((a.max(b) & (i32::MAX as u32)) >> 23) as Level;
        match differing.leading_zeros() {
            32 => POINT,
            0 => ALL,
            // Their exponents differ: the cell begins at zero.
            1..=8 => exponent - 126,
            zeros => exponent.max(1) - 150 + (32 - zeros as Level),
        }
    };
    along(a.x, b.x).max(along(a.y, b.y)).max(along(a.z, b.z))
}

/// The eighth of the cell of this level that the point is in: one bit for each axis.
#[inline]
fn octant(point: Vec3, level: Level) -> u8 {
    let half = |coordinate: f32| {
        let bits = coordinate.to_bits();
        if level == ALL {
            return (bits >> 31) as u8;
        }
        let exponent = (bits >> 23 & 0xff) as Level;
        let mantissa = (bits & MANTISSA) | u32::from(exponent > 0) << 23;
        let place = level - 1 - (exponent.max(1) - 150);
        if (0..24).contains(&place) {
            (mantissa >> place & 1) as u8
        } else {
            0
        }
    };
    half(point.x) | half(point.y) << 1 | half(point.z) << 2
}

/// A point in each of some cells, the level of the smallest cell that contains all, and the greatest size.
fn combine(mut members: impl Iterator<Item = (Spot, Level)>) -> (Vec3, Level, Level) {
    let (first, level) = members.next().expect("something to contain");
    members.fold(
        (first.center, level, first.size),
        |(point, all, size), (spot, level)| {
            let common = common_level(point, spot.center);
            (point, all.max(level).max(common), size.max(spot.size))
        },
    )
}

/// A lane of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place(u32);

impl Place {
    /// Of a leaf that is in no node at the time.
    pub(super) const NOWHERE: Self = Self(u32::MAX);

    #[inline]
    pub(super) fn new(node: u32, lane: usize) -> Self {
        Self(node * LANES as u32 + lane as u32)
    }

    #[inline]
    pub(super) fn node(self) -> u32 {
        self.0 / LANES as u32
    }

    #[inline]
    pub(super) fn lane(self) -> usize {
        self.0 as usize % LANES
    }
}

/// How the boxes in a node are told apart when there are too many.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// By size, and by octant.
    Cell,
    /// They are all too large for smaller cells: by the octant of the centre alone.
    Crowd,
}

/// What a child of a node is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Branch {
    /// What is in this octant, and fits into smaller cells.
    Octant(u8),
    /// All that fits into smaller cells: there is one where the octants and the rest need nine lanes.
    Small,
    /// What fits into no smaller cell.
    Large,
}

impl Branch {
    /// The number of different branches.
    pub(super) const COUNT: usize = 10;

    /// All branches, by their index.
    pub(super) const ALL: [Self; Self::COUNT] = [
        Self::Octant(0),
        Self::Octant(1),
        Self::Octant(2),
        Self::Octant(3),
        Self::Octant(4),
        Self::Octant(5),
        Self::Octant(6),
        Self::Octant(7),
        Self::Small,
        Self::Large,
    ];

    pub(super) fn index(self) -> usize {
        match self {
            Self::Octant(octant) => octant as usize,
            Self::Small => 8,
            Self::Large => 9,
        }
    }
}

/// What a node is for, and where it is: the part that queries do not need.
#[derive(Clone, Debug)]
pub(super) struct Cell {
    /// Any point of the cell: with the level it tells the bounds.
    pub point: Vec3,
    pub level: Level,
    /// No box in the node has a greater [`Spot::size`], and in a crowd all have this.
    pub size: Level,
    pub kind: Kind,
    /// The lanes below which boxes have changed, and bounds not yet.
    pub stale: u8,
    /// Where the node is; of no meaning for the root.
    pub parent: Place,
    /// The number of boxes below.
    pub count: u32,
    /// What each lane is for; `None` for boxes.
    pub branches: [Option<Branch>; LANES],
}

impl Cell {
    pub(super) fn new(kind: Kind, point: Vec3, level: Level, size: Level) -> Self {
        Self {
            point,
            level,
            size,
            kind,
            stale: 0,
            parent: Place::NOWHERE,
            count: 0,
            branches: [None; LANES],
        }
    }

    /// The smallest cell for boxes like this.
    pub(super) fn around(spot: &Spot) -> Self {
        Self::new(Kind::Cell, spot.center, spot.size, spot.size)
    }

    /// Whether such a box may be in this node.
    #[inline]
    pub(super) fn accepts(&self, spot: &Spot) -> bool {
        let fits = match self.kind {
            Kind::Cell => spot.size <= self.size,
            Kind::Crowd => spot.size == self.size,
        };
        fits && common_level(self.point, spot.center) <= self.level
    }

    /// What a cell around this one must contain.
    pub(super) fn as_member(&self) -> (Spot, Level) {
        let spot = Spot {
            center: self.point,
            size: self.size,
        };
        (spot, self.level)
    }

    /// The smallest cell around some cells and boxes: of the latter, the level is [`POINT`].
    pub(super) fn containing(members: impl Iterator<Item = (Spot, Level)>) -> Self {
        let (point, level, size) = combine(members);
        Self::new(Kind::Cell, point, level.max(size), level.max(size))
    }

    /// The smallest cell for a child of this one that is to hold all of a branch.
    pub(super) fn child(&self, branch: Branch, members: impl Iterator<Item = (Spot, Level)>) -> Self {
        match (self.kind, branch) {
            (Kind::Cell, Branch::Octant(_)) => Self::containing(members),
            (Kind::Cell, Branch::Small) => Self::new(Kind::Cell, self.point, self.level, self.level - 1),
            (Kind::Cell, Branch::Large) | (Kind::Crowd, _) => {
                let (point, level, _) = combine(members);
                Self::new(Kind::Crowd, point, level, self.size)
            }
        }
    }

    /// The lane of the child for a branch.
    #[inline]
    pub(super) fn lane_of(&self, branch: Branch) -> Option<usize> {
        self.branches.iter().position(|&b| b == Some(branch))
    }

    /// The branch for a box that this node accepts.
    #[inline]
    pub(super) fn branch(&self, spot: &Spot) -> Branch {
        match self.kind {
            Kind::Cell if spot.size == self.level => Branch::Large,
            Kind::Cell if self.lane_of(Branch::Small).is_some() => Branch::Small,
            _ => Branch::Octant(octant(spot.center, self.level)),
        }
    }

    /// The branch for a node within this one.
    pub(super) fn branch_of_child(&self, child: &Cell) -> Branch {
        match self.kind {
            Kind::Cell if child.kind == Kind::Crowd && child.size == self.level => Branch::Large,
            Kind::Cell if child.level == self.level => Branch::Small,
            _ => Branch::Octant(octant(child.point, self.level)),
        }
    }

    /// The cell as a box, closed; of the greatest cells, the part that has finite coordinates.
    pub(super) fn bounds(&self) -> Aabb3d {
        if self.level == POINT {
            return Aabb3d {
                min: self.point.into(),
                max: self.point.into(),
            };
        }
        let side = 2f64.powi(self.level.into());
        let near = (self.point.abs().as_dvec3() / side).floor() * side;
        let (near, far) = (near, near + DVec3::splat(side));
        let is_mirrored = Vec3A::from(self.point).is_negative_bitmask();
        let (mut min, mut max) = (near, far);
        for axis in (0..3).filter(|axis| is_mirrored >> axis & 1 == 1) {
            (min[axis], max[axis]) = (-far[axis], -near[axis]);
        }
        let largest = Vec3A::splat(f32::MAX);
        Aabb3d {
            min: rounding::down3(min).max(-largest),
            max: rounding::up3(max).min(largest),
        }
    }
}
