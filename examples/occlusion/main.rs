//! What hides what: a walk through the streets of a city, in which nearly everything is behind the next house.
//!
//! ```sh
//! cargo run --release --example occlusion                # a window where there is a display, else figures
//! cargo run --release --example occlusion -- --headless  # the figures
//! cargo run --release --example occlusion -- --help      # all options
//! ```
//!
//! **In the window** is what the walker sees. The buildings have [`Occluder::Auto`], the walker's camera has
//! [`SoftwareOcclusion`], and that is all: what is behind the buildings is not drawn. The small pictures show that. On the
//! left is the depth buffer, into which the nearest buildings were drawn on the CPU. On the right is the walker from
//! behind and above: what it sees is in its colours, what is hidden from it is a blue ghost, and what is outside of its
//! view is dark. O switches occlusion off and on, M takes the other mode, R another resolution; V hides the small
//! pictures, which are in the figures too; Space stops the walk, or walk yourself with W A S D, E, Q and the right mouse
//! button held.
//!
//! **Headless** walks one round with occlusion and one without, checks that everything that rays from the eye meet was
//! seen, and prints the figures. It fails if nothing was hidden, or if something was that can be seen.

#[path = "../shared/by_hand.rs"]
mod by_hand;
#[path = "../shared/command_line.rs"]
mod command_line;
#[path = "../shared/look.rs"]
mod look;
#[path = "../shared/panel.rs"]
mod panel;
#[path = "../city/plan.rs"]
mod plan;
#[path = "../shared/picture.rs"]
mod ray_cast_picture;
#[path = "../city/scenery.rs"]
mod scenery;
#[path = "../shared/mod.rs"]
mod shared;
#[path = "../shared/times.rs"]
mod times;

mod controls;
mod figures;
mod headless;
mod options;
mod paint;
mod picture;
mod sight;
mod stopwatch;
mod street_life;
mod views;
mod walk;

use bevy::{camera_controller::free_camera::FreeCameraPlugin, prelude::*};
use bevy_sightline::prelude::*;

use options::Options;
use shared::script::PlayScript;

fn main() -> AppExit {
    let options = match command_line::read(Options::parse) {
        Ok(options) => options,
        Err(exit) => return exit,
    };
    let headless = options.headless;
    let mut app = App::new();
    app.add_plugins(shared::plugins("bevy_sightline: occlusion", headless))
        .insert_resource(options)
        .add_plugins((SightlinePlugins, scenery::plugin, street_life::plugin))
        .add_plugins((walk::plugin, sight::plugin, stopwatch::plugin));
    if headless {
        headless::run(app)
    } else {
        app.add_plugins((FreeCameraPlugin, controls::plugin, views::plugin))
            .add_plugins((paint::plugin, figures::plugin))
            .configure_sets(
                Last,
                PlayScript.run_if(|occluders: Res<Occluders>| occluders.making() == 0),
            )
            .run()
    }
}
