//! What there is to see in the city: occluders, levels of detail, and a second camera.

use bevy::{
    camera::{Viewport, visibility::RenderLayers},
    camera_controller::free_camera::FreeCamera,
    prelude::*,
    window::PrimaryWindow,
};
use bevy_sightline::prelude::*;

use crate::{
    kinds::MARKS,
    plan::PITCH,
    scenery::{Thing, file_of, is_building},
};

/// The part of the window that the second camera has, in width and height, and its distance from the edges in pixels.
const INSET: f32 = 0.26;
const MARGIN: f32 = 14.0;

/// Stands in a street.
#[derive(Component)]
pub struct Scout;

pub fn plugin(app: &mut App) {
    app.add_systems(PostStartup, (dress, place_cameras))
        .add_systems(Update, lay_out);
}

/// Has all buildings occlude, and gives everything the levels of detail that its model has.
fn dress(mut commands: Commands, things: Query<(Entity, &Thing, &Mesh3d)>, assets: Res<AssetServer>) {
    for (entity, thing, mesh) in &things {
        let level = |level: usize| -> Handle<Mesh> { assets.load(file_of(thing.model, level)) };
        let levels = ProxyLod::new(LodMetric::Height, mesh.0.clone())
            .then(0.25, level(1))
            .then(0.10, level(2));
        commands.entity(entity).insert(levels);
        if is_building(thing.model) {
            commands.entity(entity).insert(Occluder::Auto);
        }
    }
}

/// The free camera looks over the roofs, the scout along a street.
fn place_cameras(mut commands: Commands, free: Single<(Entity, &mut Transform), With<FreeCamera>>) {
    let (free, mut place) = free.into_inner();
    // It alone shows gizmos and the legend.
    let shows_all = (RenderLayers::from_layers(&[0, MARKS]), IsDefaultUiCamera);
    commands.entity(free).insert(shows_all);
    *place = Transform::from_xyz(-2.6 * PITCH, 95.0, 3.4 * PITCH)
        .looking_at(Vec3::new(-1.4 * PITCH, 0.0, 1.6 * PITCH), Vec3::Y);
    commands.spawn((
        Scout,
        Camera3d::default(),
        Camera { order: 1, ..default() },
        Projection::from(PerspectiveProjection { far: 90.0, ..default() }),
        Transform::from_xyz(-2.0 * PITCH, 9.0, 2.5 * PITCH).looking_to(Vec3::new(0.35, -0.02, -1.0), Vec3::Y),
    ));
}

/// Puts the picture of the scout into the corner of the window.
fn lay_out(window: Single<&Window, With<PrimaryWindow>>, mut scout: Single<&mut Camera, With<Scout>>) {
    let size = window.physical_size();
    let inset = (size.as_vec2() * INSET).as_uvec2();
    let margin = UVec2::splat((MARGIN * window.scale_factor()) as u32);
    let fits = (inset + margin).cmplt(size).all() && inset.cmpgt(UVec2::ZERO).all();
    let corner = fits.then(|| Viewport {
        physical_position: size - inset - margin,
        physical_size: inset,
        ..default()
    });
    let place = |viewport: &Option<Viewport>| viewport.as_ref().map(|v| (v.physical_position, v.physical_size));
    if place(&scout.viewport) != place(&corner) {
        scout.viewport = corner;
    }
}
