//! The rays of pointers.

use bevy::{
    camera::visibility::RenderLayers,
    ecs::{
        change_detection::{Res, ResMut},
        system::Query,
    },
    gizmos::gizmos::Gizmos,
    picking::backend::ray::RayMap,
};

use super::{DrawStructures, SightlineGizmoStats, SightlineGizmos, nearest::Nearest};
use crate::{
    index::{SceneQuery, SceneQuerySettings},
    phase::phase,
};

/// The lines of a ray with a hit: the ray, the normal, a cross and a triangle.
const RAY_LINES: usize = 8;

/// Draws the ray of every pointer through every camera that it is over, with what it hits of what the camera shows.
pub(super) fn draw_pointer_rays(
    rays: Option<Res<RayMap>>,
    layers: Query<&RenderLayers>,
    scene: SceneQuery,
    mut stats: ResMut<SightlineGizmoStats>,
    mut gizmos: Gizmos<SightlineGizmos>,
) {
    let Some(rays) = rays.filter(|_| gizmos.config.enabled && gizmos.config_ext.rays) else {
        return;
    };
    let phase = phase!("sightline/gizmos/draw");
    let mut all = Nearest::new(gizmos.config_ext.limit, RAY_LINES);
    rays.iter().for_each(|(id, ray)| all.offer(0.0, (id.camera, *ray)));
    stats.rays = all.draw(|(camera, ray), left| {
        if left < RAY_LINES || !ray.origin.is_finite() {
            return None;
        }
        let layers = layers.get(camera).ok();
        let settings = SceneQuerySettings::default().with_layers(layers.unwrap_or_default());
        gizmos.ray_hit(ray, scene.cast_ray(ray, &settings).as_ref());
        Some(RAY_LINES)
    });
    stats.draw += phase.end();
}
