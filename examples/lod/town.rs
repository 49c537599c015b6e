//! Builds the city: houses with levels of their own, in blocks with a proxy each, and trees and lamps with meshes that are
//! swapped.

use bevy::{
    asset::AssetId,
    camera::primitives::{Aabb, MeshAabb},
    light::GlobalAmbientLight,
    platform::collections::HashMap,
    prelude::*,
};
use bevy_sightline::prelude::*;

use crate::{
    house::{ERRORS, PROXY_ERROR, STYLES},
    options::Options,
    paint::{Paints, Palette},
    plan::{Block, KERB, PITCH, Plan, STREET},
    solid::Solid,
    street,
};

/// From the ground towards the sun.
pub const TO_SUN: Vec3 = Vec3::new(0.45, 0.75, 0.55);
/// The colour of the sky and of the haze.
pub const SKY: Srgba = Srgba::rgb(0.66, 0.79, 0.90);

/// Houses and blocks may deviate from their finest level by so many pixels.
const METRIC: LodMetric = LodMetric::PixelError(2.0);

/// The root of a house.
#[derive(Component)]
#[require(Visibility)]
pub struct House;

/// A tree or a lamp.
#[derive(Component)]
pub struct SmallThing;

/// What a house, a tree or a lamp would be without levels.
#[derive(Component, Clone, Copy)]
pub struct Finest {
    pub triangles: usize,
    pub bounds: Aabb,
}

/// What is known of each mesh.
#[derive(Resource, Default)]
pub struct Models {
    palette: Palette,
    triangles: HashMap<AssetId<Mesh>, usize>,
    /// Of trees and lamps.
    levels: HashMap<AssetId<Mesh>, usize>,
}

impl Models {
    pub fn triangles(&self, mesh: &Mesh3d) -> usize {
        self.triangles.get(&mesh.id()).copied().unwrap_or_default()
    }

    fn add(&mut self, solid: Solid, meshes: &mut Assets<Mesh>) -> Handle<Mesh> {
        let triangles = solid.triangles();
        let mesh = meshes.add(solid.into_mesh(&mut self.palette));
        self.triangles.insert(mesh.id(), triangles);
        mesh
    }
}

/// The meshes of something, from finest to coarsest.
struct Levels {
    meshes: Vec<Handle<Mesh>>,
    finest: Finest,
}

impl Levels {
    fn new(solids: impl IntoIterator<Item = Solid>, models: &mut Models, meshes: &mut Assets<Mesh>) -> Self {
        let handles: Vec<_> = solids.into_iter().map(|solid| models.add(solid, meshes)).collect();
        let bounds = meshes.get(&handles[0]).and_then(MeshAabb::compute_aabb);
        let finest = Finest {
            triangles: models.triangles[&handles[0].id()],
            bounds: bounds.unwrap_or_default(),
        };
        Self {
            meshes: handles,
            finest,
        }
    }

    /// For what has its meshes swapped.
    fn swapped(self, thresholds: &[f32], nothing: f32, models: &mut Models) -> (Handle<Mesh>, ProxyLod, Finest) {
        let numbered = self.meshes.iter().enumerate();
        models.levels.extend(numbered.map(|(level, mesh)| (mesh.id(), level)));
        let finest = self.meshes[0].clone();
        let lod = ProxyLod::new(LodMetric::Height, finest.clone()).hit_as(LodHits::Shown);
        let coarser = thresholds.iter().zip(&self.meshes[1..]);
        let lod = coarser.fold(lod, |lod, (&below, mesh)| lod.then(below, mesh.clone()));
        (finest, lod.then_nothing(nothing), self.finest)
    }
}

pub fn plugin(app: &mut App) {
    app.init_resource::<Models>()
        .insert_resource(ClearColor(SKY.into()))
        .insert_resource(GlobalAmbientLight {
            brightness: 900.0,
            color: Color::srgb(0.86, 0.92, 1.0),
            ..default()
        })
        .add_systems(Startup, (build, lay_ground))
        .add_systems(PostUpdate, repaint.after(LodSystems::Choose));
}

fn build(
    mut commands: Commands,
    options: Res<Options>,
    mut paints: ResMut<Paints>,
    mut models: ResMut<Models>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut images: ResMut<Assets<Image>>,
) {
    let (models, meshes) = (&mut *models, &mut *meshes);
    let houses = STYLES.map(|style| Levels::new(style.levels(), models, meshes));
    // Parts of the height of the view.
    let tree = Levels::new(street::tree(), models, meshes).swapped(&[0.16, 0.06], 0.018, models);
    let lamp = Levels::new(street::lamp(), models, meshes).swapped(&[0.12], 0.03, models);

    for (number, block) in (Plan { blocks: options.blocks }).blocks().enumerate() {
        let root = commands
            .spawn((
                Name::new(format!("block {number}")),
                Transform::from_translation(block.center),
                Visibility::default(),
            ))
            .id();
        let mut spawn_small = |name: &str, (mesh, lod, finest): &(Handle<Mesh>, ProxyLod, Finest), place: Transform| {
            commands
                .spawn((
                    Name::new(format!("{name} of block {number}")),
                    SmallThing,
                    Mesh3d(mesh.clone()),
                    paints.of_level(0),
                    place,
                    lod.clone(),
                    *finest,
                    ChildOf(root),
                ))
                .id()
        };
        // Those in the street go by their own size, those in the gardens with the block as well.
        let lamps = block.lamps.iter().map(|&place| (&lamp, place));
        for (model, place) in lamps.chain(block.street_trees.iter().map(|&place| (&tree, place))) {
            spawn_small("street", model, place);
        }
        let mut things: Vec<Entity> = Vec::new();
        for &place in &block.garden_trees {
            things.push(spawn_small("garden", &tree, place));
        }
        for (house, &(style, place)) in block.houses.iter().enumerate() {
            let levels: Vec<Entity> = (houses[style].meshes.iter().enumerate())
                .map(|(level, mesh)| {
                    let look = (Mesh3d(mesh.clone()), paints.of_level(level));
                    commands.spawn((look, Transform::default())).id()
                })
                .collect();
            let lod = ProxyLod::new(METRIC, levels[0])
                .then(ERRORS[1], levels[1])
                .then(ERRORS[2], levels[2])
                .hit_as(LodHits::Shown);
            let name = Name::new(format!("house {house} of block {number}"));
            let mut root_of_house = commands.spawn((name, House, place, lod, houses[style].finest, ChildOf(root)));
            things.push(root_of_house.add_children(&levels).id());
        }
        let proxy = models.add(merge(&block), meshes);
        let proxy = commands
            .spawn((Mesh3d(proxy), paints.of_level(3), Transform::default(), ChildOf(root)))
            .id();
        let lod = ProxyLod::new(METRIC, things).then(PROXY_ERROR, proxy);
        commands.entity(root).insert(lod.hit_as(LodHits::Shown));
    }
    paints.colors_of_things = images.add(std::mem::take(&mut models.palette).into_image());
}

/// All houses of a block in one mesh.
fn merge(block: &Block) -> Solid {
    let mut merged = Solid::default();
    for (style, place) in &block.houses {
        merged.add(&STYLES[*style].proxy(), place);
    }
    merged
}

/// A mesh that is swapped has the material of its entity: this gives it that of the level.
fn repaint(
    mut things: Query<(&Mesh3d, &mut MeshMaterial3d<StandardMaterial>), (With<SmallThing>, Changed<Mesh3d>)>,
    models: Res<Models>,
    paints: Res<Paints>,
) {
    for (mesh, mut material) in &mut things {
        if let Some(&level) = models.levels.get(&mesh.id()) {
            *material = paints.of_level(level);
        }
    }
}

fn lay_ground(
    mut commands: Commands,
    options: Res<Options>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let plan = Plan { blocks: options.blocks };
    let mut matte = |color: Color| {
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: color,
            perceptual_roughness: 1.0,
            reflectance: 0.1,
            ..default()
        }))
    };
    let (meadow, asphalt) = (
        matte(Color::srgb(0.55, 0.62, 0.48)),
        matte(Color::srgb(0.40, 0.41, 0.43)),
    );
    let (pavement, lawn) = (
        matte(Color::srgb(0.68, 0.67, 0.64)),
        matte(Color::srgb(0.58, 0.66, 0.50)),
    );
    let side = 2.0 * plan.half_size() + STREET;
    let mut plane = |side: f32| Mesh3d(meshes.add(Plane3d::default().mesh().size(side, side)));
    commands.spawn((plane(5.0 * side), meadow, Transform::from_xyz(0.0, -0.2, 0.0)));
    commands.spawn((plane(side), asphalt));
    let in_kerbs = PITCH - STREET;
    let block = Mesh3d(meshes.add(Cuboid::new(in_kerbs, 2.0 * KERB, in_kerbs)));
    let garden = Mesh3d(meshes.add(Cuboid::new(in_kerbs - 9.0, 0.06, 34.0)));
    for Block { center, .. } in plan.blocks() {
        let center = Transform::from_translation(center);
        let ground = Transform::from_translation(center.translation.with_y(0.0));
        commands.spawn((block.clone(), pavement.clone(), ground));
        commands.spawn((garden.clone(), lawn.clone(), center));
    }
    commands.spawn((
        DirectionalLight {
            illuminance: 9_000.0,
            color: Color::srgb(1.0, 0.96, 0.88),
            ..default()
        },
        Transform::IDENTITY.looking_to(-TO_SUN, Vec3::Y),
    ));
}
