//! What following sprites has cost.

use std::time::Duration;

use bevy::{
    ecs::{reflect::ReflectResource, resource::Resource},
    reflect::{Reflect, std_traits::ReflectDefault},
};

/// What following sprites took in the last frame.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Resource, Default, Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SpriteIndexStats {
    /// The sprites that are known.
    pub sprites: usize,
    /// The sprites that were looked at: they, or their images, had come, changed or gone.
    pub reconciled: usize,
    /// The time that it took.
    pub follow: Duration,
}
