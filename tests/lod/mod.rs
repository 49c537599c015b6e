//! Levels of detail: of each group exactly one, in every view, in every frame.

mod bad_input;
mod choosing;
mod differential;
mod events;
mod fade;
mod members;
mod nested;
mod others;
mod shadows;
mod stability;
mod streaming;
mod swapped;
mod variants;
mod views;

use std::any::TypeId;

use bevy::{
    camera::{RenderTargetInfo, visibility::VisibleEntities},
    gizmos::GizmoPlugin,
    light::LightPlugin,
    prelude::*,
};
use bevy_sightline::prelude::*;

use crate::common::*;

/// An app with cameras, lights and no window.
fn app() -> App {
    headless_app_with(|app| _ = app.add_plugins((GizmoPlugin, LightPlugin)))
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

fn despawn(app: &mut App, entity: Entity) {
    app.world_mut().despawn(entity);
}

fn set_parent(app: &mut App, child: Entity, parent: Entity) {
    app.world_mut().entity_mut(parent).add_child(child);
}

fn settings(app: &mut App) -> Mut<'_, LodSettings> {
    app.world_mut().resource_mut()
}

fn choices(app: &App) -> &LodChoices {
    app.world().resource()
}

/// A group whose levels are entities.
struct Statue {
    root: Entity,
    levels: Vec<Entity>,
}

/// A group of so many unit cubes at the origin, each a child and a level.
fn spawn_statue(app: &mut App, levels: usize, lod: impl FnOnce(&[Entity]) -> ProxyLod) -> Statue {
    let mesh = add_mesh(app, Cuboid::default());
    let root = spawn(app, (Transform::default(), Visibility::default()));
    let levels: Vec<Entity> = (0..levels)
        .map(|_| spawn(app, (Mesh3d(mesh.clone()), ChildOf(root))))
        .collect();
    let lod = lod(&levels);
    insert(app, root, lod);
    Statue { root, levels }
}

/// Levels that take over at these thresholds.
fn lod(metric: LodMetric, levels: &[Entity], thresholds: &[f32]) -> ProxyLod {
    let coarser = levels[1..].iter().zip(thresholds);
    coarser.fold(ProxyLod::new(metric, levels[0]), |lod, (&level, &threshold)| {
        lod.then(threshold, level)
    })
}

/// Three levels, of which the second takes over at 10 m and the third at 20 m.
fn by_distance(levels: &[Entity]) -> ProxyLod {
    lod(LodMetric::Distance, levels, &[10.0, 20.0])
}

/// A statue at the origin with three levels: up to 10 m, up to 20 m, and beyond.
fn spawn_statue_by_distance(app: &mut App) -> Statue {
    spawn_statue(app, 3, by_distance)
}

/// A camera that looks along -z at the origin, so far from the face of a unit cube that is there.
fn at_distance(distance: f32) -> Transform {
    Transform::from_xyz(0.0, 0.0, distance + 0.5)
}

fn spawn_camera(app: &mut App, distance: f32) -> Entity {
    spawn(app, (Camera3d::default(), at_distance(distance)))
}

/// Gives a camera a viewport that is so high in physical pixels, as the renderer does.
fn set_viewport_height(app: &mut App, camera: Entity, height: u32) {
    let mut camera = app.world_mut().get_mut::<Camera>(camera).expect("a camera");
    camera.computed.target_info = Some(RenderTargetInfo {
        physical_size: UVec2::new(height * 2, height),
        scale_factor: 1.0,
    });
}

/// The meshes in the list of a camera, by index.
fn listed(app: &App, camera: Entity) -> Vec<Entity> {
    let lists = app.world().get::<VisibleEntities>(camera).expect("a camera");
    let mut listed = lists.get(TypeId::of::<Mesh3d>()).to_vec();
    listed.sort_unstable_by_key(|entity| entity.index());
    let set = app.world().get::<VisibleSet>(camera).expect("a camera");
    assert!(
        listed.iter().all(|&entity| set.contains(entity)),
        "one list is as the other"
    );
    listed
}

fn sees(app: &App, camera: Entity, entity: Entity) -> bool {
    listed(app, camera).contains(&entity)
}

/// The level of a statue that a camera shows, by its list; there must be exactly one, and nobody may say otherwise.
#[track_caller]
fn shown(app: &App, camera: Entity, statue: &Statue) -> usize {
    let listed = listed(app, camera);
    let shown: Vec<usize> = (0..statue.levels.len())
        .filter(|&level| listed.contains(&statue.levels[level]))
        .collect();
    assert_eq!(shown.len(), 1, "exactly one level is shown, and not {shown:?}");
    let choices = choices(app);
    assert_eq!(choices.level(statue.root, camera), Some(shown[0]));
    for (level, &entity) in statue.levels.iter().enumerate() {
        assert_eq!(choices.shows(camera, entity), level == shown[0]);
    }
    shown[0]
}

/// The level that a camera shows, after a frame.
#[track_caller]
fn look(app: &mut App, camera: Entity, statue: &Statue) -> usize {
    app.update();
    shown(app, camera, statue)
}

/// The level that a camera shows, after a frame, from so far away.
#[track_caller]
fn look_from(app: &mut App, camera: Entity, distance: f32, statue: &Statue) -> usize {
    insert(app, camera, at_distance(distance));
    look(app, camera, statue)
}
