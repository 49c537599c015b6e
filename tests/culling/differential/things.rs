//! What happens to things: where they are, what they belong to, whether they may be seen.

use std::any::TypeId;

use bevy::{
    camera::{
        ShadowLodOrigin,
        primitives::Aabb,
        visibility::{
            DynamicSkinnedMeshBounds, InheritedVisibility, NoAutoAabb, NoCpuCulling, NoFrustumCulling, RenderLayers,
            ViewVisibility, VisibilityClass, VisibilityRange, add_visibility_class,
        },
    },
    ecs::{entity_disabling::Disabled, lifecycle::HookContext, world::DeferredWorld},
    light::NotShadowCaster,
    mesh::skinning::SkinnedMesh,
    prelude::*,
};
use bevy_sightline::prelude::*;
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use super::{
    bounds::random_bounds,
    cast::{Cast, Change, Meshes, Role, Skin, Way},
};
use crate::common::{random_point, random_rotation};

/// Half the side of the world.
pub const SIZE: f32 = 30.0;

/// A class of its own.
#[derive(Component, Clone, Default)]
#[require(Visibility, VisibilityClass, Transform)]
#[component(on_add = add_visibility_class::<Tree>)]
pub struct Tree;

/// A class that adds itself twice.
#[derive(Component, Clone, Default)]
#[require(Visibility, VisibilityClass, Transform)]
#[component(on_add = add_twice)]
pub struct Rock;

fn add_twice(mut world: DeferredWorld, context: HookContext) {
    add_visibility_class::<Rock>(world.reborrow(), context);
    add_visibility_class::<Rock>(world, context);
}

pub const WAYS: &[Way] = &[
    (30, move_a_little),
    (8, jump),
    (6, turn),
    (6, scale),
    (3, lose_its_place),
    (4, have_a_place_again),
    (2, be_placed_by_hand),
    (1, lose_its_global_place),
    (14, show_or_hide),
    (8, change_parent),
    (3, leave_parent),
    (6, have_layers),
    (4, change_layers_in_place),
    (3, lose_layers),
    (4, have_range),
    (2, lose_range),
    (6, spawn),
    (6, despawn),
    (5, be_replaced),
    (2, be_no_thing_and_then_again),
    (3, have_a_class),
    (2, lose_a_class),
    (2, edit_classes),
    (2, lose_view_visibility),
    (2, have_view_visibility),
    (1, lose_inherited_visibility),
    (1, have_inherited_visibility),
    (3, toggle::<NoFrustumCulling>),
    (3, toggle::<NoCpuCulling>),
    (2, toggle::<NoAutoAabb>),
    (3, toggle::<NoSpatialIndex>),
    (3, toggle::<NotShadowCaster>),
    (3, toggle::<Disabled>),
    (1, toggle::<ShadowLodOrigin>),
    (6, move_a_joint),
];

pub fn any_thing(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Entity> {
    cast.any(Role::Thing, rng)
}

fn toggle<C: Component + Default>(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    any_thing(rng, cast).map(|thing| Change::toggle::<C>(thing, rng))
}

/// Mostly in the world, at times far outside, at times many at one place.
fn random_place(rng: &mut ChaCha8Rng) -> Vec3 {
    match rng.random_range(0..20) {
        0 => random_point(rng, 1e5),
        1 => Vec3::splat(7.0),
        _ => random_point(rng, SIZE),
    }
}

fn random_scale(rng: &mut ChaCha8Rng) -> Vec3 {
    let mut axis = || match rng.random_range(0..12) {
        0 => 0.0,
        1 => -1.0,
        2 => rng.random_range(-20.0..20.0),
        _ => rng.random_range(0.2..3.0),
    };
    Vec3::new(axis(), axis(), axis())
}

pub fn random_transform(rng: &mut ChaCha8Rng) -> Transform {
    Transform {
        translation: random_place(rng),
        rotation: random_rotation(rng),
        scale: random_scale(rng),
    }
}

pub fn random_layers(rng: &mut ChaCha8Rng) -> RenderLayers {
    match rng.random_range(0..12) {
        0 => RenderLayers::none(),
        1 => RenderLayers::layer(1),
        2..=4 => RenderLayers::layer(0),
        5..=7 => RenderLayers::from_layers(&[0, 1]),
        8 | 9 => RenderLayers::layer(0).with(70),
        10 => RenderLayers::none().with(70),
        _ => RenderLayers::layer(0).with(130).without(0),
    }
}

fn random_visibility(rng: &mut ChaCha8Rng) -> Visibility {
    match rng.random_range(0..8) {
        0 => Visibility::Hidden,
        1 | 2 => Visibility::Visible,
        _ => Visibility::Inherited,
    }
}

fn random_range(rng: &mut ChaCha8Rng) -> VisibilityRange {
    let start = rng.random_range(0.0..30.0);
    let end = start + rng.random_range(0.0..60.0);
    VisibilityRange {
        start_margin: start..start,
        end_margin: end..end + rng.random_range(0.0..5.0),
        use_aabb: rng.random(),
    }
}

fn move_a_little(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let by = random_point(rng, 5.0);
    let what = format!("moves by {by}");
    let edit = move |place: &mut Transform| place.translation += by;
    Some(Change::edit(any_thing(rng, cast)?, &what, edit))
}

fn jump(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let to = random_place(rng);
    let edit = move |place: &mut Transform| place.translation = to;
    Some(Change::edit(any_thing(rng, cast)?, &format!("jumps to {to}"), edit))
}

fn turn(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let to = random_rotation(rng);
    let edit = move |place: &mut Transform| place.rotation = to;
    Some(Change::edit(any_thing(rng, cast)?, &format!("turns to {to}"), edit))
}

fn scale(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let scale = random_scale(rng);
    let edit = move |place: &mut Transform| place.scale = scale;
    Some(Change::edit(any_thing(rng, cast)?, &format!("has scale {scale}"), edit))
}

fn lose_its_place(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let bad = [f32::NAN, f32::INFINITY, 3e38][rng.random_range(0..3)];
    let edit = move |place: &mut Transform| place.translation.y = bad;
    Some(Change::edit(any_thing(rng, cast)?, &format!("is at y = {bad}"), edit))
}

/// Also for those that have lost their `Transform` or their `GlobalTransform`.
fn have_a_place_again(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let place = random_transform(rng);
    Some(Change::insert(
        any_thing(rng, cast)?,
        &format!("is put at {place:?}"),
        place,
    ))
}

/// Without a `Transform`, nobody writes its `GlobalTransform` but its owner.
fn be_placed_by_hand(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let (thing, place) = (any_thing(rng, cast)?, random_transform(rng));
    let what = format!("{thing} has no Transform, and the GlobalTransform {place:?}");
    Some(Change::new(what, move |world| {
        if let Ok(mut thing) = world.get_entity_mut(thing) {
            thing.remove::<Transform>().insert(GlobalTransform::from(place));
        }
    }))
}

fn lose_its_global_place(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    any_thing(rng, cast).map(Change::remove::<GlobalTransform>)
}

fn show_or_hide(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let visibility = random_visibility(rng);
    let thing = any_thing(rng, cast)?;
    Some(Change::insert(thing, &format!("is {visibility:?}"), visibility))
}

/// Parents are things too, so that hierarchies become deep, and shear what is below them.
fn change_parent(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let (child, parent) = (any_thing(rng, cast)?, any_thing(rng, cast)?);
    Some(Change::new(
        format!("{child} becomes a child of {parent}"),
        move |world| {
            let mut ancestor = Some(parent);
            while let Some(entity) = ancestor {
                if entity == child {
                    return;
                }
                ancestor = world.get::<ChildOf>(entity).map(ChildOf::parent);
            }
            if world.get_entity(parent).is_ok()
                && let Ok(mut child) = world.get_entity_mut(child)
            {
                child.insert(ChildOf(parent));
            }
        },
    ))
}

fn leave_parent(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    any_thing(rng, cast).map(Change::remove::<ChildOf>)
}

fn have_layers(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let (thing, layers) = (any_thing(rng, cast)?, random_layers(rng));
    Some(Change::insert(thing, &format!("has {layers:?}"), layers))
}

fn change_layers_in_place(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let (thing, layers) = (any_thing(rng, cast)?, random_layers(rng));
    let what = format!("has {layers:?} in place");
    Some(Change::edit(thing, &what, move |its: &mut RenderLayers| {
        its.clone_from(&layers);
    }))
}

fn lose_layers(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    any_thing(rng, cast).map(Change::remove::<RenderLayers>)
}

fn have_range(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let (thing, range) = (any_thing(rng, cast)?, random_range(rng));
    let what = format!("has range {:?} to {:?}", range.start_margin, range.end_margin);
    Some(Change::insert(thing, &what, range))
}

fn lose_range(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    any_thing(rng, cast).map(Change::remove::<VisibilityRange>)
}

pub fn spawn(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let (kind, place) = (rng.random_range(0..12), random_transform(rng));
    let (mesh, bounds) = (rng.random_range(0..16), random_bounds(rng));
    let (visibility, layers, range) = (random_visibility(rng), random_layers(rng), random_range(rng));
    let parent = any_thing(rng, cast).filter(|_| rng.random_bool(0.3));
    let mut chance = |chance: f64| rng.random_bool(chance);
    let has_layers = chance(0.2);
    let has_range = chance(0.15);
    let flags = [0; 5].map(|_| chance(0.05));
    let is_ours_to_cull = flags.iter().all(|flag| !flag);
    let what = format!(
        "is spawned: kind {kind}, mesh {mesh}, plain {is_ours_to_cull}, {visibility:?}, child of {parent:?}, {place:?}"
    );
    Some(Change::spawn(Role::Thing, what, move |world, thing| {
        let meshes = &world.resource::<Meshes>().0;
        let mesh = meshes[mesh % meshes.len()].clone();
        let parent = parent.filter(|parent| world.get_entity(*parent).is_ok());
        let mut thing = world.entity_mut(thing);
        thing.insert((place, visibility));
        match kind {
            0..=5 => _ = thing.insert(Mesh3d(mesh)),
            6 => _ = thing.insert(Mesh2d(mesh)),
            7 => _ = thing.insert((Mesh3d(mesh), Tree)),
            8 => _ = thing.insert((Tree, bounds.0)),
            9 => _ = thing.insert((Rock, bounds.1)),
            // Without bounds, and without a class.
            10 => _ = thing.insert(Tree),
            _ => (),
        }
        if has_layers {
            thing.insert(layers.clone());
        }
        if has_range {
            thing.insert(range.clone());
        }
        let [everywhere, by_the_gpu, by_hand, not_indexed, lit] = flags;
        if everywhere {
            thing.insert(NoFrustumCulling);
        }
        if by_the_gpu {
            thing.insert(NoCpuCulling);
        }
        if by_hand {
            thing.insert(NoAutoAabb);
        }
        if not_indexed {
            thing.insert(NoSpatialIndex);
        }
        if lit {
            thing.insert(NotShadowCaster);
        }
        if let Some(parent) = parent {
            thing.insert(ChildOf(parent));
        }
    }))
}

/// A skinned mesh, with those joints that there are.
pub fn spawn_rig(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let place = Transform::from_translation(random_point(rng, SIZE));
    let joints: Vec<Entity> = cast.of(Role::Joint).collect();
    let what = format!("is spawned, a rig of {joints:?} at {}", place.translation);
    Some(Change::spawn(Role::Thing, what, move |world, rig| {
        let mesh = world.resource::<Meshes>().0.last().expect("the skinned mesh").clone();
        let skin = SkinnedMesh {
            inverse_bindposes: world.resource::<Skin>().0.clone(),
            joints: joints.clone(),
        };
        // Bevy updates bounds that are there, and lets none of its own be made.
        let bounds = (DynamicSkinnedMeshBounds, NoAutoAabb, Aabb::default());
        world.entity_mut(rig).insert((Mesh3d(mesh), skin, place, bounds));
    }))
}

pub fn spawn_joint(rng: &mut ChaCha8Rng) -> Change {
    let place = Transform::from_translation(random_point(rng, SIZE));
    let what = format!("is spawned, a joint at {}", place.translation);
    Change::spawn(Role::Joint, what, move |world, joint| {
        world.entity_mut(joint).insert(place);
    })
}

fn move_a_joint(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let (joint, to) = (cast.any(Role::Joint, rng)?, random_point(rng, SIZE));
    let edit = move |place: &mut Transform| place.translation = to;
    Some(Change::edit(joint, &format!("moves to {to}"), edit))
}

fn despawn(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    any_thing(rng, cast).map(Change::despawn)
}

fn be_replaced(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let thing = any_thing(rng, cast)?;
    Some(spawn(rng, cast)?.in_place_of(thing))
}

/// In one go, so that nobody but a hook could tell.
fn be_no_thing_and_then_again(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let thing = any_thing(rng, cast)?;
    let what = format!("{thing} loses its GlobalTransform and its Aabb and has them again");
    Some(Change::new(what, move |world| {
        if let Ok(mut thing) = world.get_entity_mut(thing)
            && let Some(bounds) = thing.take::<(GlobalTransform, Aabb)>()
        {
            thing.insert(bounds);
        }
    }))
}

fn have_a_class(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let thing = any_thing(rng, cast)?;
    Some(if rng.random() {
        Change::insert(thing, "has the class Tree", Tree)
    } else {
        Change::insert(thing, "has the class Rock", Rock)
    })
}

/// The component goes and the class stays; or the other way round.
fn lose_a_class(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let thing = any_thing(rng, cast)?;
    Some(match rng.random_range(0..3) {
        0 => Change::remove::<Tree>(thing),
        1 => Change::remove::<Rock>(thing),
        _ => Change::remove::<VisibilityClass>(thing),
    })
}

fn edit_classes(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let thing = any_thing(rng, cast)?;
    Some(match rng.random_range(0..3) {
        0 => Change::edit(thing, "has no class", |class: &mut VisibilityClass| class.clear()),
        1 => Change::edit(
            thing,
            "has the class Tree once more, in place",
            |class: &mut VisibilityClass| class.push(TypeId::of::<Tree>()),
        ),
        _ => Change::insert(
            thing,
            "has the class Rock alone",
            VisibilityClass([TypeId::of::<Rock>()].into_iter().collect()),
        ),
    })
}

fn lose_view_visibility(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    any_thing(rng, cast).map(Change::remove::<ViewVisibility>)
}

fn have_view_visibility(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let value = [ViewVisibility::HIDDEN, ViewVisibility::VISIBLE][rng.random_range(0..2)];
    Some(Change::insert(
        any_thing(rng, cast)?,
        &format!("has {value:?} by hand"),
        value,
    ))
}

fn lose_inherited_visibility(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    any_thing(rng, cast).map(Change::remove::<InheritedVisibility>)
}

fn have_inherited_visibility(rng: &mut ChaCha8Rng, cast: &Cast) -> Option<Change> {
    let value = [InheritedVisibility::HIDDEN, InheritedVisibility::VISIBLE][rng.random_range(0..2)];
    Some(Change::insert(
        any_thing(rng, cast)?,
        &format!("has {value:?} by hand"),
        value,
    ))
}
