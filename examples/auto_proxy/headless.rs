//! The levels as a table, without a window.

use std::{error::Error, path::PathBuf};

use bevy::{asset::RecursiveDependencyLoadState, prelude::*, world_serialization::WorldAssetRoot};
use bevy_sightline::index::MeshBvhs;

use crate::{
    gallery::{Gallery, SKY, TO_SUN, pixels, pixels_at_one},
    options::Options,
    ray_cast_picture::{Daylight, Painter, Picture},
};

/// In rays: four make a pixel.
const SIZE: UVec2 = UVec2::new(2560, 1440);

/// Makes the levels, and prints them.
pub fn run(mut app: App) -> AppExit {
    app.finish();
    app.cleanup();
    while app.world().resource::<Gallery>().columns.is_empty() {
        app.update();
        if let Some(why) = failure(app.world_mut()) {
            eprintln!("{why}");
            return AppExit::error();
        }
    }
    // The copies arrive, and are moved to their places.
    for _ in 0..5 {
        app.update();
    }
    while app.world().resource::<MeshBvhs>().building() > 0 {
        app.update();
    }
    let file = app.world().resource::<Options>().picture.clone();
    let drawn = app.world_mut().run_system_cached(print_table).map_err(Into::into);
    let drawn = drawn.and_then(|()| app.world_mut().run_system_cached_with(draw, file.clone())?);
    match drawn {
        Ok(()) => {
            println!("\npicture: {}", file.display());
            AppExit::Success
        }
        Err(error) => {
            eprintln!("{}: {error}", file.display());
            AppExit::error()
        }
    }
}

/// Why there will be nothing to see.
fn failure(world: &mut World) -> Option<String> {
    let mut models = world.query::<&WorldAssetRoot>();
    let models: Vec<_> = models.iter(world).map(|model| model.id().untyped()).collect();
    let server = world.resource::<AssetServer>();
    models
        .into_iter()
        .find_map(|model| match server.get_recursive_dependency_load_state(model) {
            Some(RecursiveDependencyLoadState::Failed(error)) => Some(format!("cannot load the model: {error}")),
            _ => None,
        })
}

fn print_table(gallery: Res<Gallery>, camera: Single<(&Camera, &GlobalTransform)>) {
    let (camera, eye) = *camera;
    println!("level  triangles        error   pixels here   one pixel from");
    for (number, column) in gallery.columns.iter().enumerate() {
        println!(
            "{number:5} {:10} {:12.6} {:13.2} {:14.2} m",
            column.triangles,
            column.error,
            pixels(column, camera, eye),
            column.error * pixels_at_one(camera),
        );
    }
    if let Some(took) = gallery.took {
        println!("made in {:.2} s, in the background", took.as_secs_f32());
    }
}

/// Draws what the camera sees into a PNG file.
fn draw(
    In(file): In<PathBuf>,
    painter: Painter,
    camera: Single<(&Camera, &GlobalTransform)>,
) -> Result<(), Box<dyn Error + Send + Sync>> {
    let daylight = Daylight {
        sky: SKY,
        to_sun: TO_SUN,
        haze: 1e6,
    };
    Picture::ray_cast(SIZE, *camera, |ray| painter.shade(ray, &daylight)).save(&file)
}
