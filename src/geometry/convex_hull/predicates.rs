//! Exact orientation of double-precision points (Shewchuk, *Adaptive Precision Floating-Point Arithmetic and Fast
//! Robust Geometric Predicates*, 1997).
//!
//! Exact for points whose coordinates are `f32`: no product of three of their differences overflows or underflows.

use bevy::math::{DVec2, DVec3, Vec3Swizzles};
use robust::{Coord, Coord3D};

/// Positive if `point` sees the triangle counter-clockwise, zero if it lies in its plane.
pub(super) fn orient3d([a, b, c]: [DVec3; 3], point: DVec3) -> f64 {
    let coord = |p: DVec3| Coord3D { x: p.x, y: p.y, z: p.z };
    -robust::orient3d(coord(a), coord(b), coord(c), coord(point))
}

/// Positive if the triangle runs counter-clockwise, zero if its corners lie on a line.
pub(super) fn orient2d([a, b, c]: [DVec2; 3]) -> f64 {
    let coord = |p: DVec2| Coord { x: p.x, y: p.y };
    robust::orient2d(coord(a), coord(b), coord(c))
}

/// The projections along the three axes, each of which keeps the cyclic order of the other two.
pub(super) const PROJECTIONS: [fn(DVec3) -> DVec2; 3] = [|p| p.yz(), |p| p.zx(), |p| p.xy()];

/// Whether the three points lie on a line.
pub(super) fn collinear(corners: [DVec3; 3]) -> bool {
    (PROJECTIONS.iter()).all(|&project| orient2d(corners.map(project)) == 0.0)
}
