//! What an entity hides things by.

use bevy::{
    asset::Handle,
    ecs::{
        component::Component,
        reflect::{ReflectComponent, ReflectResource},
        resource::Resource,
    },
    mesh::Mesh,
    reflect::{Reflect, std_traits::ReflectDefault},
};

use crate::mesh::InnerBoxSettings;

/// Has an entity hide what is behind it. [`occlusion`](super) compares the kinds.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sightline::occlusion::Occluder;
/// # fn spawn(mut commands: Commands, house: Handle<Mesh>, hill: Handle<Mesh>, core: Handle<Mesh>) {
/// commands.spawn((Mesh3d(house), Occluder::Auto));
/// commands.spawn((Mesh3d(hill), Occluder::Proxy(core)));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, PartialEq, Default)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub enum Occluder {
    /// By [boxes inside](crate::mesh::InnerBoxes) of its `Mesh3d`, which are found once for each mesh. The mesh must be
    /// closed. What is seen from inside of it, through faces that are seen from behind, may be hidden too.
    ///
    /// For a mesh that is edited all the time, they are never done: use another kind.
    #[default]
    Auto,
    /// By its `Aabb`, which it fills, and which hides as if it were solid.
    Box,
    /// By the triangles of its `Mesh3d`.
    Mesh,
    /// By the triangles of another mesh, in the same place. What is hidden by this must be hidden by what is drawn: it
    /// should lie within.
    Proxy(Handle<Mesh>),
}

/// How occluders are made.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Resource, Default, Debug, Clone, PartialEq)]
pub struct OccluderSettings {
    /// How the boxes of [`Occluder::Auto`] are looked for. All are found anew when it changes.
    pub inner: InnerBoxSettings,
}
