//! View frusta, prepared for many tests.

use bevy::math::{
    DVec3,
    bounding::BoundingSphere,
    primitives::{HalfSpace, ViewFrustum},
};
use smallvec::SmallVec;

use super::{
    polyhedron::{Interval, Line, Plane, Polyhedron},
    sphere,
};
use crate::geometry::support::Support;

/// A [`ViewFrustum`] with its edges, found once for many tests.
///
/// Whatever its half-spaces have in common: bounded or not, with a tip or without, even with no inside at all. A
/// half-space whose normal is zero or NaN, as Bevy has it for a far plane at infinity, bounds nothing. The half-spaces
/// count as closed, and exactly as they are; the edges are in double precision, and a little longer by rounding.
#[derive(Clone, Debug)]
pub struct Frustum {
    planes: SmallVec<[Plane; 6]>,
    edges: SmallVec<[Line; 16]>,
}

impl From<&ViewFrustum> for Frustum {
    fn from(frustum: &ViewFrustum) -> Self {
        let planes: SmallVec<[Plane; 6]> = frustum.half_spaces.iter().filter_map(plane).collect();
        let edges = edges(&planes);
        Self { planes, edges }
    }
}

/// The plane of a half-space, or `None` if that is the whole space.
fn plane(half_space: &HalfSpace) -> Option<Plane> {
    let (normal, offset) = (half_space.normal().as_dvec3(), f64::from(half_space.d()));
    let bounds = if normal == DVec3::ZERO {
        offset < 0.0
    } else {
        normal.is_finite() && offset < f64::INFINITY
    };
    bounds.then_some(Plane {
        normal: -normal,
        // Finite, so that nothing becomes NaN, and beyond every coordinate.
        offset: offset.max(-f64::from(f32::MAX) * 4.0),
    })
}

/// The lines in which two planes meet, clipped by the others, as half-lines and segments.
fn edges(planes: &[Plane]) -> SmallVec<[Line; 16]> {
    let mut edges = SmallVec::new();
    for (second_index, second) in planes.iter().enumerate() {
        for (first_index, first) in planes[..second_index].iter().enumerate() {
            let direction = first.normal.cross(second.normal);
            let length_squared = direction.length_squared();
            if length_squared == 0.0 {
                continue;
            }
            let origin = (second.normal.cross(direction) * first.offset
                + direction.cross(first.normal) * second.offset)
                / length_squared;
            let others = planes
                .iter()
                .enumerate()
                .filter(|&(index, _)| index != first_index && index != second_index)
                .map(|(_, &plane)| plane);
            edges.extend([direction, -direction].into_iter().filter_map(|direction| {
                let half_line = Line {
                    origin,
                    direction,
                    interval: Interval {
                        first: 0.0,
                        last: f64::INFINITY,
                    },
                };
                half_line.clipped(others.clone())
            }));
        }
    }
    edges
}

impl Polyhedron for Frustum {
    fn planes(&self) -> impl Iterator<Item = Plane> {
        self.planes.iter().copied()
    }

    fn edges(&self) -> impl Iterator<Item = Line> {
        self.edges.iter().copied()
    }
}

impl Frustum {
    /// Its corners, of which several may be the same, or `None` if it has none or no end.
    pub(crate) fn corners(&self) -> Option<impl Iterator<Item = DVec3>> {
        let bounded = self.edges.iter().all(|edge| edge.interval.last.is_finite());
        (bounded && !self.edges.is_empty()).then(|| self.edges.iter().flat_map(Line::ends))
    }

    /// The same edges between planes that are `amount` farther out.
    pub(crate) fn with_planes_moved_out(&self, amount: f64) -> Self {
        let mut moved = self.clone();
        for plane in &mut moved.planes {
            plane.offset += amount * plane.normal.length();
        }
        moved
    }

    /// Most shapes are behind one of the planes, which is quick to see; of the others the edges decide.
    pub(crate) fn touches(&self, other: &(impl Polyhedron + Support)) -> bool {
        let admits_some = |plane: &Plane| plane.admits(other.support_point(-plane.normal));
        self.planes.iter().all(admits_some) && (other.enters(self) || self.enters(other))
    }

    /// Two frusta that have no edges touch for lack of a proof.
    pub(crate) fn touches_frustum(&self, other: &Self) -> bool {
        self.edges.is_empty() && other.edges.is_empty() || other.enters(self) || self.enters(other)
    }

    /// Whether the point of the frustum that is closest to the centre is close enough: it is the centre, or on an edge,
    /// or the projection of the centre on a face.
    pub(crate) fn touches_sphere(&self, sphere: &BoundingSphere) -> bool {
        let (center, reach) = (sphere.center.as_dvec3(), sphere::reach(sphere, 0.0));
        let mut inside = true;
        for plane in &self.planes {
            let length = plane.normal.length();
            let excess = plane.excess(center) - plane.rounding(center);
            if excess > reach * length {
                return false;
            }
            inside &= excess <= 0.0;
        }
        let close_to_face = |face: &Plane| {
            let projection = center - face.normal * (face.excess(center) / face.normal.length_squared());
            face.excess(center) >= 0.0 && self.planes.iter().all(|plane| plane.admits(projection))
        };
        inside || self.edges.iter().any(|edge| edge.touches_sphere(sphere)) || self.planes.iter().any(close_to_face)
    }
}
