//! The thief: goes its own way until somebody takes it by the keys.

use bevy::prelude::*;
use bevy_sightline::prelude::*;

use crate::{
    courtyard::{Paints, Solid, model},
    walk::{Walk, yaw_of},
};

/// In metres a second.
const SPEED: f32 = 2.6;
/// Half as wide as what it fits through.
const RADIUS: f32 = 0.4;

/// Who walks around.
#[derive(Component)]
pub struct Person;

impl Person {
    pub const SCALE: f32 = 1.35;
    /// Where a body is looked for: how far to the side, and how high. From the feet to the head, and at both shoulders.
    pub const POINTS: [(f32, f32); 7] = [
        (0.0, 0.15),
        (0.0, 0.75),
        (0.0, 1.25),
        (0.0, 1.7),
        (0.0, 2.2),
        (-0.22, 1.6),
        (0.22, 1.6),
    ];
    /// Of these the one in the middle.
    pub const MIDDLE: usize = 2;
}

/// Would rather not be seen.
#[derive(Component)]
pub struct Thief {
    walk: Walk,
    along: f32,
    /// Whether it goes its own way.
    pub is_free: bool,
}

pub fn plugin(app: &mut App) {
    app.add_systems(Startup, spawn).add_systems(Update, step);
}

fn spawn(
    mut commands: Commands,
    assets: Res<AssetServer>,
    paints: Res<Paints>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let corners = [
        [-9.7, 8.3],
        [-6.6, 8.1],
        [-1.0, 8.0],
        [1.4, 6.4],
        [2.0, 5.4],
        [6.0, 5.3],
        [6.0, 2.6],
        [10.0, 3.2],
        [10.0, 0.8],
        [9.8, -1.6],
        [13.2, -2.0],
        [13.0, -4.4],
        [9.0, -5.2],
        [5.4, -5.1],
        [2.0, -5.2],
        [1.6, -6.4],
        [-1.0, -6.2],
        [-1.6, -7.8],
        [-4.6, -7.9],
        [-7.0, -7.0],
        [-6.8, -5.0],
        [-5.2, -2.8],
        [-6.2, -1.8],
        [-9.8, -1.8],
        [-9.6, 1.0],
        [-7.0, 1.4],
        [-7.0, 4.0],
        [-10.2, 5.0],
        [-9.7, 6.6],
    ];
    let dark = StandardMaterial {
        base_color: Color::srgb(0.45, 0.35, 0.85),
        ..materials.get(&paints.painted).cloned().unwrap_or_default()
    };
    commands.spawn((
        Name::new("thief"),
        Person,
        Thief {
            walk: Walk(corners.map(Vec2::from).into()),
            along: 0.0,
            is_free: true,
        },
        model(&assets, "person"),
        MeshMaterial3d(materials.add(dark)),
        Transform::from_scale(Vec3::splat(Person::SCALE)),
    ));
}

fn step(
    time: Res<Time>,
    keys: Res<ButtonInput<KeyCode>>,
    scene: SceneQuery,
    solid: Query<(), With<Solid>>,
    thief: Single<(&mut Thief, &mut Transform)>,
) {
    let (mut thief, mut transform) = thief.into_inner();
    let held = |either: [KeyCode; 2]| f32::from(u8::from(keys.any_pressed(either)));
    let wanted = Vec2::new(
        held([KeyCode::ArrowRight, KeyCode::KeyD]) - held([KeyCode::ArrowLeft, KeyCode::KeyA]),
        held([KeyCode::ArrowDown, KeyCode::KeyS]) - held([KeyCode::ArrowUp, KeyCode::KeyW]),
    );
    if wanted != Vec2::ZERO {
        thief.is_free = false;
    }
    thief.is_free |= keys.just_pressed(KeyCode::KeyR);

    let before = transform.translation;
    let way = SPEED * time.delta_secs();
    if thief.is_free {
        thief.along += way;
        let (place, _) = thief.walk.at(thief.along);
        // Back from where it was led at no more than twice the speed.
        let step = (place - before.xz()).clamp_length_max(if thief.along > way { 2.0 * way } else { f32::INFINITY });
        transform.translation += Vec3::new(step.x, 0.0, step.y);
    } else {
        let is_solid = |entity| solid.contains(entity);
        for axis in [Vec3::X * wanted.x, Vec3::Z * wanted.y] {
            let Ok(direction) = Dir3::new(axis) else { continue };
            let way = way / wanted.length();
            let settings = SceneQuerySettings::default()
                .with_max_distance(way + 0.05)
                .filter(&is_solid);
            let path = Ray3d::new(transform.translation + Vec3::Y * 0.6, direction);
            let free = scene
                .sweep_sphere(path, RADIUS, &settings)
                .map_or(way, |hit| hit.distance - 0.05);
            transform.translation += direction * free.clamp(0.0, way);
        }
    }
    let moved = (transform.translation - before).xz();
    if moved.length() > 0.1 * way {
        let turned = Quat::from_rotation_y(yaw_of(moved));
        transform.rotation = transform
            .rotation
            .slerp(turned, 1.0 - (-12.0 * time.delta_secs()).exp());
    }
}
