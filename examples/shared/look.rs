//! Holding what a camera sees against rays.

use bevy::prelude::*;
use bevy_sightline::prelude::*;

/// What rays from an eye have met.
#[derive(Clone, Copy, Default)]
pub struct Rays {
    pub cast: usize,
    /// Those that met what the camera does not see.
    pub missed: usize,
}

impl Rays {
    /// Casts so many rays, across and down, from the eye through the whole view.
    pub fn look(
        &mut self,
        (camera, transform, visible): (&Camera, &GlobalTransform, &VisibleSet),
        scene: &SceneQuery,
        rays: UVec2,
    ) {
        let Some(size) = camera.logical_viewport_size() else {
            return;
        };
        for place in (0..rays.y).flat_map(|y| (0..rays.x).map(move |x| UVec2::new(x, y))) {
            let pixel = (place.as_vec2() + 0.5) / rays.as_vec2() * size;
            if let Ok(ray) = camera.viewport_to_world(transform, pixel) {
                let hit = scene.cast_ray(ray, &SceneQuerySettings::default());
                self.cast += 1;
                self.missed += usize::from(hit.is_some_and(|hit| !visible.contains(hit.entity)));
            }
        }
    }
}
