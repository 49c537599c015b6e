//! What each part of the crate does in the city, held against another way to find that out. Nothing may move by itself.

use std::any::TypeId;

use bevy::{
    camera::{primitives::Aabb, visibility::VisibleEntities},
    picking::pointer::PointerAction,
    prelude::*,
};
use bevy_sightline::prelude::*;

use crate::{
    blocks::{Lot, Proxy},
    drawing::Selecting,
    flight::route,
    interaction::Selected,
    levels::{BLOCK, Reach},
    look::Rays,
    options::Options,
    outline::draw_by_script,
    pointer::{click, play},
    scenery::Thing,
};

/// Rays from the eye, across and down.
const RAYS: UVec2 = UVec2::new(192, 108);
/// How exactly distances are held against those from which on levels are shown, in metres.
const ROUNDING: f32 = 0.05;
/// Where on the way around the eye is in a street.
const IN_A_STREET: f32 = 0.38;

fn camera(app: &mut App) -> Entity {
    let world = app.world_mut();
    let mut cameras = world.query_filtered::<Entity, With<Camera3d>>();
    cameras.single(world).expect("the scenery has one camera")
}

fn selected(app: &mut App) -> Vec<Entity> {
    let world = app.world_mut();
    world.query_filtered::<Entity, With<Selected>>().iter(world).collect()
}

/// Selects a tower, drags it away and back: it must follow, and stay where it is let go.
pub fn check_drag(app: &mut App) -> Result<(), String> {
    let (tower, aside) = (Vec2::new(0.195, 0.55), Vec2::new(0.24, 0.60));
    play(app, click(tower));
    let [thing] = selected(app)[..] else {
        return Err("a click has not selected one thing".into());
    };
    let place = |app: &App| {
        app.world()
            .get::<GlobalTransform>(thing)
            .map(GlobalTransform::translation)
    };
    let before = place(app);
    let press = Some(PointerAction::Press(PointerButton::Primary));
    let release = Some(PointerAction::Release(PointerButton::Primary));
    play(
        app,
        [
            (tower, press),
            (tower.midpoint(aside), None),
            (aside, None),
            (aside, None),
        ],
    );
    let moved = place(app).zip(before).map_or(0.0, |(there, here)| there.distance(here));
    play(app, [(tower, None), (tower, None), (tower, release), (tower, None)]);
    let left = place(app)
        .zip(before)
        .map_or(f32::INFINITY, |(there, here)| there.distance(here));
    let in_block = app.world().get::<ChildOf>(thing).is_some();
    if moved < 1.0 || left > 0.1 || in_block {
        return Err(format!("dragged {moved} m away and back, and {left} m off"));
    }
    Ok(())
}

/// Draws a box in both modes: what is enclosed is touched, too, and what is touched is touched by its bounds. Says how
/// many things are touched.
pub fn check_box(app: &mut App) -> Result<usize, String> {
    let places = [
        Vec2::new(330.0, 250.0),
        Vec2::new(700.0, 330.0),
        Vec2::new(880.0, 560.0),
    ];
    let mut draw = |mode, precision| {
        app.world_mut().resource_mut::<Selecting>().settings = SelectionSettings { mode, precision };
        draw_by_script(app, Some(KeyCode::ShiftLeft), &places);
        let mut found = selected(app);
        found.sort_unstable();
        found
    };
    let enclosed = draw(SelectionMode::Enclosed, SelectionPrecision::Mesh);
    let touched_bounds = draw(SelectionMode::Touching, SelectionPrecision::Bounds);
    let touched = draw(SelectionMode::Touching, SelectionPrecision::Mesh);
    let is_within = |few: &[Entity], many: &[Entity]| few.iter().all(|entity| many.binary_search(entity).is_ok());
    if enclosed.is_empty() || !is_within(&enclosed, &touched) || !is_within(&touched, &touched_bounds) {
        return Err(format!(
            "a box encloses {}, touches {}, and the bounds of {}",
            enclosed.len(),
            touched.len(),
            touched_bounds.len()
        ));
    }
    Ok(touched.len())
}

/// What is in view with occlusion off must be what Bevy's own culling keeps of the same levels. Says how many that are.
pub fn check_culling(app: &mut App) -> Result<usize, String> {
    let camera = camera(app);
    let occlusion = app.world_mut().entity_mut(camera).take::<SoftwareOcclusion>();
    app.world_mut().entity_mut(camera).remove::<OcclusionBuffer>();
    let mut kept = [true, false].map(|is_on| {
        app.world_mut().resource_mut::<ViewCullingSettings>().enabled = is_on;
        app.update();
        app.update();
        let visible = app.world().get::<VisibleEntities>(camera);
        visible.map_or(Vec::new(), |visible| visible.get(TypeId::of::<Mesh3d>()).to_vec())
    });
    app.world_mut().resource_mut::<ViewCullingSettings>().enabled = true;
    app.world_mut().entity_mut(camera).insert(occlusion.unwrap_or_default());
    app.update();
    for list in &mut kept {
        list.sort_unstable();
    }
    let [ours, bevy] = kept;
    (ours == bevy && !ours.is_empty()).then_some(ours.len()).ok_or(format!(
        "{} things are kept, and by Bevy {}",
        ours.len(),
        bevy.len()
    ))
}

/// Every level must be what the distance says. Says how many things, and proxies of blocks, are in view at each.
pub fn check_levels(app: &mut App) -> Result<[usize; 4], String> {
    let hysteresis = std::mem::replace(&mut app.world_mut().resource_mut::<LodSettings>().hysteresis, 0.0);
    app.update();
    app.update();
    let counted = app.world_mut().run_system_cached(count_levels);
    app.world_mut().resource_mut::<LodSettings>().hysteresis = hysteresis;
    counted.map_err(|error| error.to_string())?
}

fn count_levels(
    eye: Single<(Entity, &GlobalTransform, &VisibleSet), With<Camera3d>>,
    choices: Res<LodChoices>,
    things: Query<(Entity, &Thing, &Aabb, &GlobalTransform)>,
    lots: Query<(Entity, &GlobalTransform), With<Lot>>,
    proxies: Query<(), With<Proxy>>,
) -> Result<[usize; 4], String> {
    let (camera, eye, visible) = *eye;
    let is_level = |level: Option<usize>, distance: f32, switches: &[f32]| {
        let at = |distance: f32| switches.iter().filter(|&&switch| distance >= switch).count();
        level.is_some_and(|level| (at(distance - ROUNDING)..=at(distance + ROUNDING)).contains(&level))
    };
    let mut counts = [0; 4];
    for (entity, thing, aabb, place) in &things {
        let Reach { middle, far, nothing } = Reach::of(thing.model);
        let switches = [middle, far, nothing.unwrap_or(f32::INFINITY)];
        let distance = eye.translation().distance(place.transform_point(aabb.center.into()));
        let level = choices.level(entity, camera);
        if !is_level(level, distance, &switches) {
            return Err(format!("{} at {distance} m is shown at level {level:?}", thing.model));
        }
        if visible.contains(entity) {
            counts[level.unwrap_or_default().min(2)] += 1;
        }
    }
    for (slab, place) in &lots {
        let Some(bounds) = choices.bounds(slab) else {
            return Err(format!("block {slab} has no bounds"));
        };
        let distance = eye.translation().distance(place.transform_point(bounds.center.into()));
        let level = choices.level(slab, camera);
        if !is_level(level, distance, &[BLOCK]) {
            return Err(format!("block {slab} at {distance} m is shown at level {level:?}"));
        }
    }
    counts[3] = visible
        .entities()
        .iter()
        .filter(|&&entity| proxies.contains(entity))
        .count();
    Ok(counts)
}

/// From within a street nothing that rays meet may be hidden, and something must be. Says how much is.
pub fn check_occlusion(app: &mut App) -> Result<usize, String> {
    let camera = camera(app);
    let blocks = app.world().resource::<Options>().blocks;
    // Rays meet the finest levels.
    app.world_mut().resource_mut::<LodSettings>().enabled = false;
    let before = app.world().get::<Transform>(camera).copied().unwrap_or_default();
    let put = |app: &mut App, place: Transform| {
        if let Some(mut transform) = app.world_mut().get_mut::<Transform>(camera) {
            *transform = place;
        }
        app.update();
    };
    put(app, route(blocks).place(IN_A_STREET));
    let rays = app.world_mut().run_system_cached(look_around);
    let rays = rays.map_err(|error| error.to_string())?;
    let hidden = app
        .world()
        .get::<OcclusionBuffer>(camera)
        .map_or(0, |buffer| buffer.stats().hidden);
    app.world_mut().resource_mut::<LodSettings>().enabled = true;
    put(app, before);
    if rays.missed > 0 || rays.cast == 0 {
        return Err(format!("{} of {} rays met what was hidden", rays.missed, rays.cast));
    }
    (hidden > 0).then_some(hidden).ok_or("nothing was hidden".into())
}

fn look_around(view: Single<(&Camera, &GlobalTransform, &VisibleSet), With<Camera3d>>, scene: SceneQuery) -> Rays {
    let mut rays = Rays::default();
    rays.look(*view, &scene, RAYS);
    rays
}
