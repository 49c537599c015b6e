//! A city of 17,000 things, loaded from glTF: whatever is under the mouse is known exactly and at once.
//!
//! ```sh
//! cargo run --release --example city                 # a window where there is a display, else a report
//! cargo run --release --example city -- --headless   # the report
//! cargo run --release --example city -- --help       # all options
//! ```
//!
//! **In the window** fly with W A S D, E, Q and the right mouse button held; the wheel changes the speed, Shift runs.
//! Move the mouse over anything, click to select it, and drag what is selected along the ground. Look for the white box
//! of bounds, the yellow triangle under the pointer with its normal, and the line of text: what is there, and how many
//! microseconds it took to find out. It does not depend on the number of things: try `--blocks 40`.
//!
//! **Headless** runs the same scene without a window or a GPU, sweeps a synthetic pointer over the view and clicks, and
//! prints what was found, the time per pick beside that of Bevy's `MeshRayCast` on the same rays, and where it put a
//! picture of the view, made by casting a ray per pixel.

#[path = "../shared/command_line.rs"]
mod command_line;
mod headless;
mod interaction;
mod options;
#[path = "../shared/panel.rs"]
mod panel;
mod picture;
mod plan;
#[path = "../shared/pointer.rs"]
mod pointer;
#[path = "../shared/picture.rs"]
mod ray_cast_picture;
mod scenery;
#[path = "../shared/mod.rs"]
mod shared;
mod traffic;

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
    app.add_plugins(shared::plugins("bevy_sightline: city", headless));
    app.insert_resource(options)
        .add_plugins((SightlinePlugins, scenery::plugin, traffic::plugin, interaction::plugin));
    if headless {
        headless::run(app)
    } else {
        app.add_plugins((FreeCameraPlugin, interaction::window_plugin)).run()
    }
}
