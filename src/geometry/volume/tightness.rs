//! What a bounding volume is worth.

use super::Volume;
use crate::geometry::convex_hull::ConvexHull;

/// How much larger a bounding volume is than the convex hull of what it bounds: 1 is the best that a convex volume can
/// do.
///
/// Ratios of what is rounded to `f32`. Where the hull has none and the volume has some, as with a box around a
/// slanted flat hull, a ratio is infinite; where neither has any, or both overflow, it is 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tightness {
    /// The ratio of the volumes.
    pub volume: f32,
    /// The ratio of the projected areas, averaged over all directions: how many times more random rays hit the volume
    /// than the hull. By Cauchy's formula it is the ratio of the surface areas.
    pub projected_area: f32,
}

impl Tightness {
    /// The tightness of `volume`, which bounds what `hull` is the hull of, both in one space.
    pub fn of(volume: &impl Volume, hull: &ConvexHull) -> Self {
        Self {
            volume: ratio(volume.volume(), hull.volume()),
            projected_area: ratio(volume.surface_area(), hull.surface_area()),
        }
    }
}

fn ratio(size: f32, hull_size: f32) -> f32 {
    if size == hull_size { 1.0 } else { size / hull_size }
}
