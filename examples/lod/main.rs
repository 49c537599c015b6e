//! Levels of detail: a city of houses with three levels each, in blocks with one proxy each, seen by two cameras that
//! choose for themselves.
//!
//! ```sh
//! cargo run --release --example lod                # a window where there is a display, else figures
//! cargo run --release --example lod -- --headless  # the figures
//! cargo run --release --example lod -- --headless --picture docs/lod.png
//! cargo run --release --example lod -- --help      # all options
//! ```
//!
//! **In the window** the left half is the player's view and the right half that of a bird above it. Levels have colours: red
//! is the finest, yellow lacks the details, green is a box under a roof, and blue is one mesh for a whole block. Look at
//! the same houses in both halves: near the player they are red on the left, and something else on the right. Only trees
//! and lamps are the same in both, as their meshes are swapped for the player's camera.
//!
//! Drag the bar at the bottom, or hold an arrow key, to give the player's camera more or fewer details; zoom with the
//! wheel in either half, and the levels follow. C shows things as they look, and one should see no level switch. F has
//! the bird stay where it is, so that the player flies away from under it; Space stops the flight, or fly yourself with
//! W A S D, E, Q and the right mouse button held. B swings the player back and forth in one place: with hysteresis nearly
//! nothing switches; switch that off with H, and see houses pop. L shows everything at the finest level: look at the
//! triangles and at the time of frames.
//!
//! **Headless** flies around once and prints for each second what both cameras show. It fails if the bird shows more than
//! a tenth of the triangles, or if both always show the same.

#[path = "../shared/by_hand.rs"]
mod by_hand;
#[path = "../shared/command_line.rs"]
mod command_line;
#[path = "../shared/picture.rs"]
mod ray_cast_picture;
#[path = "../shared/route.rs"]
mod route;
#[path = "../shared/mod.rs"]
mod shared;
#[path = "../shared/times.rs"]
mod times;

mod controls;
mod figures;
mod flight;
mod headless;
mod house;
mod options;
mod paint;
mod picture;
mod plan;
mod slider;
mod solid;
mod stopwatch;
mod street;
mod tally;
mod town;
mod views;

use bevy::{camera_controller::free_camera::FreeCameraPlugin, prelude::*};
use bevy_sightline::prelude::*;

use options::Options;

fn main() -> AppExit {
    let options = match command_line::read(Options::parse) {
        Ok(options) => options,
        Err(exit) => return exit,
    };
    let headless = options.headless;
    let mut app = App::new();
    app.add_plugins(shared::plugins("bevy_sightline: lod", headless))
        .insert_resource(options)
        .add_plugins((SightlinePlugins, paint::plugin, town::plugin))
        .add_plugins((views::plugin, tally::plugin));
    if headless {
        headless::run(app)
    } else {
        app.add_plugins((FreeCameraPlugin, flight::plugin, controls::plugin, slider::plugin))
            .add_plugins((paint::window_plugin, views::window_plugin))
            .add_plugins((stopwatch::plugin, figures::plugin))
            .run()
    }
}
