//! Whether a convex shape is in a region, as it is seen on the screen.

use bevy::math::{DAffine3, DVec2, DVec3, DVec4};

use super::{
    outline::ScreenRect,
    view::{PlacedView, View, corners, place},
};
use crate::geometry::{
    intersection::gjk,
    support::{Support, farthest},
    tolerance::DOUBLE,
};

impl PlacedView<'_> {
    /// Whether a convex shape touches the region. Exact up to the rounding of [`gjk`].
    pub fn hull_touches(&self, hull: &dyn Support) -> bool {
        let hull = self.in_view(hull);
        let view = self.view;
        let planes = view.planes.map(|plane| view.screen_from_view.transpose() * plane);
        let is_behind = |plane: &DVec4| plane.dot(hull.support_point(plane.truncate()).extend(1.0)) < 0.0;
        if planes.iter().any(is_behind) {
            return false;
        }
        let beyond = hull.depth_beyond(view);
        let ScreenRect { min, max } = view.rect;
        let in_rect = Points(
            corners(min.extend(beyond), max.extend(1.0)).map(|corner| view.unproject(corner.truncate(), corner.z)),
        );
        let common = gjk::distance(&hull, &in_rect);
        if common.distance > 0.0 {
            return false;
        }
        let somewhere = || view.screen_from_view * common.points[0].extend(1.0);
        view.outline.is_rect() || hull.meets_an_edge(view, beyond) || view.outline.is_inside(place(somewhere()))
    }

    /// Whether a convex shape is wholly in the region. One that touches the outline from inside counts as enclosed by a
    /// rectangle, and not by a polygon.
    pub fn hull_is_enclosed(&self, hull: &dyn Support) -> bool {
        let hull = self.in_view(hull);
        let view = self.view;
        let planes = view.planes.map(|plane| view.screen_from_view.transpose() * plane);
        let is_before = |plane: &DVec4| {
            let nearest = hull.support_point(-plane.truncate()).extend(1.0);
            plane.dot(nearest) >= -DOUBLE * plane.abs().dot(nearest.abs())
        };
        let is_in_rect = planes.iter().all(is_before);
        let somewhere = || view.screen_from_view * hull.support_point(DVec3::X).extend(1.0);
        is_in_rect
            && (view.outline.is_rect()
                || !hull.meets_an_edge(view, hull.depth_beyond(view)) && view.outline.is_inside(place(somewhere())))
    }

    fn in_view<'a>(&self, hull: &'a dyn Support) -> HullInView<'a> {
        HullInView {
            hull,
            view_from_local: self.view_from_local,
        }
    }
}

/// A convex shape in the space of the camera.
struct HullInView<'a> {
    hull: &'a dyn Support,
    view_from_local: DAffine3,
}

impl Support for HullInView<'_> {
    fn support_point(&self, direction: DVec3) -> DVec3 {
        let local = self.view_from_local.matrix3.transpose() * direction;
        self.view_from_local.transform_point3(self.hull.support_point(local))
    }
}

impl HullInView<'_> {
    fn corners_around(&self) -> [DVec3; 8] {
        let reach = |direction: DVec3| self.support_point(direction).dot(direction);
        let max = DVec3::from_array(DVec3::AXES.map(reach));
        let min = -DVec3::from_array(DVec3::AXES.map(|axis| reach(-axis)));
        corners(min, max)
    }

    /// A depth that is farther than everything of the shape, but not beyond the far plane.
    fn depth_beyond(&self, view: &View) -> f64 {
        let corners = self
            .corners_around()
            .map(|corner| view.screen_from_view * corner.extend(1.0));
        let in_front = corners.iter().filter(|corner| corner.w > 0.0);
        let farthest = in_front.map(|corner| corner.z / corner.w).fold(1.0, f64::min);
        // By a hundredth, so that rounding makes no difference.
        farthest.max(0.0) * 0.99
    }

    /// Whether the shape meets what is behind an edge of the region on the screen, from the near plane to a depth.
    fn meets_an_edge(&self, view: &View, beyond: f64) -> bool {
        let corners = self
            .corners_around()
            .map(|corner| view.screen_from_view * corner.extend(1.0));
        let is_in_front = corners.iter().all(|corner| corner.w > 0.0 && corner.z <= corner.w);
        let near = if is_in_front {
            ScreenRect::around(corners.map(place)).intersection(&view.rect)
        } else {
            view.rect
        };
        let mut edges = view
            .outline
            .edges_near(&near)
            .filter_map(|edge| clipped(edge, &view.rect));
        edges.any(|[from, to]| {
            let wall = [(from, 1.0), (to, 1.0), (from, beyond), (to, beyond)];
            let wall = Points(wall.map(|(place, depth)| view.unproject(place, depth)));
            gjk::intersects(self, &wall)
        })
    }
}

/// The convex hull of some points.
struct Points<const N: usize>([DVec3; N]);

impl<const N: usize> Support for Points<N> {
    fn support_point(&self, direction: DVec3) -> DVec3 {
        farthest(self.0, direction)
    }
}

/// The part of a segment in a rectangle, if there is one (Liang and Barsky, *A New Concept and Method for Line Clipping*,
/// 1984).
fn clipped([from, to]: [DVec2; 2], rect: &ScreenRect) -> Option<[DVec2; 2]> {
    let way = to - from;
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        for (speed, room) in [
            (way[axis], rect.max[axis] - from[axis]),
            (-way[axis], from[axis] - rect.min[axis]),
        ] {
            if speed > 0.0 {
                last = last.min(room / speed);
            } else if speed < 0.0 {
                first = first.max(room / speed);
            } else if room < 0.0 {
                return None;
            }
        }
    }
    (first <= last).then(|| [from + way * first, from + way * last])
}
