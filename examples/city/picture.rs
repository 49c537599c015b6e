//! The picture of the headless run.

use std::{error::Error, path::PathBuf, time::Instant};

use bevy::{color::palettes::tailwind::SKY_500, prelude::*};
use bevy_sightline::{geometry::obb::Obb, prelude::*};

use crate::{
    interaction::{Hovered, Selected},
    ray_cast_picture::{Daylight, Painter, Picture},
    scenery::{SKY, TO_SUN},
};

/// In rays: four make a pixel.
const SIZE: UVec2 = UVec2::new(2560, 1440);

const DAYLIGHT: Daylight = Daylight {
    sky: SKY,
    to_sun: TO_SUN,
    haze: 2500.0,
};

/// Draws what the camera sees into a PNG file, and returns the milliseconds that the rays took.
pub fn draw(
    In(file): In<PathBuf>,
    painter: Painter,
    camera: Single<(&Camera, &GlobalTransform)>,
    things: Query<(Entity, Has<Selected>), Or<(With<Hovered>, With<Selected>)>>,
    index: Res<SpatialIndex>,
) -> Result<f64, Box<dyn Error + Send + Sync>> {
    let start = Instant::now();
    let mut picture = Picture::ray_cast(SIZE, *camera, |ray| painter.shade(ray, &DAYLIGHT));
    let ms = start.elapsed().as_secs_f64() * 1e3;
    for (entity, is_selected) in &things {
        if let Some(bounds) = index.aabb(entity) {
            for edge in Obb::from(bounds).edges() {
                picture.line(edge.map(Vec3::from), if is_selected { SKY_500 } else { Srgba::WHITE });
            }
        }
    }
    picture.save(&file)?;
    Ok(ms)
}
