//! The box of inner cells that adds most.
//!
//! For every run of layers, the cells that are inside in all of them are a picture, and the boxes are the rectangles in
//! it. Only those matter that cannot be widened, and all of them are found in the time that it takes to look at each
//! cell of the picture, by a stack of heights (Vandevoorde, *The Maximal Rectangle Problem*, Dr. Dobb's Journal, 1998).
//! With n cells along each side, that is O(n⁴).

use super::grid::{Cell, CellBox, Grid};

impl Grid {
    /// The box of inner cells with the most surface, in the part of its volume that is not covered, and how much that
    /// is. `None` if all is covered.
    ///
    /// A quarter of the surface of a box is its shadow, averaged over all directions: what it hides.
    pub fn largest_box(&self) -> Option<(CellBox, f64)> {
        // The axis with the fewest layers last, of which there are the most runs.
        let mut axes = [0, 1, 2];
        axes.sort_by_key(|&axis| std::cmp::Reverse(self.len(axis)));
        let [u, v, w] = axes;
        let uncovered = Volumes::uncovered(self);
        let mut largest: Option<(CellBox, f64)> = None;
        let mut picture = Picture::new(self.len(u), self.len(v));
        for first in 0..self.len(w) {
            picture.cells.fill(true);
            for last in first..self.len(w) {
                picture.keep(|place_u, place_v| {
                    let mut place = [0; 3];
                    (place[u], place[v], place[w]) = (place_u, place_v, last);
                    matches!(self.cell(place), Cell::Inside | Cell::Covered)
                });
                if picture.is_empty() {
                    break;
                }
                let depth = self.length(w, first, last + 1);
                picture.visit_rectangles(|[u_from, u_to], [v_from, v_to]| {
                    let (width, height) = (self.length(u, u_from, u_to), self.length(v, v_from, v_to));
                    let surface = 2.0 * (width * height + depth * (width + height));
                    let best = largest.map_or(0.0, |(_, best)| best);
                    if surface <= best {
                        return;
                    }
                    let (mut min, mut max) = ([0; 3], [0; 3]);
                    (min[u], min[v], min[w]) = (u_from, v_from, first);
                    (max[u], max[v], max[w]) = (u_to, v_to, last + 1);
                    let cells = CellBox { min, max };
                    let gain = surface * uncovered.of(&cells) / (width * height * depth);
                    // What is left of sums and differences is no volume.
                    if gain > best && gain > 1e-9 * surface {
                        largest = Some((cells, gain));
                    }
                });
            }
        }
        largest
    }
}

/// The volume of uncovered cells in any box, from eight sums.
struct Volumes {
    /// Of the cells before a place on all axes.
    sums: Vec<f64>,
    strides: [usize; 2],
}

impl Volumes {
    fn uncovered(grid: &Grid) -> Self {
        let [x_end, y_end, z_end] = [0, 1, 2].map(|axis| grid.len(axis) + 1);
        let strides = [y_end * z_end, z_end];
        let mut sums = vec![0.0; x_end * y_end * z_end];
        for x in 1..x_end {
            for y in 1..y_end {
                let mut in_row = 0.0;
                for z in 1..z_end {
                    if grid.cell([x - 1, y - 1, z - 1]) == Cell::Inside {
                        in_row += grid.length(0, x - 1, x) * grid.length(1, y - 1, y) * grid.length(2, z - 1, z);
                    }
                    let at = x * strides[0] + y * strides[1] + z;
                    let before = sums[at - strides[0]] + sums[at - strides[1]] - sums[at - strides[0] - strides[1]];
                    sums[at] = before + in_row;
                }
            }
        }
        Self { sums, strides }
    }

    fn of(&self, cells: &CellBox) -> f64 {
        let sum = |x: usize, y: usize, z: usize| self.sums[x * self.strides[0] + y * self.strides[1] + z];
        let ([x0, y0, z0], [x1, y1, z1]) = (cells.min, cells.max);
        let before = |z: usize| sum(x1, y1, z) - sum(x0, y1, z) - sum(x1, y0, z) + sum(x0, y0, z);
        before(z1) - before(z0)
    }
}

/// A picture in black and white.
struct Picture {
    width: usize,
    /// Row by row.
    cells: Vec<bool>,
    /// How many cells in a row are white above each cell of a row, with that; and zero at the end.
    heights: Vec<usize>,
    /// Where rectangles begin that may go on, with their heights, which rise.
    open: Vec<(usize, usize)>,
}

impl Picture {
    fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            cells: vec![true; width * height],
            heights: vec![0; width + 1],
            open: Vec::new(),
        }
    }

    /// Blackens the cells that are not to be kept.
    fn keep(&mut self, mut is_kept: impl FnMut(usize, usize) -> bool) {
        for (row, cells) in self.cells.chunks_mut(self.width).enumerate() {
            for (column, cell) in cells.iter_mut().enumerate() {
                *cell = *cell && is_kept(column, row);
            }
        }
    }

    fn is_empty(&self) -> bool {
        !self.cells.contains(&true)
    }

    /// Visits the columns and rows of rectangles of white cells, from and to; among them all that cannot be widened.
    fn visit_rectangles(&mut self, mut visit: impl FnMut([usize; 2], [usize; 2])) {
        self.heights.fill(0);
        for (row, cells) in self.cells.chunks(self.width).enumerate() {
            for (height, &cell) in self.heights.iter_mut().zip(cells) {
                *height = if cell { *height + 1 } else { 0 };
            }
            for (column, &height) in self.heights.iter().enumerate() {
                let mut start = column;
                while let Some(&(begin, open_height)) = self.open.last()
                    && open_height > height
                {
                    self.open.pop();
                    visit([begin, column], [row + 1 - open_height, row + 1]);
                    start = begin;
                }
                if height > self.open.last().map_or(0, |&(_, open_height)| open_height) {
                    self.open.push((start, height));
                }
            }
        }
    }
}
