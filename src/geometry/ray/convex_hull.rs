//! Ray against convex hull: clipping by its planes.

use bevy::math::Vec3A;

use super::Ray;
use crate::geometry::{
    convex_hull::{ConvexHull, LANES, PlaneLanes},
    tolerance,
};

impl Ray {
    /// The parameter at which the ray enters `hull`, in the space of both, or `None` if it misses.
    ///
    /// Its [`t_min`](Ray::t_min) where the ray starts inside. Conservative: never misses a hull that the exact ray touches,
    /// and may report one that it misses by [`tolerance::HULL_RAY`] of the way there, or of the distance of the two from
    /// the origin; the parameter is never too large. Close to overflow every ray hits.
    ///
    /// Source: Kay and Kajiya, *Ray Tracing Complex Scenes*, 1986; Ericson, *Real-Time Collision Detection*, 2005,
    /// §5.3.8. The distance to each plane and the speed away from it are lowered by their rounding before they are
    /// divided: as no parameter is negative, that moves entries forward and exits back, and decides parallel planes too.
    #[inline]
    pub fn convex_hull_intersection_at(&self, hull: &ConvexHull) -> Option<f32> {
        let origin = self.origin;
        let reach = sum_of_coordinates(origin);
        if reach > f32::MAX / 8.0 {
            return (self.t_min <= self.t_max).then_some(self.t_min);
        }
        // A power of two takes the direction to where its products neither overflow nor underflow.
        let scale = power_of_two_below(self.direction.abs().max_element());
        let direction = self.direction / scale;
        let slack = reach * tolerance::HULL_RAY + f32::MIN_POSITIVE * tolerance::HULL_RAY;
        let slack_of_speed = sum_of_coordinates(direction) * tolerance::HULL_RAY;

        let (mut enter, mut leave) = ([0.0f32; LANES], [f32::INFINITY; LANES]);
        for PlaneLanes { x, y, z, offset } in hull.lanes() {
            for lane in 0..LANES {
                let along = |v: Vec3A| x[lane] * v.x + y[lane] * v.y + z[lane] * v.z;
                let speed = along(direction) - slack_of_speed;
                let t = (offset[lane] - along(origin) + slack) / speed;
                // Of a plane that the ray runs in, t is NaN: no bound. Outside of one that it runs along, -inf: a miss.
                let (entered, left) = if speed < 0.0 { (t, f32::INFINITY) } else { (0.0, t) };
                enter[lane] = larger(entered, enter[lane]);
                leave[lane] = smaller(left, leave[lane]);
            }
            if enter.iter().zip(&leave).any(|(enter, leave)| enter > leave) {
                return None;
            }
        }
        // Each quotient may have underflown by half a unit; of normal numbers this changes nothing.
        let scaled = combined(enter, larger) - SMALLEST;
        let leave = (combined(leave, smaller) + SMALLEST) / scale;
        let enter = scaled / scale;
        // Rounds only where it underflows.
        let enter = if enter * scale > scaled {
            enter.next_down()
        } else {
            enter
        };
        let enter = enter.max(self.t_min);
        (enter <= leave && enter <= self.t_max && enter < f32::INFINITY).then_some(enter)
    }
}

/// The smallest positive `f32`, by which all denormals differ.
const SMALLEST: f32 = f32::MIN_POSITIVE * f32::EPSILON;

/// The larger of the two, and `b` if one is NaN: what one instruction computes.
#[inline]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The smaller of the two, and `b` if one is NaN.
#[inline]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// All lanes in one, half by half.
#[inline]
fn combined(lanes: [f32; LANES], combine: impl Fn(f32, f32) -> f32) -> f32 {
    let halves: [f32; LANES / 2] = std::array::from_fn(|lane| combine(lanes[lane], lanes[lane + LANES / 2]));
    let quarters: [f32; LANES / 4] = std::array::from_fn(|lane| combine(halves[lane], halves[lane + LANES / 4]));
    combine(quarters[0], quarters[1])
}

#[inline]
fn sum_of_coordinates(v: Vec3A) -> f32 {
    v.abs().element_sum()
}

/// The largest power of two that is no larger than a positive number; of a denormal, the smallest there is.
#[inline]
fn power_of_two_below(value: f32) -> f32 {
    const FRACTION: u32 = (1 << (f32::MANTISSA_DIGITS - 1)) - 1;
    if value < f32::MIN_POSITIVE {
        // Of a denormal the fraction holds the exponent: any power that is no larger will do.
        return SMALLEST;
    }
    f32::from_bits(value.to_bits() & !FRACTION)
}
