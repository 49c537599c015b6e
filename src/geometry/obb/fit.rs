//! The search for the axes of a small box around points.
//!
//! An idea of Larsson and Källberg, *Fast Computation of Tight-Fitting Oriented Bounding Boxes*, Game Engine Gems 2,
//! 2011: search with the points that are extremal along some fixed directions. Those here are spread so that each
//! octant, however it is turned, has one well inside, so that the sample of points that fill a box has all its corners.
//! An edge of the box is then the line between two of the sample, and with that as one axis the others are exact: they
//! are a smallest rectangle. The lines between any two of the sample are tried so (cf. Barequet and Har-Peled, *Efficiently
//! Approximating the Minimum-Volume Bounding Box of a Point Set in Three Dimensions*, J. Algorithms 38, 2001); the best
//! are improved by smallest rectangles about each axis in turn, and points that stick out join the sample.

use bevy::math::{DMat3, DVec2, DVec3};

use super::{extent, rectangle};
use crate::geometry::tolerance;

/// The axes of a small box around the points, of which there is one at least.
pub fn axes(points: &[DVec3]) -> DMat3 {
    let measure = Measure::among(points);
    let mut sample = Vec::new();
    let mut best = DMat3::IDENTITY;
    for round in 0..2 {
        // A thin set has the same few points at its ends along most directions: the second time they are those of the
        // space in which the box found so far is a cube.
        let stretched = if round == 0 {
            DMat3::IDENTITY
        } else {
            best * measure.cube(points, &best)
        };
        let ends = extremal(
            points,
            &DIRECTIONS.map(|direction| stretched * DVec3::from_array(direction)),
        );
        join(&mut sample, &ends);
        best = searched(best, &ends, &sample, &measure);
    }
    for _ in 0..REPAIRS {
        if !join(&mut sample, &extremal(points, &[best.x_axis, best.y_axis, best.z_axis])) {
            break;
        }
        (best, _) = refined(best, &sample, &measure);
    }
    best
}

/// The axes of the smallest box around the sample with a first axis between two of the `ends`, or with the axes of the
/// space or those given, as refined.
fn searched(known: DMat3, ends: &[DVec3], sample: &[DVec3], measure: &Measure) -> DMat3 {
    let sized = |axes: DMat3| (axes, measure.of_points(sample, &axes));
    let mut candidates: Vec<_> = first_axes(ends)
        .into_iter()
        .map(|axis| sized(about(axis, sample, measure)))
        .collect();
    candidates.sort_by(|(_, a), (_, b)| a.total_cmp(b));
    candidates.truncate(REFINED);
    candidates
        .into_iter()
        .map(|(axes, _)| axes)
        .chain([DMat3::IDENTITY, known])
        .map(|axes| refined(axes, sample, measure))
        .min_by(|(_, a), (_, b)| a.total_cmp(b))
        .map_or(known, |(axes, _)| axes)
}

/// Adds what is new among the `points`; whether there was any.
fn join(sample: &mut Vec<DVec3>, points: &[DVec3]) -> bool {
    let known = sample.len();
    for point in points {
        if !sample.contains(point) {
            sample.push(*point);
        }
    }
    sample.len() > known
}

/// How many of the candidates are refined.
const REFINED: usize = 4;

/// How often points that stick out may join the sample.
const REPAIRS: usize = 4;

/// The 13 axes of a cube through its faces, edges and corners.
const DIRECTIONS: [[f64; 3]; 13] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 1.0, 0.0],
    [1.0, -1.0, 0.0],
    [1.0, 0.0, 1.0],
    [1.0, 0.0, -1.0],
    [0.0, 1.0, 1.0],
    [0.0, 1.0, -1.0],
    [1.0, 1.0, 1.0],
    [1.0, 1.0, -1.0],
    [1.0, -1.0, 1.0],
    [1.0, -1.0, -1.0],
];

/// The size of a box by which boxes are compared.
pub struct Measure {
    /// The extent below which one is noise.
    noise: f64,
}

impl Measure {
    /// The measure among boxes around coordinates up to `magnitude`.
    pub fn above(magnitude: f64) -> Self {
        Self {
            noise: magnitude * tolerance::FLAT,
        }
    }

    /// The measure among boxes around the points.
    pub fn among(points: &[DVec3]) -> Self {
        Self::above(points.iter().map(|point| point.abs().max_element()).fold(0.0, f64::max))
    }

    /// The volume, with extents that are noise taken for as long as noise is: of flat boxes it compares the area, and of
    /// thin ones the length, whatever the rounding of the points makes of the rest.
    pub fn of(&self, size: DVec3) -> f64 {
        size.max(DVec3::splat(self.noise)).element_product()
    }

    /// The same of a rectangle.
    pub fn of_rectangle(&self, size: DVec2) -> f64 {
        size.max(DVec2::splat(self.noise)).element_product()
    }

    /// What makes the box with these axes around the points a cube.
    fn cube(&self, points: &[DVec3], axes: &DMat3) -> DMat3 {
        let [min, max] = extent(points, axes);
        let size = (max - min).max(DVec3::splat(self.noise));
        DMat3::from_diagonal(size.max_element() / size)
    }

    fn of_points(&self, points: &[DVec3], axes: &DMat3) -> f64 {
        let [min, max] = extent(points, axes);
        self.of(max - min)
    }
}

/// The points that are farthest along the directions and against them, each once.
fn extremal(points: &[DVec3], directions: &[DVec3]) -> Vec<DVec3> {
    let mut extremal = Vec::with_capacity(2 * directions.len());
    for &direction in directions {
        let mut ends = [(f64::INFINITY, points[0]), (f64::NEG_INFINITY, points[0])];
        for &point in points {
            let along = direction.dot(point);
            if along < ends[0].0 {
                ends[0] = (along, point);
            }
            if along > ends[1].0 {
                ends[1] = (along, point);
            }
        }
        join(&mut extremal, &ends.map(|(_, end)| end));
    }
    extremal
}

/// The directions between any two of the points.
fn first_axes(points: &[DVec3]) -> Vec<DVec3> {
    let pairs = points
        .iter()
        .enumerate()
        .flat_map(|(index, a)| points[..index].iter().map(move |b| a - b));
    pairs
        .filter_map(|along| (along / along.abs().max_element()).try_normalize())
        .collect()
}

/// The axes of the smallest box that has this axis.
fn about(axis: DVec3, points: &[DVec3], measure: &Measure) -> DMat3 {
    let (u, v) = axis.any_orthonormal_pair();
    turned(&DMat3::from_cols(u, v, axis), 2, points, measure)
}

/// The axes of the smallest box that has the axis with this number.
fn turned(axes: &DMat3, number: usize, points: &[DVec3], measure: &Measure) -> DMat3 {
    let (u, v) = (axes.col((number + 1) % 3), axes.col((number + 2) % 3));
    let mut projected: Vec<_> = points
        .iter()
        .map(|&point| point - points[0])
        .map(|point| DVec2::new(u.dot(point), v.dot(point)))
        .collect();
    let (side, _) = rectangle::smallest(&mut projected, measure);
    let mut turned = *axes;
    *turned.col_mut((number + 1) % 3) = u * side.x + v * side.y;
    *turned.col_mut((number + 2) % 3) = v * side.x - u * side.y;
    turned
}

/// The axes turned about each of them in turn until the box gets no smaller, and its size.
fn refined(axes: DMat3, points: &[DVec3], measure: &Measure) -> (DMat3, f64) {
    let mut best = (axes, measure.of_points(points, &axes));
    let mut in_vain = 0;
    for number in (0..3).cycle().take(TURNS) {
        let axes = turned(&best.0, number, points, measure);
        let size = measure.of_points(points, &axes);
        if size < best.1 {
            best = (axes, size);
            in_vain = 0;
        } else {
            in_vain += 1;
        }
        if in_vain == 3 {
            break;
        }
    }
    best
}

/// How often the axes are turned at the most: as a rule three to nine turns do, but on some thin sets each gains a
/// little without end.
const TURNS: usize = 24;
