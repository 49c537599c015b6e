//! Builds what stands still: models from glTF, ground, light and camera.

use bevy::{
    asset::AssetPath, camera_controller::free_camera::FreeCamera, gltf::GltfAssetLabel, light::GlobalAmbientLight,
    platform::collections::HashMap, prelude::*,
};

use crate::{
    options::Options,
    plan::{District, PITCH, Plan, STREET},
};

/// From the ground towards the sun.
pub const TO_SUN: Vec3 = Vec3::new(0.45, 0.75, 0.35);
/// The colour of the sky and of the haze.
pub const SKY: Srgba = Srgba::rgb(0.66, 0.79, 0.90);

/// The finest level of each model, by name, through Bevy's glTF loader.
#[derive(Resource, Default)]
pub struct Models {
    meshes: HashMap<&'static str, Handle<Mesh>>,
    /// White: the colours are in the vertices.
    pub painted: Handle<StandardMaterial>,
}

impl Models {
    /// The mesh of a model.
    pub fn mesh(&mut self, assets: &AssetServer, name: &'static str) -> Mesh3d {
        let load = || assets.load(file_of(name, 0));
        Mesh3d(self.meshes.entry(name).or_insert_with(load).clone())
    }
}

/// Where the mesh of a model is, at one of its three levels of detail, of which zero is the finest.
pub fn file_of(name: &str, level: usize) -> AssetPath<'static> {
    let mesh = GltfAssetLabel::Primitive {
        mesh: level,
        primitive: 0,
    };
    mesh.from_asset(format!("{name}.glb"))
}

/// Whether a model is a building, which hides what is behind it.
#[allow(dead_code, reason = "not every example asks")]
pub fn is_building(name: &str) -> bool {
    const BUILDINGS: [&str; 12] = [
        "apartment_block",
        "arch_gate",
        "church",
        "corner_shop",
        "office_block",
        "pavilion_dome",
        "row_house",
        "tower_glass",
        "tower_round",
        "tower_stepped",
        "tower_twisted",
        "warehouse",
    ];
    BUILDINGS.contains(&name)
}

/// Something in the city.
#[derive(Component, Clone, Copy)]
#[allow(dead_code, reason = "not every example asks what a thing is")]
pub struct Thing {
    /// The name of its model.
    pub model: &'static str,
    /// The number of its block, if it stays in one.
    pub block: Option<u32>,
}

/// The ground of the block of this number.
#[derive(Component)]
#[allow(dead_code, reason = "not every example asks")]
pub struct Slab(pub u32);

/// Part of the ground: shown under the mouse, and not to be selected.
#[derive(Component)]
pub struct Ground;

pub fn plugin(app: &mut App) {
    app.init_resource::<Models>()
        .insert_resource(ClearColor(SKY.into()))
        .insert_resource(GlobalAmbientLight {
            brightness: 900.0,
            color: Color::srgb(0.86, 0.92, 1.0),
            ..default()
        })
        .add_systems(Startup, (paint, (build, lay_ground, light_and_look)).chain());
}

fn paint(mut models: ResMut<Models>, mut materials: ResMut<Assets<StandardMaterial>>) {
    models.painted = materials.add(StandardMaterial {
        perceptual_roughness: 0.85,
        reflectance: 0.25,
        ..default()
    });
}

fn build(mut commands: Commands, options: Res<Options>, assets: Res<AssetServer>, mut models: ResMut<Models>) {
    let plan = Plan { blocks: options.blocks };
    for (number, placement) in plan.placements().into_iter().enumerate() {
        commands.spawn((
            Name::new(format!("{} {number}", placement.model)),
            Thing {
                model: placement.model,
                block: Some(placement.block),
            },
            models.mesh(&assets, placement.model),
            MeshMaterial3d(models.painted.clone()),
            placement.transform,
        ));
    }
}

fn lay_ground(
    mut commands: Commands,
    options: Res<Options>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let plan = Plan { blocks: options.blocks };
    let mut matte = |color| {
        materials.add(StandardMaterial {
            base_color: color,
            perceptual_roughness: 1.0,
            reflectance: 0.1,
            ..default()
        })
    };
    let (asphalt, pavement, grass, meadow) = (
        matte(Color::srgb(0.30, 0.31, 0.33)),
        matte(Color::srgb(0.66, 0.64, 0.60)),
        matte(Color::srgb(0.42, 0.55, 0.31)),
        matte(Color::srgb(0.52, 0.60, 0.40)),
    );

    let side = 2.0 * plan.half_size() + STREET;
    commands.spawn((
        Name::new("countryside"),
        Ground,
        Mesh3d(meshes.add(Plane3d::default().mesh().size(4.0 * side, 4.0 * side))),
        MeshMaterial3d(meadow),
        Transform::from_xyz(0.0, -0.2, 0.0),
    ));
    commands.spawn((
        Name::new("streets"),
        Ground,
        Mesh3d(meshes.add(Plane3d::default().mesh().size(side, side))),
        MeshMaterial3d(asphalt),
    ));
    let block = meshes.add(Cuboid::new(PITCH - STREET, 0.3, PITCH - STREET));
    for (number, (center, district)) in (0..).zip(plan.districts()) {
        let green = matches!(district, District::Park | District::Houses);
        commands.spawn((
            Name::new(format!("block {number}")),
            Ground,
            Slab(number),
            Mesh3d(block.clone()),
            MeshMaterial3d(if green { grass.clone() } else { pavement.clone() }),
            Transform::from_translation(center),
        ));
    }
}

fn light_and_look(mut commands: Commands, options: Res<Options>) {
    commands.spawn((
        DirectionalLight {
            illuminance: 9_000.0,
            color: Color::srgb(1.0, 0.96, 0.88),
            ..default()
        },
        Transform::IDENTITY.looking_to(-TO_SUN, Vec3::Y),
    ));
    let half = Plan { blocks: options.blocks }.half_size();
    commands.spawn((
        Camera3d::default(),
        Projection::from(PerspectiveProjection {
            far: (6.0 * half).max(2000.0),
            ..default()
        }),
        Transform::from_xyz(0.28 * half, 90.0, 0.62 * half).looking_at(Vec3::new(0.0, 12.0, 0.0), Vec3::Y),
        DistanceFog {
            color: SKY.into(),
            falloff: FogFalloff::from_visibility_color((4.0 * half).max(2000.0), SKY.into()),
            ..default()
        },
        FreeCamera {
            walk_speed: 40.0,
            run_speed: 160.0,
            ..default()
        },
    ));
}
