//! Whether a triangle is in a region, as it is seen on the screen.

use bevy::math::{DVec2, DVec4, Vec3A};
use smallvec::SmallVec;

use super::view::{PlacedView, place};

/// A triangle that six planes have clipped.
type Clipped = SmallVec<[DVec4; 9]>;

impl PlacedView<'_> {
    /// Whether a triangle touches the region.
    pub fn triangle_touches(&self, corners: [Vec3A; 3]) -> bool {
        let mut clipped: Clipped = corners
            .into_iter()
            .map(|corner| self.project(corner.as_dvec3()))
            .collect();
        for plane in &self.view.planes {
            clip(&mut clipped, *plane);
        }
        let places: SmallVec<[DVec2; 9]> = clipped.into_iter().map(place).collect();
        // Not where a camera has its near plane in its eye.
        let is_somewhere = !places.is_empty() && places.iter().all(|place| place.is_finite());
        is_somewhere && (self.view.outline.is_rect() || self.view.outline.touches(&places))
    }

    /// Whether a triangle is wholly in the region.
    pub fn triangle_is_enclosed(&self, corners: [Vec3A; 3]) -> bool {
        let corners = corners.map(|corner| self.project(corner.as_dvec3()));
        let is_in_view = |corner: &DVec4| self.view.planes.iter().all(|plane| plane.dot(*corner) >= 0.0);
        let outline = self.view.outline;
        corners.iter().all(is_in_view) && (outline.is_rect() || outline.encloses(&corners.map(place)))
    }
}

/// Leaves of a convex polygon what is on the positive side of a plane through the eye, or on it (Sutherland and Hodgman,
/// *Reentrant Polygon Clipping*, 1974).
fn clip(polygon: &mut Clipped, plane: DVec4) {
    let is_whole = polygon.iter().all(|corner| plane.dot(*corner) >= 0.0);
    if is_whole {
        return;
    }
    let corners = std::mem::take(polygon);
    let next = corners.iter().cycle().skip(1);
    for (&from, &to) in corners.iter().zip(next) {
        let [at_from, at_to] = [from, to].map(|corner| plane.dot(corner));
        if at_from >= 0.0 {
            polygon.push(from);
        }
        if (at_from >= 0.0) != (at_to >= 0.0) {
            polygon.push(from + (to - from) * (at_from / (at_from - at_to)));
        }
    }
}
