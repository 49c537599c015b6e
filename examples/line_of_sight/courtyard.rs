//! The courtyard: what stands around, light and camera.

use bevy::{
    color::palettes::tailwind::{GREEN_800, STONE_200, STONE_300, STONE_400},
    gltf::GltfAssetLabel,
    light::GlobalAmbientLight,
    prelude::*,
};

/// The colour behind everything.
pub const SKY: Srgba = Srgba::rgb(0.13, 0.16, 0.20);
/// From the ground towards the sun.
pub const TO_SUN: Vec3 = Vec3::new(-0.5, 1.0, 0.35);
/// Crates and their lids.
const WOOD: Srgba = Srgba::rgb(0.66, 0.47, 0.28);
const LID: Srgba = Srgba::rgb(0.45, 0.30, 0.17);
/// Half the sides of the courtyard, in metres.
const HALF: Vec2 = Vec2::new(15.0, 10.0);

/// Stands in the way of whoever walks.
#[derive(Component)]
pub struct Solid;

/// What things are made of.
#[derive(Resource)]
pub struct Paints {
    /// White: the colours are in the vertices.
    pub painted: Handle<StandardMaterial>,
}

/// Where a wall, a hedge or a crate stands on the ground, and its size.
type Block = (Vec2, Vec3);

const WALLS: [Block; 10] = [
    (Vec2::new(0.0, -HALF.y), Vec3::new(2.0 * HALF.x + 0.6, 2.6, 0.6)),
    (Vec2::new(0.0, HALF.y + 1.0), Vec3::new(2.0 * HALF.x + 0.6, 1.8, 0.6)),
    (Vec2::new(-HALF.x, 0.5), Vec3::new(0.6, 2.0, 2.0 * HALF.y + 1.0)),
    (Vec2::new(HALF.x, 0.5), Vec3::new(0.6, 2.0, 2.0 * HALF.y + 1.0)),
    (Vec2::new(-8.7, -3.0), Vec3::new(5.0, 2.4, 0.5)),
    (Vec2::new(-11.0, -0.9), Vec3::new(0.5, 2.4, 3.7)),
    (Vec2::new(9.2, 4.2), Vec3::new(5.0, 2.4, 0.5)),
    (Vec2::new(11.5, 2.2), Vec3::new(0.5, 2.4, 3.5)),
    (Vec2::new(4.6, -6.2), Vec3::new(4.4, 2.4, 0.5)),
    (Vec2::new(-5.4, 3.4), Vec3::new(0.5, 2.4, 3.0)),
];

const HEDGES: [Block; 4] = [
    (Vec2::new(-3.2, 7.0), Vec3::new(5.0, 1.3, 0.8)),
    (Vec2::new(4.6, 6.6), Vec3::new(3.6, 1.3, 0.8)),
    (Vec2::new(10.4, -3.0), Vec3::new(4.2, 1.3, 0.8)),
    (Vec2::new(-4.4, -6.6), Vec3::new(3.4, 1.3, 0.8)),
];

const CRATES: [Block; 9] = [
    (Vec2::new(-12.6, 6.6), Vec3::new(1.4, 1.4, 1.4)),
    (Vec2::new(-11.0, 7.3), Vec3::new(1.1, 1.1, 1.1)),
    (Vec2::new(-8.2, 5.8), Vec3::new(1.4, 2.2, 1.4)),
    (Vec2::new(8.4, -0.6), Vec3::new(1.3, 2.0, 1.3)),
    (Vec2::new(7.0, -1.0), Vec3::new(1.1, 1.1, 1.1)),
    (Vec2::new(13.5, 9.4), Vec3::new(1.5, 1.5, 1.5)),
    (Vec2::new(0.6, -7.4), Vec3::new(1.2, 1.2, 1.2)),
    (Vec2::new(-10.2, -5.2), Vec3::new(1.4, 2.0, 1.4)),
    (Vec2::new(12.4, -6.6), Vec3::new(1.5, 2.1, 1.5)),
];

const PILLARS: [Vec2; 8] = [
    Vec2::new(-6.2, -0.6),
    Vec2::new(-3.4, -4.6),
    Vec2::new(0.0, -5.0),
    Vec2::new(3.4, -3.9),
    Vec2::new(5.6, 0.9),
    Vec2::new(3.4, 4.4),
    Vec2::new(0.0, 5.0),
    Vec2::new(-3.4, 4.4),
];

/// Models, where they stand, and how large they are.
const MODELS: [(&str, Vec2, f32); 5] = [
    ("fountain", Vec2::ZERO, 0.55),
    ("tree_oak", Vec2::new(-13.1, -7.2), 0.42),
    ("tree_oak", Vec2::new(13.3, 1.0), 0.42),
    ("tree_pine", Vec2::new(8.8, -7.0), 0.5),
    ("tree_pine", Vec2::new(-14.1, 2.6), 0.45),
];

pub fn plugin(app: &mut App) {
    app.insert_resource(ClearColor(SKY.into()))
        .insert_resource(GlobalAmbientLight {
            brightness: 500.0,
            color: Color::srgb(0.80, 0.88, 1.0),
            ..default()
        })
        .add_systems(PreStartup, paint)
        .add_systems(Startup, (build, place_models, light_and_look));
}

/// A model from a file, which is one mesh.
pub fn model(assets: &AssetServer, name: &str) -> Mesh3d {
    let primitive = GltfAssetLabel::Primitive { mesh: 0, primitive: 0 };
    Mesh3d(assets.load(primitive.from_asset(format!("{name}.glb"))))
}

fn paint(mut commands: Commands, mut materials: ResMut<Assets<StandardMaterial>>) {
    commands.insert_resource(Paints {
        painted: materials.add(StandardMaterial {
            perceptual_roughness: 0.85,
            reflectance: 0.25,
            ..default()
        }),
    });
}

fn build(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut materials: ResMut<Assets<StandardMaterial>>) {
    let mut matte = |color: Srgba| {
        materials.add(StandardMaterial {
            base_color: color.into(),
            perceptual_roughness: 1.0,
            reflectance: 0.1,
            ..default()
        })
    };
    let (ground, tile, stone) = (matte(STONE_400), matte(STONE_300), matte(STONE_200));
    let (leaves, wood, dark_wood) = (matte(GREEN_800), matte(WOOD), matte(LID));

    let size = 2.0 * HALF;
    commands.spawn((
        Name::new("ground"),
        Mesh3d(meshes.add(Cuboid::new(size.x + 2.0, 0.5, size.y + 4.0))),
        MeshMaterial3d(ground),
        Transform::from_xyz(0.0, -0.26, 0.0),
    ));
    let slab = meshes.add(Plane3d::default().mesh().size(1.92, 1.92));
    for (x, z) in (0..15).flat_map(|x| (0..10).map(move |z| (x, z))) {
        commands.spawn((
            Name::new("slab"),
            Mesh3d(slab.clone()),
            MeshMaterial3d(tile.clone()),
            Transform::from_xyz(2.0 * x as f32 - 14.0, 0.0, 2.0 * z as f32 - 9.0),
        ));
    }
    let blocks = (WALLS.map(|block| (block, &stone, "wall")).into_iter())
        .chain(HEDGES.map(|block| (block, &leaves, "hedge")))
        .chain(CRATES.map(|block| (block, &wood, "crate")));
    for ((place, size), material, name) in blocks {
        commands.spawn((
            Name::new(name),
            Solid,
            Mesh3d(meshes.add(Cuboid::from_size(size))),
            MeshMaterial3d(material.clone()),
            Transform::from_xyz(place.x, size.y / 2.0, place.y),
        ));
    }
    // Lids, so that crates look like crates.
    for (place, size) in CRATES {
        commands.spawn((
            Name::new("lid"),
            Mesh3d(meshes.add(Cuboid::new(size.x + 0.08, 0.12, size.z + 0.08))),
            MeshMaterial3d(dark_wood.clone()),
            Transform::from_xyz(place.x, size.y, place.y),
        ));
    }
    let (shaft, plate) = (
        meshes.add(Cylinder::new(0.4, 3.0)),
        meshes.add(Cuboid::new(1.1, 0.3, 1.1)),
    );
    for place in PILLARS {
        commands.spawn((
            Name::new("pillar"),
            Solid,
            Mesh3d(shaft.clone()),
            MeshMaterial3d(stone.clone()),
            Transform::from_xyz(place.x, 1.5, place.y),
        ));
        for y in [0.15, 3.0] {
            commands.spawn((
                Name::new("pillar"),
                Mesh3d(plate.clone()),
                MeshMaterial3d(stone.clone()),
                Transform::from_xyz(place.x, y, place.y),
            ));
        }
    }
}

fn place_models(mut commands: Commands, assets: Res<AssetServer>, paints: Res<Paints>) {
    for (name, place, scale) in MODELS {
        let mut thing = commands.spawn((
            Name::new(name),
            model(&assets, name),
            MeshMaterial3d(paints.painted.clone()),
            Transform::from_xyz(place.x, 0.0, place.y).with_scale(Vec3::splat(scale)),
        ));
        // One walks under trees.
        if name == "fountain" {
            thing.insert(Solid);
        }
    }
}

fn light_and_look(mut commands: Commands) {
    commands.spawn((
        DirectionalLight {
            illuminance: 8_000.0,
            color: Color::srgb(1.0, 0.95, 0.85),
            shadow_maps_enabled: true,
            ..default()
        },
        Transform::IDENTITY.looking_to(-TO_SUN, Vec3::Y),
    ));
    commands.spawn((
        Camera3d::default(),
        Transform::from_xyz(0.0, 24.5, 19.0).looking_at(Vec3::new(0.0, 0.0, 0.3), Vec3::Y),
    ));
}
