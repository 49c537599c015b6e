//! What occludes, and what there is to hide: cars, people and crates besides what the plan of the city has.

use std::f32::consts::{FRAC_PI_2, PI};

use bevy::prelude::*;
use bevy_sightline::prelude::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{
    options::Options,
    plan::{District, PAVEMENT, PITCH, Plan, STREET},
    scenery::{Models, Thing, is_building},
};

pub fn plugin(app: &mut App) {
    app.add_systems(PostStartup, (make_occluders, furnish));
}

/// That is all that it takes.
fn make_occluders(mut commands: Commands, things: Query<(Entity, &Thing)>) {
    for (entity, thing) in &things {
        if is_building(thing.model) {
            commands.entity(entity).insert(Occluder::Auto);
        }
    }
}

/// Parks cars along the kerbs, and puts people on the pavements and crates into the yards.
fn furnish(
    mut commands: Commands,
    options: Res<Options>,
    assets: Res<AssetServer>,
    mut models: ResMut<Models>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let crate_mesh = Mesh3d(meshes.add(Cuboid::from_length(1.1)));
    let wood = MeshMaterial3d(materials.add(StandardMaterial {
        base_color: Color::srgb(0.72, 0.52, 0.30),
        perceptual_roughness: 0.9,
        ..default()
    }));
    let plan = Plan { blocks: options.blocks };
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    for (center, district) in plan.districts() {
        for side in 0..4 {
            let turn = Quat::from_rotation_y(side as f32 * FRAC_PI_2);
            let mut put = |model: &'static str, x: f32, z: f32, height: f32, yaw: f32| {
                let place = center + turn * Vec3::new(x, height, z);
                commands.spawn((
                    Name::new(model),
                    models.mesh(&assets, model),
                    MeshMaterial3d(models.painted.clone()),
                    Transform::from_translation(place).with_rotation(turn * Quat::from_rotation_y(yaw)),
                ));
            };
            let kerb = (PITCH - STREET) / 2.0;
            for place in 0..8 {
                let x = (place as f32 - 3.5) * 7.0 + rng.random_range(-0.4..0.4);
                if rng.random_bool(0.6) {
                    let model = if rng.random_bool(0.3) { "car_van" } else { "car_sedan" };
                    put(model, x, kerb + 1.3, 0.0, FRAC_PI_2);
                }
            }
            for _ in 0..3 {
                let (x, from_kerb) = (rng.random_range(-kerb..kerb), rng.random_range(0.5..PAVEMENT - 1.0));
                put("person", x, kerb - from_kerb, 0.15, rng.random_range(0.0..2.0 * PI));
            }
        }
        if district == District::Park {
            continue;
        }
        for _ in 0..16 {
            let place = Vec3::new(rng.random_range(-24.0..24.0), 0.7, rng.random_range(-2.5..2.5));
            commands.spawn((
                Name::new("crate"),
                crate_mesh.clone(),
                wood.clone(),
                Transform::from_translation(center + place)
                    .with_rotation(Quat::from_rotation_y(rng.random_range(0.0..PI))),
            ));
        }
    }
}
