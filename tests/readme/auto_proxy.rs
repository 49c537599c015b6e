use bevy::prelude::*;
use bevy_sightline::prelude::*;

fn main() {
    App::new()
        .add_plugins((DefaultPlugins, SightlinePlugins))
        // Whatever has a mesh has levels of detail.
        .register_required_components::<Mesh3d, AutoProxy>()
        .run();
}
