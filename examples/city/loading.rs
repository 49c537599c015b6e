//! Waiting until the city is complete.

use bevy::prelude::*;
use bevy_sightline::{index::MeshBvhs, prelude::*};

use crate::{blocks::ProxiesAreUp, shared};

/// So many frames are enough for the models to arrive, and for all that is made of them.
const PATIENCE: u32 = 200_000;

/// Whether blocks have their proxies, and what is made of meshes is there.
pub fn is_complete(proxies: Res<ProxiesAreUp>, bvhs: Option<Res<MeshBvhs>>, occluders: Option<Res<Occluders>>) -> bool {
    let making = bvhs.map_or(0, |bvhs| bvhs.building()) + occluders.map_or(0, |occluders| occluders.making());
    proxies.0 && making == 0
}

/// Runs frames of a city without a window until all models are there, and it [is complete](is_complete).
pub fn load(app: &mut App) -> Result<(), String> {
    shared::load(app)?;
    for _ in 0..PATIENCE {
        if app.world_mut().run_system_cached(is_complete).unwrap_or(false) {
            // One more, in which cameras see what has come last.
            app.update();
            return Ok(());
        }
        app.update();
    }
    Err("the models do not arrive".into())
}
