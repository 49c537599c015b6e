//! The box of a mesh, cut into cells: which a triangle touches, which are inside.

use bevy::math::{DVec3, bounding::Aabb3d};

use super::{clip::Part, solid::Solid};
use crate::{
    geometry::tolerance,
    spatial::build::{Cancelled, Stage},
};

/// The fewest cells along a side.
const LEAST_CELLS: f64 = 8.0;
/// The most flat parts of the surface at which each axis is cut.
const MOST_FLATS: usize = 12;
/// How large a flat part must be, as a fraction of the section of the box that it is parallel to.
const LEAST_FLAT: f64 = 1.0 / 256.0;
/// The thickness of the cells in which flat parts lie, as a fraction of the side of the mesh.
const FLAT_CELL: f64 = 1.0 / 8192.0;
/// The connected regions that are looked at: the largest. What is in another is too small for a box that matters.
const MOST_REGIONS: usize = 256;
/// After so many triangles the search can be called off.
const STEP: usize = 1024;

/// Where the box of a mesh is cut, on each axis in rising order.
pub(super) struct GridResolution([Vec<f64>; 3]);

impl GridResolution {
    /// Cells of a side of about `step`, or less where there were few of them. `None` if the box is flat.
    pub fn new(solid: &Solid, step: f64) -> Option<Self> {
        let size = solid.max - solid.min;
        if size.min_element() <= 8.0 * solid.largest * f64::from(f32::EPSILON) {
            return None;
        }
        let cuts_on = |axis: usize| {
            let step = step.min(size[axis] / LEAST_CELLS);
            cuts([solid.min[axis], solid.max[axis]], step, &flats(solid, axis))
        };
        Some(Self([0, 1, 2].map(cuts_on)))
    }
}

/// The coordinates of the largest parts of the surface that are at right angles to an axis, in rising order.
fn flats(solid: &Solid, axis: usize) -> Vec<f64> {
    let mut flats: Vec<(f64, f64)> = Vec::new();
    let thickness = 2.0 * solid.largest * tolerance::SEAM;
    for &[a, b, c] in &solid.triangles {
        let (min, max) = (a.min(b).min(c)[axis], a.max(b).max(c)[axis]);
        if max - min <= thickness {
            flats.push(((min + max) / 2.0, (b - a).cross(c - a)[axis].abs() / 2.0));
        }
    }
    flats.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    // Those that are in one cell count as one, at the middle.
    let size = solid.max - solid.min;
    let width = size[axis] * FLAT_CELL;
    let mut merged: Vec<([f64; 2], f64)> = Vec::new();
    for (place, area) in flats {
        match merged.last_mut() {
            Some(([first, last], sum)) if place - *first < width / 2.0 => (*last, *sum) = (place, *sum + area),
            _ => merged.push(([place; 2], area)),
        }
    }
    let section = size[(axis + 1) % 3] * size[(axis + 2) % 3];
    merged.retain(|&(_, area)| area >= section * LEAST_FLAT);
    merged.sort_by(|a, b| b.1.total_cmp(&a.1));
    merged.truncate(MOST_FLATS);
    let mut places: Vec<f64> = merged
        .into_iter()
        .map(|([first, last], _)| (first + last) / 2.0)
        .collect();
    places.sort_unstable_by(f64::total_cmp);
    places
}

/// Cuts between two ends: on both sides of each flat, and of what is between them into parts of about `step`.
fn cuts([min, max]: [f64; 2], step: f64, flats: &[f64]) -> Vec<f64> {
    let half = (max - min) * FLAT_CELL / 2.0;
    let mut cuts = vec![min];
    let cut_up_to = |end: f64, cuts: &mut Vec<f64>| {
        let start = cuts[cuts.len() - 1];
        let parts = ((end - start) / step).round().max(1.0);
        for part in 1..parts as usize {
            cuts.push(start + (end - start) * part as f64 / parts);
        }
        cuts.push(end);
    };
    for &flat in flats {
        let (below, above) = (flat - half, flat + half);
        if below > cuts[cuts.len() - 1] {
            cut_up_to(below, &mut cuts);
        }
        if above < max && above > cuts[cuts.len() - 1] {
            cuts.push(above);
        }
    }
    cut_up_to(max, &mut cuts);
    cuts
}

/// What is known of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cell {
    /// Not touched by any triangle, and not inside as far as is known.
    Outside,
    /// Touched by a triangle.
    Surface,
    Inside,
    /// Inside, and in a box that was taken.
    Covered,
}

/// Cells from one corner up to, but not including, another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct CellBox {
    pub min: [usize; 3],
    pub max: [usize; 3],
}

/// What triangles go around.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Enclosed {
    /// There are cells inside.
    pub any: bool,
    /// There are cells around which triangles wind clockwise.
    pub any_inverted: bool,
}

/// The cells.
#[derive(Debug)]
pub(super) struct Grid {
    cuts: [Vec<f64>; 3],
    cells: Vec<Cell>,
}

impl Grid {
    /// Finds the cells that triangles touch.
    pub fn new(solid: &Solid, GridResolution(cuts): GridResolution, stage: &Stage) -> Result<Self, Cancelled> {
        let count = cuts.iter().map(|cuts| cuts.len() - 1).product();
        let mut grid = Self {
            cuts,
            cells: vec![Cell::Outside; count],
        };
        for triangles in solid.triangles.chunks(STEP) {
            for &corners in triangles {
                grid.touch(&Part::of(corners), 0, 0, solid.slack);
            }
            stage.advance(triangles.len())?;
        }
        Ok(grid)
    }

    /// Marks the cells that a part of a triangle touches, of those in row `row` of the axes before `axis`.
    fn touch(&mut self, part: &Part, axis: usize, row: usize, slack: f64) {
        let Some([min, max]) = part.extent(axis) else {
            return;
        };
        let cuts = &self.cuts[axis];
        let cells = cuts.len() - 1;
        let first = cuts[1..cells].partition_point(|&cut| cut < min - slack);
        let last = cuts[1..cells].partition_point(|&cut| cut <= max + slack);
        let row = row * cells;
        if axis == 2 {
            self.cells[row + first..=row + last].fill(Cell::Surface);
        } else if first == last {
            self.touch(part, axis + 1, row + first, slack);
        } else {
            for cell in first..=last {
                let cuts = &self.cuts[axis];
                let within = part.between(axis, [cuts[cell] - slack, cuts[cell + 1] + slack]);
                self.touch(&within, axis + 1, row + cell, slack);
            }
        }
    }

    /// Finds the cells that are inside: all of a connected region, or none, for no triangle goes through it.
    pub fn find_inside(&mut self, solid: &Solid) -> Enclosed {
        let mut is_known: Vec<bool> = self.cells.iter().map(|&cell| cell == Cell::Surface).collect();
        let mut regions = Vec::new();
        for cell in 0..self.cells.len() {
            if !is_known[cell] {
                regions.push(self.region(cell, &mut is_known));
            }
        }
        regions.sort_by_key(|region| std::cmp::Reverse(region.len()));
        let mut enclosed = Enclosed::default();
        for region in regions.into_iter().take(MOST_REGIONS) {
            let winding = solid.winding_number(self.center(region[0]));
            enclosed.any_inverted |= winding < 0;
            if winding > 0 {
                enclosed.any = true;
                for cell in region {
                    self.cells[cell] = Cell::Inside;
                }
            }
        }
        enclosed
    }

    /// The cells that are connected with one, by their sides.
    fn region(&self, first: usize, is_known: &mut [bool]) -> Vec<usize> {
        let mut region = vec![first];
        is_known[first] = true;
        let mut next = 0;
        while let Some(&cell) = region.get(next) {
            next += 1;
            for (axis, place) in self.place(cell).into_iter().enumerate() {
                let stride = self.stride(axis);
                let below = (place > 0).then(|| cell - stride);
                let above = (place + 1 < self.len(axis)).then(|| cell + stride);
                for neighbour in below.into_iter().chain(above) {
                    if !std::mem::replace(&mut is_known[neighbour], true) {
                        region.push(neighbour);
                    }
                }
            }
        }
        region
    }

    /// Notes that a box was taken; returns whether any of its cells was inside and not covered yet.
    pub fn cover(&mut self, cells: &CellBox) -> bool {
        let mut any = false;
        for x in cells.min[0]..cells.max[0] {
            for y in cells.min[1]..cells.max[1] {
                for z in cells.min[2]..cells.max[2] {
                    let cell = self.number([x, y, z]);
                    if self.cells[cell] == Cell::Inside {
                        self.cells[cell] = Cell::Covered;
                        any = true;
                    }
                }
            }
        }
        any
    }

    /// The same for the cells whose centres lie in a box.
    pub fn cover_within(&mut self, taken: &Aabb3d) -> bool {
        let cells_before = |axis: usize, bound: f32| {
            let cuts = &self.cuts[axis];
            let middles = (1..cuts.len()).map(|end| (cuts[end - 1] + cuts[end]) / 2.0);
            middles.take_while(|&middle| middle < f64::from(bound)).count()
        };
        let cells = CellBox {
            min: [0, 1, 2].map(|axis| cells_before(axis, taken.min[axis])),
            max: [0, 1, 2].map(|axis| cells_before(axis, taken.max[axis])),
        };
        self.cover(&cells)
    }

    /// The corners of a box of cells.
    pub fn bounds(&self, cells: &CellBox) -> [DVec3; 2] {
        [cells.min, cells.max].map(|corner| DVec3::from_array([0, 1, 2].map(|axis| self.cuts[axis][corner[axis]])))
    }

    pub fn cell(&self, place: [usize; 3]) -> Cell {
        self.cells[self.number(place)]
    }

    /// The number of cells along an axis.
    pub fn len(&self, axis: usize) -> usize {
        self.cuts[axis].len() - 1
    }

    /// The length of a run of cells along an axis.
    pub fn length(&self, axis: usize, from: usize, to: usize) -> f64 {
        self.cuts[axis][to] - self.cuts[axis][from]
    }

    fn center(&self, cell: usize) -> DVec3 {
        let place = self.place(cell);
        let middle = |axis: usize| (self.cuts[axis][place[axis]] + self.cuts[axis][place[axis] + 1]) / 2.0;
        DVec3::from_array([0, 1, 2].map(middle))
    }

    fn stride(&self, axis: usize) -> usize {
        (axis + 1..3).map(|axis| self.len(axis)).product()
    }

    fn number(&self, [x, y, z]: [usize; 3]) -> usize {
        (x * self.len(1) + y) * self.len(2) + z
    }

    fn place(&self, cell: usize) -> [usize; 3] {
        let (row, z) = (cell / self.len(2), cell % self.len(2));
        [row / self.len(1), row % self.len(1), z]
    }
}
