//! Whether two shapes touch, and whether one contains the other.
//!
//! Nine kinds of shape, each against each: points ([`Vec3A`](bevy::math::Vec3A)), [`Ray`](super::ray::Ray),
//! [`Segment3d`](bevy::math::primitives::Segment3d), [`BoundingSphere`](bevy::math::bounding::BoundingSphere),
//! [`Aabb3d`](bevy::math::bounding::Aabb3d), [`Obb`](super::obb::Obb),
//! [`ConvexHull`](super::convex_hull::ConvexHull), [`ViewFrustum`](bevy::math::primitives::ViewFrustum), or a
//! [`Frustum`] prepared from it, and [`Triangle3d`](bevy::math::primitives::Triangle3d). All must be finite, boxes with
//! `min <= max`, half sizes and radii not negative; a ray and a frustum may be endless, and a ray or a frustum without
//! points touches nothing. The order of the two makes no difference.
//!
//! # Which test is how exact
//!
//! |              | point | ray | segment | sphere | `Aabb3d` | `Obb` | hull | frustum | triangle |
//! |--------------|-------|-----|---------|--------|----------|-------|------|---------|----------|
//! | **point**    | E     | E   | E       | E      | E        | D     | P    | E       | E        |
//! | **ray**      | E     | E   | E       | D      | D        | D     | P    | D       | E        |
//! | **segment**  | E     | E   | E       | D      | D        | D     | P    | D       | E        |
//! | **sphere**   | E     | D   | D       | E      | E        | S     | G    | D       | D        |
//! | **`Aabb3d`** | E     | D   | D       | E      | E        | A     | G    | D       | A        |
//! | **`Obb`**    | D     | D   | D       | S      | A        | A     | G    | D       | A        |
//! | **hull**     | P     | P   | P       | G      | G        | G     | G    | P       | G        |
//! | **frustum**  | E     | D   | D       | D      | D        | D     | P    | D       | D        |
//! | **triangle** | E     | E   | E       | D      | A        | A     | G    | D       | E        |
//!
//! - **E: exact.** By the signs of sums and determinants, without rounding. Of rays, the origin and the direction are
//!   exact where the coordinates of the origin and the direction are within a factor of 2²⁸ of each other; the ends that
//!   they have by their parameters are, if double precision holds them.
//! - **All others are conservative:** never false of shapes that touch, and possibly true of shapes that are apart by
//!   less than this:
//!   - **D: double precision.** [`tolerance::DOUBLE`](super::tolerance::DOUBLE) of the largest coordinate. Lines are
//!     clipped by planes, spheres are held against the closest point, and two polyhedra touch where an edge of one enters
//!     the other. The frustum is exactly the intersection of its half-spaces, bounded or not: no box beside a corner slips
//!     in, as with the half-spaces one by one. Only of two frusta that have no edges at all is nothing known.
//!   - **A: separating axes**, as exact as D.
//!   - **G: GJK**, as exact as D up to a small factor: see [`gjk`].
//!   - **P: planes of a hull**, whose offsets are rounded outward to `f32`: some 10⁻⁷ of the distance from the origin.
//!   - **S:** as much of the radius as the axes of the box are off their right angles, some 10⁻⁷.
//!
//! An `Obb` is the set `center + axes * local` with `|local| <= half_size`, by its axes as they are stored. A hull is that
//! of its vertices for G, and the slightly larger inside of its planes for P.
//!
//! # Containment
//!
//! [`Contains`] errs on the other side: it never claims what does not hold. It is exact for containers that are spheres,
//! boxes, hulls (by their planes) and frusta, and contents given in `f32`: points, segments, triangles, boxes, hulls, and
//! spheres in spheres and boxes. Where an `Obb` takes part, or the content is a frustum, or a sphere in planes, the
//! content must be inside by [`tolerance::DOUBLE`](super::tolerance::DOUBLE) of the largest coordinate: a box is not
//! contained in the `Obb` that it fills. So whoever skips further tests for what is contained skips none that he needs.
//! Use [`Intersects`] with a point to ask whether it may be inside. A frustum without corners, or without end, is
//! contained in nothing.
//!
//! Bevy's `IntersectsVolume` and `BoundingVolume` have methods of the same names: import one or the other.

mod containment;
mod exact;
mod frustum;
pub mod gjk;
mod pairs;
pub(crate) mod polyhedron;
pub(crate) mod sat;
pub(crate) mod simplex;
mod sphere;

pub use frustum::Frustum;

/// Shapes that know whether they touch another kind of shape.
pub trait Intersects<Other: ?Sized> {
    /// Whether the two have a point in common; boundaries count. Both in one space.
    fn intersects(&self, other: &Other) -> bool;
}

/// Shapes that know whether they contain another kind of shape.
pub trait Contains<Other: ?Sized> {
    /// Whether every point of `other` is a point of this shape; boundaries count. Both in one space.
    fn contains(&self, other: &Other) -> bool;
}
