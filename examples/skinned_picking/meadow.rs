//! The meadow, and the foxes that run on it.

use std::f32::consts::TAU;

use bevy::{
    camera_controller::free_camera::FreeCamera,
    gltf::GltfAssetLabel,
    light::{CascadeShadowConfigBuilder, GlobalAmbientLight},
    mesh::ConeAnchor,
    prelude::*,
    world_serialization::WorldAssetRoot,
};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{options::Options, reference::Reference};

/// From the ground towards the sun.
pub const TO_SUN: Vec3 = Vec3::new(0.5, 0.8, 0.45);
pub const SKY: Srgba = Srgba::rgb(0.70, 0.83, 0.93);

/// How long a model is made, in metres, whatever it was: about a fox.
const LENGTH: f32 = 1.3;
/// Metres a second at which the feet of our own fox do not slide.
const SPEED: f32 = 3.0;

/// Runs in circles around the origin.
#[derive(Component)]
pub struct Runner {
    radius: f32,
    start: f32,
}

/// A model, which is animated once it is there.
#[derive(Component)]
pub struct Model {
    /// Which animation to play: the first whose name contains one of these, else the first of all.
    pub clip: &'static [&'static str],
    /// How far into the animation to begin, in seconds.
    pub ahead: f32,
}

/// Has not been brought to size.
#[derive(Component)]
pub struct Unfitted;

/// The file that all models are from.
#[derive(Resource)]
pub struct ModelFile(pub Handle<Gltf>);

pub fn plugin(app: &mut App) {
    app.insert_resource(ClearColor(SKY.into()))
        .insert_resource(GlobalAmbientLight {
            brightness: 700.0,
            color: Color::srgb(0.88, 0.94, 1.0),
            ..default()
        })
        .add_systems(Startup, (load_model, (spawn_foxes, lay_ground, light_and_look)).chain())
        .add_systems(Update, (run, stop_time, animate, fit));
}

pub fn load_model(mut commands: Commands, options: Res<Options>, assets: Res<AssetServer>) {
    commands.insert_resource(ModelFile(assets.load(options.model.clone())));
}

/// A model below an entity that may be moved.
pub fn model(options: &Options, assets: &AssetServer, clip: &'static [&'static str], ahead: f32) -> impl Bundle {
    let scene = assets.load(GltfAssetLabel::Scene(0).from_asset(options.model.clone()));
    (Model { clip, ahead }, Unfitted, WorldAssetRoot(scene))
}

fn spawn_foxes(mut commands: Commands, options: Res<Options>, assets: Res<AssetServer>) {
    for number in 0..options.foxes {
        let name = Name::new(format!("fox {}", number + 1));
        // One stands in the middle and looks around.
        if number == 0 {
            let watcher = model(&options, &assets, &["look", "survey"], 0.0);
            commands.spawn((
                name,
                Transform::from_rotation(Quat::from_rotation_y(0.5)),
                Visibility::default(),
                children![watcher],
            ));
            continue;
        }
        let circle = ((number - 1) / 2) as f32;
        let runner = Runner {
            radius: 1.4 + 0.95 * circle,
            start: TAU * (0.5 * (number % 2) as f32 + 0.21 * circle + 0.07),
        };
        let runs = model(&options, &assets, &["run", "gallop"], 0.17 * number as f32);
        commands.spawn((
            name,
            runner,
            Transform::default(),
            Visibility::default(),
            children![runs],
        ));
    }
}

fn run(time: Res<Time>, mut runners: Query<(&Runner, &mut Transform)>) {
    for (runner, mut transform) in &mut runners {
        let angle = runner.start + time.elapsed_secs() * SPEED / runner.radius;
        let (sin, cos) = angle.sin_cos();
        transform.translation = runner.radius * Vec3::new(cos, 0.0, sin);
        // Forward, and leaning into the curve.
        transform.rotation = Quat::from_rotation_y(-angle) * Quat::from_rotation_z(0.16 / runner.radius);
    }
}

fn stop_time(keys: Option<Res<ButtonInput<KeyCode>>>, mut time: ResMut<Time<Virtual>>) {
    if keys.is_some_and(|keys| keys.just_pressed(KeyCode::Space)) {
        if time.is_paused() {
            time.unpause();
        } else {
            time.pause();
        }
    }
}

/// Starts the animation of what has been loaded.
pub fn animate(
    mut commands: Commands,
    file: Res<ModelFile>,
    files: Res<Assets<Gltf>>,
    mut graphs: ResMut<Assets<AnimationGraph>>,
    mut players: Query<(Entity, &mut AnimationPlayer), Without<AnimationGraphHandle>>,
    parents: Query<&ChildOf>,
    models: Query<&Model>,
) {
    let Some(gltf) = files.get(&file.0) else {
        return;
    };
    for (entity, mut player) in &mut players {
        let Some(model) = parents
            .iter_ancestors(entity)
            .find_map(|ancestor| models.get(ancestor).ok())
        else {
            continue;
        };
        let is_wanted = |name: &str| model.clip.iter().any(|wanted| name.to_lowercase().contains(wanted));
        let mut named: Vec<_> = gltf.named_animations.iter().collect();
        named.sort_by_key(|(name, _)| *name);
        let clip = named
            .into_iter()
            .find(|(name, _)| is_wanted(name))
            .map(|(_, clip)| clip);
        let Some(clip) = clip.or(gltf.animations.first()) else {
            continue;
        };
        let (graph, node) = AnimationGraph::from_clip(clip.clone());
        player.play(node).repeat().seek_to(model.ahead);
        commands.entity(entity).insert(AnimationGraphHandle(graphs.add(graph)));
    }
}

/// Brings what has been loaded to size, and puts it on the ground.
pub fn fit(
    mut commands: Commands,
    mut models: Query<(Entity, &GlobalTransform, &mut Transform), With<Unfitted>>,
    children: Query<&Children>,
    meshes: Query<(), With<Mesh3d>>,
    reference: Reference,
) {
    for (model, place, mut transform) in &mut models {
        let skins = children.iter_descendants(model).filter(|&part| meshes.contains(part));
        let Some(triangles) = skins.map(|part| reference.triangles(part)).collect::<Option<Vec<_>>>() else {
            continue;
        };
        let to_model = place.affine().inverse();
        let corners = triangles
            .iter()
            .flatten()
            .flatten()
            .map(|corner| to_model.transform_point3(corner.as_vec3()));
        let bounds = corners.fold(None, |bounds: Option<(Vec3, Vec3)>, corner| {
            let (min, max) = bounds.unwrap_or((corner, corner));
            Some((min.min(corner), max.max(corner)))
        });
        if let Some((min, max)) = bounds {
            let scale = LENGTH / (max - min).max_element();
            // Our own fox is of that size already.
            if (scale - 1.0).abs() > 0.1 {
                transform.scale = Vec3::splat(scale);
                transform.translation = -scale * Vec3::new((min.x + max.x) / 2.0, min.y, (min.z + max.z) / 2.0);
            }
            commands.entity(model).remove::<Unfitted>();
        }
    }
}

fn lay_ground(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let mut matte = |color| {
        materials.add(StandardMaterial {
            base_color: color,
            perceptual_roughness: 1.0,
            reflectance: 0.1,
            ..default()
        })
    };
    let (grass, blade, painted) = (
        matte(Color::srgb(0.46, 0.60, 0.31)),
        matte(Color::srgb(0.38, 0.54, 0.25)),
        matte(Color::WHITE),
    );
    commands.spawn((
        Name::new("meadow"),
        Mesh3d(meshes.add(Plane3d::default().mesh().size(120.0, 120.0))),
        MeshMaterial3d(grass),
    ));
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut anywhere = |near: f32, far: f32| {
        let (distance, angle) = (rng.random_range(near..far), rng.random_range(0.0..TAU));
        let turned = Quat::from_rotation_y(rng.random_range(0.0..TAU));
        let place = distance * Vec3::new(angle.cos(), 0.0, angle.sin());
        Transform::from_translation(place).with_rotation(turned)
    };
    let blade_mesh = Cone::new(0.008, 0.1).mesh().resolution(3).anchor(ConeAnchor::Base);
    let tuft = (0..7).map(|i| {
        let turned = Quat::from_rotation_y(TAU * i as f32 / 7.0) * Quat::from_rotation_x(0.25 + 0.06 * (i % 3) as f32);
        Mesh::from(blade_mesh).rotated_by(turned)
    });
    let tuft = tuft.reduce(|mut tuft, blade| {
        tuft.merge(&blade).expect("blades alike");
        tuft
    });
    let tuft = meshes.add(tuft.expect("a few blades"));
    for _ in 0..220 {
        commands.spawn((
            Name::new("grass"),
            Mesh3d(tuft.clone()),
            MeshMaterial3d(blade.clone()),
            anywhere(0.4, 9.0),
        ));
    }
    for number in 0..14 {
        let name = ["tree_pine", "tree_oak"][number % 2];
        let primitive = GltfAssetLabel::Primitive { mesh: 1, primitive: 0 };
        commands.spawn((
            Name::new(name),
            Mesh3d(assets.load(primitive.from_asset(format!("{name}.glb")))),
            MeshMaterial3d(painted.clone()),
            anywhere(13.0, 30.0),
        ));
    }
}

fn light_and_look(mut commands: Commands) {
    commands.spawn((
        DirectionalLight {
            illuminance: 9_000.0,
            color: Color::srgb(1.0, 0.96, 0.88),
            shadow_maps_enabled: true,
            ..default()
        },
        CascadeShadowConfigBuilder {
            num_cascades: 1,
            maximum_distance: 16.0,
            ..default()
        }
        .build(),
        Transform::IDENTITY.looking_to(-TO_SUN, Vec3::Y),
    ));
    commands.spawn((
        Camera3d::default(),
        Transform::from_xyz(0.0, 1.35, 4.0).looking_at(Vec3::new(0.0, 0.32, 0.0), Vec3::Y),
        FreeCamera {
            walk_speed: 3.0,
            run_speed: 12.0,
            ..default()
        },
    ));
}
