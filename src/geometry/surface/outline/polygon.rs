//! Convex polygons.

use std::f64::consts::TAU;

use bevy::math::{
    DVec2, DVec3, Vec2, Vec3,
    primitives::{ConvexPolygon, Rectangle, RegularPolygon, Rhombus, Triangle2d},
};
use smallvec::SmallVec;

use super::{Edge, FlatLine, Outline, bounds_of, centered};
use crate::geometry::{
    primitive_bounds::Support2d,
    surface::{
        chart::Coordinate,
        span::{Span, Spans},
        triangle::triangle_chart,
    },
};

/// A convex polygon.
trait Polygonal: Support2d {
    /// Counter-clockwise.
    fn vertices(&self) -> SmallVec<[DVec2; 8]>;

    fn polygon_texture(&self, point: DVec2) -> [Coordinate; 2];
}

impl<P: Polygonal + Send + Sync> Outline for P {
    fn bounds(&self) -> (DVec2, DVec2) {
        bounds_of(self.vertices())
    }

    fn spans(&self, line: &FlatLine) -> Spans<u32> {
        polygon_span(line, &self.vertices()).into_iter().collect()
    }

    fn edge(&self, piece: u32, point: DVec2) -> Edge {
        polygon_edge(&self.vertices(), piece, point)
    }

    fn texture(&self, point: DVec2) -> [Coordinate; 2] {
        self.polygon_texture(point)
    }
}

fn counter_clockwise(vertices: impl IntoIterator<Item = DVec2>) -> SmallVec<[DVec2; 8]> {
    let mut vertices: SmallVec<[DVec2; 8]> = vertices.into_iter().collect();
    if doubled_area(&vertices) < 0.0 {
        vertices.reverse();
    }
    vertices
}

impl Polygonal for Rectangle {
    fn vertices(&self) -> SmallVec<[DVec2; 8]> {
        let corner = self.half_size.as_dvec2().abs();
        let other = DVec2::new(-corner.x, corner.y);
        SmallVec::from_slice(&[corner, other, -corner, -other])
    }

    fn polygon_texture(&self, point: DVec2) -> [Coordinate; 2] {
        centered(point, self.half_size.as_dvec2().abs())
    }
}

impl Polygonal for Rhombus {
    fn vertices(&self) -> SmallVec<[DVec2; 8]> {
        let DVec2 { x, y } = self.half_diagonals.as_dvec2().abs();
        SmallVec::from_slice(&[DVec2::X * x, DVec2::Y * y, DVec2::NEG_X * x, DVec2::NEG_Y * y])
    }

    fn polygon_texture(&self, point: DVec2) -> [Coordinate; 2] {
        centered(point, self.half_diagonals.as_dvec2().abs())
    }
}

impl Polygonal for RegularPolygon {
    fn vertices(&self) -> SmallVec<[DVec2; 8]> {
        let step = DVec2::from_angle(TAU / f64::from(self.sides));
        let top = DVec2::Y * f64::from(self.circumcircle.radius).abs();
        let next = |vertex: &DVec2| Some(step.rotate(*vertex));
        std::iter::successors(Some(top), next)
            .take(self.sides as usize)
            .collect()
    }

    fn polygon_texture(&self, point: DVec2) -> [Coordinate; 2] {
        centered(point, DVec2::splat(f64::from(self.circumcircle.radius).abs()))
    }
}

impl Polygonal for ConvexPolygon {
    fn vertices(&self) -> SmallVec<[DVec2; 8]> {
        counter_clockwise(self.vertices().iter().map(|vertex| vertex.as_dvec2()))
    }

    fn polygon_texture(&self, point: DVec2) -> [Coordinate; 2] {
        let (min, max) = self.bounds();
        let uv = (point - min) / (max - min);
        [Coordinate::plain(uv.x), Coordinate::plain(uv.y)]
    }
}

impl Polygonal for Triangle2d {
    fn vertices(&self) -> SmallVec<[DVec2; 8]> {
        counter_clockwise(self.vertices.map(Vec2::as_dvec2))
    }

    fn polygon_texture(&self, point: DVec2) -> [Coordinate; 2] {
        let triangle = self.vertices.map(Vec2::as_dvec2);
        let [a, b, c] = triangle.map(|vertex| vertex - point);
        let weights = DVec3::new(b.perp_dot(c), c.perp_dot(a), a.perp_dot(b));
        let chart = triangle_chart(
            triangle.map(|vertex| vertex.extend(0.0)),
            weights / weights.element_sum(),
        );
        let uv = chart.uv(Vec3::Z).as_dvec2();
        [Coordinate::plain(uv.x), Coordinate::plain(uv.y)]
    }
}

/// The part of the line in a convex polygon, whose vertices run counter-clockwise; piece `i` is the side from vertex
/// `i` to the next one. `None` also if that has no area.
fn polygon_span(line: &FlatLine, vertices: &[DVec2]) -> Option<Span<u32>> {
    let area = doubled_area(vertices);
    if area.is_nan() || area <= 0.0 {
        return None;
    }
    let mut span = Span::everywhere(0);
    for (piece, (from, to)) in sides(vertices).enumerate() {
        let normal = -(to - from).perp();
        // From the vertex: a product with its far coordinates would lose the digits of the distance.
        let side = line.relative_to(from).in_half_plane(normal, 0.0, piece as u32)?;
        span = span.and(side)?;
    }
    Some(span)
}

fn sides(vertices: &[DVec2]) -> impl Iterator<Item = (DVec2, DVec2)> {
    let next = vertices.iter().cycle().skip(1);
    vertices.iter().zip(next).map(|(&from, &to)| (from, to))
}

fn doubled_area(vertices: &[DVec2]) -> f64 {
    let first = vertices.first().copied().unwrap_or_default();
    sides(vertices)
        .map(|(from, to)| (from - first).perp_dot(to - first))
        .sum()
}

/// The place on a side of a polygon.
fn polygon_edge(vertices: &[DVec2], piece: u32, point: DVec2) -> Edge {
    let (from, to) = sides(vertices).nth(piece as usize).unwrap_or_default();
    let side = to - from;
    let along = (point - from).dot(side) / side.length_squared();
    Edge {
        normal: -side.perp().normalize_or_zero(),
        u: Coordinate::plain((f64::from(piece) + along.clamp(0.0, 1.0)) / vertices.len() as f64),
    }
}
