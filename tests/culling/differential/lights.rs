//! What happens to lights.

use bevy::{
    camera::{
        ShadowLodOrigin,
        visibility::{
            CascadesVisibleEntities, CubemapVisibleEntities, NoCpuCulling, RenderLayers, VisibilityRange,
            VisibleMeshEntities,
        },
    },
    ecs::entity_disabling::Disabled,
    light::{CascadeShadowConfig, CascadeShadowConfigBuilder},
    prelude::*,
};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use super::{
    cast::{Cast, Change, Meshes, Role, Way},
    things::{self, SIZE, random_layers},
};
use crate::common::{random_point, random_rotation};

/// More of them are not spawned.
const MOST: usize = 7;

pub const WAYS: &[Way] = &[
    (8, move_a_light),
    (6, turn_a_light),
    (5, cast_shadows_or_not),
    (4, change_range),
    (3, change_cascades),
    (3, show_or_hide),
    (2, have_layers),
    (1, lose_layers),
    (1, toggle::<NoCpuCulling>),
    (1, toggle::<Disabled>),
    (1, toggle::<ShadowLodOrigin>),
    (1, have_range_of_visibility),
    (1, have_a_mesh),
    (1, be_a_spot_as_well),
    (1, be_carried),
    (2, have_its_lists_tampered_with),
    (3, spawn),
    (2, despawn),
    (2, be_replaced),
];

fn any_light(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Entity> {
    cast.any(Role::Light, rng)
}

fn toggle<C: Component + Default>(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    any_light(rng, cast).map(|entity| Change::toggle::<C>(entity, rng))
}

fn random_place(rng: &mut ChaCha8Rng) -> Transform {
    Transform::from_translation(random_point(rng, SIZE)).with_rotation(random_rotation(rng))
}

fn random_range(rng: &mut ChaCha8Rng) -> f32 {
    match rng.random_range(0..12) {
        0 => 0.0,
        1 => -3.0,
        2 => f32::NAN,
        3 => f32::INFINITY,
        _ => rng.random_range(1.0..40.0),
    }
}

fn random_cascades(rng: &mut ChaCha8Rng) -> CascadeShadowConfig {
    CascadeShadowConfigBuilder {
        num_cascades: rng.random_range(1..=4),
        first_cascade_far_bound: rng.random_range(1.0..20.0),
        maximum_distance: rng.random_range(30.0..150.0),
        ..default()
    }
    .build()
}

fn move_a_light(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let to = random_point(rng, SIZE);
    let edit = move |place: &mut Transform| place.translation = to;
    Some(Change::edit(any_light(rng, cast)?, &format!("moves to {to}"), edit))
}

fn turn_a_light(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let to = random_rotation(rng);
    let edit = move |place: &mut Transform| place.rotation = to;
    Some(Change::edit(any_light(rng, cast)?, &format!("turns to {to}"), edit))
}

/// Whatever kind it is.
fn edit(
    light: Entity,
    what: &str,
    edit: impl Fn(Option<Mut<DirectionalLight>>, Option<Mut<PointLight>>, Option<Mut<SpotLight>>) + Send + Sync + 'static,
) -> Change {
    Change::new(format!("{light} {what}"), move |world| {
        if let Ok(mut light) = world.get_entity_mut(light)
            && let Ok((sun, lamp, spot)) = light.get_components_mut::<(
                Option<&mut DirectionalLight>,
                Option<&mut PointLight>,
                Option<&mut SpotLight>,
            )>()
        {
            edit(sun, lamp, spot);
        }
    })
}

fn cast_shadows_or_not(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let (light, on) = (any_light(rng, cast)?, rng.random_bool(0.7));
    Some(edit(light, &format!("casts shadows: {on}"), move |sun, lamp, spot| {
        if let Some(mut sun) = sun {
            sun.shadow_maps_enabled = on;
        }
        if let Some(mut lamp) = lamp {
            lamp.shadow_maps_enabled = on;
        }
        if let Some(mut spot) = spot {
            spot.shadow_maps_enabled = on;
        }
    }))
}

fn change_range(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let (light, range, angle) = (any_light(rng, cast)?, random_range(rng), rng.random_range(0.1..1.5));
    let what = format!("has range {range}, angle {angle}");
    Some(edit(light, &what, move |_, lamp, spot| {
        if let Some(mut lamp) = lamp {
            lamp.range = range;
        }
        if let Some(mut spot) = spot {
            (spot.range, spot.outer_angle) = (range, angle);
        }
    }))
}

fn change_cascades(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let cascades = random_cascades(rng);
    let what = format!("has cascades up to {:?}", cascades.bounds);
    let edit = move |its: &mut CascadeShadowConfig| its.clone_from(&cascades);
    Some(Change::edit(any_light(rng, cast)?, &what, edit))
}

fn show_or_hide(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let visibility = [Visibility::Hidden, Visibility::Inherited, Visibility::Visible][rng.random_range(0..3)];
    let light = any_light(rng, cast)?;
    Some(Change::insert(light, &format!("is {visibility:?}"), visibility))
}

fn have_layers(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let (light, layers) = (any_light(rng, cast)?, random_layers(rng));
    Some(Change::insert(light, &format!("has {layers:?}"), layers))
}

fn lose_layers(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    any_light(rng, cast).map(Change::remove::<RenderLayers>)
}

fn have_range_of_visibility(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let range = VisibilityRange::abrupt(0.0, rng.random_range(1.0..60.0));
    Some(Change::insert(
        any_light(rng, cast)?,
        "is visible from near alone",
        range,
    ))
}

fn have_a_mesh(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let light = any_light(rng, cast)?;
    Some(Change::new(format!("{light} has a mesh"), move |world| {
        let mesh = world.resource::<Meshes>().0[0].clone();
        if let Ok(mut light) = world.get_entity_mut(light) {
            light.insert(Mesh3d(mesh));
        }
    }))
}

/// Only what shines from afar: of a lamp that is a spot as well, Bevy writes the bounds twice in no certain order.
fn be_a_spot_as_well(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let light = any_light(rng, cast)?;
    let what = format!("{light} becomes a spot as well, if it is a sun");
    Some(Change::new(what, move |world| {
        if let Ok(mut light) = world.get_entity_mut(light)
            && light.contains::<DirectionalLight>()
        {
            light.insert(SpotLight {
                shadow_maps_enabled: true,
                ..default()
            });
        }
    }))
}

fn be_carried(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let (light, carrier) = (any_light(rng, cast)?, cast.any(Role::Carrier, rng)?);
    Some(Change::insert(
        light,
        &format!("is carried by {carrier}"),
        ChildOf(carrier),
    ))
}

fn have_its_lists_tampered_with(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let (light, thing) = (any_light(rng, cast)?, cast.any(Role::Thing, rng)?);
    let what = format!("{light} lists {thing} everywhere because somebody says so");
    Some(Change::new(what, move |world| {
        if let Some(mut views) = world.get_mut::<CascadesVisibleEntities>(light) {
            let lists = views.entities.values_mut().flatten();
            lists.for_each(|list| list.entities.push(thing));
        }
        if let Some(mut faces) = world.get_mut::<CubemapVisibleEntities>(light) {
            faces.iter_mut().for_each(|list| list.entities.push(thing));
        }
        if let Some(mut list) = world.get_mut::<VisibleMeshEntities>(light) {
            list.entities.push(thing);
        }
    }))
}

pub fn spawn(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    if cast.count(Role::Light) >= MOST {
        return None;
    }
    let (kind, place) = (rng.random_range(0..3), random_place(rng));
    let (range, cascades, shadow_maps_enabled) = (random_range(rng), random_cascades(rng), rng.random_bool(0.8));
    let what = format!(
        "is spawned, a light of kind {kind} at {place:?} with range {range} or cascades {:?}, shadows {shadow_maps_enabled}",
        cascades.bounds
    );
    Some(Change::spawn(Role::Light, what, move |world, light| {
        let mut light = world.entity_mut(light);
        light.insert(place);
        match kind {
            0 => light.insert((
                DirectionalLight {
                    shadow_maps_enabled,
                    ..default()
                },
                cascades.clone(),
            )),
            1 => light.insert(PointLight {
                shadow_maps_enabled,
                range,
                ..default()
            }),
            _ => light.insert(SpotLight {
                shadow_maps_enabled,
                range,
                ..default()
            }),
        };
    }))
}

fn despawn(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    any_light(rng, cast).map(Change::despawn)
}

/// By another light, or by a thing.
fn be_replaced(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let light = any_light(rng, cast)?;
    let successor = if rng.random() { spawn } else { things::spawn };
    Some(successor(rng, cast)?.in_place_of(light))
}
