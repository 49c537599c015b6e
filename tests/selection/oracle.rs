//! What a region selects, by the plainest means: every triangle is projected, clipped, and held against every edge.

use bevy::{
    math::{DMat4, DVec2, DVec3, DVec4},
    prelude::*,
};

/// A camera by its matrices.
pub struct Eye {
    screen_from_world: DMat4,
    viewport: [DVec2; 2],
}

impl Eye {
    pub fn new(camera: &Camera, transform: &GlobalTransform) -> Self {
        let viewport = camera.logical_viewport_rect().expect("a camera with a screen");
        let (min, max) = (viewport.min.as_dvec2(), viewport.max.as_dvec2());
        let to_pixels = DMat4::from_translation(min.extend(0.0))
            * DMat4::from_scale((max - min).extend(1.0))
            * DMat4::from_translation(DVec3::new(0.5, 0.5, 0.0))
            * DMat4::from_scale(DVec3::new(0.5, -0.5, 1.0));
        let view_from_world = transform.to_matrix().as_dmat4().inverse();
        Self {
            screen_from_world: to_pixels * camera.clip_from_view().as_dmat4() * view_from_world,
            viewport: [min, max],
        }
    }

    /// What is seen of a triangle, and whether that is all of it.
    fn image(&self, triangle: &[DVec3; 3]) -> (Vec<DVec2>, bool) {
        let corners = triangle.map(|corner| self.screen_from_world * corner.extend(1.0));
        let [min, max] = self.viewport;
        let seen = clip(corners.to_vec(), |p| p.w - p.z);
        let seen = clip(seen, |p| p.z);
        let seen = clip(seen, |p| p.x - min.x * p.w);
        let seen = clip(seen, |p| max.x * p.w - p.x);
        let seen = clip(seen, |p| p.y - min.y * p.w);
        let seen = clip(seen, |p| max.y * p.w - p.y);
        let is_whole = seen == corners;
        (seen.into_iter().map(|p| DVec2::new(p.x, p.y) / p.w).collect(), is_whole)
    }

    /// Whether any triangle touches the polygon on the screen.
    pub fn touches(&self, triangles: &[[DVec3; 3]], polygon: &[Vec2]) -> bool {
        let polygon: Vec<DVec2> = polygon.iter().map(|corner| corner.as_dvec2()).collect();
        triangles.iter().any(|triangle| {
            let (image, _) = self.image(triangle);
            !image.is_empty()
                && (edges_of(&image).any(|a| edges_of(&polygon).any(|b| cross(a, b)))
                    || is_inside(image[0], &polygon)
                    || polygon.iter().any(|&corner| is_in_convex(corner, &image)))
        })
    }

    /// Whether all triangles are wholly in the polygon on the screen.
    pub fn encloses(&self, triangles: &[[DVec3; 3]], polygon: &[Vec2]) -> bool {
        let polygon: Vec<DVec2> = polygon.iter().map(|corner| corner.as_dvec2()).collect();
        triangles.iter().all(|triangle| {
            let (image, is_whole) = self.image(triangle);
            is_whole
                && image.iter().all(|&corner| is_inside(corner, &polygon))
                && !edges_of(&image).any(|a| edges_of(&polygon).any(|b| cross(a, b)))
                && !polygon.iter().any(|&corner| is_in_convex(corner, &image))
        })
    }
}

fn clip(polygon: Vec<DVec4>, inside: impl Fn(DVec4) -> f64) -> Vec<DVec4> {
    let mut kept = Vec::new();
    for (index, &to) in polygon.iter().enumerate() {
        let from = polygon[(index + polygon.len() - 1) % polygon.len()];
        let (at_from, at_to) = (inside(from), inside(to));
        if (at_from < 0.0) != (at_to < 0.0) {
            kept.push(from.lerp(to, at_from / (at_from - at_to)));
        }
        if at_to >= 0.0 {
            kept.push(to);
        }
    }
    // As it was, from the same corner on.
    kept
}

fn edges_of(polygon: &[DVec2]) -> impl Iterator<Item = [DVec2; 2]> + '_ {
    (0..polygon.len()).map(|index| [polygon[index], polygon[(index + 1) % polygon.len()]])
}

fn side([from, to]: [DVec2; 2], point: DVec2) -> f64 {
    (to - from).perp_dot(point - from)
}

/// Whether two segments have a point in common, unless by a hair.
fn cross(a: [DVec2; 2], b: [DVec2; 2]) -> bool {
    side(a, b[0]) * side(a, b[1]) <= 0.0
        && side(b, a[0]) * side(b, a[1]) <= 0.0
        && a[0].min(a[1]).cmple(b[0].max(b[1])).all()
        && b[0].min(b[1]).cmple(a[0].max(a[1])).all()
}

/// By the even-odd rule, along a line upward.
pub fn is_inside(point: DVec2, polygon: &[DVec2]) -> bool {
    let crossings = edges_of(polygon).filter(|[from, to]| {
        let spans = (from.x > point.x) != (to.x > point.x);
        spans && from.y + (to.y - from.y) * (point.x - from.x) / (to.x - from.x) > point.y
    });
    crossings.count() % 2 == 1
}

fn is_in_convex(point: DVec2, polygon: &[DVec2]) -> bool {
    let sides: Vec<f64> = edges_of(polygon).map(|edge| side(edge, point)).collect();
    sides.len() > 2 && (sides.iter().all(|&side| side >= 0.0) || sides.iter().all(|&side| side <= 0.0))
}
