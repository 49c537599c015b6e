//! The distance between two convex shapes, from nothing but their farthest points.
//!
//! Sources: Gilbert, Johnson and Keerthi, *A Fast Procedure for Computing the Distance Between Complex Objects in
//! Three-Dimensional Space*, 1988; van den Bergen, *A Fast and Robust GJK Implementation*, 1999, for the bounds that it
//! ends by; Ericson, *Real-Time Collision Detection*, 2005, §9.5.
//!
//! Two shapes count as apart when a direction is found in which one ends before the other begins, by more than the
//! rounding of their farthest points ([`tolerance::DOUBLE`] of the largest coordinate). Without such a proof they count
//! as touching: so the search may end at any time, and never misses a contact. Polytopes that are farther apart than a
//! few times that are told apart; round shapes, which it closes in on step by step, from about 10⁻⁷ of their size.
//!
//! For coordinates of the range of `f32`. A NaN counts as touching.

use bevy::math::DVec3;

use super::simplex::{Closest, closest_to_origin, weighted};
use crate::geometry::{support::Support, tolerance};

/// How far apart two shapes are, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Separation {
    /// The distance, in units of the space of both; zero if the shapes touch or overlap.
    pub distance: f64,
    /// A lower bound of the distance, no more than that, proven by the [`normal`](Self::normal) up to rounding; zero if the shapes touch or overlap.
    pub bound: f64,
    /// The unit vector that points from the second shape to the first, along which they are `bound` apart; zero if the
    /// shapes touch or overlap.
    pub normal: DVec3,
    /// The closest points of the first and of the second shape. Where the shapes touch or overlap, a point of each that
    /// are the same up to rounding.
    pub points: [DVec3; 2],
}

/// Whether the two have a point in common; boundaries count. Both in one space.
///
/// Conservative: see the [module](self). The order of the two makes no difference beyond that slack.
pub fn intersects(a: &impl Support, b: &impl Support) -> bool {
    search(a, b, true).distance == 0.0
}

/// How far apart the two are, in the space of both, to [`tolerance::GJK_CONVERGENCE`] of the distance and
/// [`tolerance::DOUBLE`] of the largest coordinate.
pub fn distance(a: &impl Support, b: &impl Support) -> Separation {
    search(a, b, false)
}

/// Enough for every polytope: each step but the last few halves the remaining gap between the bounds, or adds a vertex
/// for good. A search that is cut off says that the shapes touch, or gives the distance that it has.
const STEPS: usize = 256;

/// With `until_apart`, ends as soon as the shapes are known to be apart: the distance is then merely not zero.
fn search(a: &impl Support, b: &impl Support, until_apart: bool) -> Separation {
    let mut simplex = Simplex::new(a.support_point(DVec3::NEG_X), b.support_point(DVec3::X));
    let mut nearest = simplex.difference[0];
    let mut largest = simplex.largest();
    let (mut proven, mut normal) = (0.0, DVec3::ZERO);
    for _ in 0..STEPS {
        let length = nearest.length();
        if length <= tolerance::DOUBLE * largest {
            break;
        }
        let direction = simplex.direction(nearest);
        let (of_a, of_b) = (a.support_point(-direction), b.support_point(direction));
        largest = largest.max(of_a.abs().max_element()).max(of_b.abs().max_element());
        let bound = direction.dot(of_a - of_b);
        if bound > tolerance::DOUBLE * largest {
            if bound > proven {
                (proven, normal) = (bound, direction);
            }
            if until_apart {
                break;
            }
        }
        if length - bound <= tolerance::GJK_CONVERGENCE * length || simplex.has(of_a - of_b) {
            break;
        }
        let mut grown = simplex;
        let next = grown.grow(of_a, of_b);
        // Not where rounding has the last word, nor where a coordinate is NaN.
        let closer = next.length_squared() < nearest.length_squared();
        if !closer {
            break;
        }
        (simplex, nearest) = (grown, next);
        if simplex.count == 4 {
            // The origin is inside.
            break;
        }
    }
    let distance = if proven > 0.0 { nearest.length() } else { 0.0 };
    Separation {
        distance,
        bound: proven.min(distance),
        normal,
        points: simplex.points(),
    }
}

/// One to four points of the difference of the two shapes, and the weights of the point among them that is closest to
/// the origin.
#[derive(Clone, Copy)]
struct Simplex {
    count: usize,
    of_a: [DVec3; 4],
    of_b: [DVec3; 4],
    difference: [DVec3; 4],
    weights: [f64; 4],
}

impl Simplex {
    fn new(of_a: DVec3, of_b: DVec3) -> Self {
        Self {
            count: 1,
            of_a: [of_a; 4],
            of_b: [of_b; 4],
            difference: [of_a - of_b; 4],
            weights: [1.0, 0.0, 0.0, 0.0],
        }
    }

    fn largest(&self) -> f64 {
        self.of_a[0].abs().max_element().max(self.of_b[0].abs().max_element())
    }

    fn has(&self, difference: DVec3) -> bool {
        self.difference[..self.count].contains(&difference)
    }

    /// Adds a point, drops those that the closest point does not need, and returns that.
    fn grow(&mut self, of_a: DVec3, of_b: DVec3) -> DVec3 {
        self.of_a[self.count] = of_a;
        self.of_b[self.count] = of_b;
        self.difference[self.count] = of_a - of_b;
        self.count += 1;
        let Closest { point, weights } = closest_to_origin(&self.difference[..self.count]);
        let before = std::mem::replace(&mut self.count, 0);
        for (index, &weight) in weights[..before].iter().enumerate() {
            if weight > 0.0 {
                self.of_a[self.count] = self.of_a[index];
                self.of_b[self.count] = self.of_b[index];
                self.difference[self.count] = self.difference[index];
                self.weights[self.count] = weight;
                self.count += 1;
            }
        }
        point
    }

    /// The unit vector towards `nearest`, the point closest to the origin.
    ///
    /// At right angles to the edge or the triangle that this is: the closer that comes to the origin, the less does the
    /// closest point alone say about the direction.
    fn direction(&self, nearest: DVec3) -> DVec3 {
        let [a, b, c, _] = self.difference;
        let direction = match self.count {
            2 => nearest - (b - a) * (nearest.dot(b - a) / (b - a).length_squared()),
            3 => {
                let normal = (b - a).cross(c - a);
                normal * normal.dot(a).signum()
            }
            _ => nearest,
        };
        direction.try_normalize().unwrap_or(nearest.normalize_or_zero())
    }

    fn points(&self) -> [DVec3; 2] {
        [
            weighted(&self.of_a[..self.count], &self.weights),
            weighted(&self.of_b[..self.count], &self.weights),
        ]
    }
}
