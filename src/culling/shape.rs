//! What a view sees: Bevy's tests, to the last bit, and the half-spaces that decide most of them beforehand.

use bevy::{
    camera::primitives::{Aabb, Frustum, Sphere},
    math::primitives::ViewFrustum,
    transform::components::GlobalTransform,
};

use crate::spatial::aabb_tree::HalfSpaces;

/// The part of space that a view sees.
#[derive(Clone, Debug)]
pub(super) struct ViewShape {
    frustum: Frustum,
    kind: ViewKind,
    pub half_spaces: HalfSpaces,
}

/// How Bevy tests for a view.
#[derive(Clone, Copy, Debug)]
pub(super) enum ViewKind {
    /// A camera: first the sphere around the box, then the box; nothing is too far.
    Camera,
    /// A cascade of a directional light: what casts shadows may be before the near plane.
    Cascade,
    /// A face of a point light, or a spot light: what it reaches is in its sphere and in its frustum.
    Local(Sphere),
}

impl ViewShape {
    pub fn new(frustum: &Frustum, kind: ViewKind) -> Self {
        let ignored = match kind {
            ViewKind::Camera => Some(ViewFrustum::FAR_PLANE_IDX),
            ViewKind::Cascade => Some(ViewFrustum::NEAR_PLANE_IDX),
            ViewKind::Local(_) => None,
        };
        let tested = frustum.half_spaces.iter().enumerate();
        let tested = tested.filter(|&(index, _)| Some(index) != ignored);
        let half_spaces = HalfSpaces::new(tested.map(|(_, half_space)| half_space));
        Self {
            frustum: *frustum,
            kind,
            half_spaces: match kind {
                ViewKind::Local(reach) => half_spaces.within(reach.center, reach.radius),
                ViewKind::Camera | ViewKind::Cascade => half_spaces,
            },
        }
    }

    /// Whether the view sees an entity with this box: Bevy's answer.
    pub fn sees(&self, aabb: &Aabb, transform: &GlobalTransform) -> bool {
        let world_from_local = transform.affine();
        match &self.kind {
            ViewKind::Camera => {
                let around = Sphere {
                    center: world_from_local.transform_point3a(aabb.center),
                    radius: transform.radius_vec3a(aabb.half_extents),
                };
                self.frustum.intersects_sphere(&around, false)
                    && self.frustum.intersects_obb(aabb, &world_from_local, true, false)
            }
            ViewKind::Cascade => self.frustum.intersects_obb(aabb, &world_from_local, false, true),
            ViewKind::Local(reach) => {
                reach.intersects_obb(aabb, &world_from_local)
                    && self.frustum.intersects_obb(aabb, &world_from_local, true, true)
            }
        }
    }

    /// Whether the same is seen of all that stays where it is.
    pub fn is_same(&self, other: &Self) -> bool {
        let planes = |shape: &Self| shape.frustum.half_spaces.map(|half_space| half_space.normal_d());
        let kinds = match (&self.kind, &other.kind) {
            (ViewKind::Camera, ViewKind::Camera) | (ViewKind::Cascade, ViewKind::Cascade) => true,
            (ViewKind::Local(one), ViewKind::Local(other)) => one.center == other.center && one.radius == other.radius,
            _ => false,
        };
        kinds && planes(self) == planes(other)
    }

    /// Whether a camera sees an entity that has a sphere and no box.
    pub fn sees_sphere(&self, sphere: &Sphere) -> bool {
        self.frustum.intersects_sphere(sphere, false)
    }
}
