//! What hides what is behind it.

mod cameras;
mod changes;
mod city;
mod exact;
mod occluders;
mod proof;
mod reasons;
mod regressions;

use std::any::TypeId;

use bevy::{camera::visibility::VisibleEntities, prelude::*};
use bevy_sightline::prelude::*;

use crate::common::*;

/// A camera at the origin that looks along -z, and does not see what is hidden.
fn spawn_camera(app: &mut App) -> Entity {
    spawn(app, (Camera3d::default(), SoftwareOcclusion::default()))
}

fn spawn(app: &mut App, bundle: impl Bundle) -> Entity {
    app.world_mut().spawn(bundle).id()
}

fn insert(app: &mut App, entity: Entity, bundle: impl Bundle) {
    app.world_mut().entity_mut(entity).insert(bundle);
}

fn remove<B: Bundle>(app: &mut App, entity: Entity) {
    app.world_mut().entity_mut(entity).remove::<B>();
}

/// A wall of 8 by 6 m and a depth of 1 m, 10 m before the camera, that hides what is behind it.
fn spawn_wall(app: &mut App) -> Entity {
    let wall = spawn_mesh(app, Cuboid::new(8.0, 6.0, 1.0), Transform::from_xyz(0.0, 0.0, -10.0));
    insert(app, wall, Occluder::Box);
    wall
}

/// A unit cube at a distance straight ahead of the camera.
fn spawn_ahead(app: &mut App, distance: f32) -> Entity {
    spawn_cube(app, Vec3::new(0.0, 0.0, -distance))
}

/// The meshes that a camera sees, after a frame.
fn look(app: &mut App, camera: Entity) -> Vec<Entity> {
    app.update();
    listed(app, camera)
}

fn listed(app: &App, camera: Entity) -> Vec<Entity> {
    let lists = app.world().get::<VisibleEntities>(camera).expect("a camera");
    lists.get(TypeId::of::<Mesh3d>()).to_vec()
}

/// Whether a camera sees an entity, after a frame.
fn sees(app: &mut App, camera: Entity, entity: Entity) -> bool {
    look(app, camera).contains(&entity)
}
