//! Pictures of the headless run: the city, and over it the lines that gizmos are.

use std::{any::TypeId, error::Error, path::PathBuf};

use bevy::{
    camera_controller::free_camera::FreeCamera,
    gizmos::{GizmoAsset, GizmoHandles},
    prelude::*,
};
use bevy_sightline::prelude::*;

use crate::{
    ray_cast_picture::{Daylight, Painter, Picture},
    scenery::{SKY, TO_SUN},
};

/// In rays: four make a pixel.
const SIZE: UVec2 = UVec2::new(1920, 1080);

const DAYLIGHT: Daylight = Daylight {
    sky: SKY,
    to_sun: TO_SUN,
    haze: 2500.0,
};

/// Draws what the free camera sees, with the gizmos of the last frame, into a PNG file.
pub fn draw(
    In(file): In<PathBuf>,
    painter: Painter,
    camera: Single<(&Camera, &GlobalTransform), With<FreeCamera>>,
    handles: Res<GizmoHandles>,
    assets: Res<Assets<GizmoAsset>>,
) -> Result<(), Box<dyn Error + Send + Sync>> {
    let mut picture = Picture::ray_cast(SIZE, *camera, |ray| {
        let (color, along) = painter.shade(ray, &DAYLIGHT);
        // So that lines stand out.
        (color * 0.55, along)
    });
    let handle = handles.handles().get(&TypeId::of::<SightlineGizmos>());
    if let Some(asset) = handle.and_then(Option::as_ref).and_then(|handle| assets.get(handle)) {
        let lines = asset.buffer();
        for (ends, colors) in lines.list_positions.chunks(2).zip(lines.list_colors.chunks(2)) {
            picture.line([ends[0], ends[1]], colors[0]);
        }
        for (ends, colors) in lines.strip_positions.windows(2).zip(&lines.strip_colors) {
            // Strips are parted by what is no number.
            if ends[0].is_finite() && ends[1].is_finite() {
                picture.line([ends[0], ends[1]], *colors);
            }
        }
    }
    picture.save(&file)
}
