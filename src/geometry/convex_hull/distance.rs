//! How far a point lies outside of a hull, for hulls of every rank.

use bevy::math::DVec3;

use super::{ConvexHull, HullRank, polytope::unit_normal, predicates::orient3d};

impl ConvexHull {
    /// The distance of a point, which must be finite, from what the corners span: zero inside, exactly, and outside
    /// right to a few units in the last place of `f64`, of the largest coordinate.
    pub(super) fn distance_from_corners(&self, point: DVec3) -> f64 {
        let corner = |index: u32| self.vertices[index as usize].as_dvec3();
        match self.rank {
            HullRank::Point => point.distance(corner(0)),
            HullRank::Segment => distance_from_segment(point, [corner(0), corner(1)]),
            HullRank::Polygon => self.distance_from_face(point, 0),
            // Exact, because planes that meet in a needle, and round, would meet far from its point.
            HullRank::Solid => (0..self.faces.len())
                .filter(|&face| {
                    let corners = self.faces.corners(face);
                    orient3d([corners[0], corners[1], corners[2]].map(corner), point) > 0.0
                })
                .map(|face| self.distance_from_face(point, face))
                .reduce(f64::min)
                .unwrap_or(0.0),
        }
    }

    fn distance_from_face(&self, point: DVec3, face: usize) -> f64 {
        let corners: Vec<DVec3> = (self.faces.corners(face).iter())
            .map(|&corner| self.vertices[corner as usize].as_dvec3())
            .collect();
        let numbers: Vec<u32> = (0..corners.len() as u32).collect();
        let normal = unit_normal(&corners, &numbers);
        let next = corners.iter().cycle().skip(1);
        let edges = || corners.iter().zip(next.clone());
        if edges().all(|(&a, &b)| normal.cross(b - a).dot(point - a) >= 0.0) {
            return normal.dot(point - corners[0]).abs();
        }
        edges()
            .map(|(&a, &b)| distance_from_segment(point, [a, b]))
            .fold(f64::INFINITY, f64::min)
    }
}

fn distance_from_segment(point: DVec3, [a, b]: [DVec3; 2]) -> f64 {
    let along = b - a;
    let t = ((point - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    point.distance(a + along * t)
}
