//! Foxes that run in circles: click on one, and a pin stays on the very triangle that was hit.
//!
//! ```sh
//! cargo run --release --example skinned_picking                  # a window where there is a display, else a report
//! cargo run --release --example skinned_picking -- --headless    # the report
//! cargo run --release --example skinned_picking -- --compare     # a window: are the picked and the drawn fox alike?
//! cargo run --release --example skinned_picking -- --help        # all options, another model among them
//! ```
//!
//! **In the window** move the mouse over a fox and click. Fly with W A S D, E, Q and the right mouse button held; the
//! wheel changes the speed. Space stops the time. Look for the yellow triangle under the mouse: it is where the fox is
//! drawn now, in the middle of its stride, not where it was modelled; for the white box, which breathes with the pose;
//! and for the pins, which stay on the skin while it stretches.
//!
//! **Headless** runs the same scene without a window or a GPU, clicks on a fox, casts rays at all of them in each
//! frame, and prints whether the hits are where a skinning of the model in double precision says, what they cost, and
//! where it put a picture of the view, made by casting a ray per pixel.

#[path = "../shared/command_line.rs"]
mod command_line;
mod compare;
mod headless;
mod marks;
mod meadow;
mod options;
#[path = "../shared/panel.rs"]
mod panel;
#[path = "../shared/pointer.rs"]
mod pointer;
#[path = "../shared/picture.rs"]
mod ray_cast_picture;
mod reference;
#[path = "../shared/mod.rs"]
mod shared;

use bevy::{asset::UnapprovedPathMode, camera_controller::free_camera::FreeCameraPlugin, prelude::*};
use bevy_sightline::prelude::*;

use options::{Mode, Options};

fn main() -> AppExit {
    let options = match command_line::read(Options::parse) {
        Ok(options) => options,
        Err(exit) => return exit,
    };
    let mode = options.mode;
    // A model may be anywhere.
    let assets = AssetPlugin {
        file_path: concat!(env!("CARGO_MANIFEST_DIR"), "/assets").into(),
        unapproved_path_mode: UnapprovedPathMode::Allow,
        ..default()
    };
    let plugins = shared::plugins("bevy_sightline: skinned picking", mode == Mode::Headless).set(assets);
    let mut app = App::new();
    app.add_plugins((plugins, SightlinePlugins)).insert_resource(options);
    match mode {
        Mode::Window => app
            .add_plugins((FreeCameraPlugin, meadow::plugin, marks::plugin, marks::window_plugin))
            .run(),
        Mode::Headless => {
            app.add_plugins((meadow::plugin, marks::plugin));
            headless::run(app)
        }
        Mode::Compare => app.add_plugins(compare::plugin).run(),
    }
}
