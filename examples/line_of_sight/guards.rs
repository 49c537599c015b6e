//! The guards: their rounds, and what they see.

use std::{
    f32::consts::{PI, TAU},
    time::{Duration, Instant},
};

use bevy::prelude::*;
use bevy_sightline::prelude::*;

use crate::{
    courtyard::{Paints, model},
    thief::{Person, Thief},
    walk::{Walk, yaw_of},
};

/// How far guards see, in metres, and how far to each side, in radians.
pub const RANGE: f32 = 9.5;
pub const HALF_ANGLE: f32 = 0.52;
/// The rays of a fan.
pub const FAN: usize = 97;
/// How many points of the thief the share is measured by.
const SAMPLES: u32 = 64;
/// In metres a second, and radians a second.
const SPEED: f32 = 1.5;
const TURN: f32 = 2.5;

/// Over the ground.
const EYES: f32 = 2.15;
/// The height at which fans show what can be seen.
pub const CHEST: f32 = 1.7;

/// Walks around.
#[derive(Component)]
pub struct Guard {
    pub number: usize,
    walk: Walk,
    /// How far it has come.
    along: f32,
    /// Where it looks, around y from +z.
    pub yaw: f32,
}

/// What a guard sees, as of this frame.
#[derive(Component, Default)]
pub struct Sight {
    pub eye: Vec3,
    pub state: State,
    /// The points of the thief that are seen.
    pub points: Vec<Vec3>,
    /// The share of the thief that can be seen.
    pub share: f32,
    /// Where the line to the thief ends at something else.
    pub blocked_at: Option<Vec3>,
    /// Where the rays of the fan end.
    pub fan: Vec<Vec3>,
}

/// How it is between a guard and the thief.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum State {
    /// The thief is elsewhere.
    #[default]
    Calm,
    /// The thief is where the guard looks, and none of the points can be seen.
    Blocked,
    Sees,
}

/// What it took to look, in this frame.
#[derive(Resource, Default)]
pub struct Effort {
    pub rays: usize,
    pub lines: usize,
    pub took: Duration,
}

pub fn plugin(app: &mut App) {
    app.init_resource::<Effort>()
        .add_systems(Startup, spawn)
        .add_systems(Update, patrol)
        .add_systems(PostUpdate, look.after(SpatialIndexSystems::Optimize));
}

fn spawn(mut commands: Commands, assets: Res<AssetServer>, paints: Res<Paints>) {
    let rounds: [&[[f32; 2]]; 5] = [
        &[[-3.6, -2.8], [3.8, -2.6], [4.2, 3.0], [-4.0, 2.8]],
        &[[-13.0, -3.6], [-13.0, 4.6], [-9.0, 3.6], [-9.2, 0.6], [-12.4, 2.0]],
        &[
            [13.4, -4.8],
            [12.6, -1.0],
            [12.6, 7.6],
            [10.2, 8.4],
            [6.0, 5.4],
            [6.3, 2.6],
            [9.9, 0.6],
            [10.0, -1.4],
            [7.4, -2.6],
            [7.4, -4.8],
        ],
        &[[-10.8, -8.7], [10.8, -8.7], [10.8, -9.2], [-10.8, -9.2]],
        &[[-9.8, 9.0], [8.8, 8.8], [8.8, 8.3], [-6.6, 8.3]],
    ];
    for (number, corners) in rounds.into_iter().enumerate() {
        commands.spawn((
            Name::new(format!("guard {}", number + 1)),
            Person,
            Guard {
                number: number + 1,
                walk: Walk(corners.iter().copied().map(Vec2::from).collect()),
                along: 5.0 * number as f32,
                yaw: 0.0,
            },
            Sight::default(),
            model(&assets, "person"),
            MeshMaterial3d(paints.painted.clone()),
            Transform::from_scale(Vec3::splat(Person::SCALE)),
        ));
    }
}

/// Guards who see the thief stop and look at it; the others walk on, and look left and right as they go.
fn patrol(
    time: Res<Time>,
    thief: Single<&GlobalTransform, With<Thief>>,
    mut guards: Query<(&mut Guard, &Sight, &mut Transform)>,
) {
    for (mut guard, sight, mut transform) in &mut guards {
        let sees = sight.state == State::Sees;
        if !sees {
            guard.along += SPEED * time.delta_secs();
        }
        let (place, ahead) = guard.walk.at(guard.along);
        let to_thief = thief.translation().xz() - place;
        let sweep = 0.55 * (0.9 * guard.along + guard.number as f32).sin();
        let wanted = if sees { yaw_of(to_thief) } else { yaw_of(ahead) + sweep };
        let turn = (wanted - guard.yaw + PI).rem_euclid(TAU) - PI;
        let most = TURN * time.delta_secs();
        guard.yaw += turn.clamp(-most, most);
        transform.translation = Vec3::new(place.x, 0.0, place.y);
        transform.rotation = Quat::from_rotation_y(guard.yaw);
    }
}

/// What everybody sees.
pub fn look(
    scene: SceneQuery,
    mut guards: Query<(Entity, &Guard, &GlobalTransform, &mut Sight)>,
    thief: Single<(Entity, &GlobalTransform), With<Thief>>,
    people: Query<(), With<Person>>,
    mut effort: ResMut<Effort>,
    mut rays: Local<Vec<Ray3d>>,
    mut hits: Local<Vec<Option<RayHit>>>,
) {
    let start = Instant::now();
    let (thief, body) = *thief;
    rays.clear();
    effort.lines = 0;
    for (guard, Guard { yaw, .. }, place, mut sight) in &mut guards {
        let Sight {
            eye,
            state,
            points,
            share,
            blocked_at,
            ..
        } = &mut *sight;
        *eye = place.translation() + Vec3::Y * EYES;
        (*state, *share, *blocked_at) = default();
        points.clear();
        rays.extend(fan_directions(*yaw).map(|direction| Ray3d::new(eye.with_y(CHEST), direction)));

        // The cone.
        let to_thief = body.translation() - place.translation();
        let looks = Vec3::new(yaw.sin(), 0.0, yaw.cos());
        if to_thief.length() > RANGE || to_thief.angle_between(looks) > HALF_ANGLE {
            continue;
        }
        // What is in the way, but the two.
        let both = [guard, thief];
        let between = SceneQuerySettings::default().excluding(&both);
        let aside = to_thief.cross(Vec3::Y).normalize_or_zero();
        let on_body = Person::POINTS.map(|(side, height)| body.translation() + aside * side + Vec3::Y * height);
        points.extend(
            on_body
                .iter()
                .filter(|&&point| scene.line_of_sight(*eye, point, &between)),
        );
        *share = scene
            .visible_fraction_from(*eye, thief, SAMPLES, &between.excluding(&both[..1]))
            .unwrap_or(0.0);
        *blocked_at = scene
            .line_of_sight_blocker(*eye, on_body[Person::MIDDLE], &between)
            .map(|hit| hit.position);
        *state = if points.is_empty() { State::Blocked } else { State::Sees };
        effort.lines += on_body.len() + 1;
    }
    // The fans of all guards at once, through people.
    let is_still = |entity| !people.contains(entity);
    let scenery = SceneQuerySettings::default().with_max_distance(RANGE).filter(&is_still);
    scene.cast_rays(&rays, &scenery, &mut hits);
    for ((.., mut sight), (rays, hits)) in guards.iter_mut().zip(rays.chunks(FAN).zip(hits.chunks(FAN))) {
        sight.fan.clear();
        let ends = rays.iter().zip(hits);
        sight
            .fan
            .extend(ends.map(|(ray, hit)| ray.get_point(hit.map_or(RANGE, |hit| hit.distance))));
    }
    effort.rays = rays.len();
    effort.took = start.elapsed();
}

/// The directions of a fan, from left to right.
fn fan_directions(yaw: f32) -> impl Iterator<Item = Dir3> {
    (0..FAN).map(move |n| {
        let aside = HALF_ANGLE * (1.0 - 2.0 * n as f32 / (FAN - 1) as f32);
        Quat::from_rotation_y(yaw + aside) * Dir3::Z
    })
}
