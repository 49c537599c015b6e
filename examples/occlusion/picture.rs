//! The picture of the headless run: the walker from above.

use std::{error::Error, path::PathBuf};

use bevy::{color::palettes::tailwind::AMBER_300, prelude::*};
use bevy_sightline::prelude::*;

use crate::{
    ray_cast_picture::{Daylight, Painter, Picture},
    scenery::TO_SUN,
    sight::Sight,
    views,
    walk::Walker,
};

/// In rays: four make a pixel.
const SIZE: UVec2 = UVec2::new(2560, 1440);

const DAYLIGHT: Daylight = Daylight {
    sky: Srgba::rgb(0.03, 0.04, 0.06),
    to_sun: TO_SUN,
    haze: 2500.0,
};

/// Draws what is seen in its colours, what is hidden in blue, and the rest dark, into a PNG file.
pub fn draw(
    In(file): In<PathBuf>,
    painter: Painter,
    scene: SceneQuery,
    walker: Single<(&Camera, &GlobalTransform), With<Walker>>,
    sight: Res<Sight>,
) -> Result<(), Box<dyn Error + Send + Sync>> {
    let (camera, eye) = *walker;
    let above = GlobalTransform::from(views::above(&eye.compute_transform()));
    let mut picture = Picture::ray_cast(SIZE, (camera, &above), |ray| {
        let (color, along) = painter.shade(ray, &DAYLIGHT);
        let Some(hit) = scene.cast_ray(ray, &SceneQuerySettings::default()) else {
            return (color, along);
        };
        let is_in = |list: &[Entity]| list.binary_search(&hit.entity).is_ok();
        let color = if is_in(&sight.seen) {
            color
        } else if is_in(&sight.hidden) {
            LinearRgba::rgb(0.02, 0.10, 0.34).mix(&color, 0.12)
        } else {
            color * 0.08
        };
        (color, along)
    });
    for line in views::frustum_lines(camera, eye) {
        picture.line(line, AMBER_300);
    }
    picture.save(&file)
}
