//! Which volumes contain which shapes.
//!
//! A convex volume contains a polytope if and only if it contains its vertices.

use bevy::math::{
    DVec3, Vec3A,
    bounding::{Aabb3d, BoundingSphere},
    primitives::{Segment3d, Triangle3d, ViewFrustum},
};

use super::{
    Contains,
    exact::sum_sign,
    frustum::Frustum,
    polyhedron::{ObbFrame, Plane, Polyhedron},
    sphere,
};
use crate::geometry::{convex_hull::ConvexHull, obb::Obb, tolerance::DOUBLE};

/// How well a vertex is known.
#[derive(Clone, Copy, PartialEq)]
enum Vertex {
    /// Given in `f32`.
    Exact,
    /// Computed in double precision.
    Rounded,
}

trait Container {
    fn has_point(&self, point: DVec3, vertex: Vertex) -> bool;
    fn has_sphere(&self, sphere: &BoundingSphere) -> bool;
}

trait Content {
    fn is_in(&self, container: &impl Container) -> bool;
}

impl Container for BoundingSphere {
    fn has_point(&self, point: DVec3, vertex: Vertex) -> bool {
        if vertex == Vertex::Exact {
            return sphere::touches_point(self, point);
        }
        let center = self.center.as_dvec3();
        let slack = DOUBLE * (f64::from(self.radius()) + center.abs().max_element());
        center.distance(point) <= f64::from(self.radius()) - slack
    }

    fn has_sphere(&self, sphere: &BoundingSphere) -> bool {
        let radii = [f64::from(self.radius()), -f64::from(sphere.radius())];
        self.radius() >= sphere.radius() && sphere::within(self.center.as_dvec3(), sphere.center.as_dvec3(), radii)
    }
}

impl Container for Aabb3d {
    fn has_point(&self, point: DVec3, vertex: Vertex) -> bool {
        let slack = if vertex == Vertex::Exact {
            DVec3::ZERO
        } else {
            DOUBLE * point.abs()
        };
        (self.min.as_dvec3() + slack).cmple(point).all() && point.cmple(self.max.as_dvec3() - slack).all()
    }

    fn has_sphere(&self, sphere: &BoundingSphere) -> bool {
        let (center, radius) = (sphere.center.as_dvec3(), f64::from(sphere.radius()));
        let (min, max) = (self.min.as_dvec3(), self.max.as_dvec3());
        (0..3).all(|axis| {
            sum_sign([center[axis], -radius, -min[axis]]) >= 0.0 && sum_sign([max[axis], -radius, -center[axis]]) >= 0.0
        })
    }
}

impl Container for Obb {
    fn has_point(&self, point: DVec3, _vertex: Vertex) -> bool {
        ObbFrame::from(self).planes().all(|plane| plane.admits_surely(point))
    }

    fn has_sphere(&self, sphere: &BoundingSphere) -> bool {
        planes_admit(ObbFrame::from(self).planes(), sphere)
    }
}

impl Container for ConvexHull {
    fn has_point(&self, point: DVec3, vertex: Vertex) -> bool {
        Polyhedron::planes(self).all(|plane| admits(&plane, point, vertex))
    }

    fn has_sphere(&self, sphere: &BoundingSphere) -> bool {
        planes_admit(Polyhedron::planes(self), sphere)
    }
}

impl Container for Frustum {
    fn has_point(&self, point: DVec3, vertex: Vertex) -> bool {
        Polyhedron::planes(self).all(|plane| admits(&plane, point, vertex))
    }

    fn has_sphere(&self, sphere: &BoundingSphere) -> bool {
        planes_admit(Polyhedron::planes(self), sphere)
    }
}

fn admits(plane: &Plane, point: DVec3, vertex: Vertex) -> bool {
    match vertex {
        Vertex::Exact => plane.admits_exactly(point),
        Vertex::Rounded => plane.admits_surely(point),
    }
}

fn planes_admit(mut planes: impl Iterator<Item = Plane>, sphere: &BoundingSphere) -> bool {
    let (center, radius) = (sphere.center.as_dvec3(), f64::from(sphere.radius()));
    planes.all(|plane| {
        let reach = radius * plane.normal.length();
        plane.excess(center) + reach <= -plane.rounding(center) - DOUBLE * reach
    })
}

impl Content for Vec3A {
    fn is_in(&self, container: &impl Container) -> bool {
        container.has_point(self.as_dvec3(), Vertex::Exact)
    }
}

impl Content for Segment3d {
    fn is_in(&self, container: &impl Container) -> bool {
        self.vertices
            .iter()
            .all(|vertex| container.has_point(vertex.as_dvec3(), Vertex::Exact))
    }
}

impl Content for Triangle3d {
    fn is_in(&self, container: &impl Container) -> bool {
        self.vertices
            .iter()
            .all(|vertex| container.has_point(vertex.as_dvec3(), Vertex::Exact))
    }
}

impl Content for BoundingSphere {
    fn is_in(&self, container: &impl Container) -> bool {
        container.has_sphere(self)
    }
}

impl Content for Aabb3d {
    fn is_in(&self, container: &impl Container) -> bool {
        let bounds = [self.min.as_dvec3(), self.max.as_dvec3()];
        (0..8).all(|corner| {
            let point = DVec3::from_array([0, 1, 2].map(|axis| bounds[corner >> axis & 1][axis]));
            container.has_point(point, Vertex::Exact)
        })
    }
}

impl Content for Obb {
    fn is_in(&self, container: &impl Container) -> bool {
        let frame = ObbFrame::from(self);
        (0..8).all(|corner| container.has_point(frame.corner(corner), Vertex::Rounded))
    }
}

impl Content for ConvexHull {
    fn is_in(&self, container: &impl Container) -> bool {
        let margin = self.margin();
        let mut vertices = self.vertices().iter();
        match margin {
            0.0 => vertices.all(|vertex| container.has_point(vertex.as_dvec3(), Vertex::Exact)),
            _ => {
                margin.is_finite() && vertices.all(|&vertex| container.has_sphere(&BoundingSphere::new(vertex, margin)))
            }
        }
    }
}

impl Content for Frustum {
    fn is_in(&self, container: &impl Container) -> bool {
        self.corners()
            .is_some_and(|mut corners| corners.all(|corner| container.has_point(corner, Vertex::Rounded)))
    }
}

/// Containers and contents that can be tested as they are.
macro_rules! contains {
    ($($container:ty),*: $contents:tt) => { $(contains!(@ $container: $contents);)* };
    (@ $container:ty: [$($content:ty),*]) => { $(
        impl Contains<$content> for $container {
            fn contains(&self, other: &$content) -> bool {
                other.is_in(self)
            }
        }
    )* };
}

contains!(BoundingSphere, Aabb3d, Obb, ConvexHull, Frustum:
    [Vec3A, Segment3d, Triangle3d, BoundingSphere, Aabb3d, Obb, ConvexHull, Frustum]);

/// Those of which one or both must be prepared.
macro_rules! contains_frustum {
    ($($container:ty),*) => { $(
        impl Contains<ViewFrustum> for $container {
            fn contains(&self, other: &ViewFrustum) -> bool {
                self.contains(&Frustum::from(other))
            }
        }
    )* };
}

contains_frustum!(BoundingSphere, Aabb3d, Obb, ConvexHull, Frustum);

impl<Other> Contains<Other> for ViewFrustum
where
    Frustum: Contains<Other>,
{
    fn contains(&self, other: &Other) -> bool {
        Frustum::from(self).contains(other)
    }
}
