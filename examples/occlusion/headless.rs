//! The walk without a window: nothing that can be seen may be hidden.

use bevy::prelude::*;
use bevy_sightline::{occlusion::OcclusionStats, prelude::*};

use crate::{
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
    seen: Vec<Entity>,
    stats: Option<OcclusionStats>,
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
    let (mut rays, mut missed) = (0, 0);
    let with = walk(app, |app, frame| {
        let every = app.world().resource::<Options>().frames.div_ceil(LOOKS);
        if frame.is_multiple_of(every)
            && let Ok((cast, blind)) = app.world_mut().run_system_cached(look_around)
        {
            rays += cast;
            missed += blind;
        }
    });
    let picture = app.world().resource::<Options>().picture.clone();
    if let Some(file) = picture {
        match app.world_mut().run_system_cached_with(picture::draw, file.clone()) {
            Ok(Ok(())) => println!("picture: {}", file.display()),
            Ok(Err(error)) => return Err(format!("no picture: {error}")),
            Err(error) => return Err(format!("no picture: {error}")),
        }
    }
    let world = app.world_mut();
    let walker = world.query_filtered::<Entity, With<Walker>>().single(world);
    let walker = walker.map_err(|error| error.to_string())?;
    world
        .entity_mut(walker)
        .remove::<(SoftwareOcclusion, OcclusionBuffer)>();
    let without = walk(app, |_, _| ());

    for (frame, (with, without)) in with.iter().zip(&without).enumerate() {
        if with
            .seen
            .iter()
            .any(|entity| without.seen.binary_search(entity).is_err())
        {
            return Err(format!("frame {frame}: something is seen that is not in the frustum"));
        }
    }
    print_report(app, &with, &without, rays, missed);
    if missed > 0 {
        return Err(format!("{missed} rays met what was hidden"));
    }
    let is_any_hidden = with
        .iter()
        .zip(&without)
        .any(|(with, without)| with.seen.len() < without.seen.len());
    is_any_hidden.then_some(()).ok_or("nothing was hidden".into())
}

/// One round.
fn walk(app: &mut App, mut after: impl FnMut(&mut App, u32)) -> Vec<Frame> {
    let frames = app.world().resource::<Options>().frames;
    let mut walk = Vec::new();
    for frame in 0..frames {
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
        let stats = buffers.iter(world).map(|buffer| *buffer.stats()).next();
        let seen = world.resource::<Sight>().seen.clone();
        walk.push(Frame { seen, stats });
    }
    walk
}

/// Casts rays from the eye through the whole view; returns how many, and how many of them met what is not seen.
fn look_around(
    walker: Single<(&Camera, &GlobalTransform, &VisibleSet), With<Walker>>,
    scene: SceneQuery,
) -> (u32, u32) {
    let (camera, transform, visible) = *walker;
    let Some(size) = camera.logical_viewport_size() else {
        return (0, 0);
    };
    let pixels = (0..RAYS.y).flat_map(|y| (0..RAYS.x).map(move |x| Vec2::new(x as f32, y as f32)));
    let rays: Vec<Ray3d> = pixels
        .filter_map(|pixel| {
            camera
                .viewport_to_world(transform, (pixel + 0.5) / RAYS.as_vec2() * size)
                .ok()
        })
        .collect();
    let hits = rays
        .iter()
        .filter_map(|&ray| scene.cast_ray(ray, &SceneQuerySettings::default()));
    let missed = hits.filter(|hit| !visible.contains(hit.entity)).count();
    (rays.len() as u32, missed as u32)
}

fn print_report(app: &mut App, with: &[Frame], without: &[Frame], rays: u32, missed: u32) {
    let world = app.world_mut();
    let things = world.resource::<SpatialIndex>().len();
    let [seen, in_frustum] = [with, without].map(|walk| median(walk.iter().map(|frame| frame.seen.len())));
    let hidden: Vec<f64> = with
        .iter()
        .zip(without)
        .map(|(with, without)| 1.0 - with.seen.len() as f64 / without.seen.len().max(1) as f64)
        .collect();
    let stat = |of: fn(&OcclusionStats) -> usize| median(with.iter().filter_map(|frame| frame.stats.as_ref()).map(of));
    let occluders = world.resource::<Occluders>();
    println!("things                            {things:>10}");
    println!("things that occlude               {:>10}", occluders.len());
    println!("things that should and do not     {:>10}", occluders.refused().len());
    println!("frames of a round                 {:>10}", with.len());
    println!("in the frustum, median            {in_frustum:>10}");
    println!("seen, median                      {seen:>10}");
    println!(
        "hidden, mean share                {:>9.1}%",
        100.0 * hidden.iter().sum::<f64>() / hidden.len() as f64
    );
    println!(
        "occluders drawn, median           {:>10}",
        stat(|stats| stats.occluders)
    );
    println!(
        "triangles drawn, median           {:>10}",
        stat(|stats| stats.triangles)
    );
    println!("boxes tested, median              {:>10}", stat(|stats| stats.tested));
    println!("hidden as counted, median         {:>10}", stat(|stats| stats.hidden));
    let watch = world.resource::<Stopwatch>();
    println!(
        "with occlusion, median ms         {:>10.3}",
        watch.with_occlusion.median()
    );
    println!("without, median ms                {:>10.3}", watch.without.median());
    println!("rays cast from the eye            {rays:>10}");
    println!("of them onto what was hidden      {missed:>10}");
    if cfg!(debug_assertions) {
        println!("the times mean little without --release");
    }
}

fn median(values: impl Iterator<Item = usize>) -> usize {
    let mut values: Vec<usize> = values.collect();
    values.sort_unstable();
    values.get(values.len() / 2).copied().unwrap_or_default()
}
