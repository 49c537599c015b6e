//! Hulls of few corners, around hulls of many.

use bevy::math::{DMat3, DVec3, Vec3A};

use super::{
    ConvexHull, HullRank,
    polytope::unit_normal,
    simplex::{bounds, farthest},
};
use crate::geometry::{
    support::unit,
    volume::{UnboundablePoints, Volume},
};

impl ConvexHull {
    /// A hull around all `points` with at most `max_vertices` corners, or four if that is less.
    ///
    /// Conservative: where the hull of the points has more, this one is larger, and its corners are none of the points.
    /// From eight corners on, it lies within the box around the points, or, if these are coplanar, within a rectangle.
    ///
    /// Greedy: starts from that box (a tetrahedron for fewer than eight corners) and cuts off the farthest corner along a
    /// face of the hull, as long as the corners suffice. For import time: a cut looks at all faces for each new corner.
    ///
    /// # Errors
    ///
    /// As [`Volume::enclosing`].
    pub fn with_vertex_budget(
        points: impl IntoIterator<Item = Vec3A>,
        max_vertices: usize,
    ) -> Result<Self, UnboundablePoints> {
        let hull = Self::enclosing(points)?;
        let max_vertices = max_vertices.max(4);
        if hull.vertices.len() <= max_vertices {
            return Ok(hull);
        }
        let corners: Vec<Vec3A> = hull
            .outer_corners(max_vertices)
            .into_iter()
            .map(|corner| (hull.vertices[0].as_dvec3() + corner).as_vec3a())
            .collect();
        if !corners.iter().copied().all(super::is_in_range) {
            return Err(UnboundablePoints::Overflow);
        }
        let outer = Self::spanned(&corners, 0.0);
        let outside = |vertex: &Vec3A| outer.distance_from_corners(vertex.as_dvec3());
        let margin = hull.vertices.iter().map(outside).fold(0.0, f64::max);
        Ok(Self::spanned(&corners, outer.reach() + margin))
    }

    /// The corners of a polytope around the hull, relative to its first vertex: a small hull far out keeps its digits.
    fn outer_corners(&self, max_vertices: usize) -> Vec<DVec3> {
        let first = self.vertices[0].as_dvec3();
        let vertices: Vec<DVec3> = self.vertices.iter().map(|vertex| vertex.as_dvec3() - first).collect();
        let normal = |face: usize| unit_normal(&vertices, self.faces.corners(face));
        let plane = |normal: DVec3| Plane::supporting(&vertices, normal);
        if self.rank == HullRank::Solid {
            let side = |face: usize| Plane::through(vertices[self.faces.corners(face)[0] as usize], normal(face));
            let sides = (0..self.faces.len()).map(side).collect();
            let start = if max_vertices < 8 {
                Outer::tetrahedron(plane, sides)
            } else {
                Outer::block(DMat3::IDENTITY, plane, sides)
            };
            return start.cut(max_vertices);
        }

        // A prism over the polygon, cut along its edges only, of which the polygon is the middle.
        let up = normal(0);
        let start = |corner: u32| vertices[corner as usize];
        let edges: Vec<(DVec3, DVec3)> = (self.faces.edges(0))
            .map(|([a, b], _)| (start(a), start(b) - start(a)))
            .collect();
        let longest = (edges.iter()).fold(DVec3::ZERO, |longest, &(_, edge)| {
            if edge.length_squared() > longest.length_squared() {
                edge
            } else {
                longest
            }
        });
        let forward = unit(longest);
        let frame = DMat3::from_cols(forward, up.cross(forward), up);
        let sides = (edges.iter())
            .map(|&(start, edge)| Plane::through(start, unit(edge.cross(up))))
            .collect();
        let (min, max) = bounds(&vertices);
        let height = (max - min).length();
        let thick = |normal: DVec3| Plane {
            offset: plane(normal).offset + height * normal.dot(up).abs(),
            ..plane(normal)
        };
        let top = Outer::block(frame, thick, sides).cut(2 * max_vertices);
        (top.into_iter().filter(|corner| corner.dot(up) > 0.0))
            .map(|corner| corner - up * height)
            .collect()
    }
}

#[derive(Clone, Copy)]
struct Plane {
    normal: DVec3,
    offset: f64,
}

impl Plane {
    fn supporting(vertices: &[DVec3], normal: DVec3) -> Self {
        Self::through(vertices[farthest(vertices, |vertex| vertex.dot(normal))], normal)
    }

    fn through(point: DVec3, normal: DVec3) -> Self {
        let offset = point.dot(normal);
        Self { normal, offset }
    }

    fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }
}

#[derive(Clone)]
struct Corner {
    position: DVec3,
    /// The planes that it lies in, by their numbers.
    planes: Vec<usize>,
    /// Which of the sides cuts off most here, and how much.
    deepest: (usize, f64),
}

/// A polytope by its corners and the planes that these lie in: the double description (Motzkin, Raiffa, Thompson and
/// Thrall, 1953).
struct Outer {
    corners: Vec<Corner>,
    /// How many planes there are.
    planes: usize,
    /// The planes to cut along.
    sides: Vec<Plane>,
}

impl Outer {
    /// The block along the axes of `frame`.
    fn block(frame: DMat3, plane: impl Fn(DVec3) -> Plane, sides: Vec<Plane>) -> Self {
        let axes = [frame.x_axis, frame.y_axis, frame.z_axis];
        let planes = axes.iter().flat_map(|&axis| [plane(axis), plane(-axis)]).collect();
        Self::around(
            planes,
            (0..8).map(|corner| [corner & 1, 2 + (corner >> 1 & 1), 4 + (corner >> 2)]),
            sides,
        )
    }

    /// The tetrahedron whose faces look along four diagonals of a cube.
    fn tetrahedron(plane: impl Fn(DVec3) -> Plane, sides: Vec<Plane>) -> Self {
        let diagonals = [
            DVec3::ONE,
            DVec3::new(1.0, -1.0, -1.0),
            DVec3::new(-1.0, 1.0, -1.0),
            DVec3::new(-1.0, -1.0, 1.0),
        ];
        let planes = diagonals.map(|diagonal| plane(diagonal.normalize())).to_vec();
        Self::around(planes, [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]], sides)
    }

    fn around(planes: Vec<Plane>, corners: impl IntoIterator<Item = [usize; 3]>, sides: Vec<Plane>) -> Self {
        let mut outer = Self {
            corners: Vec::new(),
            planes: planes.len(),
            sides,
        };
        for numbers in corners {
            let [a, b, c] = numbers.map(|number| planes[number]);
            let (bc, ca, ab) = (
                b.normal.cross(c.normal),
                c.normal.cross(a.normal),
                a.normal.cross(b.normal),
            );
            let position = (bc * a.offset + ca * b.offset + ab * c.offset) / a.normal.dot(bc);
            let corner = outer.corner(position, numbers.to_vec());
            outer.corners.push(corner);
        }
        outer
    }

    fn corner(&self, position: DVec3, planes: Vec<usize>) -> Corner {
        let mut deepest = (0, f64::NEG_INFINITY);
        for (number, side) in self.sides.iter().enumerate() {
            let height = side.height(position);
            if height > deepest.1 {
                deepest = (number, height);
            }
        }
        Corner {
            position,
            planes,
            deepest,
        }
    }

    /// Cuts along the sides as long as there are no more than `max` corners, and returns these.
    fn cut(mut self, max: usize) -> Vec<DVec3> {
        let size = self
            .corners
            .iter()
            .map(|corner| corner.position.abs().max_element())
            .fold(0.0, f64::max);
        // What is left is rounding.
        let thickness = size * f64::from(f32::EPSILON);
        loop {
            self.corners.sort_by(|a, b| b.deepest.1.total_cmp(&a.deepest.1));
            let cuts = self
                .corners
                .iter()
                .map(|corner| corner.deepest)
                .take_while(|&(_, height)| height > thickness);
            let fitting = cuts
                .map(|(side, _)| self.cut_along(side))
                .find(|corners| corners.len() <= max);
            match fitting {
                Some(corners) => self.corners = corners,
                None => return self.corners.into_iter().map(|corner| corner.position).collect(),
            }
            self.planes += 1;
        }
    }

    /// The corners after a cut along a side.
    fn cut_along(&self, side: usize) -> Vec<Corner> {
        let side = self.sides[side];
        let (outside, mut kept): (Vec<Corner>, Vec<Corner>) = self
            .corners
            .iter()
            .cloned()
            .partition(|corner| side.height(corner.position) > 0.0);
        let mut new = Vec::new();
        for out in &outside {
            for corner in &kept {
                let mut shared: Vec<usize> = out
                    .planes
                    .iter()
                    .copied()
                    .filter(|plane| corner.planes.contains(plane))
                    .collect();
                let (above, below) = (side.height(out.position), side.height(corner.position));
                // Corners that share two planes are the ends of an edge.
                if shared.len() > 1 && below < 0.0 {
                    shared.push(self.planes);
                    let position = corner.position.lerp(out.position, below / (below - above));
                    new.push(self.corner(position, shared));
                }
            }
        }
        for corner in kept.iter_mut().filter(|corner| side.height(corner.position) == 0.0) {
            corner.planes.push(self.planes);
        }
        kept.append(&mut new);
        kept
    }
}
