//! Who looks, from where, and how large it sees things.

use bevy::{
    camera::{Camera, Camera3d, Projection, ShadowLodOrigin},
    ecs::{
        change_detection::Res,
        entity::{Entity, EntityHashSet},
        query::{Has, With, Without},
        system::{Query, SystemParam},
    },
    math::Mat4,
    transform::components::GlobalTransform,
};
use tracing::warn;

use super::{LodBias, LodSettings, choices::LodView, lens::Lens, view_levels::Sight};
use crate::index::clip_from_view;

/// All cameras, and the other places from which levels are chosen for shadows.
#[derive(SystemParam)]
pub(super) struct Eyes<'w, 's> {
    settings: Res<'w, LodSettings>,
    cameras: Query<
        'w,
        's,
        (
            Entity,
            &'static Camera,
            &'static GlobalTransform,
            Option<&'static Projection>,
            Option<&'static LodBias>,
            Has<Camera3d>,
        ),
    >,
    other_origins: Query<'w, 's, (Entity, &'static GlobalTransform), (With<ShadowLodOrigin>, Without<Camera>)>,
}

impl Eyes<'_, '_> {
    pub fn settings(&self) -> &LodSettings {
        &self.settings
    }

    /// Lists whatever looks, written over `views`, and returns the camera for which meshes are swapped, if there is one.
    /// Whoever is in `warned` has been told of.
    pub fn look(&self, views: &mut Vec<(LodView, Sight)>, warned: &mut EntityHashSet) -> Option<Entity> {
        let settings = &*self.settings;
        views.clear();
        let mut main: Option<(isize, Entity)> = None;
        for (camera, view, place, projection, bias, is_3d) in &self.cameras {
            if !view.is_active {
                continue;
            }
            let height = view
                .physical_viewport_size()
                // Of a window that is minimised.
                .filter(|size| size.y > 0)
                .map_or(settings.viewport_height, |size| size.y as f32);
            let clip_from_view = clip_from_view(view, projection);
            let bias = bias.map_or(1.0, |bias| bias.0);
            let is_seen = add(camera, place, &clip_from_view, height, bias, settings, views);
            if is_seen {
                warned.remove(&camera);
            } else if warned.insert(camera) {
                warn!(
                    "for the camera {camera} all is shown in full detail: its place, its projection or a bias is no good"
                );
            }
            if is_seen && is_3d && main.is_none_or(|first| (view.order, camera) < first) {
                main = Some((view.order, camera));
            }
        }
        for (origin, place) in &self.other_origins {
            // As if through a usual camera.
            let clip_from_view = Projection::default().get_clip_from_view();
            let height = settings.viewport_height;
            add(origin, place, &clip_from_view, height, 1.0, settings, views);
        }
        let looks = |camera: &Entity| views.iter().any(|&(view, _)| view == LodView::Camera(*camera));
        settings.main_camera.filter(looks).or(main.map(|(_, camera)| camera))
    }
}

/// The bias of shadow maps, if it is one.
pub(super) fn shadow_bias(settings: &LodSettings) -> f32 {
    let bias = settings.shadow_bias;
    if bias > 0.0 && bias.is_finite() { bias } else { 1.0 }
}

/// Adds what a camera sees, and if that is something else what it has shadow maps see. Returns whether it sees anything.
fn add(
    viewer: Entity,
    place: &GlobalTransform,
    clip_from_view: &Mat4,
    viewport_height: f32,
    bias: f32,
    settings: &LodSettings,
    views: &mut Vec<(LodView, Sight)>,
) -> bool {
    let eye = place.translation();
    let stay = 1.0 + settings.hysteresis.max(0.0);
    let mut add = |view, bias| {
        let lens = if settings.enabled {
            Lens::new(clip_from_view, viewport_height, bias * settings.bias)
        } else {
            Some(Lens::FINEST)
        };
        let lens = lens.filter(|_| eye.is_finite() && stay.is_finite());
        views.extend(lens.map(|lens| {
            let dwell = settings.min_dwell.as_secs_f64();
            (view, Sight { eye, lens, stay, dwell })
        }));
        lens.is_some()
    };
    if shadow_bias(settings) != 1.0 {
        add(LodView::Shadows(viewer), bias * shadow_bias(settings));
    }
    add(LodView::Camera(viewer), bias)
}
