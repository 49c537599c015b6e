//! Quickhull in exact arithmetic.
//!
//! Source: Barber, Dobkin and Huhdanpaa, *The Quickhull Algorithm for Convex Hulls*, ACM TOMS 22(4), 1996. Every side is
//! decided exactly, so there is no thickness of a face and no repair: the strictly visible triangles are always a disc,
//! its border a simple loop, and no new triangle degenerate.

use bevy::math::DVec3;

use super::{
    facets,
    flat::polygon,
    polytope::{HullRank, Polytope},
    predicates::orient3d,
    simplex::{bounds, spanning_simplex},
};

/// No point, or no triangle.
const NONE: u32 = u32::MAX;

/// The hull of points, of which there is at least one, with the coordinates of finite `f32`s.
pub(super) fn convex_hull(points: &[DVec3]) -> Polytope {
    match spanning_simplex(points)[..] {
        [a, b, c, d] => facets::merged(points, &Quickhull::new(points, [a, b, c, d]).run()),
        [a, b, c] => polygon(points, [a, b, c]),
        [a, b] => Polytope::without_faces(HullRank::Segment, vec![a, b]),
        _ => Polytope::without_faces(HullRank::Point, vec![0]),
    }
}

/// A triangle of the hull so far.
pub(super) struct Triangle {
    /// Counter-clockwise seen from outside.
    pub corners: [u32; 3],
    /// The triangle across the edge from each corner to the next.
    pub neighbors: [u32; 3],
    start: DVec3,
    normal: DVec3,
    /// The largest rounding error of a height over the triangle.
    error: f64,
    /// The first of the points that lie outside, and are not outside of another triangle's list.
    outside: u32,
    /// The one of them that is highest.
    highest: (u32, f64),
    /// The last round that looked at this triangle from its eye, and what it saw.
    seen: (u32, bool),
    pub alive: bool,
}

impl Triangle {
    fn new(points: &[DVec3], corners: [u32; 3], extent: DVec3) -> Self {
        let [a, b, c] = corners.map(|corner| points[corner as usize]);
        let (ab, ac) = (b - a, c - a);
        let permanent =
            |p: DVec3, q: DVec3| DVec3::new(p.y * q.z + p.z * q.y, p.z * q.x + p.x * q.z, p.x * q.y + p.y * q.x);
        Self {
            corners,
            neighbors: [NONE; 3],
            start: a,
            normal: ab.cross(ac),
            // Shewchuk's first bound is 7 roundings of the permanent, which the extent bounds here for all points.
            error: 5.0 * f64::EPSILON * permanent(ab.abs(), ac.abs()).dot(extent),
            outside: NONE,
            highest: (NONE, 0.0),
            seen: (0, false),
            alive: true,
        }
    }

    /// How far out the point lies; the sign is exact, the scale that of the triangle.
    #[inline]
    pub fn height(&self, points: &[DVec3], point: DVec3) -> f64 {
        let height = self.normal.dot(point - self.start);
        if height.abs() > self.error {
            return height;
        }
        orient3d(self.corners.map(|corner| points[corner as usize]), point)
    }
}

struct Quickhull<'a> {
    points: &'a [DVec3],
    extent: DVec3,
    triangles: Vec<Triangle>,
    /// Triangles that are gone, for reuse.
    free: Vec<u32>,
    /// The next point in the list of the same triangle.
    next: Vec<u32>,
    /// Triangles that may have points outside.
    pending: Vec<u32>,
    round: u32,
    /// Of each corner on the horizon, the new triangle whose horizon edge starts there.
    starting_at: Vec<u32>,
}

impl<'a> Quickhull<'a> {
    fn new(points: &'a [DVec3], simplex: [u32; 4]) -> Self {
        let (min, max) = bounds(points);
        let mut hull = Self {
            points,
            extent: max - min,
            triangles: Vec::new(),
            free: Vec::new(),
            next: vec![NONE; points.len()],
            pending: Vec::new(),
            round: 0,
            starting_at: vec![NONE; points.len()],
        };
        let [mut a, mut b, c, d] = simplex;
        let corner = |index: u32| points[index as usize];
        if orient3d([a, b, c].map(corner), corner(d)) > 0.0 {
            std::mem::swap(&mut a, &mut b);
        }
        for (corners, neighbors) in [
            ([a, b, c], [1, 2, 3]),
            ([b, a, d], [0, 3, 2]),
            ([c, b, d], [0, 1, 3]),
            ([a, c, d], [0, 2, 1]),
        ] {
            let triangle = hull.add(corners);
            hull.triangles[triangle as usize].neighbors = neighbors;
        }
        for point in 0..points.len() as u32 {
            hull.assign(point, &[0, 1, 2, 3]);
        }
        hull.pending = vec![0, 1, 2, 3];
        hull
    }

    fn run(mut self) -> Vec<Triangle> {
        let (mut visible, mut horizon, mut new) = (Vec::new(), Vec::new(), Vec::new());
        while let Some(triangle) = self.pending.pop() {
            let Triangle {
                alive,
                highest: (eye, _),
                ..
            } = self.triangles[triangle as usize];
            if !alive || eye == NONE {
                continue;
            }
            self.look(eye, triangle, &mut visible, &mut horizon);
            self.cover(eye, &horizon, &mut new);
            for &seen in &visible {
                let mut point = self.triangles[seen as usize].outside;
                while point != NONE {
                    let next = self.next[point as usize];
                    if point != eye {
                        self.assign(point, &new);
                    }
                    point = next;
                }
            }
            for &seen in &visible {
                self.triangles[seen as usize].alive = false;
            }
            self.free.append(&mut visible);
            self.pending.extend(&new);
        }
        self.triangles
    }

    fn add(&mut self, corners: [u32; 3]) -> u32 {
        let triangle = Triangle::new(self.points, corners, self.extent);
        if let Some(index) = self.free.pop() {
            self.triangles[index as usize] = triangle;
            return index;
        }
        self.triangles.push(triangle);
        self.triangles.len() as u32 - 1
    }

    /// Puts the point into the list of a triangle that it lies outside of; a point inside of all is dropped.
    fn assign(&mut self, point: u32, triangles: &[u32]) {
        let position = self.points[point as usize];
        for &index in triangles {
            let triangle = &mut self.triangles[index as usize];
            let height = triangle.height(self.points, position);
            if height > 0.0 {
                self.next[point as usize] = triangle.outside;
                triangle.outside = point;
                if height > triangle.highest.1 {
                    triangle.highest = (point, height);
                }
                return;
            }
        }
    }

    /// Finds the triangles that the eye is strictly above, starting from one of them, and the edges between these and
    /// the others: the other triangle, and the number of the edge there.
    fn look(&mut self, eye: u32, start: u32, visible: &mut Vec<u32>, horizon: &mut Vec<(u32, usize)>) {
        self.round += 1;
        horizon.clear();
        visible.clear();
        visible.push(start);
        self.triangles[start as usize].seen = (self.round, true);
        let position = self.points[eye as usize];
        let mut next = 0;
        while let Some(&index) = visible.get(next) {
            next += 1;
            for neighbor in self.triangles[index as usize].neighbors {
                let triangle = &mut self.triangles[neighbor as usize];
                if triangle.seen.0 != self.round {
                    triangle.seen = (self.round, triangle.height(self.points, position) > 0.0);
                    if triangle.seen.1 {
                        visible.push(neighbor);
                    }
                }
                if !triangle.seen.1 {
                    horizon.extend(
                        triangle
                            .neighbors
                            .iter()
                            .position(|&n| n == index)
                            .map(|edge| (neighbor, edge)),
                    );
                }
            }
        }
    }

    /// Joins the eye to the edges of the horizon.
    fn cover(&mut self, eye: u32, horizon: &[(u32, usize)], new: &mut Vec<u32>) {
        new.clear();
        for &(hidden, edge) in horizon {
            let corners = self.triangles[hidden as usize].corners;
            let (start, end) = (corners[(edge + 1) % 3], corners[edge]);
            let triangle = self.add([start, end, eye]);
            self.triangles[triangle as usize].neighbors[0] = hidden;
            self.triangles[hidden as usize].neighbors[edge] = triangle;
            self.starting_at[start as usize] = triangle;
            new.push(triangle);
        }
        for &triangle in new.iter() {
            let following = self.starting_at[self.triangles[triangle as usize].corners[1] as usize];
            self.triangles[triangle as usize].neighbors[1] = following;
            self.triangles[following as usize].neighbors[2] = triangle;
        }
    }
}
