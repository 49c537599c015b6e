//! What culling keeps, seen from above: a camera flies through the city, and all that it does not see is dark.
//!
//! ```sh
//! cargo run --release --example culling                # a window where there is a display, else figures
//! cargo run --release --example culling -- --headless  # the figures
//! cargo run --release --example culling -- --help      # all options
//! ```
//!
//! **In the window** the small picture is what the flying camera sees, the large one the whole city from above: bright is
//! what was kept for that camera, dark what was culled. The boxes are the nodes of the tree that had to be looked at, each
//! once: green ones are inside the frustum and were taken as a whole, red ones are outside and were dropped as a whole,
//! and only what is in the amber ones was looked at further. Space hands culling to Bevy's own systems and back: the
//! picture stays as it is, and the figures tell what each takes per frame. B hides the boxes, V the view from above (for
//! which the rest of the city is culled too, and which is in the figures); F holds the flight still, or fly yourself with
//! W A S D, E, Q and the right mouse button held.
//!
//! **Headless** flies one round with each, checks in each frame that both keep the same things, and prints the figures.

#[path = "../shared/by_hand.rs"]
mod by_hand;
#[path = "../shared/command_line.rs"]
mod command_line;
#[path = "../shared/panel.rs"]
mod panel;
#[path = "../city/plan.rs"]
mod plan;
#[path = "../city/scenery.rs"]
mod scenery;
#[path = "../shared/mod.rs"]
mod shared;
#[path = "../shared/times.rs"]
mod times;

mod drawing;
mod headless;
mod nodes;
mod options;
mod paint;
mod stopwatch;
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
    app.add_plugins(shared::plugins("bevy_sightline: culling", headless));
    app.insert_resource(options)
        .add_plugins((SightlinePlugins, scenery::plugin, stopwatch::plugin));
    if headless {
        headless::run(app)
    } else {
        app.add_plugins((FreeCameraPlugin, views::plugin, paint::plugin, drawing::plugin))
            .run()
    }
}
