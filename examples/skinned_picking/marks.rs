//! What is under the mouse, and the pins that clicks put on triangles.

use bevy::{
    color::palettes::tailwind::{AMBER_300, FUCHSIA_500, LIME_400, ROSE_500, SKY_500, YELLOW_300},
    picking::pointer::PointerInteraction,
    prelude::*,
};
use bevy_sightline::prelude::*;

use crate::{meadow::Model, panel::panel};

const COLORS: [Srgba; 5] = [SKY_500, FUCHSIA_500, LIME_400, AMBER_300, ROSE_500];
/// The height of a pin over the skin, in metres.
const HEIGHT: f32 = 0.16;

/// A point on a triangle of an entity, wherever that goes.
#[derive(Component, Clone, Copy)]
pub struct Mark {
    pub entity: Entity,
    pub triangle: u32,
    pub barycentrics: Vec3,
    pub color: Srgba,
}

impl Mark {
    /// Where it is on the triangle with these corners, and the unit normal there.
    pub fn place(&self, [a, b, c]: [Vec3; 3]) -> (Vec3, Vec3) {
        let weights = self.barycentrics;
        let normal = (b - a).cross(c - a).normalize_or(Vec3::Y);
        (a * weights.x + b * weights.y + c * weights.z, normal)
    }
}

#[derive(Resource)]
struct PinHead(Handle<Mesh>);

pub fn plugin(app: &mut App) {
    app.add_systems(Startup, make_pin_head).add_observer(put_mark);
}

/// What only a window can show.
pub fn window_plugin(app: &mut App) {
    app.add_systems(Startup, spawn_text)
        .add_systems(Update, tell_what_is_under_the_mouse)
        // Later than all that moves, so that they do not lag behind.
        .add_systems(
            PostUpdate,
            (move_marks, outline_hovered).after(SpatialIndexSystems::Sync),
        );
}

fn make_pin_head(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>) {
    commands.insert_resource(PinHead(meshes.add(Sphere::new(0.022))));
}

fn put_mark(
    click: On<Pointer<Click>>,
    mut commands: Commands,
    foxes: Foxes,
    marks: Query<&Mark>,
    pin_head: Res<PinHead>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let Some(hit) = click
        .hit
        .extra_as::<RayHit>()
        .filter(|hit| foxes.name(hit.entity).is_some())
    else {
        return;
    };
    // The event goes on to the parents of what was clicked.
    let is_meant = click.entity == hit.entity && click.button == PointerButton::Primary;
    let Some(triangle) = hit.triangle.filter(|_| is_meant) else {
        return;
    };
    let color = COLORS[marks.iter().len() % COLORS.len()];
    commands.spawn((
        Mark {
            entity: hit.entity,
            triangle: triangle.index,
            barycentrics: triangle.barycentrics,
            color,
        },
        Mesh3d(pin_head.0.clone()),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: color.into(),
            emissive: LinearRgba::from(color) * 0.3,
            ..default()
        })),
        Transform::from_translation(hit.position),
        NoSpatialIndex,
        Pickable::IGNORE,
    ));
}

fn move_marks(scene: SceneQuery, mut marks: Query<(&Mark, &mut GlobalTransform)>, mut gizmos: Gizmos) {
    for (mark, mut transform) in &mut marks {
        let Some(corners) = scene.triangle(mark.entity, mark.triangle) else {
            continue;
        };
        let (place, normal) = mark.place(corners);
        // Transforms have been propagated already.
        *transform = GlobalTransform::from_translation(place + normal * HEIGHT);
        gizmos.line(place, place + normal * HEIGHT, mark.color);
        gizmos.lineloop(corners.map(|corner| corner + normal * 0.002), mark.color);
    }
}

/// Draws the bounds of the fox under the mouse, and the triangle that the mouse is on.
fn outline_hovered(pointers: Query<&PointerInteraction>, scene: SceneQuery, foxes: Foxes, mut gizmos: Gizmos) {
    for hit in hovered(&pointers).filter(|hit| foxes.name(hit.entity).is_some()) {
        if let Some(bounds) = scene.index().aabb(hit.entity) {
            gizmos.aabb_3d(bounds, Transform::IDENTITY, Color::WHITE);
        }
        let triangle = hit
            .triangle
            .and_then(|triangle| scene.triangle(hit.entity, triangle.index));
        if let Some(corners) = triangle {
            let lift = hit.normal * 0.003;
            gizmos.lineloop(corners.map(|corner| corner + lift), YELLOW_300);
        }
    }
}

fn hovered(pointers: &Query<&PointerInteraction>) -> impl Iterator<Item = RayHit> {
    let nearest = pointers.iter().filter_map(|pointer| pointer.get_nearest_hit());
    nearest.filter_map(|(_, data)| data.extra_as::<RayHit>().copied())
}

#[derive(Component)]
struct HitText;

fn spawn_text(mut commands: Commands) {
    commands.spawn(panel(HitText, ""));
}

fn tell_what_is_under_the_mouse(
    pointers: Query<&PointerInteraction>,
    foxes: Foxes,
    marks: Query<&Mark>,
    mut text: Single<&mut Text, With<HitText>>,
) {
    let tell = |entity, triangle: u32| {
        let name = foxes.name(entity).unwrap_or("something");
        format!("{name}, triangle {triangle}")
    };
    let mut lines = vec![match hovered(&pointers).find(|hit| foxes.name(hit.entity).is_some()) {
        Some(hit) => {
            let triangle = hit.triangle.map_or(0, |triangle| triangle.index);
            let uv = hit
                .uv
                .map_or(String::new(), |uv| format!(", uv ({:.3}, {:.3})", uv.x, uv.y));
            format!("under the mouse: {}{uv}", tell(hit.entity, triangle))
        }
        None => "click on a fox; Space stops the time".into(),
    }];
    lines.extend(
        marks
            .iter()
            .map(|mark| format!("pin: {}", tell(mark.entity, mark.triangle))),
    );
    text.0 = lines.join("\n");
}

/// Tells foxes from the rest.
#[derive(bevy::ecs::system::SystemParam)]
pub struct Foxes<'w, 's> {
    parents: Query<'w, 's, &'static ChildOf>,
    models: Query<'w, 's, &'static ChildOf, With<Model>>,
    names: Query<'w, 's, &'static Name>,
}

impl Foxes<'_, '_> {
    /// The name of the fox that an entity is a part of, if any.
    pub fn name(&self, part: Entity) -> Option<&str> {
        let fox = self
            .parents
            .iter_ancestors(part)
            .find_map(|ancestor| self.models.get(ancestor).ok())?;
        Some(self.names.get(fox.parent()).map_or("a fox", |name| name.as_str()))
    }
}
