//! From where one looks, and what is in view.

use bevy::{
    camera::{Camera, primitives::Frustum, visibility::RenderLayers},
    ecs::{
        entity::Entity,
        system::{Query, SystemParam},
    },
    math::{Vec3A, bounding::Aabb3d, primitives::ViewFrustum},
    transform::components::GlobalTransform,
};

use crate::spatial::{aabb_tree::HalfSpaces, region::distance_squared};

/// All active cameras.
#[derive(SystemParam)]
pub(super) struct Cameras<'w, 's> {
    cameras: Query<
        'w,
        's,
        (
            Entity,
            &'static Camera,
            &'static GlobalTransform,
            &'static Frustum,
            Option<&'static RenderLayers>,
        ),
    >,
}

impl Cameras<'_, '_> {
    /// What cameras see that show these layers.
    pub fn views(&self, layers: &RenderLayers) -> Views {
        let shows = |own: Option<&RenderLayers>| own.unwrap_or_default().intersects(layers);
        let cameras = self.cameras.iter().filter(|(_, camera, ..)| camera.is_active);
        let views = cameras
            .filter(|&(.., own)| shows(own))
            .filter_map(|(_, _, place, frustum, _)| {
                let eye = place.translation_vec3a();
                eye.is_finite().then(|| View::new(eye, frustum))
            });
        Views { views: views.collect() }
    }

    /// The frusta of all active cameras.
    pub fn frusta(&self) -> impl Iterator<Item = &Frustum> + '_ {
        let cameras = self.cameras.iter().filter(|(_, camera, ..)| camera.is_active);
        cameras.map(|(_, _, _, frustum, _)| frustum)
    }

    /// The frustum of a camera.
    pub fn frustum(&self, camera: Entity) -> Option<&Frustum> {
        self.cameras.get(camera).ok().map(|(_, _, _, frustum, _)| frustum)
    }
}

/// What somebody sees.
#[derive(Clone, Debug)]
pub(super) struct View {
    eye: Vec3A,
    frustum: ViewFrustum,
    pub half_spaces: HalfSpaces,
}

impl View {
    pub fn new(eye: Vec3A, frustum: &ViewFrustum) -> Self {
        // As Bevy culls: nothing is too far.
        let near = &frustum.half_spaces[..ViewFrustum::FAR_PLANE_IDX];
        Self {
            eye,
            frustum: *frustum,
            half_spaces: HalfSpaces::new(near),
        }
    }

    /// Whether some of a box may be in view.
    pub fn may_see(&self, aabb: &Aabb3d) -> bool {
        let (center, half_size) = ((aabb.min + aabb.max) * 0.5, (aabb.max - aabb.min) * 0.5);
        self.frustum.half_spaces[..ViewFrustum::FAR_PLANE_IDX]
            .iter()
            .all(|plane| {
                let normal = plane.normal();
                let is_outside = normal.dot(center) + plane.d() < -normal.abs().dot(half_size);
                !is_outside
            })
    }
}

/// What several see together.
#[derive(Clone, Debug)]
pub(super) struct Views {
    pub views: Vec<View>,
}

impl Views {
    /// Whether somebody may see some of a box.
    pub fn may_see(&self, aabb: &Aabb3d) -> bool {
        self.views.iter().any(|view| view.may_see(aabb))
    }

    /// The square of the distance of a box from who is nearest; zero if nobody is there.
    pub fn distance_squared(&self, aabb: &Aabb3d) -> f32 {
        let distances = self.views.iter().map(|view| distance_squared(view.eye, aabb));
        distances.reduce(f32::min).unwrap_or_default()
    }
}
