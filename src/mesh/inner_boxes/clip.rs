//! What of a triangle lies between planes that are parallel to the axes.

use bevy::math::DVec3;
use smallvec::{SmallVec, smallvec};

/// A part of a triangle: convex, up to rounding.
///
/// Sutherland and Hodgman, *Reentrant Polygon Clipping*, 1974. Each cut moves a corner by a few roundings of the
/// largest coordinate at most, so that whoever cuts at planes that lie further out by that loses no point.
#[derive(Clone, Debug)]
pub(super) struct Part(SmallVec<[DVec3; 10]>);

impl Part {
    pub fn of([a, b, c]: [DVec3; 3]) -> Self {
        Self(smallvec![a, b, c])
    }

    /// The least and the largest coordinate on an axis, unless nothing is left.
    pub fn extent(&self, axis: usize) -> Option<[f64; 2]> {
        let mut all = self.0.iter().map(|corner| corner[axis]);
        let first = all.next()?;
        Some(all.fold([first; 2], |[min, max], value| [min.min(value), max.max(value)]))
    }

    /// What lies between two coordinates on an axis.
    pub fn between(&self, axis: usize, [min, max]: [f64; 2]) -> Self {
        self.beyond(axis, min, 1.0).beyond(axis, max, -1.0)
    }

    /// What lies on one side of a plane.
    fn beyond(&self, axis: usize, bound: f64, side: f64) -> Self {
        let depth = |corner: DVec3| side * (corner[axis] - bound);
        let mut kept = SmallVec::new();
        let Some(&(mut from)) = self.0.last() else {
            return Self(kept);
        };
        for &to in &self.0 {
            let (before, after) = (depth(from), depth(to));
            if (before >= 0.0) != (after >= 0.0) {
                let mut crossing = from + (to - from) * (before / (before - after));
                crossing[axis] = bound;
                kept.push(crossing);
            }
            if after >= 0.0 {
                kept.push(to);
            }
            from = to;
        }
        Self(kept)
    }
}
