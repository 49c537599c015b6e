//! What gizmos draw, line for line.

mod bad_data;
mod limits;
mod one_entity;
mod setup;
mod structures;
mod switches;
mod views;

use std::any::TypeId;

use bevy::{
    gizmos::{GizmoAsset, GizmoHandles, GizmoPlugin},
    light::LightPlugin,
    math::bounding::Aabb3d,
    prelude::*,
};
use bevy_sightline::prelude::*;

use crate::common::*;

/// An app with gizmos and no window.
fn app() -> App {
    headless_app_with(|app| _ = app.add_plugins((GizmoPlugin, LightPlugin)))
}

/// A camera at the origin that looks along -z.
fn spawn_camera(app: &mut App) -> Entity {
    app.world_mut().spawn(Camera3d::default()).id()
}

/// The only camera.
fn camera(app: &mut App) -> Entity {
    let mut cameras = app.world_mut().query_filtered::<Entity, With<Camera>>();
    cameras.single(app.world()).expect("one")
}

/// An app in which a camera sees unit cubes at these distances, straight ahead.
fn app_with_cubes(distances: impl IntoIterator<Item = f32>) -> (App, Vec<Entity>) {
    let mut app = app();
    spawn_camera(&mut app);
    let ahead = distances.into_iter().map(|distance| Vec3::NEG_Z * distance);
    let cubes = ahead.map(|place| spawn_cube(&mut app, place)).collect();
    settle(&mut app);
    (app, cubes)
}

/// Changes what is drawn, and draws a frame.
fn draw(app: &mut App, change: impl FnOnce(&mut SightlineGizmos)) {
    let mut store = app.world_mut().resource_mut::<GizmoConfigStore>();
    change(store.config_mut::<SightlineGizmos>().1);
    app.update();
}

fn stats(app: &App) -> SightlineGizmoStats {
    *app.world().resource()
}

fn count(drawn: usize, left_out: usize) -> GizmoCount {
    GizmoCount { drawn, left_out }
}

/// What was drawn in the last frame.
fn asset(app: &App) -> Option<&GizmoAsset> {
    let handles = app.world().resource::<GizmoHandles>().handles();
    let handle = handles.get(&TypeId::of::<SightlineGizmos>())?.as_ref()?;
    app.world().resource::<Assets<GizmoAsset>>().get(handle)
}

/// The lines that were drawn in the last frame, but for those of curves.
fn lines(app: &App) -> Vec<[Vec3; 2]> {
    let positions = asset(app).map(|asset| &asset.buffer().list_positions[..]);
    let (lines, _) = positions.unwrap_or_default().as_chunks::<2>();
    lines.to_vec()
}

/// The colours of these lines.
fn colors(app: &App) -> Vec<LinearRgba> {
    let colors = asset(app).map(|asset| asset.buffer().list_colors.clone());
    colors.unwrap_or_default().into_iter().step_by(2).collect()
}

/// Whether nothing was drawn at all.
fn is_blank(app: &App) -> bool {
    asset(app).is_none_or(|asset| asset.buffer().list_positions.is_empty() && asset.buffer().strip_positions.is_empty())
}

/// The boxes that were drawn, sorted, if nothing else was.
fn boxes(app: &App) -> Vec<[Vec3; 2]> {
    boxes_of(&lines(app))
}

fn boxes_of(lines: &[[Vec3; 2]]) -> Vec<[Vec3; 2]> {
    let (boxes, rest) = lines.as_chunks::<12>();
    assert!(rest.is_empty(), "a box is twelve lines");
    let mut boxes: Vec<_> = boxes.iter().map(|edges| corners_around(edges)).collect();
    sort(&mut boxes);
    boxes
}

/// The least and the greatest corner of the box around some lines.
fn corners_around(lines: &[[Vec3; 2]]) -> [Vec3; 2] {
    let ends = || lines.iter().flatten().copied();
    let min = ends().reduce(Vec3::min).expect("a line");
    [min, ends().reduce(Vec3::max).expect("a line")]
}

fn corners(aabb: &Aabb3d) -> [Vec3; 2] {
    [aabb.min.into(), aabb.max.into()]
}

fn sort(boxes: &mut [[Vec3; 2]]) {
    let key = |[min, max]: &[Vec3; 2]| [min.to_array(), max.to_array()];
    boxes.sort_by(|a, b| key(a).partial_cmp(&key(b)).expect("numbers"));
}

fn sorted(boxes: impl IntoIterator<Item = [Vec3; 2]>) -> Vec<[Vec3; 2]> {
    let mut boxes: Vec<_> = boxes.into_iter().collect();
    sort(&mut boxes);
    boxes
}

/// The world boxes of entities.
fn world_boxes(app: &App, entities: &[Entity]) -> Vec<[Vec3; 2]> {
    let aabb = |&entity: &Entity| index(app).aabb(entity).expect("an indexed entity");
    sorted(entities.iter().map(|entity| corners(&aabb(entity))))
}

#[track_caller]
fn assert_alike(boxes: &[[Vec3; 2]], others: &[[Vec3; 2]]) {
    let are_near = |a: Vec3, b: Vec3| a.abs_diff_eq(b, 1e-3);
    let mut pairs = boxes.iter().zip(others);
    let all_are = pairs.all(|(a, b)| are_near(a[0], b[0]) && are_near(a[1], b[1]));
    assert!(boxes.len() == others.len() && all_are, "{boxes:?}, {others:?}");
}
