//! Flat shapes with round parts.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use bevy::math::{
    DVec2,
    primitives::{Annulus, Capsule2d, Circle, CircularSector, CircularSegment, Ellipse},
};
use smallvec::SmallVec;

use super::{Edge, FlatLine, Outline, bounds_of, centered};
use crate::geometry::surface::{
    chart::Coordinate,
    span::{Span, Spans, slab_span},
};

/// The direction of a vector; any, if a long and thin extrusion has no digits left for the vector.
fn outward(vector: DVec2) -> DVec2 {
    vector.normalize_or(DVec2::Y)
}

/// A vector as seen from the +y axis, from which angles along an outline count.
fn from_top(vector: DVec2) -> DVec2 {
    -vector.perp()
}

fn radius_of(circle: Circle) -> DVec2 {
    DVec2::splat(f64::from(circle.radius).abs())
}

fn difference(outer: Option<Span<u32>>, inner: Option<Span<u32>>) -> Spans<u32> {
    match (outer, inner) {
        (Some(outer), Some(inner)) => outer.minus(inner).collect(),
        (outer, _) => outer.into_iter().collect(),
    }
}

impl Outline for Ellipse {
    fn bounds(&self) -> (DVec2, DVec2) {
        let half_size = self.half_size.as_dvec2().abs();
        (-half_size, half_size)
    }

    fn round_size(&self) -> f64 {
        f64::from(self.half_size.abs().min_element())
    }

    fn spans(&self, line: &FlatLine) -> Spans<u32> {
        line.in_ellipse(self.half_size.as_dvec2().abs(), 0)
            .into_iter()
            .collect()
    }

    fn edge(&self, _: u32, point: DVec2) -> Edge {
        let half_size = self.half_size.as_dvec2().abs();
        let unit = point / half_size;
        Edge {
            normal: outward(unit / half_size * half_size.min_element()),
            u: Coordinate::turn(from_top(unit)),
        }
    }

    fn texture(&self, point: DVec2) -> [Coordinate; 2] {
        centered(point, self.half_size.as_dvec2().abs())
    }
}

impl Outline for Circle {
    fn bounds(&self) -> (DVec2, DVec2) {
        (-radius_of(*self), radius_of(*self))
    }

    fn round_size(&self) -> f64 {
        f64::from(self.radius).abs()
    }

    fn spans(&self, line: &FlatLine) -> Spans<u32> {
        line.in_ellipse(radius_of(*self), 0).into_iter().collect()
    }

    fn edge(&self, _: u32, point: DVec2) -> Edge {
        Edge {
            normal: outward(point),
            u: Coordinate::turn(from_top(point)),
        }
    }

    fn texture(&self, point: DVec2) -> [Coordinate; 2] {
        centered(point, radius_of(*self))
    }
}

/// Piece 0 is the inner circle, 1 the outer one.
impl Outline for Annulus {
    fn bounds(&self) -> (DVec2, DVec2) {
        self.outer_circle.bounds()
    }

    fn round_size(&self) -> f64 {
        self.outer_circle.round_size()
    }

    fn spans(&self, line: &FlatLine) -> Spans<u32> {
        let outer = line.in_ellipse(radius_of(self.outer_circle), 1);
        difference(outer, line.in_ellipse(radius_of(self.inner_circle), 0))
    }

    fn edge(&self, piece: u32, point: DVec2) -> Edge {
        let Edge { normal, u } = self.outer_circle.edge(0, point);
        if piece == 0 {
            Edge {
                normal: -normal,
                u: u.scaled(-0.5, 0.5),
            }
        } else {
            Edge {
                normal,
                u: u.scaled(0.5, 0.5),
            }
        }
    }

    fn texture(&self, point: DVec2) -> [Coordinate; 2] {
        let (inner, outer) = (radius_of(self.inner_circle).x, radius_of(self.outer_circle).x);
        [
            Coordinate::plain((point.length() - inner) / (outer - inner)),
            Coordinate::turn(from_top(point)),
        ]
    }
}

/// An arc around the +y axis: its radius, and half of its angle, which is at most π.
fn arc(radius: f32, half_angle: f32) -> (f64, f64) {
    (f64::from(radius).abs(), f64::from(half_angle).abs().min(PI))
}

/// The corners of the box around an arc.
fn arc_extremes((radius, half_angle): (f64, f64)) -> SmallVec<[DVec2; 6]> {
    let end = DVec2::new(half_angle.sin(), half_angle.cos()) * radius;
    let mut extremes = SmallVec::from_slice(&[DVec2::Y * radius, end, DVec2::new(-end.x, end.y)]);
    if half_angle >= FRAC_PI_2 {
        extremes.extend([DVec2::X * radius, DVec2::NEG_X * radius]);
    }
    extremes
}

/// The place on an arc, which has the second half of the outline.
fn arc_edge((_, half_angle): (f64, f64), point: DVec2) -> Edge {
    Edge {
        normal: outward(point),
        u: Coordinate {
            offset: 0.75,
            per_radian: (0.25 / half_angle) as f32,
            angle_of: from_top(point).as_vec2(),
        },
    }
}

/// Piece 0 is the left straight side, 1 the right one, 2 the arc.
impl Outline for CircularSector {
    fn bounds(&self) -> (DVec2, DVec2) {
        let arc = arc(self.arc.radius, self.arc.half_angle);
        bounds_of(arc_extremes(arc).into_iter().chain([DVec2::ZERO]))
    }

    fn round_size(&self) -> f64 {
        f64::from(self.arc.radius).abs()
    }

    fn spans(&self, line: &FlatLine) -> Spans<u32> {
        let (radius, half_angle) = arc(self.arc.radius, self.arc.half_angle);
        let disc = line.in_ellipse(DVec2::splat(radius), 2);
        if half_angle.is_nan() || half_angle == 0.0 {
            return Spans::new();
        }
        if half_angle >= PI {
            return disc.into_iter().collect();
        }
        let (sin, cos) = half_angle.sin_cos();
        let (left, right) = (DVec2::new(-cos, -sin), DVec2::new(cos, -sin));
        if half_angle <= FRAC_PI_2 {
            let sector = || {
                let wedge = line
                    .in_half_plane(left, 0.0, 0)?
                    .and(line.in_half_plane(right, 0.0, 1)?)?;
                disc?.and(wedge)
            };
            sector().into_iter().collect()
        } else {
            let wedge = || {
                line.in_half_plane(-left, 0.0, 0)?
                    .and(line.in_half_plane(-right, 0.0, 1)?)
            };
            difference(disc, wedge())
        }
    }

    fn edge(&self, piece: u32, point: DVec2) -> Edge {
        let arc = arc(self.arc.radius, self.arc.half_angle);
        let (sin, cos) = arc.1.sin_cos();
        // From the end of the left side, over the centre, to the end of the right one.
        let along = 0.25 * point.length() / arc.0;
        match piece {
            0 => Edge {
                normal: DVec2::new(-cos, -sin),
                u: Coordinate::plain(0.25 - along),
            },
            1 => Edge {
                normal: DVec2::new(cos, -sin),
                u: Coordinate::plain(0.25 + along),
            },
            _ => arc_edge(arc, point),
        }
    }

    fn texture(&self, point: DVec2) -> [Coordinate; 2] {
        centered(point, DVec2::splat(f64::from(self.arc.radius).abs()))
    }
}

/// Piece 0 is the chord, 1 the arc.
impl Outline for CircularSegment {
    fn bounds(&self) -> (DVec2, DVec2) {
        bounds_of(arc_extremes(arc(self.arc.radius, self.arc.half_angle)))
    }

    fn round_size(&self) -> f64 {
        f64::from(self.arc.radius).abs()
    }

    fn spans(&self, line: &FlatLine) -> Spans<u32> {
        let (radius, half_angle) = arc(self.arc.radius, self.arc.half_angle);
        let segment = || {
            let disc = line.in_ellipse(DVec2::splat(radius), 1)?;
            if half_angle >= PI {
                return Some(disc);
            }
            let above = line.in_half_plane(DVec2::NEG_Y, -radius * half_angle.cos(), 0)?;
            (half_angle > 0.0).then(|| disc.and(above))?
        };
        segment().into_iter().collect()
    }

    fn edge(&self, piece: u32, point: DVec2) -> Edge {
        let arc = arc(self.arc.radius, self.arc.half_angle);
        if piece == 1 {
            return arc_edge(arc, point);
        }
        Edge {
            normal: DVec2::NEG_Y,
            u: Coordinate::plain(0.25 + 0.25 * point.x / (arc.0 * arc.1.sin())),
        }
    }

    fn texture(&self, point: DVec2) -> [Coordinate; 2] {
        centered(point, DVec2::splat(f64::from(self.arc.radius).abs()))
    }
}

/// Piece 0 is the upper half circle, then counter-clockwise.
impl Outline for Capsule2d {
    fn bounds(&self) -> (DVec2, DVec2) {
        let (radius, half_length) = (f64::from(self.radius).abs(), f64::from(self.half_length).abs());
        let half_size = DVec2::new(radius, half_length + radius);
        (-half_size, half_size)
    }

    fn round_size(&self) -> f64 {
        f64::from(self.radius).abs()
    }

    fn spans(&self, line: &FlatLine) -> Spans<u32> {
        let (radius, half_length) = (f64::from(self.radius).abs(), f64::from(self.half_length).abs());
        let (origin, direction) = (line.origin, line.direction);
        let half_circle = |center: f64, piece| {
            line.relative_to(DVec2::Y * center)
                .in_ellipse(DVec2::splat(radius), piece)
        };
        let sides = || {
            slab_span(origin.x, direction.x, radius, [1, 3])?.and(slab_span(
                origin.y,
                direction.y,
                half_length,
                [2, 0],
            )?)
        };
        let parts = [half_circle(half_length, 0), half_circle(-half_length, 2), sides()];
        let whole = parts.into_iter().flatten().reduce(Span::or);
        whole.filter(|_| radius > 0.0).into_iter().collect()
    }

    fn edge(&self, piece: u32, point: DVec2) -> Edge {
        let half_length = f64::from(self.half_length).abs();
        let along = 0.5 * point.y / half_length.max(f64::MIN_POSITIVE);
        let half_circle = |center: f64| point - DVec2::Y * center;
        match piece {
            0 => Edge {
                normal: outward(half_circle(half_length)),
                u: Coordinate {
                    offset: 0.0,
                    per_radian: (0.5 / TAU) as f32,
                    angle_of: half_circle(half_length).as_vec2(),
                },
            },
            1 => Edge {
                normal: DVec2::NEG_X,
                u: Coordinate::plain(0.375 - 0.25 * along),
            },
            2 => Edge {
                normal: outward(half_circle(-half_length)),
                u: Coordinate {
                    offset: 0.5,
                    per_radian: (0.5 / TAU) as f32,
                    angle_of: -half_circle(-half_length).as_vec2(),
                },
            },
            _ => Edge {
                normal: DVec2::X,
                u: Coordinate::plain(0.875 + 0.25 * along),
            },
        }
    }

    fn texture(&self, point: DVec2) -> [Coordinate; 2] {
        centered(point, self.bounds().1)
    }
}
