//! Tori.

use bevy::math::{DVec2, DVec3, primitives::Torus};
use smallvec::SmallVec;

use super::{
    Surface, SurfaceHit,
    chart::{Chart, Coordinate},
    solid::{Solid, surface_by_solid},
    span::{Crossing, Line, slab_span},
};
use crate::geometry::{
    ray::{Ray, triangle::Backfaces},
    tolerance,
};

/// The set where (√(x² + z²) ∓ major)² + y² = minor², for both signs: of a spindle torus, whose tube is wider than its
/// ring, also the lemon inside, which bounds a cavity as it does on the mesh. u goes around the ring, from the +x axis
/// towards +z; v goes around the tube, from the outermost circle upward.
///
/// Where a ray grazes the surface, and two hits are closer than some 2⁻²⁶ of the size of the torus, rounding may find
/// none of them.
impl Surface for Torus {
    surface_by_solid!(Torus, Ring);
}

struct Ring {
    major: f64,
    minor: f64,
}

impl From<&Torus> for Ring {
    #[inline]
    fn from(torus: &Torus) -> Self {
        Self {
            major: f64::from(torus.major_radius).abs(),
            minor: f64::from(torus.minor_radius).abs(),
        }
    }
}

/// A line that passes the origin at the parameter 0, in a space where its direction is a unit vector and the torus has
/// an outer radius of 1.
struct UnitLine {
    origin: DVec3,
    direction: DVec3,
    major: f64,
    minor: f64,
}

impl UnitLine {
    /// Negative in the tube, zero on the surface: a quartic in `s`; and its derivative.
    fn depth(&self, s: f64) -> (f64, f64) {
        let point = self.origin + self.direction * s;
        let (ground, across) = (
            DVec2::new(point.x, point.z),
            DVec2::new(self.direction.x, self.direction.z),
        );
        let radius = ground.length();
        // In factors: their difference of squares has lost the tube of a thin torus.
        let (near, far) = (radius - self.major, radius + self.major);
        let rest = (point.y - self.minor) * (point.y + self.minor);
        let (near, far, middle) = (
            near * near + rest,
            far * far + rest,
            radius * radius + self.major * self.major + rest,
        );
        // Half of the derivatives of radius² and of y².
        let (outward, upward) = (ground.dot(across), point.y * self.direction.y);
        let slope = 4.0 * (outward * (middle - 2.0 * self.major * self.major) + upward * middle);
        (near * far, slope)
    }

    /// The derivative of the depth, and its derivative in turn.
    ///
    /// Without the factors the depth is s⁴ + c₂ s² + c₁ s + c₀, because the origin is the point that is nearest to the
    /// centre.
    fn slope(&self) -> impl Fn(f64) -> (f64, f64) {
        let (major2, rise) = (self.major * self.major, self.direction.y);
        let flat = 1.0 - rise * rise;
        let c2 = 2.0 * (self.origin.length_squared() + major2 - self.minor * self.minor) - 4.0 * major2 * flat;
        let c1 = 8.0 * major2 * self.origin.y * rise;
        move |s| ((4.0 * s * s + 2.0 * c2) * s + c1, 12.0 * s * s + 2.0 * c2)
    }

    /// The parameters in ascending order at which the line crosses the surface.
    fn crossings(&self) -> impl Iterator<Item = f64> {
        let slope = self.slope();
        let bend = (-slope(0.0).1 / 12.0).max(0.0).sqrt();
        let turns: SmallVec<[f64; 3]> = roots_between([-OUTSIDE, -bend, bend, OUTSIDE], slope).collect();
        roots_between([-OUTSIDE].into_iter().chain(turns).chain([OUTSIDE]), |s| self.depth(s))
    }
}

/// A parameter at which a line is outside of the unit ball on either side.
const OUTSIDE: f64 = 1.001;

/// The roots of a function that is monotonic between the given points, in ascending order. It also gives its derivative.
fn roots_between(
    points: impl IntoIterator<Item = f64>,
    function: impl Fn(f64) -> (f64, f64),
) -> impl Iterator<Item = f64> {
    let mut points = points.into_iter();
    let mut from = points.next().map(|point| (point, function(point).0));
    std::iter::from_fn(move || {
        loop {
            let (a, at_a) = from?;
            let b = points.next()?;
            let at_b = function(b).0;
            from = Some((b, at_b));
            if (at_a < 0.0) != (at_b < 0.0) {
                return Some(root_between(a, b, at_a < 0.0, &function));
            }
        }
    })
}

/// The root of a function between two points, at the first of which it is negative or not, and at the second the
/// opposite: Newton's method, with a bisection whenever that leaves the interval or is slow (Press et al., *Numerical
/// Recipes*, 2007, §9.4).
fn root_between(mut a: f64, mut b: f64, rises: bool, function: impl Fn(f64) -> (f64, f64)) -> f64 {
    let mut root = 0.5 * (a + b);
    let mut last_step = b - a;
    for _ in 0..STEPS {
        let (value, slope) = function(root);
        if value == 0.0 {
            break;
        }
        if (value < 0.0) == rises {
            a = root;
        } else {
            b = root;
        }
        let newton = root - value / slope;
        let next = if a < newton && newton < b && (newton - root).abs() <= 0.5 * last_step {
            newton
        } else {
            0.5 * (a + b)
        };
        last_step = (next - root).abs();
        root = next;
        if last_step <= SHORT_STEP {
            break;
        }
    }
    root
}

/// The step after which the next one would not show in an `f32`, nor in the tube of a torus that is one in a million
/// thick; rounding makes no steps of this size.
const SHORT_STEP: f64 = 1.0 / (1u64 << 46) as f64;

/// More than the bits that an interval of the size of the torus has for bisection.
const STEPS: usize = 100;

impl Solid for Ring {
    type Face = ();

    fn half_size(&self) -> DVec3 {
        let outer = self.major + self.minor;
        DVec3::new(outer, self.minor, outer)
    }

    #[inline]
    fn round_size(&self) -> f64 {
        self.major + self.minor
    }

    fn first_crossing(&self, line: &Line, ray: &Ray, backfaces: Backfaces) -> Option<Crossing<()>> {
        let outer = self.round_size();
        slab_span(line.origin.y, line.direction.y, self.minor, [(); 2])?;
        let speed = line.direction.length();
        let nearest = -line.origin.dot(line.direction) / (speed * speed);
        let unit = UnitLine {
            origin: line.at(nearest) / outer,
            direction: line.direction / speed,
            major: self.major / outer,
            minor: self.minor / outer,
        };
        if !(unit.origin.length_squared() <= 1.0 && self.minor > 0.0) {
            return None;
        }
        let scale = outer / speed;
        unit.crossings().enumerate().find_map(|(number, s)| {
            // The line begins outside, and each crossing changes sides.
            let enters = number % 2 == 0;
            if !enters && backfaces == Backfaces::Cull {
                return None;
            }
            let t = nearest + s * scale;
            // A ray that starts on the surface hits it there, and not a rounding before.
            let t = if t.abs() <= nearest.abs() * tolerance::TORUS_START {
                0.0
            } else {
                t
            };
            Some(Crossing {
                point: (unit.origin + unit.direction * s) * outer,
                ..Crossing::at((t, ()), line, ray)?
            })
        })
    }

    fn hit(&self, Crossing { t, point, .. }: Crossing<()>) -> SurfaceHit {
        let ground = DVec2::new(point.x, point.z);
        let radius = ground.length();
        let rest = point.y * point.y - self.minor * self.minor;
        let off = |radius: f64| ((radius - self.major) * (radius - self.major) + rest).abs();
        // On the lemon, the centre of the tube is across the axis.
        let on_lemon = self.minor > self.major && off(-radius) < off(radius);
        let side = if on_lemon { -1.0 } else { 1.0 };
        let outward = if radius > 0.0 { ground / radius } else { DVec2::X };
        let (across, up) = (side * radius - self.major, point.y);
        let normal = DVec3::new(side * outward.x * across, up, side * outward.y * across).normalize_or(DVec3::Y);
        SurfaceHit {
            t,
            normal: (normal * side).as_vec3(),
            chart: Chart::Angles {
                u: Coordinate::turn(outward * side),
                v: Coordinate::turn(DVec2::new(across, up)),
            },
        }
    }
}
