//! The boxes, how space is divided, and the way of the ray.

use bevy::{math::bounding::Aabb3d, prelude::*};
use bevy_sightline::spatial::{TraceStep, TracedNode};

use crate::{explorer::Explorer, view::Eye};

/// The colours that tell the order of visits.
const SHADES: usize = 24;

/// More visits than this have no numbers.
const MOST_LABELS: usize = 80;

/// Numbers closer to each other than this are put side by side.
const NEARBY: f32 = 1.5;

/// What lines over boxes in the plane are drawn at.
const ABOVE: f32 = 2.0;

const IDLE: Srgba = Srgba::rgb(0.42, 0.49, 0.58);
const TESTED: Srgba = Srgba::rgb(0.78, 0.83, 0.90);
const ENTERED: Srgba = Srgba::rgb(0.98, 0.70, 0.22);
const NEAREST: Srgba = Srgba::rgb(0.25, 0.86, 0.50);
const CURRENT: Srgba = Srgba::rgb(1.0, 0.95, 0.55);

/// Lines that are to be seen first.
#[derive(Default, Reflect, GizmoConfigGroup)]
struct Bold;

/// A box, by its number.
#[derive(Component)]
struct Thing(u32);

/// The inside of a node that has been visited.
#[derive(Component)]
struct Fill;

/// The number of a visit, and where it is in the world.
#[derive(Component)]
struct Label {
    at: Vec3,
    /// In pixels to the right.
    beside: f32,
}

#[derive(Resource)]
struct Paint {
    cuboid: Handle<Mesh>,
    things: [Handle<StandardMaterial>; 4],
    fills: Vec<Handle<StandardMaterial>>,
}

pub fn plugin(app: &mut App) {
    app.init_gizmo_group::<Bold>()
        .add_systems(Startup, set_up)
        .add_systems(
            Update,
            (spawn_things, paint, fill, (draw_parts, draw_way, draw_ray)).chain(),
        )
        .add_systems(PostUpdate, place_labels.after(TransformSystems::Propagate));
}

fn set_up(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut gizmos: ResMut<GizmoConfigStore>,
) {
    let (config, _) = gizmos.config_mut::<DefaultGizmoConfigGroup>();
    config.line.width = 1.0;
    config.depth_bias = -0.5;
    let (config, _) = gizmos.config_mut::<Bold>();
    config.line.width = 3.0;
    config.depth_bias = -1.0;
    let things = [
        IDLE.with_alpha(0.6),
        TESTED.with_alpha(0.8),
        ENTERED.with_alpha(1.0),
        NEAREST.with_alpha(1.0),
    ];
    let mut material = |color: Color, unlit| {
        materials.add(StandardMaterial {
            base_color: color,
            unlit,
            alpha_mode: AlphaMode::Blend,
            perceptual_roughness: 1.0,
            reflectance: 0.0,
            ..default()
        })
    };
    commands.insert_resource(Paint {
        cuboid: meshes.add(Cuboid::from_length(1.0)),
        things: things.map(|color| material(color.into(), false)),
        fills: (0..SHADES)
            .map(|shade| material(order_color(shade, SHADES).with_alpha(0.16), true))
            .collect(),
    });
}

/// From blue for the first to red for the last.
fn order_color(order: usize, count: usize) -> Color {
    let along = order as f32 / count.max(2).saturating_sub(1) as f32;
    Color::oklch(0.72, 0.16, 265.0 + (390.0 - 265.0) * along.min(1.0))
}

/// The colour of a visit, by its step.
fn step_color(explorer: &Explorer, step: usize) -> Color {
    order_color(step, explorer.trace.steps.len())
}

/// Makes anew what is shown of the boxes, where they are others.
fn spawn_things(
    mut commands: Commands,
    explorer: Res<Explorer>,
    paint: Res<Paint>,
    mut shown: Local<Vec<Aabb3d>>,
    things: Query<Entity, With<Thing>>,
) {
    if *shown == explorer.boxes.boxes {
        return;
    }
    shown.clone_from(&explorer.boxes.boxes);
    things.iter().for_each(|thing| commands.entity(thing).despawn());
    for (number, aabb) in (0..).zip(&explorer.boxes.boxes) {
        commands.spawn((
            Thing(number),
            Mesh3d(paint.cuboid.clone()),
            MeshMaterial3d(paint.things[0].clone()),
            filling(aabb),
        ));
    }
}

/// A unit cube as this box.
fn filling(aabb: &Aabb3d) -> Transform {
    let (min, max) = (Vec3::from(aabb.min), Vec3::from(aabb.max));
    Transform::from_translation((min + max) / 2.0).with_scale(max - min)
}

/// Gives boxes the colours of what has been done with them.
fn paint(
    explorer: Res<Explorer>,
    paint: Res<Paint>,
    mut things: Query<(Ref<Thing>, &mut MeshMaterial3d<StandardMaterial>)>,
) {
    if !explorer.is_changed() && things.iter().all(|(thing, _)| !thing.is_added()) {
        return;
    }
    let mut states = vec![0; explorer.boxes.boxes.len()];
    for (_, node) in explorer.visited() {
        for tested in node.boxes.iter().filter_map(|tested| tested.key) {
            states[tested as usize] = 1;
        }
    }
    for step in explorer.taken() {
        if let TraceStep::Leaf(leaf) = step {
            states[leaf.key as usize] = 2;
        }
    }
    if let Some((nearest, _)) = explorer.nearest() {
        states[nearest as usize] = 3;
    }
    for (thing, mut material) in &mut things {
        if let Some(&state) = states.get(thing.0 as usize) {
            material.set_if_neq(MeshMaterial3d(paint.things[state].clone()));
        }
    }
}

/// Fills what has been visited, and numbers it.
fn fill(
    mut commands: Commands,
    explorer: Res<Explorer>,
    paint: Res<Paint>,
    old: Query<Entity, Or<(With<Fill>, With<Label>)>>,
) {
    if !explorer.is_changed() {
        return;
    }
    old.iter().for_each(|entity| commands.entity(entity).despawn());
    let current = explorer.visited().last().map(|(step, _)| step);
    let count = explorer.trace.nodes().count();
    for (order, (step, node)) in explorer.visited().enumerate() {
        let is_current = current == Some(step);
        // In space, what is filled hides what is behind.
        if !explorer.boxes.three_d || is_current {
            let shade = step * (SHADES - 1) / explorer.trace.steps.len().max(1);
            let mut place = filling(&node.bounds);
            if !explorer.boxes.three_d {
                place.translation.z = -10.0 + 0.1 * order as f32;
                place.scale.z = 0.01;
            }
            let material = MeshMaterial3d(paint.fills[shade].clone());
            commands.spawn((Fill, Mesh3d(paint.cuboid.clone()), material, place));
        }
        if count <= MOST_LABELS {
            // Not over the number of a visit that begins in the same corner.
            let at = corner(node);
            let before = explorer.visited().take(order);
            let beside = before.filter(|(_, other)| corner(other).distance(at) < NEARBY).count();
            let color = if is_current {
                CURRENT.into()
            } else {
                step_color(&explorer, step)
            };
            commands.spawn((
                Label {
                    at,
                    beside: 20.0 * beside as f32,
                },
                Text::new((order + 1).to_string()),
                TextFont::from_font_size(if is_current { 18.0 } else { 14.0 }),
                TextColor(color),
                Node {
                    position_type: PositionType::Absolute,
                    ..default()
                },
                Visibility::Hidden,
            ));
        }
    }
}

/// Where the number of a visit is.
fn corner(node: &TracedNode<u32>) -> Vec3 {
    let (min, max) = (node.bounds.min, node.bounds.max);
    Vec3::new(min.x, max.y, max.z)
}

fn place_labels(
    camera: Single<(&Camera, &GlobalTransform), With<Eye>>,
    mut labels: Query<(&Label, &mut Node, &mut Visibility)>,
) {
    let (camera, eye) = *camera;
    for (label, mut node, mut visibility) in &mut labels {
        let Ok(place) = camera.world_to_viewport(eye, label.at) else {
            continue;
        };
        let (left, top) = (
            px((place.x + 4.0 + label.beside).max(0.0)),
            px((place.y + 1.0).max(0.0)),
        );
        if (node.left, node.top) != (left, top) {
            (node.left, node.top) = (left, top);
        }
        visibility.set_if_neq(Visibility::Inherited);
    }
}

/// The edges of a box; in the plane, of a rectangle over all.
fn outline<G: GizmoConfigGroup>(gizmos: &mut Gizmos<G>, three_d: bool, aabb: &Aabb3d, color: impl Into<Color>) {
    if three_d {
        gizmos.aabb_3d(*aabb, Transform::IDENTITY, color);
    } else {
        let (min, max) = (aabb.min, aabb.max);
        let corners = [(min.x, min.y), (max.x, min.y), (max.x, max.y), (min.x, max.y)];
        gizmos.lineloop(corners.map(|(x, y)| Vec3::new(x, y, ABOVE)), color);
    }
}

fn draw_parts(explorer: Res<Explorer>, mut gizmos: Gizmos) {
    let three_d = explorer.boxes.three_d;
    let color = Color::WHITE.with_alpha(if three_d { 0.07 } else { 0.16 });
    for part in explorer.structure().parts() {
        outline(&mut gizmos, three_d, &part, color);
    }
}

fn draw_way(explorer: Res<Explorer>, mut gizmos: Gizmos, mut bold: Gizmos<Bold>) {
    let three_d = explorer.boxes.three_d;
    let mut current: Option<&TracedNode<u32>> = None;
    for (step, node) in explorer.visited() {
        outline(&mut gizmos, three_d, &node.bounds, step_color(&explorer, step));
        current = Some(node);
    }
    let Some(current) = current else { return };
    outline(&mut bold, three_d, &current.bounds, CURRENT);
    for tested in &current.boxes {
        match tested.at {
            Some(_) => outline(&mut bold, three_d, &tested.aabb, ENTERED),
            None => outline(&mut gizmos, three_d, &tested.aabb, TESTED),
        }
    }
    if let Some(TraceStep::Leaf(leaf)) = explorer.taken().last() {
        outline(&mut bold, three_d, &leaf.aabb, Color::WHITE);
    }
}

fn draw_ray(explorer: Res<Explorer>, eye: Single<&GlobalTransform, With<Eye>>, mut bold: Gizmos<Bold>) {
    let at = |t: f32| {
        let point = Vec3::from(explorer.ray.at(t));
        if explorer.boxes.three_d {
            point
        } else {
            point.with_z(ABOVE)
        }
    };
    let origin = at(0.0);
    let far = 3.0 * explorer.boxes.size().length();
    let reach = explorer.nearest().map_or(far, |(_, reach)| reach);
    bold.line(origin, at(reach), Color::WHITE);
    bold.line(at(reach), at(far), Color::WHITE.with_alpha(0.12));
    let facing = |point| Isometry3d::new(point, eye.rotation());
    bold.circle(facing(origin), 0.7, Color::WHITE);
    if let Some((nearest, _)) = explorer.nearest() {
        let aabb = &explorer.boxes.boxes[nearest as usize];
        outline(&mut bold, explorer.boxes.three_d, aabb, NEAREST);
        bold.circle(facing(at(reach)), 0.35, Color::WHITE);
    }
}
