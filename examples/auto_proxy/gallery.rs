//! The model, and a copy of it for each of its levels.

use std::time::{Duration, Instant};

use bevy::{
    asset::AssetId,
    camera_controller::free_camera::FreeCamera,
    math::bounding::{Aabb3d, BoundingVolume},
    platform::collections::HashMap,
    prelude::*,
    world_serialization::WorldAssetRoot,
};
use bevy_sightline::{mesh::TriangleMesh, prelude::*};

use crate::options::Options;

/// The light of the sky, and where the sun is.
pub const SKY: Srgba = Srgba::rgb(0.55, 0.66, 0.78);
pub const TO_SUN: Vec3 = Vec3::new(0.5, 0.9, 0.8);

pub fn plugin(app: &mut App) {
    app.init_resource::<Gallery>()
        .insert_resource(ClearColor(SKY.into()))
        .add_observer(note_ready)
        .add_systems(Startup, set_up)
        .add_systems(Update, (ask_for_levels, show_levels, swap_copies).chain());
}

/// What is shown.
#[derive(Resource, Default)]
pub struct Gallery {
    /// The levels of each mesh of the model, from the original on.
    levels: HashMap<AssetId<Mesh>, Vec<Level>>,
    /// When the first level was asked for.
    start: Option<Instant>,
    /// How long it took until all were there.
    pub took: Option<Duration>,
    /// What the columns show, from the original on; empty until all is made.
    pub columns: Vec<Column>,
}

struct Level {
    mesh: Handle<Mesh>,
    /// In the units of the mesh.
    error: f32,
}

/// One copy of the model.
#[derive(Clone, Copy, Default)]
pub struct Column {
    pub triangles: usize,
    /// In the world.
    pub error: f32,
    /// Where it stands.
    pub bounds: Option<Aabb3d>,
}

/// A copy of the model, by the number of its level.
#[derive(Component)]
struct Copy(usize);

fn set_up(mut commands: Commands, options: Res<Options>, assets: Res<AssetServer>) {
    let model = assets.load(GltfAssetLabel::Scene(0).from_asset(options.model.clone()));
    commands.spawn((
        Copy(0),
        WorldAssetRoot(model),
        Transform::default(),
        Visibility::default(),
    ));
    let sun = Transform::default().looking_to(-TO_SUN, Vec3::Y);
    commands.spawn((DirectionalLight::default(), sun));
    commands.insert_resource(GlobalAmbientLight {
        brightness: 700.0,
        ..default()
    });
    commands.spawn((Camera3d::default(), FreeCamera::default(), Transform::default()));
}

/// Every mesh of the model is to have levels.
fn ask_for_levels(
    mut commands: Commands,
    mut gallery: ResMut<Gallery>,
    arrived: Query<Entity, (Added<Mesh3d>, Without<AutoProxy>)>,
) {
    if gallery.columns.is_empty() {
        for entity in &arrived {
            gallery.start.get_or_insert_with(Instant::now);
            commands.entity(entity).insert(AutoProxy::default());
        }
    }
}

/// Notes the levels of a mesh, and takes them off its entity, which shows the original.
fn note_ready(
    ready: On<ProxyReady>,
    mut commands: Commands,
    mut gallery: ResMut<Gallery>,
    groups: Query<(&Mesh3d, Option<&ProxyLod>)>,
) {
    let Ok((mesh, group)) = groups.get(ready.entity) else {
        return;
    };
    let levels = group.map_or(&[][..], |group| &group.levels);
    let of_group = levels.iter().filter_map(|level| match &level.content {
        LodContent::Mesh(mesh) => Some(Level {
            mesh: mesh.clone(),
            error: level.threshold,
        }),
        _ => None,
    });
    let mut of_mesh: Vec<Level> = of_group.collect();
    if of_mesh.is_empty() {
        of_mesh.push(Level {
            mesh: mesh.0.clone(),
            error: 0.0,
        });
    }
    gallery.levels.insert(of_mesh[0].mesh.id(), of_mesh);
    commands.entity(ready.entity).remove::<ProxyLod>();
}

/// Once all are there, puts up a copy for each level, and steps back until all are in sight.
fn show_levels(
    mut commands: Commands,
    mut gallery: ResMut<Gallery>,
    progress: Res<ProxyProgress>,
    model: Query<&WorldAssetRoot>,
    parts: Query<(Entity, &Mesh3d, &GlobalTransform), With<AutoProxy>>,
    meshes: Res<Assets<Mesh>>,
    mut camera: Single<(&mut Transform, &Projection), With<FreeCamera>>,
) {
    let is_made = progress.total > 0 && progress.is_done() && gallery.columns.is_empty();
    let (true, Some(model)) = (is_made, model.iter().next()) else {
        return;
    };
    let count = gallery.levels.values().map(Vec::len).max().unwrap_or(1);
    let mut columns = vec![Column::default(); count];
    let mut bounds: Option<Aabb3d> = None;
    for (entity, mesh, place) in &parts {
        commands.entity(entity).remove::<AutoProxy>();
        let scale = place
            .affine()
            .matrix3
            .to_cols_array_2d()
            .map(|axis| Vec3::from(axis).length());
        let scale = scale.into_iter().fold(0.0, f32::max);
        for (number, column) in columns.iter_mut().enumerate() {
            let (shown, error) = gallery.level(mesh.id(), number).unwrap_or((mesh.0.clone(), 0.0));
            let triangles = meshes.get(&shown).and_then(|shown| TriangleMesh::from_mesh(shown).ok());
            column.triangles += triangles.as_ref().map_or(0, TriangleMesh::len);
            column.error = column.error.max(error * scale);
            if let (0, Some(triangles)) = (number, triangles) {
                let corners = triangles
                    .corners_of_all()
                    .flatten()
                    .map(|corner| place.transform_point(corner));
                let of_part = Aabb3d::from_point_cloud(Isometry3d::IDENTITY, corners);
                bounds = Some(bounds.map_or(of_part, |bounds| bounds.merge(&of_part)));
            }
        }
    }
    let Some(bounds) = bounds else {
        return;
    };
    let size = Vec3::from(bounds.max - bounds.min);
    let step = 1.35 * size.x.max(0.4 * size.y);
    for (number, column) in columns.iter_mut().enumerate() {
        let offset = Vec3::X * step * number as f32;
        column.bounds = Some(bounds.translated_by(offset));
        if number > 0 {
            let place = Transform::from_translation(offset);
            commands.spawn((Copy(number), model.clone(), place, Visibility::default()));
        }
    }
    let width = step * count as f32;
    let middle = Vec3::from(bounds.center()) + Vec3::X * (width - step) / 2.0;
    let Projection::Perspective(lens) = camera.1 else {
        return;
    };
    let half = (lens.fov / 2.0).tan();
    let distance = (width / (2.0 * half * lens.aspect_ratio)).max(size.y / (1.3 * half)) + size.z / 2.0;
    let eye = middle + Vec3::new(0.0, 0.25, 1.0).normalize() * distance;
    *camera.0 = Transform::from_translation(eye).looking_at(middle - Vec3::Y * 0.08 * size.y, Vec3::Y);
    gallery.took = gallery.start.map(|start| start.elapsed());
    gallery.columns = columns;
}

impl Gallery {
    /// A level of a mesh with its error; the last if it has not so many.
    fn level(&self, mesh: AssetId<Mesh>, number: usize) -> Option<(Handle<Mesh>, f32)> {
        let levels = self.levels.get(&mesh)?;
        let level = levels.get(number).or(levels.last())?;
        Some((level.mesh.clone(), level.error))
    }
}

/// Gives the copies the meshes of their levels.
fn swap_copies(
    gallery: Res<Gallery>,
    mut arrived: Query<(Entity, &mut Mesh3d), Added<Mesh3d>>,
    parents: Query<&ChildOf>,
    copies: Query<&Copy>,
) {
    for (entity, mut mesh) in &mut arrived {
        let number = parents
            .iter_ancestors(entity)
            .find_map(|ancestor| copies.get(ancestor).ok());
        if let Some(&Copy(number @ 1..)) = number
            && let Some((level, _)) = gallery.level(mesh.id(), number)
        {
            mesh.0 = level;
        }
    }
}

/// How many pixels an error is in a column, seen from somewhere.
pub fn pixels(column: &Column, camera: &Camera, eye: &GlobalTransform) -> f32 {
    let distance = column.bounds.map_or(0.0, |bounds| {
        Vec3::from(bounds.closest_point(eye.translation())).distance(eye.translation())
    });
    column.error * pixels_at_one(camera) / distance
}

/// How many pixels something of length one is at a distance of one.
pub fn pixels_at_one(camera: &Camera) -> f32 {
    let height = camera.physical_viewport_size().map_or(0, |size| size.y);
    camera.clip_from_view().y_axis.y * height as f32 / 2.0
}
