//! Box and lasso over a city of thousands of things: whatever they touch is known exactly, and while they are drawn.
//!
//! ```sh
//! cargo run --release --example marquee                 # a window where there is a display, else a check
//! cargo run --release --example marquee -- --headless   # the check
//! cargo run --release --example marquee -- --help       # all options
//! ```
//!
//! **In the window** hold the left mouse button and drag a box, or with Shift held draw a lasso; a click selects all that is
//! behind the mouse. T tells whether things must be touched or wholly enclosed, B whether their meshes count or their
//! bounds. Fly with W A S D, E, Q and the right mouse button held. Look for the lamps and trees between the towers: only
//! what the outline really touches lights up, and where a lasso crosses itself, what it goes around twice is left out. The
//! panel says how long it takes, which hardly depends on the number of things: try `--blocks 40`.
//!
//! **Headless** runs the same scene without a window or a GPU, draws a box and a lasso with a synthetic mouse, and holds
//! what was selected against every triangle of the city, projected to the screen in double precision.

#[path = "../shared/command_line.rs"]
mod command_line;
mod drawing;
mod headless;
mod marquee;
mod options;
#[allow(dead_code, reason = "the tests of the library ask more of it")]
#[path = "../../tests/selection/oracle.rs"]
mod oracle;
#[path = "../shared/outline.rs"]
mod outline;
#[path = "../shared/panel.rs"]
mod panel;
#[path = "../city/plan.rs"]
mod plan;
#[path = "../city/scenery.rs"]
mod scenery;
#[path = "../shared/mod.rs"]
mod shared;

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
    app.add_plugins(shared::plugins("bevy_sightline: marquee", headless))
        .insert_resource(options)
        .add_plugins((SightlinePlugins, scenery::plugin, marquee::plugin));
    if headless {
        headless::run(app)
    } else {
        app.add_plugins((FreeCameraPlugin, drawing::plugin)).run()
    }
}
