use bevy::prelude::*;
use bevy_sightline::prelude::*;

fn main() {
    App::new()
        .add_plugins((DefaultPlugins, SightlinePlugins, SightlineInspectorPlugin))
        .run();
}
