//! Hovering, selecting and dragging: observers of pointer events, and nothing else that knows of picking.

use bevy::{
    color::palettes::tailwind::{AMBER_400, SKY_500},
    prelude::*,
};

use crate::{
    levels::OtherLevel,
    scenery::{Models, Thing},
};

/// Under the pointer.
#[derive(Component)]
pub struct Hovered;

/// Clicked last, or in the box that was drawn last.
#[derive(Component)]
pub struct Selected;

/// Being dragged along the ground.
#[derive(Component)]
pub struct Dragged {
    /// From the point at which it, or another with it, was grabbed to its origin.
    offset: Vec3,
}

/// How high that point is.
#[derive(Resource, Default)]
struct GripHeight(f32);

/// Whether the mouse draws, so that it does not drag or click.
#[derive(Resource, Default)]
pub struct IsDrawing(pub bool);

#[derive(Resource)]
struct Highlights {
    hovered: Handle<StandardMaterial>,
    selected: Handle<StandardMaterial>,
}

pub fn plugin(app: &mut App) {
    app.init_resource::<IsDrawing>()
        .init_resource::<GripHeight>()
        .add_systems(Startup, mix_highlights)
        .add_systems(Update, highlight)
        .add_observer(hover)
        .add_observer(leave)
        .add_observer(select)
        .add_observer(grab)
        .add_observer(drag)
        .add_observer(drop);
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

fn hover(over: On<Pointer<Over>>, mut commands: Commands, things: Query<(), With<Thing>>) {
    if things.contains(over.entity) {
        commands.entity(over.entity).insert(Hovered);
    }
}

fn leave(out: On<Pointer<Out>>, mut commands: Commands, hovered: Query<(), With<Hovered>>) {
    if hovered.contains(out.entity) {
        commands.entity(out.entity).try_remove::<Hovered>();
    }
}

fn select(
    click: On<Pointer<Click>>,
    mut commands: Commands,
    things: Query<(), With<Thing>>,
    selected: Query<Entity, With<Selected>>,
    is_drawing: Res<IsDrawing>,
) {
    if click.button != PointerButton::Primary || is_drawing.0 || !things.contains(click.entity) {
        return;
    }
    for old in selected.iter().filter(|&old| old != click.entity) {
        commands.entity(old).remove::<Selected>();
    }
    commands.entity(click.entity).insert(Selected);
}

/// Takes hold of all that is selected by one of it.
fn grab(
    start: On<Pointer<DragStart>>,
    mut commands: Commands,
    selected: Query<(Entity, &GlobalTransform), With<Selected>>,
    is_drawing: Res<IsDrawing>,
    mut height: ResMut<GripHeight>,
) {
    let Some(grabbed) = start.hit.position.filter(|_| selected.contains(start.entity)) else {
        return;
    };
    if start.button != PointerButton::Primary || is_drawing.0 {
        return;
    }
    height.0 = grabbed.y;
    for (entity, place) in &selected {
        // What is dragged away belongs to no block.
        commands.entity(entity).remove_parent_in_place().insert(Dragged {
            offset: place.translation() - grabbed,
        });
    }
}

/// Moves what is dragged so that the point at which it was grabbed stays under the pointer, at its height.
fn drag(
    drag: On<Pointer<Drag>>,
    camera: Single<(&Camera, &GlobalTransform)>,
    height: Res<GripHeight>,
    mut dragged: Query<(&Dragged, &mut Transform)>,
) {
    if !dragged.contains(drag.entity) {
        return;
    }
    let (camera, camera_transform) = *camera;
    let plane = InfinitePlane3d::new(Vec3::Y);
    let point = camera
        .viewport_to_world(camera_transform, drag.pointer_location.position)
        .ok()
        .and_then(|ray| ray.plane_intersection_point(Vec3::Y * height.0, plane));
    for (grip, mut transform) in &mut dragged {
        if let Some(point) = point {
            transform.translation = point + grip.offset;
        }
    }
}

fn drop(end: On<Pointer<DragEnd>>, mut commands: Commands, dragged: Query<Entity, With<Dragged>>) {
    if dragged.contains(end.entity) {
        for entity in &dragged {
            commands.entity(entity).remove::<Dragged>();
        }
    }
}

/// Paints what has come under the pointer or was selected, and what is not any more, with all levels that are its
/// children.
fn highlight(
    things: Query<(Has<Hovered>, Has<Selected>, Option<&Children>), With<Thing>>,
    mut looks: Query<&mut MeshMaterial3d<StandardMaterial>, Or<(With<Thing>, With<OtherLevel>)>>,
    changed: Query<Entity, Or<(Added<Hovered>, Added<Selected>)>>,
    mut no_longer_hovered: RemovedComponents<Hovered>,
    mut no_longer_selected: RemovedComponents<Selected>,
    highlights: Res<Highlights>,
    models: Res<Models>,
) {
    let removed = no_longer_hovered.read().chain(no_longer_selected.read());
    for entity in changed.iter().chain(removed) {
        let Ok((is_hovered, is_selected, levels)) = things.get(entity) else {
            continue;
        };
        let paint = match (is_hovered, is_selected) {
            (true, _) => &highlights.hovered,
            (false, true) => &highlights.selected,
            (false, false) => &models.painted,
        };
        for part in levels.into_iter().flatten().chain([&entity]) {
            if let Ok(mut look) = looks.get_mut(*part) {
                look.0 = paint.clone();
            }
        }
    }
}
