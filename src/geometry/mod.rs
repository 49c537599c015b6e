//! Geometry without an ECS: bounding volumes, surfaces, and the tests between rays and shapes.
//!
//! | for | see |
//! |---|---|
//! | what is around something | [`volume`]: the trait [`Volume`](volume::Volume), and which of [spheres](bounding_sphere), [boxes](aabb), [oriented boxes](obb) and [convex hulls](convex_hull) to choose |
//! | boxes of Bevy's primitives under any transform | [`primitive_bounds`] |
//! | what a ray hits | [`ray`], [`surface`]: primitives, groups, bounded surfaces |
//! | whether two shapes touch, or one contains the other | [`intersection`]: the table of all pairs |
//! | where two triangles meet | [`triangle_triangle`] |
//! | how far and where | [`closest_point`], [`intersection::gjk`] |
//! | when a moving shape touches another | [`sweep`] |
//!
//! # Conventions
//!
//! - **Types.** [`bevy_math`](bevy::math) has most of the types; this module adds what they lack. Boxes are
//!   [`Aabb3d`](bevy::math::bounding::Aabb3d), spheres [`BoundingSphere`](bevy::math::bounding::BoundingSphere).
//! - **Spaces.** *World* is the space of `GlobalTransform`, *local* that of a mesh. A function that takes several
//!   shapes wants them all in one space, whichever it is; a function that changes space says so in its name.
//! - **Units.** Lengths are Bevy's, metres by habit. A [`Ray`](ray::Ray) measures along itself in its own parameter
//!   `t`, in multiples of the length of its direction, so that a ray keeps its parameter under every affine transform.
//! - **Closed sets.** Boxes, intervals and triangles contain their boundary: touching counts as intersecting.
//! - **Rounding.** What culls rounds outward: a box test may report a box that the exact ray misses by a few units
//!   in the last place, and never the reverse. Every such slack lives in [`tolerance`], with its unit and its reason.

pub mod aabb;
pub mod bounding_sphere;
pub mod closest_point;
pub mod convex_hull;
pub mod intersection;
pub mod obb;
pub mod primitive_bounds;
pub mod ray;
pub(crate) mod rounding;
pub mod support;
pub mod surface;
pub mod sweep;
pub mod tolerance;
pub mod triangle_triangle;
pub mod volume;
