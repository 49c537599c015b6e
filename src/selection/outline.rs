//! The outline of a region, ready to be held against many things on the screen.

use std::ops::Range;

use bevy::math::DVec2;
use robust::{Coord, orient2d};

use crate::geometry::tolerance::SCREEN_CONTACT;

/// The most rows that the edges of a polygon are sorted into.
const MOST_ROWS: usize = 256;

/// A rectangle on the screen, closed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ScreenRect {
    pub min: DVec2,
    pub max: DVec2,
}

impl ScreenRect {
    /// The smallest around all points; no point is in that of none.
    pub fn around(points: impl IntoIterator<Item = DVec2>) -> Self {
        let none = Self {
            min: DVec2::INFINITY,
            max: DVec2::NEG_INFINITY,
        };
        points.into_iter().fold(none, |rect, point| Self {
            min: rect.min.min(point),
            max: rect.max.max(point),
        })
    }

    pub fn intersection(&self, other: &Self) -> Self {
        Self {
            min: self.min.max(other.min),
            max: self.max.min(other.max),
        }
    }

    pub fn grown(&self, amount: f64) -> Self {
        Self {
            min: self.min - amount,
            max: self.max + amount,
        }
    }

    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    pub fn center(&self) -> DVec2 {
        self.min.midpoint(self.max)
    }

    fn touches(&self, other: &Self) -> bool {
        !self.intersection(other).is_empty()
    }

    fn corners(&self) -> [DVec2; 4] {
        let Self { min, max } = *self;
        [min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)]
    }
}

/// The edges of a region, from corner to corner, and where they are.
#[derive(Clone, Debug)]
pub(super) struct Outline {
    edges: Vec<[DVec2; 2]>,
    bounds: ScreenRect,
    /// Whether the region is all that is in the bounds.
    is_rect: bool,
    rows: Rows,
}

impl Outline {
    pub fn rect(min: DVec2, max: DVec2) -> Self {
        Self {
            is_rect: true,
            ..Self::polygon(ScreenRect { min, max }.corners())
        }
    }

    /// Of one corner at least.
    pub fn polygon(corners: impl IntoIterator<Item = DVec2>) -> Self {
        let corners: Vec<DVec2> = corners.into_iter().collect();
        let next = corners.iter().cycle().skip(1);
        let edges: Vec<[DVec2; 2]> = corners.iter().zip(next).map(|(&from, &to)| [from, to]).collect();
        let bounds = ScreenRect::around(corners);
        Self {
            rows: Rows::new(&edges, &bounds),
            edges,
            bounds,
            is_rect: false,
        }
    }

    pub fn bounds(&self) -> &ScreenRect {
        &self.bounds
    }

    pub fn is_rect(&self) -> bool {
        self.is_rect
    }

    /// The edges that come near a rectangle, some of them possibly more than once.
    pub fn edges_near(&self, rect: &ScreenRect) -> impl Iterator<Item = [DVec2; 2]> + '_ {
        let rect = rect.grown(SCREEN_CONTACT);
        let edges = self.rows.members(rect.min.y..rect.max.y);
        let edges = edges.iter().map(|&edge| self.edges[edge as usize]);
        edges.filter(move |&edge| ScreenRect::around(edge).touches(&rect))
    }

    /// Whether an edge comes into a rectangle.
    pub fn enters(&self, rect: &ScreenRect) -> bool {
        let corners = rect.corners();
        let mut edges = self.edges_near(rect);
        edges.any(|edge| gap(&corners, edge) <= SCREEN_CONTACT)
    }

    /// Whether a point is in the region, by the even-odd rule; on the outline, either.
    pub fn is_inside(&self, point: DVec2) -> bool {
        let crosses = |&&edge: &&u32| {
            let [from, to] = self.edges[edge as usize];
            let (lower, upper) = if from.y <= to.y { (from, to) } else { (to, from) };
            // The lower end belongs to the edge and the upper one does not, so that a corner is passed once or twice.
            (lower.y <= point.y && point.y < upper.y) && orient2d(coord(lower), coord(upper), coord(point)) > 0.0
        };
        self.rows.at(point.y).iter().filter(crosses).count() % 2 == 1
    }

    /// Whether a point is in the region or on its outline.
    pub fn contains(&self, point: DVec2) -> bool {
        self.is_inside(point) || self.enters(&ScreenRect { min: point, max: point })
    }

    /// Whether a convex polygon, which may be flat, and its corners in either direction, touches the region.
    pub fn touches(&self, polygon: &[DVec2]) -> bool {
        let rect = ScreenRect::around(polygon.iter().copied());
        let mut edges = self.edges_near(&rect);
        edges.any(|edge| gap(polygon, edge) <= SCREEN_CONTACT) || polygon.first().is_some_and(|&at| self.is_inside(at))
    }

    /// Whether a convex polygon, which may be flat, and its corners in either direction, is wholly in the region.
    pub fn encloses(&self, polygon: &[DVec2]) -> bool {
        let rect = ScreenRect::around(polygon.iter().copied());
        let mut edges = self.edges_near(&rect);
        let is_crossed = edges.any(|edge| gap(polygon, edge) < -SCREEN_CONTACT);
        let middle = polygon.iter().sum::<DVec2>() / polygon.len() as f64;
        !is_crossed && self.contains(middle)
    }
}

/// How far apart a convex polygon and a segment are, or if they are not, how deep the one is in the other, negative: at
/// most, along any of the directions in which convex shapes can be told apart (Ericson, *Real-Time Collision Detection*,
/// 2005, §5.2.1). Zero where they touch. The axes of the screen tell flat ones apart that are on one line.
fn gap(polygon: &[DVec2], [from, to]: [DVec2; 2]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    let sides = polygon.iter().zip(next).map(|(&from, &to)| to - from);
    let axes = sides.chain([to - from]).filter_map(|side| side.perp().try_normalize());
    let mut gap = f64::NEG_INFINITY;
    for axis in [DVec2::X, DVec2::Y].into_iter().chain(axes) {
        let along = polygon.iter().map(|corner| axis.dot(*corner));
        let (first, last) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(first, last), at| {
            (first.min(at), last.max(at))
        });
        let (a, b) = (axis.dot(from), axis.dot(to));
        gap = gap.max(first - a.max(b)).max(a.min(b) - last);
    }
    gap
}

fn coord(point: DVec2) -> Coord<f64> {
    Coord { x: point.x, y: point.y }
}

/// Rows of equal height, each with the numbers of the edges that reach into it.
#[derive(Clone, Debug)]
struct Rows {
    top: f64,
    per_pixel: f64,
    /// Where the edges of each row begin among all, with the end of the last.
    starts: Vec<u32>,
    edges: Vec<u32>,
}

impl Rows {
    fn new(edges: &[[DVec2; 2]], bounds: &ScreenRect) -> Self {
        let count = edges.len().min(MOST_ROWS);
        let per_pixel = count as f64 / (bounds.max.y - bounds.min.y);
        let mut rows = Self {
            top: bounds.min.y,
            // Without a height, there is one row.
            per_pixel: if per_pixel.is_finite() { per_pixel } else { 0.0 },
            starts: vec![0; count + 1],
            edges: Vec::new(),
        };
        let reach = |rows: &Self, [from, to]: [DVec2; 2]| rows.row(from.y.min(to.y))..=rows.row(from.y.max(to.y));
        for &edge in edges {
            for row in reach(&rows, edge) {
                rows.starts[row + 1] += 1;
            }
        }
        for row in 0..count {
            rows.starts[row + 1] += rows.starts[row];
        }
        rows.edges = vec![0; rows.starts[count] as usize];
        let mut ends = rows.starts.clone();
        for (number, &edge) in (0..).zip(edges) {
            for row in reach(&rows, edge) {
                rows.edges[ends[row] as usize] = number;
                ends[row] += 1;
            }
        }
        rows
    }

    /// The row of a height; of what is above or below, the first or the last.
    fn row(&self, y: f64) -> usize {
        // Negative numbers become zero.
        (((y - self.top) * self.per_pixel) as usize).min(self.starts.len() - 2)
    }

    fn at(&self, y: f64) -> &[u32] {
        self.members(y..y)
    }

    fn members(&self, y: Range<f64>) -> &[u32] {
        let (first, last) = (self.row(y.start), self.row(y.end).max(self.row(y.start)));
        &self.edges[self.starts[first] as usize..self.starts[last + 1] as usize]
    }
}
