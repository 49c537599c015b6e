//! Every tolerance of the crate, each with its unit and its reason. All are relative: nothing here knows how large a
//! metre is.
//!
//! `u` below is the unit roundoff of `f32`, 2⁻²⁴, which is half of [`f32::EPSILON`]; γₙ = n·u / (1 − n·u) bounds the
//! relative error of n roundings (Higham, *Accuracy and Stability of Numerical Algorithms*, 2002, §3.1).

/// Relative slack of a box under an affine transform, as a fraction of the magnitudes that were added up.
///
/// One row of the transform costs three products and three sums (γ₄ on each side), and a box kept as centre and half
/// extents, as Bevy keeps it, lost up to 2u when it was made. 16u covers both with room to spare.
pub const BOX_TRANSFORM: f32 = 8.0 * f32::EPSILON;

/// Relative slack of the parameters at which a ray enters and leaves a box.
///
/// `(bound - origin) * recip` rounds three times, so each parameter is right to γ₃ (Ize, *Robust BVH Ray Traversal*,
/// JCGT 2013, §3). The parameter of a hit, which the ray is shortened to, is sheared by the same quotients and rounds
/// some seven times more; 16u on each side lets every such hit pass the boxes above it.
pub const SLAB: f32 = 8.0 * f32::EPSILON;

/// Slack of the box of a triangle, as a fraction of the longest side of that box.
///
/// The edge functions of a triangle of size L round by up to 4u·L², which moves an edge by 4u·L: a ray that passes so
/// close outside may be reported as a hit, and must then pass the box too.
pub const TRIANGLE_BOX: f32 = 4.0 * f32::EPSILON;
