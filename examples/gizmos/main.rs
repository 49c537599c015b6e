//! What it looks like inside: the tree, the grid, the boxes and the spheres by which all is found, drawn over the city.
//!
//! ```sh
//! cargo run --release --example gizmos                                    # a window where there is a display, else figures
//! cargo run --release --example gizmos -- --headless                      # the figures
//! cargo run --release --example gizmos -- --headless --pictures out/gizmos  # and a picture of each kind
//! cargo run --release --example gizmos -- --help                          # all options
//! ```
//!
//! **In the window** the keys 1 to 9 switch: the nodes of the tree, the cells of the grid, the boxes of things, their
//! bounding volumes (of the next kind each time), what cameras see, what occludes, the ray under the mouse with what it
//! hits, groups with levels of detail, and an octree or a k-d tree that is built of the same boxes. The legend says how many
//! of each were drawn and how many were left out. Comma and full stop take the tree and the grid level by level; L changes
//! how many lines there may be. Click on something to see what is known of it alone, and again to be rid of that. The
//! small picture is what another camera sees: look for its frustum. Fly with W A S D, E, Q and the right mouse button held.
//!
//! **Headless** draws each kind for itself, checks that something was drawn and no limit passed, and prints the figures.

#[path = "../shared/command_line.rs"]
mod command_line;
#[path = "../shared/panel.rs"]
mod panel;
#[path = "../city/plan.rs"]
mod plan;
#[path = "../shared/pointer.rs"]
#[expect(dead_code, reason = "other examples click")]
mod pointer;
#[path = "../shared/picture.rs"]
mod ray_cast_picture;
#[path = "../city/scenery.rs"]
mod scenery;
#[path = "../shared/mod.rs"]
mod shared;

mod controls;
mod headless;
mod kinds;
mod options;
mod picture;
mod scene;

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
    app.add_plugins(shared::plugins("bevy_sightline: gizmos", headless))
        .insert_resource(options)
        .add_plugins((SightlinePlugins, scenery::plugin, scene::plugin, kinds::plugin));
    if headless {
        headless::run(app)
    } else {
        app.add_plugins((FreeCameraPlugin, controls::plugin)).run()
    }
}
