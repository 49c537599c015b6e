//! Proxy LOD: the right stand-in, for each view, without popping back and forth.

mod group;

pub use group::{LodContent, LodHits, LodLevel, LodMetric, LodReference, ProxyLod};

use bevy::app::{App, Plugin};

/// Chooses levels of detail.
#[derive(Clone, Copy, Debug, Default)]
pub struct ProxyLodPlugin;

impl Plugin for ProxyLodPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<ProxyLod>();
    }
}
