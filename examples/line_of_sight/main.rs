//! Guards and a thief: who sees whom, what is in the way, and how much of somebody can be seen.
//!
//! ```sh
//! cargo run --release --example line_of_sight                # a window where there is a display, else figures
//! cargo run --release --example line_of_sight -- --headless  # the figures
//! cargo run --release --example line_of_sight -- --help      # all options
//! ```
//!
//! **In the window** five guards walk their rounds in a courtyard. The light on the ground is what each can see at the
//! height of a chest: a fan of rays, which end at walls, pillars and high crates, all cast at once. A guard who has the
//! thief in that direction asks for the lines of sight to seven points of the body: red lines reach it, and of a guard
//! who sees none of them a grey line ends in a cross at what is in the way. Guards who see stop and turn to the thief.
//! The figure over the thief is the share of it that the guards can see at most: look how it falls behind hedges and
//! crates, which hide no more than its legs. Walk it with the arrow keys or W A S D; R lets it go its own way again,
//! and Space holds everybody still.
//!
//! **Headless** runs the same scene without a window or a GPU, holds each fan against lines of sight, prints who saw
//! how much of the thief, and with `--picture FILE` draws the fullest moment, ray by ray.

#[path = "../shared/command_line.rs"]
mod command_line;
mod courtyard;
mod drawing;
mod guards;
mod headless;
mod options;
#[path = "../shared/panel.rs"]
mod panel;
#[path = "../shared/picture.rs"]
mod picture;
#[path = "../shared/mod.rs"]
mod shared;
mod thief;
mod walk;

use bevy::prelude::*;
use bevy_sightline::prelude::*;

use options::Options;

fn main() -> AppExit {
    let options = match command_line::read(Options::parse) {
        Ok(options) => options,
        Err(exit) => return exit,
    };
    let headless = options.headless;
    let mut app = App::new();
    app.add_plugins(shared::plugins("bevy_sightline: line of sight", headless))
        .insert_resource(options)
        .add_plugins((SightlinePlugins, courtyard::plugin, guards::plugin, thief::plugin));
    if headless {
        headless::run(app)
    } else {
        app.add_plugins(drawing::plugin).run()
    }
}
