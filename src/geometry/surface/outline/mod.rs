//! The outlines of flat shapes.

mod polygon;
mod round;

use bevy::math::{
    DVec2,
    primitives::{Primitive2d, Ring},
};

use super::{
    chart::Coordinate,
    span::{Quadratic, Span, Spans, half_space_span},
};
use crate::geometry::primitive_bounds::Support2d;

/// A flat shape whose outline is made of numbered pieces.
pub trait Outline: Support2d + Send + Sync {
    /// The corners of the smallest box around the shape.
    fn bounds(&self) -> (DVec2, DVec2);

    /// The size of what is round about it; infinite if nothing is.
    fn round_size(&self) -> f64 {
        f64::INFINITY
    }

    /// The parts of the line in the shape, with the pieces of the outline that it crosses there.
    fn spans(&self, line: &FlatLine) -> Spans<u32>;

    /// What there is at a point on a piece of the outline.
    fn edge(&self, piece: u32, point: DVec2) -> Edge;

    /// The texture coordinates of a point in the shape.
    fn texture(&self, point: DVec2) -> [Coordinate; 2];
}

/// A line in the plane, whose direction may be zero.
#[derive(Clone, Copy)]
pub struct FlatLine {
    pub origin: DVec2,
    pub direction: DVec2,
}

/// A place on an outline.
pub struct Edge {
    /// The unit normal, outward.
    pub normal: DVec2,
    /// How far along the outline, from 0 to 1.
    pub u: Coordinate,
}

impl FlatLine {
    fn relative_to(&self, center: DVec2) -> Self {
        Self {
            origin: self.origin - center,
            ..*self
        }
    }

    /// The part of the line in an ellipse around the origin; `None` also if that has no area.
    fn in_ellipse(&self, half_size: DVec2, piece: u32) -> Option<Span<u32>> {
        // Both axes scaled to one radius, without a division.
        let scale = DVec2::new(half_size.y, half_size.x);
        let (origin, direction) = (self.origin * scale, self.direction * scale);
        let radius = half_size.x * half_size.y;
        let a = direction.length_squared();
        let c = origin.length_squared() - radius * radius;
        if radius.is_nan() || radius == 0.0 {
            return None;
        }
        if a == 0.0 {
            return (c <= 0.0).then(|| Span::everywhere(piece));
        }
        let across = origin.perp_dot(direction);
        let discriminant = radius * radius * a - across * across;
        Some(Quadratic::new(a, origin.dot(direction), c, discriminant)?.span(piece))
    }

    /// The part of the line in the half-plane `normal · point <= offset`.
    fn in_half_plane(&self, normal: DVec2, offset: f64, piece: u32) -> Option<Span<u32>> {
        half_space_span(normal.dot(self.direction), normal.dot(self.origin) - offset, piece)
    }
}

/// The texture from corner to corner of a box around the origin, v downward.
fn centered(point: DVec2, half_size: DVec2) -> [Coordinate; 2] {
    [
        Coordinate::plain(0.5 + 0.5 * point.x / half_size.x),
        Coordinate::plain(0.5 - 0.5 * point.y / half_size.y),
    ]
}

/// The corners of a box around the points.
fn bounds_of(points: impl IntoIterator<Item = DVec2>) -> (DVec2, DVec2) {
    points
        .into_iter()
        .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(min, max), point| {
            (min.min(point), max.max(point))
        })
}

/// Even pieces are those of the outer shape, odd ones those of the inner one.
impl<P: Primitive2d + Outline> Outline for Ring<P> {
    fn bounds(&self) -> (DVec2, DVec2) {
        self.outer_shape.bounds()
    }

    fn round_size(&self) -> f64 {
        self.outer_shape.round_size()
    }

    fn spans(&self, line: &FlatLine) -> Spans<u32> {
        let mut spans: Spans<u32> = self
            .outer_shape
            .spans(line)
            .into_iter()
            .map(|span| span.map(|piece| 2 * piece))
            .collect();
        for inner in self.inner_shape.spans(line) {
            let inner = inner.map(|piece| 2 * piece + 1);
            spans = spans.into_iter().flat_map(|span| span.minus(inner)).collect();
        }
        spans
    }

    fn edge(&self, piece: u32, point: DVec2) -> Edge {
        if piece.is_multiple_of(2) {
            let Edge { normal, u } = self.outer_shape.edge(piece / 2, point);
            Edge {
                normal,
                u: u.scaled(0.5, 0.0),
            }
        } else {
            let Edge { normal, u } = self.inner_shape.edge(piece / 2, point);
            Edge {
                normal: -normal,
                u: u.scaled(-0.5, 1.0),
            }
        }
    }

    fn texture(&self, point: DVec2) -> [Coordinate; 2] {
        self.outer_shape.texture(point)
    }
}
