//! How space is divided, and what a ray visits of it: the same boxes in every structure, step by step.
//!
//! ```sh
//! cargo run --release --example structures                # a window where there is a display, else figures
//! cargo run --release --example structures -- --headless  # the figures
//! cargo run --release --example structures -- --help      # all options
//! ```
//!
//! **In the window** the keys 1 to 5 choose the structure: AABB tree, uniform grid, k-d tree, octree, a plain list; B
//! the next way to build it, where there are several. Drag with the left mouse button to aim a ray from where you press
//! to where you release; R takes back the first one. The right arrow goes one visit forward, the left one back, Space
//! plays, Home and End jump. What has been visited is coloured and numbered in its order, the present visit is bright,
//! what is tested in it outlined; boxes that were tested turn pale, those that the ray enters amber, and the nearest so
//! far green. The table tells what the same ray costs in all other structures. Tab goes from two dimensions, where all
//! is flat and seen from above, to three, where the right mouse button turns the view; N makes other boxes.
//!
//! **Headless** sends rays through all structures, in two and three dimensions, checks that each gives the answer of
//! the plain list, and prints what a ray visits and tests on average.

#[path = "../shared/command_line.rs"]
mod command_line;
#[path = "../shared/panel.rs"]
mod panel;
#[path = "../shared/mod.rs"]
#[expect(dead_code, reason = "there are no models to wait for")]
mod shared;

mod boxes;
mod controls;
mod drawing;
mod explorer;
mod figures;
mod headless;
mod options;
mod structure;
mod view;

use bevy::prelude::*;

use options::Options;

fn main() -> AppExit {
    let options = match command_line::read(Options::parse) {
        Ok(options) => options,
        Err(exit) => return exit,
    };
    if options.headless {
        return headless::run(&options);
    }
    App::new()
        .add_plugins(shared::plugins("bevy_sightline: structures", false))
        .insert_resource(options)
        .add_plugins((
            explorer::plugin,
            controls::plugin,
            view::plugin,
            drawing::plugin,
            figures::plugin,
        ))
        .run()
}
