//! Convex polyhedra by their planes and edges, bounded or not, and lines that are clipped by the planes (Cyrus and Beck,
//! *Generalized Two- and Three-Dimensional Clipping*, 1978; Ericson, *Real-Time Collision Detection*, 2005, §5.3.8).

use bevy::math::{
    DMat3, DVec3, Vec3,
    bounding::{Aabb3d, BoundingSphere},
    primitives::{Segment3d, Triangle3d},
};
use smallvec::SmallVec;

use super::{exact::sum_sign, sphere};
use crate::geometry::{convex_hull::ConvexHull, obb::Obb, ray::Ray, support::Support, tolerance::DOUBLE};

/// The points with `normal · point <= offset`. The normal may have any length.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plane {
    pub normal: DVec3,
    pub offset: f64,
}

impl Plane {
    /// How far the point is outside, in multiples of the length of the normal; negative inside.
    pub(crate) fn excess(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }

    /// A bound of the rounding of [`excess`](Self::excess).
    pub(crate) fn rounding(&self, point: DVec3) -> f64 {
        DOUBLE * (self.normal.abs().dot(point.abs()) + self.offset.abs())
    }

    /// Whether the point is inside: exact if the plane and the point were given in `f32`.
    pub(crate) fn admits_exactly(&self, point: DVec3) -> bool {
        let [x, y, z] = (self.normal * point).to_array();
        sum_sign([x, y, z, -self.offset]) <= 0.0
    }

    /// Whether the point is inside by more than rounding.
    pub(crate) fn admits_surely(&self, point: DVec3) -> bool {
        self.excess(point) <= -self.rounding(point)
    }

    /// Whether the point is inside, or outside by no more than rounding.
    pub(crate) fn admits(&self, point: DVec3) -> bool {
        // NaN, of volumes without end, is no excess.
        let excluded = self.excess(point) > self.rounding(point);
        !excluded
    }
}

/// The parameters that are not negative and satisfy some linear constraints, each of which is known up to rounding:
/// none that satisfies them is missing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interval {
    pub first: f64,
    pub last: f64,
}

impl Interval {
    /// Keeps the parameters `t` with `rate * t <= room`, where both have an error up to the one given.
    pub(crate) fn keep(&mut self, [rate, rate_error]: [f64; 2], [room, room_error]: [f64; 2]) {
        let (rate, room) = (rate - rate_error, room + room_error);
        if rate > 0.0 {
            self.last = self.last.min(room / rate);
        } else if rate < 0.0 {
            self.first = self.first.max(room / rate);
        } else if room < 0.0 {
            self.last = f64::NEG_INFINITY;
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        !(self.first * (1.0 - DOUBLE) <= self.last * (1.0 + DOUBLE) && self.first < f64::INFINITY)
    }
}

/// A segment or a ray: the points `origin + t * direction` with `t` in an interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub origin: DVec3,
    pub direction: DVec3,
    pub interval: Interval,
}

impl Line {
    pub(crate) fn between(from: DVec3, to: DVec3) -> Self {
        Self {
            origin: from,
            direction: to - from,
            interval: Interval { first: 0.0, last: 1.0 },
        }
    }

    /// The part inside all planes, and possibly a little more by rounding, or `None` if nothing of it is.
    ///
    /// The interval must not reach below zero.
    pub(crate) fn clipped(&self, planes: impl IntoIterator<Item = Plane>) -> Option<Self> {
        let mut interval = self.interval;
        for plane in planes {
            let rate = plane.normal.dot(self.direction);
            let rate_error = DOUBLE * plane.normal.abs().dot(self.direction.abs());
            let room_error = plane.rounding(self.origin);
            interval.keep([rate, rate_error], [-plane.excess(self.origin), room_error]);
            if interval.is_empty() {
                return None;
            }
        }
        (!interval.is_empty()).then_some(Self { interval, ..*self })
    }

    /// The point of the line closest to `point`.
    pub(crate) fn closest_point(&self, point: DVec3) -> DVec3 {
        let along = (point - self.origin).dot(self.direction) / self.direction.length_squared();
        // NaN where the line is a point: any parameter will do.
        let t = along.min(self.interval.last).max(self.interval.first);
        self.origin + self.direction * t
    }

    /// Whether its point closest to the centre is in the sphere, or could be.
    pub(crate) fn touches_sphere(&self, sphere: &BoundingSphere) -> bool {
        let closest = self.closest_point(sphere.center.as_dvec3());
        let magnitude = self.origin.abs().max(closest.abs()).max_element();
        sphere::reaches(sphere, closest, magnitude, 1.0)
    }

    /// Its ends, where it has some.
    pub(crate) fn ends(&self) -> impl Iterator<Item = DVec3> {
        [self.interval.first, self.interval.last]
            .into_iter()
            .filter(|t| t.is_finite())
            .map(|t| self.origin + self.direction * t)
    }
}

impl From<&Ray> for Line {
    fn from(ray: &Ray) -> Self {
        Self {
            origin: ray.origin().as_dvec3(),
            direction: ray.direction().as_dvec3(),
            interval: Interval {
                first: ray.t_min().into(),
                last: ray.t_max().into(),
            },
        }
    }
}

impl From<&Segment3d> for Line {
    fn from(segment: &Segment3d) -> Self {
        let [from, to] = segment.vertices.map(Vec3::as_dvec3);
        Self::between(from, to)
    }
}

/// A convex polyhedron: what is inside all planes, which is what its edges and vertices are the corners of.
pub(crate) trait Polyhedron {
    fn planes(&self) -> impl Iterator<Item = Plane>;

    /// Its edges; a polyhedron that is a point is an edge without length.
    fn edges(&self) -> impl Iterator<Item = Line>;

    /// Whether an edge of this one enters the other.
    ///
    /// Where two polyhedra have a point in common, what they have in common has a vertex, or contains a line; and every
    /// vertex of it lies on an edge of one, inside the other. So two polyhedra that contain no line touch if and only if
    /// this is true one way or the other.
    fn enters(&self, other: &impl Polyhedron) -> bool {
        self.edges().any(|edge| edge.clipped(other.planes()).is_some())
    }
}

impl Polyhedron for Aabb3d {
    fn planes(&self) -> impl Iterator<Item = Plane> {
        let (min, max) = (self.min.as_dvec3(), self.max.as_dvec3());
        (0..3).flat_map(move |axis| {
            let normal = DVec3::AXES[axis];
            [
                Plane {
                    normal,
                    offset: max[axis],
                },
                Plane {
                    normal: -normal,
                    offset: -min[axis],
                },
            ]
        })
    }

    fn edges(&self) -> impl Iterator<Item = Line> {
        let bounds = [self.min.as_dvec3(), self.max.as_dvec3()];
        box_edges(move |corner| DVec3::from_array(std::array::from_fn(|axis| bounds[corner >> axis & 1][axis])))
    }
}

impl Polyhedron for ObbFrame {
    fn planes(&self) -> impl Iterator<Item = Plane> {
        (0..3).flat_map(|axis| self.slab(axis))
    }

    fn edges(&self) -> impl Iterator<Item = Line> {
        box_edges(|corner| self.corner(corner))
    }
}

fn box_edges(corner: impl Fn(usize) -> DVec3) -> impl Iterator<Item = Line> {
    // Each edge starts at the corner that is lower on its axis.
    (0..24)
        .map(|index| (index / 3, 1 << (index % 3)))
        .filter(|(from, bit)| from & bit == 0)
        .map(move |(from, bit)| Line::between(corner(from), corner(from | bit)))
}

/// An [`Obb`] in double precision: exactly the parallelepiped `center + axes * local` with `|local| <= half_size`, by the
/// axes as they are, which rounding has left a little off their right angles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ObbFrame {
    pub center: DVec3,
    pub half_size: DVec3,
    pub axes: DMat3,
}

impl From<&Obb> for ObbFrame {
    fn from(obb: &Obb) -> Self {
        Self {
            center: obb.center().as_dvec3(),
            half_size: obb.half_size().as_dvec3(),
            axes: DMat3::from_cols_array(&obb.axes().to_cols_array().map(f64::from)),
        }
    }
}

impl ObbFrame {
    /// The point of the box that is closest to `point`, as if the axes were at right angles: its distance is too large by
    /// no more than the root of [`stretch_squared`](Self::stretch_squared).
    pub(crate) fn closest_point(&self, point: DVec3) -> DVec3 {
        let offset = point - self.center;
        let local = DVec3::from_array([0, 1, 2].map(|axis| {
            let normal = self.face_normal(axis);
            normal.dot(offset) / normal.dot(self.axes.col(axis))
        }));
        self.center + self.axes * local.clamp(-self.half_size, self.half_size)
    }

    /// The largest factor between the square of a distance and that which it would have if the axes were at right angles,
    /// one way and back (Gershgorin's bounds of the eigenvalues of the Gram matrix).
    pub(crate) fn stretch_squared(&self) -> f64 {
        let [x, y, z] = [self.axes.x_axis, self.axes.y_axis, self.axes.z_axis].map(DVec3::normalize_or_zero);
        let (xy, yz, zx) = (x.dot(y).abs(), y.dot(z).abs(), z.dot(x).abs());
        let skew = (xy + zx).max(xy + yz).max(yz + zx);
        (1.0 + skew) / (1.0 - skew)
    }

    pub(crate) fn corner(&self, corner: usize) -> DVec3 {
        let side = |bit: usize| if corner >> bit & 1 == 0 { -1.0 } else { 1.0 };
        self.center + self.axes * (self.half_size * DVec3::new(side(0), side(1), side(2)))
    }

    /// The normal of the faces that an axis leads to: at right angles to the other two.
    pub(crate) fn face_normal(&self, axis: usize) -> DVec3 {
        self.axes.col((axis + 1) % 3).cross(self.axes.col((axis + 2) % 3))
    }

    fn slab(&self, axis: usize) -> [Plane; 2] {
        let normal = self.face_normal(axis);
        let reach = self.half_size[axis] * normal.dot(self.axes.col(axis)).abs();
        [normal, -normal].map(|normal| Plane {
            normal,
            offset: normal.dot(self.center) + reach,
        })
    }
}

impl Support for ObbFrame {
    fn support_point(&self, direction: DVec3) -> DVec3 {
        let forward = (self.axes.transpose() * direction).cmpge(DVec3::ZERO);
        self.center + self.axes * DVec3::select(forward, self.half_size, -self.half_size)
    }
}

impl Polyhedron for ConvexHull {
    fn planes(&self) -> impl Iterator<Item = Plane> {
        ConvexHull::planes(self).iter().map(|plane| Plane {
            normal: plane.normal.as_dvec3(),
            offset: plane.offset.into(),
        })
    }

    fn edges(&self) -> impl Iterator<Item = Line> {
        let vertex = |index: u32| self.vertices()[index as usize].as_dvec3();
        let point = if ConvexHull::edges(self).is_empty() {
            self.vertices().first()
        } else {
            None
        };
        ConvexHull::edges(self)
            .iter()
            .map(move |&[from, to]| Line::between(vertex(from), vertex(to)))
            .chain(point.map(|point| Line::between(point.as_dvec3(), point.as_dvec3())))
    }
}

impl Polyhedron for Triangle3d {
    /// Of a triangle without area, a plane that admits nothing: its edges are all of it.
    fn planes(&self) -> impl Iterator<Item = Plane> {
        let vertices = self.vertices.map(Vec3::as_dvec3);
        let [a, b, c] = vertices;
        let normal = (b - a).cross(c - a);
        let longest_squared = (b - a).length_squared().max((c - a).length_squared());
        let mut planes = SmallVec::<[Plane; 5]>::new();
        if normal.length() <= DOUBLE * longest_squared {
            planes.push(Plane {
                normal: DVec3::ZERO,
                offset: -1.0,
            });
        } else {
            let outward = [
                normal,
                -normal,
                (b - a).cross(normal),
                (c - b).cross(normal),
                (a - c).cross(normal),
            ];
            planes.extend(outward.map(|normal| {
                Plane {
                    normal,
                    offset: vertices
                        .map(|vertex| normal.dot(vertex))
                        .into_iter()
                        .fold(f64::NEG_INFINITY, f64::max),
                }
            }));
        }
        planes.into_iter()
    }

    fn edges(&self) -> impl Iterator<Item = Line> {
        let [a, b, c] = self.vertices.map(Vec3::as_dvec3);
        [[a, b], [b, c], [c, a]]
            .into_iter()
            .map(|[from, to]| Line::between(from, to))
    }
}
