//! Pushing the faces of a box to the surface around it.

use bevy::math::{DVec3, bounding::Aabb3d};

use super::{clip::Part, solid::Solid};
use crate::geometry::{aabb::Aabb3dExt, rounding, tolerance};

impl Solid {
    /// Pushes the faces of a box that no triangle touches, one after the other, as far as none does, but for a margin;
    /// `None` if nothing is left.
    ///
    /// Space is free between a face and where it goes, so that the box stays inside if it was.
    pub fn push_faces(&self, [mut min, mut max]: [DVec3; 2]) -> Option<Aabb3d> {
        for axis in 0..3 {
            let [below, above] = self.free_run([min, max], axis);
            let margin =
                (above - below) * tolerance::INNER_BOX + 2.0 * self.seam + self.largest * f64::from(f32::EPSILON);
            (min[axis], max[axis]) = (below + margin, above - margin);
            if min[axis] >= max[axis] {
                return None;
            }
        }
        let pushed = Aabb3d {
            min: rounding::up3(min),
            max: rounding::down3(max),
        };
        (pushed.is_sound() && pushed.min.cmplt(pushed.max).all()).then_some(pushed)
    }

    /// How far the box may reach on an axis without touching a triangle.
    fn free_run(&self, [min, max]: [DVec3; 2], axis: usize) -> [f64; 2] {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        let middle = (min[axis] + max[axis]) / 2.0;
        let [mut below, mut above] = [self.min[axis], self.max[axis]];
        let across = |axis: usize| [min[axis] - self.slack, max[axis] + self.slack];
        for &[a, b, c] in &self.triangles {
            let (low, high) = (a.min(b).min(c), a.max(b).max(c));
            let is_beside = |axis: usize| low[axis] > max[axis] + self.slack || high[axis] < min[axis] - self.slack;
            let is_beyond = low[axis] >= above || high[axis] <= below;
            if is_beyond || is_beside(u) || is_beside(v) {
                continue;
            }
            // What of it is in the way is on one side: it does not go through the box.
            let in_the_way = Part::of([a, b, c]).between(u, across(u)).between(v, across(v));
            if let Some([nearest, farthest]) = in_the_way.extent(axis) {
                if nearest > middle {
                    above = above.min(nearest);
                } else {
                    below = below.max(farthest);
                }
            }
        }
        [below, above]
    }
}
