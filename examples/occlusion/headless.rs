//! The walk without a window: nothing that can be seen may be hidden.

use std::path::PathBuf;

use bevy::prelude::*;
use bevy_sightline::{occlusion::OcclusionStats, prelude::*};

use crate::{
    look::Rays,
    options::Options,
    picture, shared,
    sight::Sight,
    stopwatch::Stopwatch,
    walk::{Round, Walker},
};

/// In how many frames of a round rays are cast, and how many of them across and down.
const LOOKS: u32 = 24;
const RAYS: UVec2 = UVec2::new(192, 108);

/// One frame of the walk.
struct Frame {
    sight: Sight,
    stats: OcclusionStats,
}

/// Walks one round with occlusion and one without, and prints what was seen and how long it took.
pub fn run(mut app: App) -> AppExit {
    match walk_and_compare(&mut app) {
        Ok(()) => AppExit::Success,
        Err(message) => {
            eprintln!("{message}");
            AppExit::error()
        }
    }
}

fn walk_and_compare(app: &mut App) -> Result<(), String> {
    shared::load(app)?;
    while app.world().resource::<Occluders>().making() > 0 {
        app.update();
    }
    app.world_mut().resource_mut::<Stopwatch>().forget();
    let options = app.world().resource::<Options>().clone();
    let mut rays = Rays::default();
    let with = walk(app, |app, frame| {
        if frame.is_multiple_of(options.frames.div_ceil(LOOKS)) {
            let _ = app.world_mut().run_system_cached_with(look_around, &mut rays);
        }
    });
    if let Some(file) = options.picture {
        draw(app, file)?;
    }
    let world = app.world_mut();
    let mut walkers = world.query_filtered::<Entity, With<Walker>>();
    let walker = walkers.single(world).map_err(|error| error.to_string())?;
    world
        .entity_mut(walker)
        .remove::<(SoftwareOcclusion, OcclusionBuffer)>();
    let without = walk(app, |_, _| ());

    check(&with, &without)?;
    print_report(app.world(), &with, &without, &rays);
    if rays.cast == 0 {
        return Err("no ray was cast".into());
    }
    if rays.missed > 0 {
        return Err(format!("{} rays met what was hidden", rays.missed));
    }
    let is_any_hidden = with.iter().any(|frame| !frame.sight.hidden.is_empty());
    is_any_hidden.then_some(()).ok_or("nothing was hidden".into())
}

/// One round.
fn walk(app: &mut App, mut after: impl FnMut(&mut App, u32)) -> Vec<Frame> {
    let frames = app.world().resource::<Options>().frames;
    let walk = (0..frames).map(|frame| {
        let world = app.world_mut();
        let round = world.resource::<Round>();
        let place = round.place(frame as f32 / frames as f32 * round.length());
        let mut walkers = world.query_filtered::<&mut Transform, With<Walker>>();
        for mut transform in walkers.iter_mut(world) {
            *transform = place;
        }
        app.update();
        after(app, frame);
        let world = app.world_mut();
        let mut buffers = world.query_filtered::<&OcclusionBuffer, With<Walker>>();
        Frame {
            stats: buffers.single(world).map(|buffer| *buffer.stats()).unwrap_or_default(),
            sight: world.resource::<Sight>().clone(),
        }
    });
    walk.collect()
}

/// Casts rays from the eye through the whole view.
fn look_around(
    InMut(rays): InMut<Rays>,
    walker: Single<(&Camera, &GlobalTransform, &VisibleSet), With<Walker>>,
    scene: SceneQuery,
) {
    rays.look(*walker, &scene, RAYS);
}

fn draw(app: &mut App, file: PathBuf) -> Result<(), String> {
    match app.world_mut().run_system_cached_with(picture::draw, file.clone()) {
        Ok(Ok(())) => println!("picture: {}", file.display()),
        Ok(Err(error)) => return Err(format!("no picture: {error}")),
        Err(error) => return Err(format!("no picture: {error}")),
    }
    Ok(())
}

/// What is seen and what is hidden must be in the frustum: all of it is seen without occlusion.
fn check(with: &[Frame], without: &[Frame]) -> Result<(), String> {
    for (number, (with, without)) in with.iter().zip(without).enumerate() {
        let is_beside = |entity: &&Entity| without.sight.seen.binary_search(entity).is_err();
        let Sight { seen, hidden } = &with.sight;
        if let Some(entity) = seen.iter().chain(hidden).find(is_beside) {
            return Err(format!("frame {number}: {entity} is not in the frustum"));
        }
    }
    Ok(())
}

fn print_report(world: &World, with: &[Frame], without: &[Frame], rays: &Rays) {
    let [seen, in_frustum] = [with, without].map(|walk| median(walk, |frame| frame.sight.seen.len()));
    let occluders = world.resource::<Occluders>();
    let watch = world.resource::<Stopwatch>();
    let lines = [
        ("things", world.resource::<SpatialIndex>().len()),
        ("that occlude", occluders.len()),
        ("that should, and do not", occluders.refused().len()),
        ("frames of a round", with.len()),
        ("in the frustum, median", in_frustum),
        ("seen, median", seen),
        ("hidden, median", median(with, |frame| frame.sight.hidden.len())),
        ("occluders drawn, median", median(with, |frame| frame.stats.occluders)),
        ("triangles drawn, median", median(with, |frame| frame.stats.triangles)),
        ("boxes tested, median", median(with, |frame| frame.stats.tested)),
        ("rays cast from the eye", rays.cast),
        ("onto what was hidden", rays.missed),
    ];
    for (name, value) in lines {
        println!("{name:<28}{value:>10}");
    }
    let times = [("with occlusion", &watch.with_occlusion), ("without", &watch.without)];
    for (name, times) in times {
        println!("{:<28}{:>10.3}", format!("{name}, median ms"), times.median());
    }
    if cfg!(debug_assertions) {
        println!("the times mean little without --release");
    }
}

fn median(walk: &[Frame], of: impl Fn(&Frame) -> usize) -> usize {
    let mut values: Vec<usize> = walk.iter().map(of).collect();
    values.sort_unstable();
    values.get(values.len() / 2).copied().unwrap_or_default()
}
