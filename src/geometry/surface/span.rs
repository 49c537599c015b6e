//! Where a line is inside of a solid.
//!
//! A line crosses a convex solid along one interval. The interval of an intersection of solids is the intersection of
//! their intervals, and so on for the other set operations (Roth, *Ray Casting for Modeling Solids*, Computer Graphics
//! and Image Processing 18, 1982). No ray slips through a seam between two faces this way: the seam is where two
//! intervals begin, and which of them begins later decides nothing but the face.
//!
//! All in double precision, from coordinates of `f32`, whose products are exact.

use bevy::math::{DVec3, Vec3};
use smallvec::SmallVec;

use crate::geometry::ray::{Ray, triangle::Backfaces};

/// The line of a ray, in double precision.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    pub origin: DVec3,
    pub direction: DVec3,
    /// The parameter of the ray at the origin of the line.
    pub start: f64,
}

impl Line {
    /// The line of a ray against a shape around the origin of the space, which is curved with such a radius.
    ///
    /// A line from very far away is moved along itself to where it passes the origin: what is left of its digits there
    /// decides.
    #[inline]
    pub fn of(ray: &Ray, radius: f64) -> Self {
        Self::around(ray, DVec3::ZERO, radius)
    }

    /// The same in the space with its origin at `center`.
    #[inline]
    pub fn around(ray: &Ray, center: DVec3, radius: f64) -> Self {
        let line = Self {
            origin: Vec3::from(ray.origin()).as_dvec3() - center,
            direction: Vec3::from(ray.direction()).as_dvec3(),
            start: 0.0,
        };
        if line.origin.length_squared() > radius * radius * FAR * FAR {
            line.moved_close()
        } else {
            line
        }
    }

    #[inline]
    fn moved_close(self) -> Self {
        let start = -self.origin.dot(self.direction) / self.direction.length_squared();
        Self {
            origin: self.origin + self.direction * start,
            start,
            ..self
        }
    }

    /// The same line in the space with its origin at `center`.
    #[inline]
    pub fn relative_to(&self, center: DVec3) -> Self {
        Self {
            origin: self.origin - center,
            ..*self
        }
    }

    #[inline]
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }
}

/// How many times its own size a shape is away when the rounding of the line is about to show in a normal: 2⁻⁵³ of the
/// distance is then 2⁻³³ of the shape.
const FAR: f64 = (1 << 20) as f64;

/// The parameters of a line at which it enters and leaves a solid, each with the face that it crosses there. Never NaN;
/// infinite where the solid has no end.
#[derive(Clone, Copy, Debug)]
pub struct Span<F> {
    pub enter: (f64, F),
    pub leave: (f64, F),
}

/// The spans of a line in a solid, in order along the line and apart.
pub type Spans<F> = SmallVec<[Span<F>; 2]>;

impl<F: Copy> Span<F> {
    #[inline]
    pub fn new(enter: (f64, F), leave: (f64, F)) -> Option<Self> {
        (enter.0 <= leave.0).then_some(Self { enter, leave })
    }

    /// The span with the same face at both ends.
    #[inline]
    pub fn within((enter, leave): (f64, f64), face: F) -> Self {
        Self {
            enter: (enter, face),
            leave: (leave, face),
        }
    }

    /// The span of a line that is inside all along.
    #[inline]
    pub fn everywhere(face: F) -> Self {
        Self::within((f64::NEG_INFINITY, f64::INFINITY), face)
    }

    /// The span in the intersection of the two solids. Where both begin or end at once, the face is that of `self`.
    #[inline]
    pub fn and(self, other: Self) -> Option<Self> {
        Self::new(
            if other.enter.0 > self.enter.0 {
                other.enter
            } else {
                self.enter
            },
            if other.leave.0 < self.leave.0 {
                other.leave
            } else {
                self.leave
            },
        )
    }

    /// The span in the convex union of the two solids.
    #[inline]
    pub fn or(self, other: Self) -> Self {
        Self {
            enter: if other.enter.0 < self.enter.0 {
                other.enter
            } else {
                self.enter
            },
            leave: if other.leave.0 > self.leave.0 {
                other.leave
            } else {
                self.leave
            },
        }
    }

    /// The spans in this solid less the other, which takes its boundary along unless the two only touch.
    pub fn minus(self, other: Self) -> impl Iterator<Item = Self> {
        let apart = other.enter.0 >= other.leave.0 || other.enter.0 >= self.leave.0 || other.leave.0 <= self.enter.0;
        let [before, after] = if apart {
            [Some(self), None]
        } else {
            [
                (self.enter.0 < other.enter.0).then_some(Self {
                    leave: other.enter,
                    ..self
                }),
                (other.leave.0 < self.leave.0).then_some(Self {
                    enter: other.leave,
                    ..self
                }),
            ]
        };
        before.into_iter().chain(after)
    }

    /// The end of this span that the ray meets first.
    #[inline]
    pub fn crossing(&self, line: &Line, ray: &Ray, backfaces: Backfaces) -> Option<Crossing<F>> {
        match Crossing::at(self.enter, line, ray) {
            None if backfaces == Backfaces::Include => Crossing::at(self.leave, line, ray),
            entered => entered,
        }
    }

    #[inline]
    pub fn map<G>(self, mut face: impl FnMut(F) -> G) -> Span<G> {
        Span {
            enter: (self.enter.0, face(self.enter.1)),
            leave: (self.leave.0, face(self.leave.1)),
        }
    }
}

/// Where a ray crosses the boundary of a solid.
#[derive(Clone, Copy, Debug)]
pub struct Crossing<F> {
    /// The parameter of the ray, rounded.
    pub t: f32,
    /// The point, before that rounding.
    pub point: DVec3,
    pub face: F,
}

impl<F: Copy> Crossing<F> {
    /// The crossing at an end of a span, if it belongs to the ray.
    #[inline]
    pub fn at((t, face): (f64, F), line: &Line, ray: &Ray) -> Option<Self> {
        parameter_of(ray, line.start + t).map(|rounded| Self {
            t: rounded,
            point: line.at(t),
            face,
        })
    }
}

/// `t` rounded, if that is finite and belongs to the ray.
#[inline]
pub fn parameter_of(ray: &Ray, t: f64) -> Option<f32> {
    // The sum turns the negative zero into zero.
    let t = t as f32 + 0.0;
    (t >= ray.t_min() && t <= ray.t_max() && t < f32::INFINITY).then_some(t)
}

/// The parameters between which `normal · point <= offset` holds on the line: none, one end, or all of it.
#[inline]
pub fn half_space_span<F: Copy>(along: f64, distance: f64, face: F) -> Option<Span<F>> {
    let t = -distance / along;
    if along < 0.0 {
        Some(Span::within((t, f64::INFINITY), face))
    } else if along > 0.0 {
        Some(Span::within((f64::NEG_INFINITY, t), face))
    } else {
        (distance <= 0.0).then(|| Span::everywhere(face))
    }
}

/// The span in which `|origin + t * direction| <= half_size`, with the face on the negative side and that on the
/// positive one.
#[inline]
pub fn slab_span<F: Copy>(
    origin: f64,
    direction: f64,
    half_size: f64,
    [negative, positive]: [F; 2],
) -> Option<Span<F>> {
    if direction == 0.0 {
        return (origin.abs() <= half_size).then_some(Span {
            enter: (f64::NEG_INFINITY, negative),
            leave: (f64::INFINITY, positive),
        });
    }
    let (to_negative, to_positive) = ((-half_size - origin) / direction, (half_size - origin) / direction);
    if direction > 0.0 {
        Span::new((to_negative, negative), (to_positive, positive))
    } else {
        Span::new((to_positive, positive), (to_negative, negative))
    }
}

/// Where a line enters and leaves a quadric: the roots of `a t² + 2 b t + c`, with `a > 0`.
///
/// Without cancellation: Press et al., *Numerical Recipes*, 2007, §5.6; Pharr, Jakob and Humphreys, *Physically Based
/// Rendering*, 2023, §6.8. A root at zero is exact, so that a ray which starts on a surface hits it. Each root costs a
/// division, and often only the first is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Quadratic {
    a: f64,
    b: f64,
    c: f64,
    root: f64,
}

impl Quadratic {
    /// With the discriminant `b² - a c`, which the caller knows to more digits than this difference has; `None` if that
    /// is negative or NaN.
    #[inline]
    pub fn new(a: f64, b: f64, c: f64, discriminant: f64) -> Option<Self> {
        (discriminant >= 0.0).then(|| Self {
            a,
            b,
            c,
            root: discriminant.sqrt(),
        })
    }

    /// The smaller root.
    #[inline]
    pub fn enter(&self) -> f64 {
        if self.b > 0.0 {
            return self.enter_behind();
        }
        let q = self.root - self.b;
        // Without that, both roots are zero.
        if q == 0.0 { 0.0 } else { self.c / q }
    }

    /// The smaller root of a line that is past the middle of the quadric.
    #[cold]
    fn enter_behind(&self) -> f64 {
        (-self.b - self.root) / self.a
    }

    /// The larger root.
    #[inline]
    pub fn leave(&self) -> f64 {
        if self.b > 0.0 {
            self.c / (-self.b - self.root)
        } else {
            (self.root - self.b) / self.a
        }
    }

    #[inline]
    pub fn span<F: Copy>(&self, face: F) -> Span<F> {
        Span::within((self.enter(), self.leave()), face)
    }
}
