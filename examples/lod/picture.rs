//! The picture of the headless flight: both halves of the window.

use std::{error::Error, path::PathBuf};

use bevy::{color::palettes::tailwind::SLATE_900, prelude::*};
use bevy_sightline::prelude::*;

use crate::{
    ray_cast_picture::{Daylight, Painter, Picture},
    town::{SKY, TO_SUN},
    views::{Bird, Player, frustum_lines},
};

/// Of each half, in rays: four make a pixel.
const SIZE: UVec2 = UVec2::new(960, 1080);

const DAYLIGHT: Daylight = Daylight {
    sky: SKY,
    to_sun: TO_SUN,
    haze: 4000.0,
};

/// Draws what each of the cameras shows into a PNG file.
pub fn draw(
    In(file): In<PathBuf>,
    painter: Painter,
    choices: Res<LodChoices>,
    player: Single<(Entity, &Camera, &GlobalTransform), With<Player>>,
    bird: Single<(Entity, &Camera, &GlobalTransform), With<Bird>>,
) -> Result<(), Box<dyn Error + Send + Sync>> {
    let [left, mut right] = [*player, *bird].map(|(view, camera, transform)| {
        Picture::ray_cast(SIZE, (camera, transform), |ray| {
            let is_shown = |entity| choices.shows(view, entity);
            let settings = SceneQuerySettings::default().filter(&is_shown);
            painter.shade_what(&settings, ray, &DAYLIGHT)
        })
    });
    let (_, camera, transform) = *player;
    for line in frustum_lines(camera, transform) {
        right.line(line, SLATE_900);
    }
    left.beside(&right).save(&file)
}
