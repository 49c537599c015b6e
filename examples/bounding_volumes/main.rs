//! What a bounding volume is worth: one model four times, each time in another volume, and the figures of each.
//!
//! ```sh
//! cargo run --release --example bounding_volumes                # a window where there is a display
//! cargo run --release --example bounding_volumes -- --headless  # the figures of all subjects, and a picture
//! ```
//!
//! **In the window** the left and right arrow keys go through the subjects, models and primitives, and Space holds them
//! still. While they turn, the sphere, the oriented box and the hull turn with them; the axis-aligned box cannot, and
//! breathes. The table tells how much larger each volume is than the hull, and what its ray test costs.

mod measure;
#[path = "../shared/panel.rs"]
mod panel;
#[path = "../shared/picture.rs"]
mod picture;
#[path = "../shared/mod.rs"]
mod shared;
mod stage;

use std::path::Path;

use bevy::prelude::*;
use bevy_sightline::prelude::*;

use measure::Measured;
use picture::{Daylight, Painter, Picture};
use stage::{Subject, Subjects, Turntable};

fn main() -> AppExit {
    let headless = !shared::has_display() || std::env::args().any(|argument| argument == "--headless");
    let mut app = App::new();
    app.add_plugins((
        shared::plugins("bevy_sightline: bounding volumes", headless),
        SightlinePlugins,
        stage::plugin,
    ));
    if !headless {
        return app.add_plugins(stage::window_plugin).run();
    }
    match report(&mut app) {
        Ok(()) => AppExit::Success,
        Err(error) => {
            eprintln!("{error}");
            AppExit::error()
        }
    }
}

/// Prints the figures of every subject, and draws the first.
fn report(app: &mut App) -> Result<(), String> {
    let file = Path::new("out/bounding_volumes.png");
    shared::load(app)?;
    let subjects = app.world().resource::<Subjects>().len();
    for subject in 0..subjects {
        app.world_mut().resource_mut::<Subject>().0 = subject;
        app.update();
        while !app.world().contains_resource::<Measured>() {
            app.update();
        }
        app.update();
        println!("{}\n", app.world().resource::<Measured>());
        if subject == 0 {
            let drawn = app.world_mut().run_system_cached_with(draw, file);
            drawn
                .map_err(|error| error.to_string())?
                .map_err(|error| error.to_string())?;
        }
    }
    println!("picture: {}", file.display());
    Ok(())
}

fn draw(
    In(file): In<&'static Path>,
    painter: Painter,
    camera: Single<(&Camera, &GlobalTransform)>,
    tables: Query<(&Turntable, &GlobalTransform)>,
    measured: Res<Measured>,
) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    let daylight = Daylight {
        sky: stage::SKY,
        to_sun: stage::TO_SUN,
        haze: 1000.0,
    };
    let mut picture = Picture::ray_cast(UVec2::new(2560, 1440), *camera, |ray| painter.shade(ray, &daylight));
    for (table, transform) in &tables {
        for line in measured.wireframe(table.kind, transform) {
            picture.line(line, table.color());
        }
    }
    picture.save(file)
}
