//! What happens to the bounds of things.

use bevy::{
    camera::primitives::{Aabb, Sphere},
    math::Vec3A,
    prelude::{Assets, Mesh, Mesh2d, Mesh3d},
};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use super::{
    cast::{Cast, Change, Meshes, Way},
    things::any_thing,
};
use crate::common::random_point;

pub const WAYS: &[Way] = &[
    (4, have_a_box),
    (3, change_its_box),
    (3, lose_its_box),
    (3, have_a_sphere),
    (2, change_its_sphere),
    (2, lose_its_sphere),
    (4, have_a_mesh),
    (2, lose_its_mesh),
    (1, have_a_flat_mesh),
    (1, see_a_mesh_edited),
];

/// A box and a sphere, at times with numbers that make no sense.
pub fn random_bounds(rng: &mut ChaCha8Rng) -> (Aabb, Sphere) {
    let mut center = Vec3A::from(random_point(rng, 3.0));
    let mut half_extents = Vec3A::from(random_point(rng, 2.0)).abs();
    let mut radius = rng.random_range(0.0..5.0);
    match rng.random_range(0..20) {
        0 => center.x = f32::NAN,
        1 => half_extents.y = f32::INFINITY,
        2 => (half_extents, radius) = (-half_extents, -radius),
        3 => (half_extents, radius) = (Vec3A::ZERO, 0.0),
        4 => radius = f32::NAN,
        5 => (half_extents.z, radius) = (3e38, 3e38),
        _ => (),
    }
    let sphere = Sphere {
        center: 10.0 * center,
        radius,
    };
    (Aabb { center, half_extents }, sphere)
}

fn have_a_box(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let (aabb, _) = random_bounds(rng);
    Some(Change::insert(any_thing(rng, cast)?, &format!("has {aabb:?}"), aabb))
}

fn change_its_box(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let (aabb, _) = random_bounds(rng);
    let edit = move |its: &mut Aabb| *its = aabb;
    Some(Change::edit(
        any_thing(rng, cast)?,
        &format!("has {aabb:?} in place"),
        edit,
    ))
}

fn lose_its_box(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    any_thing(rng, cast).map(Change::remove::<Aabb>)
}

fn have_a_sphere(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let (_, sphere) = random_bounds(rng);
    Some(Change::insert(
        any_thing(rng, cast)?,
        &format!("has {sphere:?}"),
        sphere,
    ))
}

fn change_its_sphere(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let (_, sphere) = random_bounds(rng);
    let edit = move |its: &mut Sphere| *its = sphere;
    Some(Change::edit(
        any_thing(rng, cast)?,
        &format!("has {sphere:?} in place"),
        edit,
    ))
}

fn lose_its_sphere(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    any_thing(rng, cast).map(Change::remove::<Sphere>)
}

fn have_a_mesh(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let (thing, mesh) = (any_thing(rng, cast)?, rng.random_range(0..16));
    Some(Change::new(format!("{thing} has the mesh {mesh}"), move |world| {
        let meshes = &world.resource::<Meshes>().0;
        let mesh = meshes[mesh % meshes.len()].clone();
        if let Ok(mut thing) = world.get_entity_mut(thing) {
            thing.insert(Mesh3d(mesh));
        }
    }))
}

fn lose_its_mesh(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    any_thing(rng, cast).map(Change::remove::<Mesh3d>)
}

fn have_a_flat_mesh(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let thing = any_thing(rng, cast)?;
    Some(Change::new(format!("{thing} has a Mesh2d"), move |world| {
        let mesh = world.resource::<Meshes>().0[0].clone();
        if let Ok(mut thing) = world.get_entity_mut(thing) {
            thing.insert(Mesh2d(mesh));
        }
    }))
}

/// The asset changes, and with it the boxes of all that show it.
fn see_a_mesh_edited(rng: &mut ChaCha8Rng, _: &Cast) -> Option<Change> {
    let (mesh, factor) = (rng.random_range(0..16), rng.random_range(0.5..1.5));
    Some(Change::new(
        format!("the mesh {mesh} is scaled by {factor}"),
        move |world| {
            let meshes = &world.resource::<Meshes>().0;
            // The last one has bounds for its joints.
            let mesh = meshes[mesh % (meshes.len() - 1)].clone();
            let mut assets = world.resource_mut::<Assets<Mesh>>();
            if let Some(mut mesh) = assets.get_mut(&mesh) {
                mesh.scale_by(bevy::math::Vec3::splat(factor));
            }
        },
    ))
}
