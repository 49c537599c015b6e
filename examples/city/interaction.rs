//! Hovering, selecting and dragging: observers of pointer events, and nothing else that knows of picking.

use std::time::Instant;

use bevy::{
    color::palettes::tailwind::{AMBER_400, SKY_500, YELLOW_300},
    picking::{
        backend::ray::RayMap,
        pointer::{PointerId, PointerInteraction},
    },
    prelude::*,
};
use bevy_sightline::prelude::*;

use crate::{
    panel::panel,
    scenery::{Ground, Models},
};

/// Under the pointer.
#[derive(Component)]
pub struct Hovered;

/// Clicked last.
#[derive(Component)]
pub struct Selected;

/// Being dragged along the ground.
#[derive(Component)]
pub struct Dragged {
    /// The height at which it was grabbed.
    height: f32,
    /// From the point at which it was grabbed to its origin.
    offset: Vec3,
}

#[derive(Resource)]
struct Highlights {
    hovered: Handle<StandardMaterial>,
    selected: Handle<StandardMaterial>,
}

pub fn plugin(app: &mut App) {
    app.add_systems(Startup, mix_highlights)
        .add_systems(Update, highlight)
        .add_observer(hover)
        .add_observer(leave)
        .add_observer(select)
        .add_observer(grab)
        .add_observer(drag)
        .add_observer(drop);
}

/// What only a window can show.
pub fn window_plugin(app: &mut App) {
    app.add_systems(Startup, spawn_text)
        .add_systems(Update, tell_what_is_under_the_mouse)
        // Later than all that moves, so that the boxes do not lag behind.
        .add_systems(PostUpdate, (draw_hit, draw_selection).after(SpatialIndexSystems::Sync));
}

fn mix_highlights(mut commands: Commands, mut materials: ResMut<Assets<StandardMaterial>>) {
    let mut glowing = |color: Srgba| {
        materials.add(StandardMaterial {
            base_color: color.into(),
            emissive: LinearRgba::from(color) * 0.35,
            perceptual_roughness: 0.85,
            ..default()
        })
    };
    commands.insert_resource(Highlights {
        hovered: glowing(AMBER_400),
        selected: glowing(SKY_500),
    });
}

fn hover(over: On<Pointer<Over>>, mut commands: Commands, things: Query<(), (With<Mesh3d>, Without<Ground>)>) {
    if things.contains(over.entity) {
        commands.entity(over.entity).insert(Hovered);
    }
}

fn leave(out: On<Pointer<Out>>, mut commands: Commands) {
    commands.entity(out.entity).try_remove::<Hovered>();
}

fn select(
    click: On<Pointer<Click>>,
    mut commands: Commands,
    things: Query<(), (With<Mesh3d>, Without<Ground>)>,
    selected: Query<Entity, With<Selected>>,
) {
    if click.button != PointerButton::Primary || !things.contains(click.entity) {
        return;
    }
    for old in &selected {
        commands.entity(old).remove::<Selected>();
    }
    commands.entity(click.entity).insert(Selected);
}

fn grab(start: On<Pointer<DragStart>>, mut commands: Commands, selected: Query<&Transform, With<Selected>>) {
    let (Ok(transform), Some(grabbed)) = (selected.get(start.entity), start.hit.position) else {
        return;
    };
    if start.button == PointerButton::Primary {
        commands.entity(start.entity).insert(Dragged {
            height: grabbed.y,
            offset: transform.translation - grabbed,
        });
    }
}

/// Moves what is dragged so that the point at which it was grabbed stays under the pointer, at its height.
fn drag(
    drag: On<Pointer<Drag>>,
    camera: Single<(&Camera, &GlobalTransform)>,
    mut dragged: Query<(&Dragged, &mut Transform)>,
) {
    let (camera, camera_transform) = *camera;
    let Ok((grip, mut transform)) = dragged.get_mut(drag.entity) else {
        return;
    };
    let plane = InfinitePlane3d::new(Vec3::Y);
    let point = camera
        .viewport_to_world(camera_transform, drag.pointer_location.position)
        .ok()
        .and_then(|ray| ray.plane_intersection_point(Vec3::Y * grip.height, plane));
    if let Some(point) = point {
        transform.translation = point + grip.offset;
    }
}

fn drop(end: On<Pointer<DragEnd>>, mut commands: Commands) {
    commands.entity(end.entity).try_remove::<Dragged>();
}

fn highlight(
    mut things: Query<(&mut MeshMaterial3d<StandardMaterial>, Has<Hovered>, Has<Selected>), Without<Ground>>,
    changed: Query<Entity, Or<(Added<Hovered>, Added<Selected>)>>,
    mut no_longer_hovered: RemovedComponents<Hovered>,
    mut no_longer_selected: RemovedComponents<Selected>,
    highlights: Res<Highlights>,
    models: Res<Models>,
) {
    let removed = no_longer_hovered.read().chain(no_longer_selected.read());
    for entity in changed.iter().chain(removed) {
        if let Ok((mut material, is_hovered, is_selected)) = things.get_mut(entity) {
            material.0 = match (is_hovered, is_selected) {
                (true, _) => highlights.hovered.clone(),
                (false, true) => highlights.selected.clone(),
                (false, false) => models.painted.clone(),
            };
        }
    }
}

#[derive(Component)]
struct HitText;

fn spawn_text(mut commands: Commands) {
    commands.spawn(panel(HitText, "Move the mouse over the city."));
}

/// Asks again what the picking backend has found, to measure how long that takes.
fn tell_what_is_under_the_mouse(
    rays: Res<RayMap>,
    scene: SceneQuery,
    names: Query<NameOrEntity>,
    selected: Query<NameOrEntity, With<Selected>>,
    mut text: Single<&mut Text, With<HitText>>,
) {
    let Some((_, ray)) = rays.iter().find(|(id, _)| id.pointer == PointerId::Mouse) else {
        return;
    };
    let settings = SceneQuerySettings::default();
    let start = Instant::now();
    let hit = scene.cast_ray(*ray, &settings);
    let micros = start.elapsed().as_secs_f64() * 1e6;

    let found = hit.map_or_else(
        || "nothing".into(),
        |hit| {
            let name = names
                .get(hit.entity)
                .map_or_else(|_| hit.entity.to_string(), |name| name.to_string());
            let triangle = hit.triangle.map_or(0, |triangle| triangle.index);
            format!("{name}, {:.1} m away, triangle {triangle}", hit.distance)
        },
    );
    let held = selected.iter().next().map_or(String::new(), |name| {
        format!("\nselected: {name}; drag it along the ground")
    });
    text.0 = format!(
        "under the mouse: {found}\nfound in {micros:.1} microseconds among {} things{held}",
        scene.index().len()
    );
}

/// Draws the bounds of what is under the pointer, the triangle that was hit, and the normal there.
fn draw_hit(
    pointers: Query<&PointerInteraction>,
    index: Res<SpatialIndex>,
    ground: Query<(), With<Ground>>,
    mut gizmos: Gizmos,
) {
    let nearest = pointers.iter().filter_map(|pointer| pointer.get_nearest_hit());
    for hit in nearest.filter_map(|(_, data)| data.extra_as::<RayHit>()) {
        if let Some(bounds) = index.aabb(hit.entity).filter(|_| !ground.contains(hit.entity)) {
            gizmos.aabb_3d(bounds, Transform::IDENTITY, Color::WHITE);
        }
        if let Some(triangle) = hit.triangle {
            // A little in front of the surface, so as not to flicker.
            let lift = hit.normal * 0.002 * hit.distance;
            gizmos.lineloop(triangle.vertices.map(|vertex| vertex + lift), YELLOW_300);
        }
        gizmos.arrow(
            hit.position,
            hit.position + hit.normal * 0.08 * hit.distance,
            YELLOW_300,
        );
    }
}

fn draw_selection(selected: Query<Entity, With<Selected>>, index: Res<SpatialIndex>, mut gizmos: Gizmos) {
    for bounds in selected.iter().filter_map(|entity| index.aabb(entity)) {
        gizmos.aabb_3d(bounds, Transform::IDENTITY, SKY_500);
    }
}
