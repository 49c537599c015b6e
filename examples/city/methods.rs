//! What finds, culls and hides: `bevy_sightline`, or Bevy's built-ins.

use bevy::{picking::mesh_picking::MeshPickingPlugin, prelude::*};
use bevy_sightline::prelude::*;

use crate::{
    options::Options,
    scenery::{Thing, is_building},
};

pub fn plugin(app: &mut App) {
    if app.world().resource::<Options>().plain {
        app.add_plugins(MeshPickingPlugin);
    } else {
        app.add_plugins(SightlinePlugins).add_systems(PostStartup, occlude);
    }
}

/// Has all buildings hide what is behind them, from the camera.
fn occlude(mut commands: Commands, things: Query<(Entity, &Thing)>, camera: Single<Entity, With<Camera3d>>) {
    commands.entity(*camera).insert(SoftwareOcclusion::default());
    for (entity, thing) in &things {
        if is_building(thing.model) {
            commands.entity(entity).insert(Occluder::Auto);
        }
    }
}
