//! A city of 17,000 things, or a million, with everything that this crate does at once: picking, selection, view
//! culling, occlusion, levels of detail, and a look inside.
//!
//! ```sh
//! cargo run --release --example city                       # a window where there is a display, else a report
//! cargo run --release --example city -- --headless         # the report
//! cargo run --release --example city -- --entities 1000000 # a larger city
//! cargo run --release --example city -- --plain            # the same with what Bevy has built in
//! cargo run --release --example city -- --report           # both, in turn, and how long each stage takes
//! cargo run --release --example city -- --help             # all options
//! ```
//!
//! **In the window** move the mouse over anything, click to select it, and drag what is selected along the ground. With
//! Shift held, drag a box over what is to be selected, and with Control a lasso. Look for the yellow triangle under the
//! pointer with its normal, and for the figures at the top: what is in view, what was passed over because it is hidden,
//! at which levels of detail the rest is shown, and how long each of these takes in a frame. The keys at the bottom
//! switch each of them off and on: look at the times. G shows the nodes of the tree, the boxes of things, what
//! occludes, and the groups with levels, and F1 opens the inspector where the crate is built with it (`--features
//! inspector`). Fly with W A S D, E, Q and the right mouse button held, or let F fly.
//!
//! **Headless** runs the same scene without a window or a GPU. A synthetic pointer sweeps the view, clicks, drags and
//! draws a box; culling is held against Bevy's, occlusion against rays, levels against distances. It prints what was
//! found, the time per pick beside that of Bevy's `MeshRayCast` on the same rays, and where it put a picture of the
//! view, made by casting a ray per pixel; and it fails where anything is wrong.
//!
//! **The report** flies through the city twice at once, with this crate and with what Bevy has built in, and fails if
//! this crate shows anything that Bevy does not, or picks anything else.

#[path = "../shared/by_hand.rs"]
mod by_hand;
#[path = "../shared/command_line.rs"]
mod command_line;
#[path = "../shared/look.rs"]
mod look;
#[path = "../shared/outline.rs"]
mod outline;
#[path = "../shared/panel.rs"]
mod panel;
#[path = "../shared/pointer.rs"]
mod pointer;
#[path = "../shared/picture.rs"]
mod ray_cast_picture;
#[path = "../shared/route.rs"]
mod route;
#[path = "../shared/mod.rs"]
mod shared;
#[path = "../shared/times.rs"]
mod times;

mod blocks;
mod checks;
mod controls;
mod drawing;
mod figures;
mod flight;
mod headless;
mod interaction;
mod levels;
mod loading;
mod marks;
mod methods;
mod options;
mod picture;
mod plan;
mod report;
mod scenery;
mod stopwatch;
mod sweep;
mod traffic;

use bevy::{camera_controller::free_camera::FreeCameraPlugin, prelude::*};

use options::Options;
use shared::script::PlayScript;

fn main() -> AppExit {
    let options = match command_line::read(Options::parse) {
        Ok(options) => options,
        Err(exit) => return exit,
    };
    if options.report || (options.headless && options.plain) {
        return report::run(&options);
    }
    let mut app = App::new();
    app.add_plugins(shared::plugins("bevy_sightline: city", options.headless));
    build(&mut app, options.clone());
    if options.headless {
        return headless::run(app);
    }
    app.add_plugins((FreeCameraPlugin, flight::window_plugin, marks::window_plugin))
        .add_plugins((controls::window_plugin, figures::window_plugin))
        .configure_sets(Last, PlayScript.run_if(loading::is_complete));
    if !options.plain {
        app.add_plugins((outline::window_plugin, controls::sightline_plugin));
        #[cfg(feature = "inspector")]
        app.add_plugins(bevy_sightline::prelude::SightlineInspectorPlugin);
    }
    app.run()
}

/// The city, with whatever finds, culls and hides.
fn build(app: &mut App, options: Options) {
    let is_plain = options.plain;
    app.insert_resource(options)
        .add_plugins((methods::plugin, scenery::plugin, traffic::plugin, interaction::plugin))
        .add_plugins((levels::plugin, blocks::plugin, stopwatch::plugin));
    if !is_plain {
        app.add_plugins(drawing::plugin);
    }
}
