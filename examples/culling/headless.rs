//! The flight without a window: both methods must keep the same things in every frame.

use std::any::TypeId;

use bevy::{
    camera::{primitives::Frustum, visibility::VisibleEntities},
    camera_controller::free_camera::FreeCamera,
    prelude::*,
};
use bevy_sightline::{culling::ViewCullingSettings, prelude::*};

use crate::{
    nodes::{self, Side},
    options::Options,
    shared,
    stopwatch::{Method, Stopwatch},
    views,
};

/// What was kept in a frame: for the camera, and for any view at all.
#[derive(PartialEq)]
struct Kept {
    in_view: Vec<Entity>,
    shown: Vec<Entity>,
}

/// Flies one round with each method, and prints what they found and how long it took.
pub fn run(mut app: App) -> AppExit {
    if let Err(message) = shared::load(&mut app) {
        eprintln!("{message}");
        return AppExit::error();
    }
    let bevy = fly(&mut app, Method::Bevy);
    let sightline = fly(&mut app, Method::Sightline);
    if let Some(frame) = (0..bevy.len()).find(|&frame| bevy[frame] != sightline[frame]) {
        let (ours, theirs) = (&sightline[frame].in_view, &bevy[frame].in_view);
        eprintln!(
            "frame {frame}: {} things kept, and Bevy keeps {}",
            ours.len(),
            theirs.len()
        );
        return AppExit::error();
    }
    print_report(&mut app, &sightline);
    AppExit::Success
}

/// One round, after a frame that is not counted.
fn fly(app: &mut App, method: Method) -> Vec<Kept> {
    let Options { frames, blocks, .. } = *app.world().resource::<Options>();
    app.world_mut().resource_mut::<ViewCullingSettings>().enabled = method == Method::Sightline;
    app.update();
    if method == Method::Bevy {
        app.world_mut().resource_mut::<Stopwatch>().forget();
    }
    (0..frames)
        .map(|frame| {
            let world = app.world_mut();
            let mut cameras = world.query_filtered::<&mut Transform, With<FreeCamera>>();
            for mut transform in cameras.iter_mut(world) {
                *transform = views::place(frame as f32 / frames as f32, blocks);
            }
            app.update();
            kept(app.world_mut())
        })
        .collect()
}

fn kept(world: &mut World) -> Kept {
    let mut cameras = world.query_filtered::<&VisibleEntities, With<FreeCamera>>();
    let in_view = cameras
        .iter(world)
        .flat_map(|visible| visible.get(TypeId::of::<Mesh3d>()))
        .copied()
        .collect();
    let mut views = world.query::<(Entity, &ViewVisibility)>();
    let mut shown: Vec<Entity> = views
        .iter(world)
        .filter(|(_, view)| view.get())
        .map(|(entity, _)| entity)
        .collect();
    shown.sort_unstable();
    Kept { in_view, shown }
}

fn print_report(app: &mut App, frames: &[Kept]) {
    let world = app.world_mut();
    let mut counts: Vec<usize> = frames.iter().map(|kept| kept.in_view.len()).collect();
    counts.sort_unstable();
    let mut cameras = world.query_filtered::<&Frustum, With<FreeCamera>>();
    let frustum = *cameras.single(world).expect("the scenery has one camera");
    let index = world.resource::<SpatialIndex>();
    let (mut looked_at, mut taken_whole) = (0, 0);
    nodes::visit(index, &frustum.0, |side, _| {
        looked_at += 1;
        taken_whole += u32::from(side == Side::Inside);
    });
    let watch = world.resource::<Stopwatch>();
    let (ours, bevy) = (
        watch.culling(Method::Sightline).median(),
        watch.culling(Method::Bevy).median(),
    );
    let stats = index.stats();
    println!("frames, the same with both  {:>12}", frames.len());
    println!("things                      {:>12}", stats.entities);
    println!("kept, at least              {:>12}", counts[0]);
    println!("kept, median                {:>12}", counts[counts.len() / 2]);
    println!("kept, at most               {:>12}", counts[counts.len() - 1]);
    println!("nodes of the tree           {:>12}", stats.nodes);
    println!("looked at, last frame       {looked_at:>12}");
    println!("taken whole, last frame     {taken_whole:>12}");
    println!("culling, median ms          {ours:>12.3}");
    println!("index, median ms            {:>12.3}", watch.index().median());
    println!("culling by Bevy, median ms  {bevy:>12.3}");
    println!("times faster                {:>12.1}", bevy / ours);
    if cfg!(debug_assertions) {
        println!("the times mean little without --release");
    }
}
