//! The search for boxes in one solid, or in several that are parts of one.

use bevy::math::bounding::Aabb3d;

use super::{
    InnerBoxSettings,
    grid::{CellBox, Enclosed, Grid, GridResolution},
    solid::Solid,
};
use crate::spatial::{
    BuildProgress,
    build::{Cancelled, Stage},
};

/// The fewest and the most cells along the longest side.
const CELLS: [u32; 2] = [4, 128];

/// The cells of some solids, of which boxes are taken.
pub(super) struct Search<'a> {
    sites: Vec<Site<'a>>,
    pub enclosed: Enclosed,
}

/// The cells of one solid.
struct Site<'a> {
    solid: &'a Solid,
    grid: Grid,
    largest: Largest,
}

/// The box that adds most, and how much.
enum Largest {
    /// To be found when it is asked for.
    Unknown,
    Known(Option<(CellBox, f64)>),
}

impl Site<'_> {
    fn largest_box(&mut self) -> Option<(CellBox, f64)> {
        match self.largest {
            Largest::Known(largest) => largest,
            Largest::Unknown => {
                let largest = self.grid.largest_box();
                self.largest = Largest::Known(largest);
                largest
            }
        }
    }
}

impl<'a> Search<'a> {
    /// Finds out what is inside of each of the solids, which are parts of a whole.
    pub fn new(
        solids: &'a [Solid],
        whole: &Solid,
        settings: &InnerBoxSettings,
        progress: Option<&BuildProgress>,
    ) -> Result<Self, Cancelled> {
        let cells = settings.cells.clamp(CELLS[0], CELLS[1]);
        let step = (whole.max - whole.min).max_element() / f64::from(cells);
        let triangles = solids.iter().map(|solid| solid.triangles.len()).sum();
        let touching = Stage::new(progress, 0.1, 0.5, triangles);
        let (mut sites, mut enclosed) = (Vec::new(), Enclosed::default());
        for solid in solids {
            let Some(resolution) = GridResolution::new(solid, step) else {
                continue;
            };
            let mut grid = Grid::new(solid, resolution, &touching)?;
            let in_grid = grid.find_inside(solid);
            enclosed.any |= in_grid.any;
            enclosed.any_inverted |= in_grid.any_inverted;
            sites.push(Site {
                solid,
                grid,
                largest: Largest::Unknown,
            });
        }
        Ok(Self { sites, enclosed })
    }

    /// Takes the box that adds most, again and again, as long as that is worth it.
    pub fn take_boxes(
        &mut self,
        settings: &InnerBoxSettings,
        progress: Option<&BuildProgress>,
    ) -> Result<Vec<Aabb3d>, Cancelled> {
        let growing = Stage::new(progress, 0.5, 1.0, settings.max_boxes);
        let mut boxes = Vec::new();
        let mut covered = 0.0;
        for _ in 0..settings.max_boxes {
            growing.advance(1)?;
            let mut best: Option<(usize, CellBox, f64)> = None;
            for (number, site) in self.sites.iter_mut().enumerate() {
                if let Some((cells, gain)) = site.largest_box()
                    && best.is_none_or(|(.., best)| gain > best)
                {
                    best = Some((number, cells, gain));
                }
            }
            let Some((number, cells, gain)) = best else {
                break;
            };
            if gain < covered * f64::from(settings.least_gain) {
                break;
            }
            covered += gain;
            let Site { solid, grid, largest } = &mut self.sites[number];
            grid.cover(&cells);
            *largest = Largest::Unknown;
            let pushed = solid.push_faces(grid.bounds(&cells));
            if let Some(pushed) = pushed.filter(|pushed| solid.is_clear(pushed)) {
                for site in &mut self.sites {
                    if site.grid.cover_within(&pushed) {
                        site.largest = Largest::Unknown;
                    }
                }
                boxes.push(pushed);
            }
        }
        Ok(boxes)
    }
}
