//! Whether two triangles touch, and where.
//!
//! Triangles are three vertices in any order, in one space. They are closed: those that share only a vertex, or touch
//! only at their boundaries, have a point in common. Coordinates are `f64`; those of a mesh, which are `f32`, convert
//! without loss.
//!
//! There are two tests with the same answers: [`intersect_by_edges`], the plainest, and [`intersect_by_intervals`],
//! which rejects triangles that are apart sooner and is the one behind [`Intersects`] and [`contact`].
//!
//! # Exactness
//!
//! The tests have the answer that exact arithmetic on the given coordinates has. They follow only from the signs of
//! determinants; one that rounding could have turned is computed exactly. That takes coordinates of which the largest
//! is less than 2⁶⁴⁴ times the smallest, leaving out zeros. `f32` coordinates always are, denormal ones included: they
//! span 2²⁷⁷.

mod contact;
mod determinant;
mod edges;
mod flat;
mod intervals;
mod predicates;

use bevy::math::{Vec3, primitives::Triangle3d};

pub use self::{
    contact::{TriangleContact, contact},
    edges::intersect_by_edges,
    intervals::intersect_by_intervals,
};
use super::intersection::Intersects;

/// By [`intersect_by_intervals`], so exact; false if a coordinate is NaN or infinite.
impl Intersects<Triangle3d> for Triangle3d {
    #[inline]
    fn intersects(&self, other: &Triangle3d) -> bool {
        let [a, b] = [self, other].map(|triangle| triangle.vertices.map(Vec3::as_dvec3));
        intersect_by_intervals(a, b)
    }
}
