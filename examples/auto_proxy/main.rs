//! Levels of detail that are made of any model, side by side.
//!
//! ```sh
//! cargo run --release --features simplify --example auto_proxy                    # a window, or a table without one
//! cargo run --release --features simplify --example auto_proxy -- --model X.glb   # another model
//! cargo run --release --features simplify --example auto_proxy -- --headless      # the table, and a picture
//! cargo run --release --features simplify --example auto_proxy -- --help          # all options
//! ```
//!
//! **In the window** the original stands on the left, and beside it each level that [`AutoProxy`] has made of it, with
//! its triangles, the measured error in pixels from where you are, and from how far away that is one pixel. A bar
//! counts what is done while levels are made. L draws the edges of the triangles. Fly with W A S D, E, Q and the right
//! mouse button held; the wheel changes the speed. Look for the difference between two neighbours from where the error
//! is below a pixel.
//!
//! **Headless** makes the same levels without a window or a GPU, and prints them as a table, with how long they took.
//! The picture is made by casting a ray per pixel.

#[path = "../shared/command_line.rs"]
#[expect(dead_code, reason = "other examples read numbers too")]
mod command_line;
mod gallery;
mod headless;
mod labels;
mod options;
#[path = "../shared/panel.rs"]
mod panel;
#[path = "../shared/picture.rs"]
#[expect(dead_code, reason = "other examples draw lines too")]
mod ray_cast_picture;
#[path = "../shared/mod.rs"]
#[expect(dead_code, reason = "other examples show everything that they load")]
mod shared;

use bevy::{
    asset::UnapprovedPathMode,
    camera_controller::free_camera::FreeCameraPlugin,
    pbr::wireframe::{WireframeConfig, WireframePlugin},
    prelude::*,
};
use bevy_sightline::prelude::*;

use gallery::Gallery;
use options::Options;
use shared::script::PlayScript;

fn main() -> AppExit {
    let options = match command_line::read(Options::parse) {
        Ok(options) => options,
        Err(exit) => return exit,
    };
    let (headless, edges) = (options.headless, options.edges);
    // A model may be anywhere.
    let assets = AssetPlugin {
        file_path: concat!(env!("CARGO_MANIFEST_DIR"), "/assets").into(),
        unapproved_path_mode: UnapprovedPathMode::Allow,
        ..default()
    };
    let plugins = shared::plugins("bevy_sightline: auto_proxy", headless).set(assets);
    let mut app = App::new();
    app.add_plugins((plugins, SightlinePlugins, gallery::plugin))
        .insert_resource(options);
    if headless {
        return headless::run(app);
    }
    app.add_plugins((FreeCameraPlugin, WireframePlugin::default(), labels::plugin))
        .insert_resource(WireframeConfig {
            global: edges,
            default_color: Color::srgb(0.02, 0.05, 0.1),
            ..default()
        })
        .add_systems(Update, toggle_edges)
        .configure_sets(
            Last,
            PlayScript.run_if(|gallery: Res<Gallery>| !gallery.columns.is_empty()),
        )
        .run()
}

fn toggle_edges(keys: Res<ButtonInput<KeyCode>>, mut edges: ResMut<WireframeConfig>) {
    if keys.just_pressed(KeyCode::KeyL) {
        edges.global = !edges.global;
    }
}
