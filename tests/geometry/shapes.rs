//! One of each kind of shape, and strategies for them.

use bevy::math::{
    DVec3, Quat, Vec3, Vec3A, Vec4,
    bounding::{Aabb3d, BoundingSphere},
    primitives::{HalfSpace, Segment3d, Triangle3d, ViewFrustum},
};
use bevy_sightline::geometry::{
    convex_hull::ConvexHull,
    intersection::{Contains, Intersects},
    obb::Obb,
    ray::Ray,
    support::Support,
    volume::Volume,
};
use proptest::prelude::*;

use crate::properties;

#[derive(Clone, Debug)]
pub enum Shape {
    Point(Vec3A),
    Ray(Ray),
    Segment(Segment3d),
    Sphere(BoundingSphere),
    Aabb(Aabb3d),
    Obb(Obb),
    Hull(ConvexHull),
    Frustum(ViewFrustum),
    Triangle(Triangle3d),
}

macro_rules! for_each_kind {
    ($shape:expr, $inner:ident => $body:expr) => {
        match $shape {
            Shape::Point($inner) => $body,
            Shape::Ray($inner) => $body,
            Shape::Segment($inner) => $body,
            Shape::Sphere($inner) => $body,
            Shape::Aabb($inner) => $body,
            Shape::Obb($inner) => $body,
            Shape::Hull($inner) => $body,
            Shape::Frustum($inner) => $body,
            Shape::Triangle($inner) => $body,
        }
    };
}

impl Shape {
    pub fn touches(&self, other: &Shape) -> bool {
        for_each_kind!(self, a => for_each_kind!(other, b => a.intersects(b)))
    }

    /// `None` where containment has no meaning.
    pub fn holds(&self, other: &Shape) -> Option<bool> {
        macro_rules! contains {
            ($container:expr) => {
                match other {
                    Shape::Point(b) => Some($container.contains(b)),
                    Shape::Ray(_) => None,
                    Shape::Segment(b) => Some($container.contains(b)),
                    Shape::Sphere(b) => Some($container.contains(b)),
                    Shape::Aabb(b) => Some($container.contains(b)),
                    Shape::Obb(b) => Some($container.contains(b)),
                    Shape::Hull(b) => Some($container.contains(b)),
                    Shape::Frustum(b) => Some($container.contains(b)),
                    Shape::Triangle(b) => Some($container.contains(b)),
                }
            };
        }
        match self {
            Shape::Sphere(a) => contains!(a),
            Shape::Aabb(a) => contains!(a),
            Shape::Obb(a) => contains!(a),
            Shape::Hull(a) => contains!(a),
            Shape::Frustum(a) => contains!(a),
            _ => None,
        }
    }

    /// The farthest point, of finite rays and of frusta by their corners.
    pub fn support(&self, direction: DVec3) -> DVec3 {
        let farthest = |points: &[Vec3A]| {
            points
                .iter()
                .map(|point| point.as_dvec3())
                .max_by(|a, b| a.dot(direction).total_cmp(&b.dot(direction)))
                .expect("points")
        };
        match self {
            Shape::Point(a) => a.support_point(direction),
            Shape::Ray(a) => {
                let end = a.origin().as_dvec3() + a.direction().as_dvec3() * f64::from(a.t_max());
                let start = a.origin().as_dvec3() + a.direction().as_dvec3() * f64::from(a.t_min());
                if end.dot(direction) > start.dot(direction) {
                    end
                } else {
                    start
                }
            }
            Shape::Segment(a) => a.support_point(direction),
            Shape::Sphere(a) => a.support_point(direction),
            Shape::Aabb(a) => a.support_point(direction),
            Shape::Obb(a) => a.support_point(direction),
            Shape::Hull(a) => a.support_point(direction),
            Shape::Frustum(a) => farthest(&a.corners().expect("corners").map(Vec3A::from)),
            Shape::Triangle(a) => a.support_point(direction),
        }
    }

    /// Moved, as far as `f32` allows.
    pub fn translated(&self, by: Vec3A) -> Shape {
        match self {
            Shape::Point(a) => Shape::Point(*a + by),
            Shape::Ray(a) => Shape::Ray(
                Ray::new(a.origin() + by, a.direction(), a.t_max())
                    .expect("sound")
                    .with_interval(a.t_min(), a.t_max()),
            ),
            Shape::Segment(a) => Shape::Segment(Segment3d {
                vertices: a.vertices.map(|v| v + Vec3::from(by)),
            }),
            Shape::Sphere(a) => Shape::Sphere(BoundingSphere::new(a.center + by, a.radius())),
            Shape::Aabb(a) => Shape::Aabb(Aabb3d {
                min: a.min + by,
                max: a.max + by,
            }),
            Shape::Obb(a) => Shape::Obb(obb_with(a.center() + by, a.half_size(), a)),
            Shape::Hull(a) => Shape::Hull(hull(a.vertices().iter().map(|&v| v + by))),
            Shape::Frustum(a) => Shape::Frustum(ViewFrustum {
                half_spaces: a
                    .half_spaces
                    .map(|h| HalfSpace::new(Vec3::from(h.normal()).extend(h.d() - h.normal().dot(by)))),
            }),
            Shape::Triangle(a) => Shape::Triangle(Triangle3d {
                vertices: a.vertices.map(|v| v + Vec3::from(by)),
            }),
        }
    }
}

fn obb_with(center: Vec3A, half_size: Vec3A, like: &Obb) -> Obb {
    Obb::new(center, half_size, Quat::from_mat3a(&like.axes())).expect("a sound box")
}

pub fn hull(points: impl IntoIterator<Item = Vec3A>) -> ConvexHull {
    ConvexHull::enclosing(points).expect("bounded")
}

pub fn lattice_point() -> impl Strategy<Value = Vec3A> {
    [-3i8..=3, -3i8..=3, -3i8..=3].prop_map(|p| Vec3A::from_array(p.map(f32::from)))
}

pub fn aabb_frustum(min: Vec3A, max: Vec3A) -> ViewFrustum {
    let plane = |normal: Vec3, d: f32| HalfSpace::new(normal.extend(d));
    ViewFrustum {
        half_spaces: [
            plane(Vec3::X, -min.x),
            plane(Vec3::NEG_X, max.x),
            plane(Vec3::NEG_Y, max.y),
            plane(Vec3::Y, -min.y),
            plane(Vec3::NEG_Z, max.z),
            plane(Vec3::Z, -min.z),
        ],
    }
}

/// Bevy's far plane at infinity.
pub fn inactive() -> HalfSpace {
    HalfSpace::new(Vec4::new(0.0, 0.0, 0.0, f32::INFINITY))
}

/// A shape that contains a given lattice point, often on its boundary, exactly as it is represented.
pub fn around(point: Vec3A) -> impl Strategy<Value = Shape> {
    let offsets = || (lattice_point(), lattice_point());
    let half = || [0u8..3, 0u8..3, 0u8..3].prop_map(|h| Vec3A::from_array(h.map(f32::from)));
    // Which side of the point the box reaches to: -1 and 1 put the point on a face.
    let side = || [-1i8..=1, -1i8..=1, -1i8..=1].prop_map(|s| Vec3A::from_array(s.map(f32::from)));
    prop_oneof![
        Just(Shape::Point(point)),
        (offsets(), 0u8..4, any::<bool>()).prop_filter_map("a direction", move |((u, _), steps, endless)| {
            let steps = f32::from(steps);
            let ray = Ray::new(point - u * steps, u, if endless { f32::INFINITY } else { steps })?;
            Some(Shape::Ray(ray))
        }),
        (offsets(), any::<bool>()).prop_map(move |((u, _), middle)| {
            let other = if middle { point - u } else { point };
            Shape::Segment(Segment3d::new((point + u).into(), other.into()))
        }),
        (side(), 0u8..4).prop_map(move |(side, radius)| {
            let radius = f32::from(radius);
            // On the boundary where the side is an axis.
            let reach = if side.length_squared() == 1.0 {
                side * radius
            } else {
                side * radius * 0.5
            };
            Shape::Sphere(BoundingSphere::new(point + reach, radius))
        }),
        (half(), side()).prop_map(move |(half, side)| Shape::Aabb(Aabb3d::new(point + half * side, half))),
        (half(), side()).prop_map(move |(half, side)| Shape::Obb(
            Obb::new(point + half * side, half, Quat::IDENTITY).expect("a sound box")
        )),
        (half(), side(), properties::rotation()).prop_map(move |(half, side, rotation)| {
            let center = point + rotation * (half * side * 0.75);
            Shape::Obb(Obb::new(center, half + 1e-3, rotation).expect("a sound box"))
        }),
        prop::collection::vec(lattice_point(), 0..7)
            .prop_map(move |others| Shape::Hull(hull(others.into_iter().chain([point])))),
        (offsets(), offsets()).prop_map(move |((u, v), (w, _))| Shape::Hull(hull([
            point + u,
            point - u,
            point + v,
            point + w
        ]))),
        (half(), side()).prop_map(move |(half, side)| {
            let center = point + half * side;
            Shape::Frustum(aabb_frustum(center - half, center + half))
        }),
        (half(), side()).prop_map(move |(half, side)| {
            let center = point + half * side;
            let mut frustum = aabb_frustum(center - half, center + half);
            frustum.half_spaces[ViewFrustum::FAR_PLANE_IDX] = inactive();
            Shape::Frustum(frustum)
        }),
        (offsets(), 0u8..4).prop_map(move |((u, v), kind)| {
            let vertices = match kind {
                0 => [point, point + u, point + v],
                1 => [point + u, point - u, point + v],
                2 => [point + u, point + v, point - u - v],
                _ => [point, point, point + u],
            };
            Shape::Triangle(Triangle3d {
                vertices: vertices.map(Vec3::from),
            })
        }),
    ]
}

/// A bounded shape of any kind, of a size and place that games have.
pub fn any_shape() -> impl Strategy<Value = Shape> {
    use properties::{direction, point, rotation};
    let half = || [0.0f32..5.0, 0.0f32..5.0, 0.0f32..5.0].prop_map(Vec3A::from_array);
    let near = || [-8.0f32..8.0, -8.0f32..8.0, -8.0f32..8.0].prop_map(Vec3A::from_array);
    let shape = prop_oneof![
        near().prop_map(Shape::Point),
        (near(), direction(), 0.0f32..20.0).prop_map(|(o, d, t)| Shape::Ray(Ray::new(o, d, t).expect("sound"))),
        (near(), near()).prop_map(|(a, b)| Shape::Segment(Segment3d::new(a.into(), b.into()))),
        (near(), 0.0f32..5.0).prop_map(|(c, r)| Shape::Sphere(BoundingSphere::new(c, r))),
        (near(), half()).prop_map(|(c, h)| Shape::Aabb(Aabb3d::new(c, h))),
        (near(), half(), rotation()).prop_map(|(c, h, r)| Shape::Obb(Obb::new(c, h, r).expect("a sound box"))),
        prop::collection::vec(near(), 1..10).prop_map(|points| Shape::Hull(hull(points))),
        (near(), near()).prop_map(|(a, b)| Shape::Frustum(aabb_frustum(a.min(b), a.max(b)))),
        frustum().prop_map(Shape::Frustum),
        (near(), near(), near()).prop_map(|(a, b, c)| Shape::Triangle(Triangle3d::new(a.into(), b.into(), c.into()))),
    ];
    (shape, prop_oneof![4 => Just(Vec3A::ZERO), 1 => point()]).prop_map(|(shape, by)| shape.translated(by))
}

/// A perspective frustum with a far plane.
pub fn frustum() -> impl Strategy<Value = ViewFrustum> {
    use bevy::math::{Affine3A, Mat4};
    (
        0.3f32..2.0,
        0.5f32..2.0,
        0.1f32..2.0,
        1.0f32..10.0,
        properties::rotation(),
        properties::point(),
    )
        .prop_map(|(fov, aspect, near, depth, rotation, place)| {
            let clip_from_view = Mat4::perspective_rh(fov, aspect, near, near + depth);
            let world_from_view = Affine3A::from_rotation_translation(rotation, (place * 0.1).into());
            let clip_from_world = clip_from_view * Mat4::from(world_from_view.inverse());
            let mut frustum = ViewFrustum::from_clip_from_world(&clip_from_world);
            // The depth of this projection runs from 0 at the near plane to 1 at the far one.
            frustum.half_spaces[4] = HalfSpace::new(clip_from_world.row(2));
            frustum.half_spaces[5] = HalfSpace::new(clip_from_world.row(3) - clip_from_world.row(2));
            frustum
        })
}
