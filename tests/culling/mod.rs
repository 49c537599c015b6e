//! What cameras and lights see: exactly what Bevy's own systems say.
//!
//! Every behaviour that is Bevy's is asked of Bevy's own systems first, and then of ours.

mod cameras;
mod changes;
mod classes;
mod differential;
mod frusta;
mod layers;
mod lights;
mod marks;
mod paused;
mod reports;
mod settings;
mod visibility;
mod visible_set;

use std::any::TypeId;

use bevy::{camera::visibility::VisibleEntities, ecs::change_detection::Tick, prelude::*};

use differential::{
    apps::{bevys, ours},
    cast::Meshes,
};

/// Asks Bevy's own culling, and then ours.
fn of_both(test: impl Fn(&mut App)) {
    test(&mut bevys());
    test(&mut ours());
}

/// A camera at z = 10 that looks at the origin.
fn spawn_camera(app: &mut App) -> Entity {
    let place = Transform::from_xyz(0.0, 0.0, 10.0);
    app.world_mut().spawn((Camera3d::default(), place)).id()
}

fn spawn(app: &mut App, bundle: impl Bundle) -> Entity {
    app.world_mut().spawn(bundle).id()
}

/// The mesh of a unit cube.
fn cube(app: &App) -> Mesh3d {
    Mesh3d(app.world().resource::<Meshes>().0[0].clone())
}

/// A unit cube in front of the camera.
fn spawn_cube(app: &mut App) -> Entity {
    let cube = cube(app);
    spawn(app, cube)
}

/// A unit cube somewhere.
fn spawn_cube_at(app: &mut App, x: f32, y: f32, z: f32) -> Entity {
    let cube = cube(app);
    spawn(app, (cube, Transform::from_xyz(x, y, z)))
}

fn insert(app: &mut App, entity: Entity, bundle: impl Bundle) {
    app.world_mut().entity_mut(entity).insert(bundle);
}

fn remove<B: Bundle>(app: &mut App, entity: Entity) {
    app.world_mut().entity_mut(entity).remove::<B>();
}

/// What a camera sees of a class, after a frame.
fn look_for<C: 'static>(app: &mut App, camera: Entity) -> Vec<Entity> {
    app.update();
    listed::<C>(app, camera)
}

/// The meshes that a camera sees, after a frame.
fn look(app: &mut App, camera: Entity) -> Vec<Entity> {
    look_for::<Mesh3d>(app, camera)
}

/// The list of a camera for a class.
fn listed<C: 'static>(app: &App, camera: Entity) -> Vec<Entity> {
    let lists = app.world().get::<VisibleEntities>(camera).expect("a camera");
    lists.get(TypeId::of::<C>()).to_vec()
}

/// Whether something is seen by anything.
fn is_seen(app: &App, entity: Entity) -> bool {
    let visibility = app.world().get::<ViewVisibility>(entity);
    visibility.expect("an entity that can be seen").get()
}

/// When a component was last written to.
fn written<C: Component>(app: &App, entity: Entity) -> Tick {
    let component = app.world().entity(entity).get_ref::<C>();
    component.expect("such a component").last_changed()
}

/// In the order of lists.
fn sorted(entities: impl IntoIterator<Item = Entity>) -> Vec<Entity> {
    let mut entities: Vec<Entity> = entities.into_iter().collect();
    entities.sort_unstable();
    entities
}
