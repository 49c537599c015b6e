//! How levels are chosen, for all groups and for single cameras.

use std::time::Duration;

use bevy::{
    ecs::{
        component::Component, entity::Entity, reflect::ReflectComponent, reflect::ReflectResource, resource::Resource,
    },
    reflect::{Reflect, std_traits::ReflectDefault},
};

/// How levels are chosen in all views.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Resource, Default, Debug, Clone, PartialEq)]
pub struct LodSettings {
    /// Whether levels are chosen. If not, everything is shown by its finest level: for comparison.
    pub enabled: bool,
    /// Multiplies the size of everything in all views: over 1, finer levels are shown from farther away.
    pub bias: f32,
    /// The same for shadow maps, on top of all else: under 1, shadows are cast by coarser levels. At 1 they are cast by
    /// what the camera shows, and so they are if this is no positive number.
    pub shadow_bias: f32,
    /// How far beyond a threshold a coarser level takes over, as a fraction of the distance. A finer level comes at the
    /// threshold itself, which so is a promise; between the two nothing switches.
    pub hysteresis: f32,
    /// How long a level stays at least, in the time of [`Time`](bevy::time::Time).
    pub min_dwell: Duration,
    /// How long levels that are entities fade into each other, in the time of [`Time`](bevy::time::Time); zero for not at
    /// all. Bevy's renderer dithers them, by a [`VisibilityRange`](bevy::camera::visibility::VisibilityRange) that they have
    /// as long as they fade: so it is for a single active camera, and for what has no `VisibilityRange` of its own. With
    /// more cameras, or more than 1,024 entities that fade, levels switch at once.
    pub cross_fade: Duration,
    /// The camera for which meshes are swapped. By default the first active one that has a `Camera3d`: by its `order`,
    /// then by entity.
    pub main_camera: Option<Entity>,
    /// The height of a viewport of which none is known, in physical pixels: without a window.
    pub viewport_height: f32,
}

impl Default for LodSettings {
    fn default() -> Self {
        Self {
            enabled: true,
            bias: 1.0,
            shadow_bias: 1.0,
            hysteresis: 0.1,
            min_dwell: Duration::ZERO,
            cross_fade: Duration::ZERO,
            main_camera: None,
            viewport_height: 1080.0,
        }
    }
}

/// On a camera: multiplies the size of everything in its view, over 1 for finer levels. For a camera on which this is no
/// positive number all is shown by its finest level, with one warning.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub struct LodBias(pub f32);

impl Default for LodBias {
    fn default() -> Self {
        Self(1.0)
    }
}
