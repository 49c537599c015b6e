//! Every tolerance that shows in an answer, each with its unit and its reason. All are relative: nothing here knows how
//! large a metre is. Bounds on the rounding of one expression, which only decide when to compute it exactly or how far to
//! round outward, stand beside it.
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

/// Relative slack of the box around a mesh in a pose, as a fraction of the magnitudes that were added up.
///
/// A skinned vertex rounds some nine times: four matrices are weighted and added up (γ₄), and the sum is applied (γ₅). The
/// box of a joint rounds twice where its centre is taken and five times where it is moved, that of the mesh three times
/// where it is scaled by the sum of the weights. 32u cover both sides.
pub const POSED_BOX: f32 = 16.0 * f32::EPSILON;

/// What each morph target adds to [`POSED_BOX`]: a product and a sum for the vertex, and as much for its box.
pub const MORPHED: f32 = 2.0 * f32::EPSILON;

/// Slack of the box of a triangle, as a fraction of the longest side of that box.
///
/// The edge functions of a triangle of size L round by up to 4u·L², which moves an edge by 4u·L: a ray that passes so
/// close outside may be reported as a hit, and must then pass the box too.
pub const TRIANGLE_BOX: f32 = 4.0 * f32::EPSILON;

/// How far [`Affine3A::transform_point3a`](bevy::math::Affine3A::transform_point3a) may be off in each coordinate, as a
/// fraction of the magnitudes that were added up: γ₄ for a product and three sums, rounded up to 5u.
pub const TRANSFORMED_POINT: f64 = 2.5 * f32::EPSILON as f64;

/// What the image of a point or a box under an affine transform loses where its products underflow, in units of its
/// space.
///
/// Not a length: eight times the smallest positive `f32`, by which all denormals differ. A dozen roundings lose up to
/// half of that each, six in all.
pub const UNDERFLOW: f32 = 8.0 * f32::MIN_POSITIVE * f32::EPSILON;

/// Relative slack of what is computed in `f64` from `f32` numbers: the few dozen roundings of 2⁻⁵³ of a test, with room
/// to spare, and a millionth of what `f32` resolves.
pub const DOUBLE: f64 = 64.0 * f64::EPSILON;

/// The extent below which points are flat, as a fraction of their largest coordinate: 16u, for coordinates that were
/// rotated into place are off by some 8u on either side.
pub const FLAT: f64 = 8.0 * f32::EPSILON as f64;

/// How far the faces of a convex hull may lie below a plane that they share, as a fraction of the sum of its largest
/// coordinates on the three axes.
///
/// The corners of what was one face before it was rotated in `f32` lie within some 4u of a plane.
pub const HULL_FACE: f64 = 2.0 * f32::EPSILON as f64;

/// Relative slack of the ray test of a convex hull, as a fraction of the magnitudes that were added up.
///
/// The distance of the start of the ray from a plane costs three products and four sums, the speed towards it three and
/// three, and their quotient rounds once more: below 7u for each, and 8u are allowed.
pub const HULL_RAY: f32 = 4.0 * f32::EPSILON;

/// How close to the start of a ray a hit on a torus is at the start, as a fraction of the distance from there to the
/// point of the ray that is nearest to the centre of the torus.
///
/// Roots are measured from that point, and are right to some 2⁻⁵⁰ of this distance unless the tube is thin; 2⁻⁴⁰ is
/// still far below the spacing of `f32`, 2⁻²⁴.
pub const TORUS_START: f64 = 1.0 / (1u64 << 40) as f64;

/// When the search for the distance between two convex shapes ends: upper and lower bound differ by no more than this
/// fraction of the distance.
///
/// Far above the rounding of double precision, so that it is reached, and 10⁴ times below that of `f32`, so that
/// nobody sees it in the result. Curved shapes, which the search closes in on one point at a time, need it.
pub const GJK_CONVERGENCE: f64 = 1e-11;

/// How close a moving shape must come to count as touching, as a fraction of the largest coordinate in play.
///
/// The closest points come from double precision, with an error of [`DOUBLE`], or from GJK, with a few times that; this
/// is 2⁸ times the former, and 10⁴ times below the spacing of `f32`.
pub const SWEEP_CONTACT: f64 = 256.0 * DOUBLE;

/// How close to the centre of a moving sphere the point that it touches is the centre, as a fraction of the largest
/// coordinate in play: the direction from the one to the other is then no normal.
///
/// The parameter of the contact is rounded to `f32`, by u of the way to there; at 16u the direction is right to a
/// sixteenth.
pub const CONTACT_NORMAL: f64 = 8.0 * f32::EPSILON as f64;

/// Bound on the rounding of an orientation determinant in `f64`, as a fraction of the sum of the magnitudes of its
/// products.
///
/// Each product of a 3×3 determinant of differences rounds eight times at most, so γ₈ with `f64`'s u = 2⁻⁵³ would do;
/// 16u covers the rounding of the sum of magnitudes too. A determinant beyond the bound has the right sign.
pub const ORIENTATION: f64 = 8.0 * f64::EPSILON;

/// What an orientation determinant must exceed besides [`ORIENTATION`], in the unit of the magnitudes that are added up.
///
/// It covers what underflow takes away from a product, 2⁻¹⁰⁷⁴ at most, whatever the product is multiplied by. No
/// determinant of `f32` coordinates is smaller but zero: the least is 2⁻⁴⁴⁷.
pub const ORIENTATION_UNDERFLOW: f64 = f64::MIN_POSITIVE / f64::EPSILON;

/// The least determinant that a point is constructed from as it is, as a fraction of the sum of the magnitudes of its
/// products. Below, it is computed exactly and rounded once.
///
/// At 2⁻⁸ the relative error of a determinant is [`ORIENTATION`] / 2⁻⁸ = 2⁻⁴¹.
pub const WELL_CONDITIONED: f64 = 1.0 / 256.0;

/// Relative slack of the signed distance of a box from a plane, and of a corner of a region, as a fraction of the
/// magnitudes that were added up: three products and three sums of rounded factors, γ₆, doubled.
///
/// Decides only whether what is in a box is looked at one by one, never what is found.
pub const REGION_PLANE: f32 = 8.0 * f32::EPSILON;

/// How much farther than a moving shape reaches boxes are looked for, as a fraction of the largest coordinate of the
/// shape: [`SWEEP_CONTACT`], rounded up to where `f32` tells the difference.
pub const SWEEP_REACH: f32 = f32::EPSILON;

/// Distances below this may have a square that is rounded to zero, or to that of another: √2⁻¹⁴⁹, rounded up.
pub const SQUARE_UNDERFLOW: f32 = 1e-22;

/// How close to each other two things on the screen count as touching, in logical pixels: a billionth of one.
///
/// Far below what anybody can point at, and a thousand times what double precision leaves uncertain of a place on a screen
/// of some thousand pixels.
pub const SCREEN_CONTACT: f64 = 1e-9;

/// How far coverage of pixels errs to the safe side, in pixels: far more than double precision leaves uncertain of a
/// place on the screen, and far less than anybody sees.
pub const RASTER_PIXELS: f32 = 1.0 / 256.0;

/// Relative slack of a line or a depth on the screen, as a fraction of the magnitudes that are added up: rounding a
/// start, a slope and a distance to `f32`, and one product and two sums.
pub const RASTER_LINE: f32 = 4.0 * f32::EPSILON;

/// The volume that three corners in clip space must span with the eye, as a fraction of the product of their distances,
/// for the depth between them to be told from their plane: double precision then leaves 2⁻²² of it uncertain.
pub const RASTER_PLANE: f64 = 1.0 / (1u64 << 28) as f64;

/// Relative slack of a box on the screen, as a fraction of the magnitudes that are added up to the place of a corner:
/// four products and three sums, and the corner itself, γ₆, doubled.
pub const RASTER_BOX: f32 = 8.0 * f32::EPSILON;

/// The same for a corner in double precision, sixteenfold: what is drawn strictly must be surer of its place than a
/// sixteenth of [`RASTER_PIXELS`].
pub const RASTER_CORNER: f64 = 128.0 * f64::EPSILON;

/// How far beside the screen something must be to be left out unseen, as a fraction of the half of the screen: far more than
/// rounding, and no pixel.
pub const RASTER_BESIDE: f64 = 1.0 / 1024.0;

/// How much of a pixel an edge must go down to bound what is beside it: less is level.
pub const RASTER_LEVEL: f64 = 1.0 / (1u64 << 31) as f64;

/// How far apart the two sides of a seam of a solid mesh may be, as a fraction of the largest coordinate.
///
/// A full turn ends beside its beginning, for the sine of 2π as `f32` has it is 1.5u off zero, and a few roundings more
/// where the turn is placed; 32u cover that, and no gap of this width is seen on any screen.
pub const SEAM: f64 = 16.0 * f32::EPSILON as f64;

/// How far the faces of a box inside of a mesh stay away from the surface, as a fraction of the size of the box on that
/// axis.
///
/// A depth buffer of `f32` that is drawn by the box, and asked about what lies on the surface, tells the two apart.
pub const INNER_BOX: f64 = 1.0 / 4096.0;

/// How close to an end of a line of sight what it meets is at that end, and not in between, as a fraction of the largest
/// coordinate of the two ends.
///
/// A point where a ray hit a surface is off that by some 8u, of the coordinates of both; along a line of sight that is
/// more by the slope at which it leaves the surface: 64u leave room for angles down to a tenth of a radian.
pub const LINE_OF_SIGHT: f32 = 32.0 * f32::EPSILON;
