//! Boxes, triangles and segments by separating axes: two convex polytopes are apart if and only if they are so along a
//! normal of a face, or a direction at right angles to an edge of each.
//!
//! Sources: Gottschalk, Lin and Manocha, *OBBTree*, 1996; Akenine-Möller, *Fast 3D Triangle-Box Overlap Testing*, 2001;
//! Ericson, *Real-Time Collision Detection*, 2005, §4.4.1, §5.2.9 and, for moving shapes, §5.5.

use bevy::math::{
    DVec3, Vec3,
    bounding::Aabb3d,
    primitives::{Segment3d, Triangle3d},
};

use super::polyhedron::{Interval, ObbFrame};
use crate::geometry::tolerance::DOUBLE;

/// A convex polytope, as separating axes see it.
pub(crate) trait Polytope {
    /// The normals of its faces, of any length, one of each parallel pair.
    fn face_normals(&self) -> impl AsRef<[DVec3]>;

    /// The directions of its edges, of any length, one of each parallel bundle.
    fn edge_directions(&self) -> impl AsRef<[DVec3]>;

    /// The least and largest value of `axis · point` over its points.
    fn extent(&self, axis: DVec3) -> [f64; 2];

    /// The largest absolute values of its coordinates, or more.
    fn magnitude(&self) -> DVec3;
}

impl Polytope for Aabb3d {
    fn face_normals(&self) -> impl AsRef<[DVec3]> {
        DVec3::AXES
    }

    fn edge_directions(&self) -> impl AsRef<[DVec3]> {
        DVec3::AXES
    }

    #[inline]
    fn extent(&self, axis: DVec3) -> [f64; 2] {
        let (low, high) = (axis * self.min.as_dvec3(), axis * self.max.as_dvec3());
        [low.min(high).element_sum(), low.max(high).element_sum()]
    }

    fn magnitude(&self) -> DVec3 {
        self.min.abs().max(self.max.abs()).as_dvec3()
    }
}

impl Polytope for ObbFrame {
    fn face_normals(&self) -> impl AsRef<[DVec3]> {
        [0, 1, 2].map(|axis| self.face_normal(axis))
    }

    fn edge_directions(&self) -> impl AsRef<[DVec3]> {
        [self.axes.x_axis, self.axes.y_axis, self.axes.z_axis]
    }

    #[inline]
    fn extent(&self, axis: DVec3) -> [f64; 2] {
        let center = axis.dot(self.center);
        let reach = (self.axes.transpose() * axis).abs().dot(self.half_size);
        [center - reach, center + reach]
    }

    fn magnitude(&self) -> DVec3 {
        self.center.abs() + self.half_size.element_sum()
    }
}

impl Polytope for Triangle3d {
    fn face_normals(&self) -> impl AsRef<[DVec3]> {
        let [a, b, c] = self.vertices.map(Vec3::as_dvec3);
        [(b - a).cross(c - a)]
    }

    fn edge_directions(&self) -> impl AsRef<[DVec3]> {
        let [a, b, c] = self.vertices.map(Vec3::as_dvec3);
        [b - a, c - b, a - c]
    }

    #[inline]
    fn extent(&self, axis: DVec3) -> [f64; 2] {
        let [a, b, c] = self.vertices.map(|vertex| axis.dot(vertex.as_dvec3()));
        [a.min(b).min(c), a.max(b).max(c)]
    }

    fn magnitude(&self) -> DVec3 {
        let [a, b, c] = self.vertices.map(|vertex| vertex.as_dvec3().abs());
        a.max(b).max(c)
    }
}

/// Has no faces: complete against a box, which brings three, and not against another segment or a triangle.
impl Polytope for Segment3d {
    fn face_normals(&self) -> impl AsRef<[DVec3]> {
        []
    }

    fn edge_directions(&self) -> impl AsRef<[DVec3]> {
        let [from, to] = self.vertices.map(Vec3::as_dvec3);
        [to - from]
    }

    #[inline]
    fn extent(&self, axis: DVec3) -> [f64; 2] {
        let [from, to] = self.vertices.map(|vertex| axis.dot(vertex.as_dvec3()));
        [from.min(to), from.max(to)]
    }

    fn magnitude(&self) -> DVec3 {
        let [from, to] = self.vertices.map(|vertex| vertex.as_dvec3().abs());
        from.max(to)
    }
}

/// Whether two polytopes, one of them a box, have a point in common. Conservative by [`DOUBLE`].
pub(crate) fn touch(a: &impl Polytope, b: &impl Polytope) -> bool {
    let magnitude = a.magnitude() + b.magnitude();
    every_axis(a, b, |axis| {
        let ([a_min, a_max], [b_min, b_max]) = (a.extent(axis), b.extent(axis));
        let slack = DOUBLE * axis.abs().dot(magnitude);
        // Of volumes without end these are NaN, and tell of no gap.
        let apart = a_min > b_max + slack || b_min > a_max + slack;
        !apart
    })
}

/// The parameters in `interval` at which `a` touches `b` when it has moved by the parameter times `velocity`; one of them
/// must be a box. Conservative by [`DOUBLE`].
pub(crate) fn touch_while_moving(
    a: &impl Polytope,
    velocity: DVec3,
    b: &impl Polytope,
    mut interval: Interval,
) -> Interval {
    let magnitude = a.magnitude() + b.magnitude();
    every_axis(a, b, |axis| {
        let ([a_min, a_max], [b_min, b_max]) = (a.extent(axis), b.extent(axis));
        let (slack, rate_error) = (
            DOUBLE * axis.abs().dot(magnitude),
            DOUBLE * axis.abs().dot(velocity.abs()),
        );
        let rate = axis.dot(velocity);
        interval.keep([rate, rate_error], [b_max - a_min, slack]);
        interval.keep([-rate, rate_error], [a_max - b_min, slack]);
        !interval.is_empty()
    });
    interval
}

/// Whether every axis that could separate the two fulfils the condition. A zero vector separates nothing.
fn every_axis(a: &impl Polytope, b: &impl Polytope, mut condition: impl FnMut(DVec3) -> bool) -> bool {
    let (a_edges, b_edges) = (a.edge_directions(), b.edge_directions());
    a.face_normals().as_ref().iter().all(|&normal| condition(normal))
        && b.face_normals().as_ref().iter().all(|&normal| condition(normal))
        && a_edges
            .as_ref()
            .iter()
            .all(|of_a| b_edges.as_ref().iter().all(|&of_b| condition(of_a.cross(of_b))))
}
