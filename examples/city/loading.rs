//! Waiting until a city without a window is complete.

use bevy::prelude::*;
use bevy_sightline::{index::MeshBvhs, prelude::*};

use crate::{blocks::ProxiesAreUp, shared};

/// So many frames are enough for the models to arrive, and for all that is made of them.
const PATIENCE: u32 = 200_000;

/// Runs frames until all models are there, blocks have their proxies, and what occludes has its shapes.
pub fn load(app: &mut App) -> Result<(), String> {
    shared::load(app)?;
    for _ in 0..PATIENCE {
        let world = app.world();
        let building = world.get_resource::<MeshBvhs>().map_or(0, MeshBvhs::building);
        let making = world.get_resource::<Occluders>().map_or(0, Occluders::making);
        if world.resource::<ProxiesAreUp>().0 && building + making == 0 {
            // One more, in which cameras see what has come last.
            app.update();
            return Ok(());
        }
        app.update();
    }
    Err("the models do not arrive".into())
}
