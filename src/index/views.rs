//! The cameras, as the index last knew them.

use bevy::{
    camera::{Camera, Projection, visibility::RenderLayers},
    ecs::{
        change_detection::ResMut,
        entity::{Entity, EntityHashMap},
        resource::Resource,
        system::Query,
    },
    math::{DAffine3, DMat4, Mat4},
    transform::components::GlobalTransform,
};

/// All cameras, as of the last [`SpatialIndexSystems::Sync`](super::SpatialIndexSystems::Sync).
///
/// Kept here so that [`SceneQuery`](super::SceneQuery) need not borrow any `Camera` of the world: a system may ask the
/// scene and change cameras.
#[derive(Resource, Debug, Default)]
pub(crate) struct CameraViews(EntityHashMap<CameraView>);

/// What a camera looks at, in double precision.
#[derive(Clone, Debug)]
pub(super) struct CameraView {
    pub world_from_view: DAffine3,
    pub clip_from_view: DMat4,
    pub layers: RenderLayers,
}

impl CameraViews {
    pub(super) fn get(&self, camera: Entity) -> Option<&CameraView> {
        self.0.get(&camera)
    }
}

/// The projection of a camera, or of the part of a view that it shows, also where there is no renderer, and nobody computes
/// the matrix of the camera.
pub(crate) fn clip_from_view(camera: &Camera, projection: Option<&Projection>) -> Mat4 {
    match (projection, &camera.sub_camera_view) {
        (Some(projection), Some(part)) => projection.get_clip_from_view_for_sub(part),
        (Some(projection), None) => projection.get_clip_from_view(),
        (None, _) => camera.clip_from_view(),
    }
}

/// Takes over all cameras: there are few.
pub(super) fn follow_cameras(
    cameras: Query<(
        Entity,
        &Camera,
        &GlobalTransform,
        Option<&Projection>,
        Option<&RenderLayers>,
    )>,
    mut views: ResMut<CameraViews>,
) {
    views.0.clear();
    views
        .0
        .extend(cameras.iter().map(|(entity, camera, place, projection, layers)| {
            let view = CameraView {
                world_from_view: place.affine().as_daffine3(),
                clip_from_view: clip_from_view(camera, projection).as_dmat4(),
                layers: layers.cloned().unwrap_or_default(),
            };
            (entity, view)
        }));
}
