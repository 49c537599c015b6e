//! Spheres and axis-aligned boxes that move along a ray, and when they first touch something.
//!
//! **Exactness.** No contact is missed. What comes closer than
//! [`tolerance::SWEEP_CONTACT`](super::tolerance::SWEEP_CONTACT) of the largest coordinate in play counts as touched, so
//! that the parameter is at most that much too early, and never too late; then it is rounded to the nearest `f32`, which
//! is half a unit in its last place either way.

mod aabb;
mod advance;
mod sphere;

pub use aabb::AabbSweep;
pub use sphere::SphereSweep;

use super::ray::Ray;

/// A moving shape that knows when it first touches another kind of shape, which stands still.
pub trait SweepIntersection<Shape: ?Sized> {
    /// The first parameter of the ray at which the moving shape touches `shape`, in the space of both, or `None` if it
    /// never does. [`t_min`](super::ray::Ray::t_min) where it touches at the start; see the [module](self) for rounding.
    fn intersection_at(&self, shape: &Shape) -> Option<f32>;
}

/// The nearest `f32` among the parameters of the ray.
fn round_within(t: f64, ray: &Ray) -> f32 {
    (t as f32).max(ray.t_min()).min(ray.t_max())
}
