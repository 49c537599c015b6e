//! What moves in every frame: cars on the streets, people on the pavements.

use std::f32::consts::FRAC_PI_2;

use bevy::prelude::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{
    interaction::Dragged,
    options::Options,
    plan::{PITCH, Plan, STREET},
    scenery::{Models, Thing},
};

/// Goes along its own +z at a steady speed, and enters the city again on the other side.
#[derive(Component)]
pub struct Traveller {
    speed: f32,
}

pub fn plugin(app: &mut App) {
    app.add_systems(PostStartup, spawn_travellers)
        .add_systems(Update, travel);
}

pub fn spawn_travellers(
    mut commands: Commands,
    options: Res<Options>,
    assets: Res<AssetServer>,
    mut models: ResMut<Models>,
) {
    let plan = Plan { blocks: options.blocks };
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut number = 0;
    for street in 0..=options.blocks {
        let across = street as f32 * PITCH - plan.half_size();
        for heading in 0..4 {
            let yaw = heading as f32 * FRAC_PI_2;
            let turn = Quat::from_rotation_y(yaw);
            let mut put = |model: &'static str, from_middle: f32, height: f32, speed: f32| {
                let along = rng.random_range(-1.0..1.0) * plan.half_size();
                // On the right-hand side, as seen along the way.
                let place = turn * Vec3::new(across - from_middle, height, along);
                commands.spawn((
                    Name::new(format!("{model} on the way {number}")),
                    Thing { model, block: None },
                    Traveller { speed },
                    models.mesh(&assets, model),
                    MeshMaterial3d(models.painted.clone()),
                    Transform::from_translation(place).with_rotation(turn),
                ));
                number += 1;
            };
            for car in 0..6 {
                let (model, speed) = if car % 3 == 2 {
                    ("car_van", 9.0)
                } else {
                    ("car_sedan", 12.0)
                };
                put(model, STREET / 4.0, 0.0, speed);
            }
            for _ in 0..5 {
                put("person", STREET / 2.0 + 3.0, 0.15, 1.4);
            }
        }
    }
}

fn travel(
    time: Res<Time>,
    options: Res<Options>,
    mut travellers: Query<(&Traveller, &mut Transform), Without<Dragged>>,
) {
    let edge = Plan { blocks: options.blocks }.half_size();
    for (traveller, mut transform) in &mut travellers {
        let forward = transform.rotation * Vec3::Z;
        transform.translation += forward * traveller.speed * time.delta_secs();
        let beyond = transform.translation.dot(forward) - edge;
        if beyond > 0.0 {
            transform.translation -= forward * 2.0 * edge;
        }
    }
}
