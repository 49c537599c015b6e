//! The flight without a window: what both cameras show, second by second.

use bevy::prelude::*;
use bevy_sightline::prelude::*;

use crate::{
    flight::swing,
    options::Options,
    picture,
    route::Route,
    shared,
    tally::{Counter, Switches, Tally},
    views::{Bird, Player},
};

const FRAMES_PER_SECOND: u32 = 30;
/// How long the player swings back and forth, in seconds, and where on the route.
const SWINGING: u32 = 10;
const SWINGING_AT: f32 = 0.16;
/// From a bird's eye, at most so much of the triangles is shown, in percent.
const ENOUGH: f64 = 10.0;
/// Where on the route the picture is taken.
const PICTURE_AT: f32 = 0.045;

/// Flies around once, and prints what was seen.
pub fn run(mut app: App) -> AppExit {
    match fly_and_report(&mut app) {
        Ok(()) => AppExit::Success,
        Err(message) => {
            eprintln!("{message}");
            AppExit::error()
        }
    }
}

fn fly_and_report(app: &mut App) -> Result<(), String> {
    shared::load(app)?;
    let world = app.world_mut();
    let options = world.resource::<Options>().clone();
    let mut cameras = world.query_filtered::<Entity, With<Player>>();
    let player = cameras.single(world).map_err(|error| error.to_string())?;
    let mut cameras = world.query_filtered::<Entity, With<Bird>>();
    let bird = cameras.single(world).map_err(|error| error.to_string())?;
    let views = [player, bird];

    println!("              the player                                   the bird");
    println!("              houses at levels     triangles      switches houses at levels     triangles      switches");
    println!(
        "second        0    1    2  proxy   shown  of all           0    1    2  proxy   shown  of all           differ"
    );
    let (mut worst, mut all) = ([0.0_f64; 2], [Tally::default(); 2]);
    let mut most_differences = 0;
    for second in 0..options.seconds {
        for frame in 0..FRAMES_PER_SECOND {
            let along = second as f32 + frame as f32 / FRAMES_PER_SECOND as f32;
            let place = app.world().resource::<Route>().place(along / options.seconds as f32);
            step(app, player, place);
        }
        let (tallies, differences) = look(app, views)?;
        let switches = take_switches(app, views);
        let rows: Vec<String> = tallies
            .iter()
            .zip(switches)
            .map(|(tally, switches)| row(tally, switches))
            .collect();
        println!("{:>6}  {}  {}  {differences:>5}", second + 1, rows[0], rows[1]);
        for (view, tally) in tallies.iter().enumerate() {
            worst[view] = worst[view].max(tally.percent());
            all[view].shown += tally.shown;
            all[view].full += tally.full;
        }
        most_differences = most_differences.max(differences);
    }
    let swung = [LodSettings::default().hysteresis, 0.0].map(|hysteresis| {
        app.world_mut().resource_mut::<LodSettings>().hysteresis = hysteresis;
        swing_about(app, player);
        take_switches(app, views)[0]
    });
    app.world_mut().resource_mut::<LodSettings>().hysteresis = LodSettings::default().hysteresis;

    println!();
    for (view, name) in ["the player", "the bird"].into_iter().enumerate() {
        let (usual, worst) = (all[view].percent(), worst[view]);
        println!("of all triangles in view, {name} shows {usual:.1} %, and at most {worst:.1} %");
    }
    println!("houses of which the two show different levels at once: up to {most_differences}");
    println!(
        "swinging back and forth for {SWINGING} s, the player's levels switch {} times;",
        swung[0]
    );
    println!("without hysteresis, {} times", swung[1]);
    if let Some(file) = options.picture {
        let place = app.world().resource::<Route>().place(PICTURE_AT);
        // What rays meet is as of the frame before.
        step(app, player, place);
        step(app, player, place);
        match app.world_mut().run_system_cached_with(picture::draw, file.clone()) {
            Ok(Ok(())) => println!("picture: {}", file.display()),
            Ok(Err(error)) => return Err(format!("no picture: {error}")),
            Err(error) => return Err(format!("no picture: {error}")),
        }
    }
    if most_differences == 0 {
        return Err("both cameras have shown the same levels".into());
    }
    let is_enough = worst[1] <= ENOUGH;
    println!(
        "at most a tenth of the triangles from a bird's eye: {}",
        if is_enough { "yes" } else { "no" }
    );
    is_enough
        .then_some(())
        .ok_or("the bird shows too many triangles".into())
}

/// One frame with the player somewhere.
fn step(app: &mut App, player: Entity, place: Transform) {
    if let Some(mut transform) = app.world_mut().get_mut::<Transform>(player) {
        *transform = place;
    }
    app.update();
}

fn swing_about(app: &mut App, player: Entity) {
    let place = app.world().resource::<Route>().place(SWINGING_AT);
    step(app, player, place);
    // Those that come from getting there do not count.
    app.insert_resource(Switches::default());
    for frame in 0..SWINGING * FRAMES_PER_SECOND {
        step(app, player, swing(&place, frame as f32 / FRAMES_PER_SECOND as f32));
    }
}

fn look(app: &mut App, views: [Entity; 2]) -> Result<([Tally; 2], usize), String> {
    let count = |In(views): In<[Entity; 2]>, counter: Counter| {
        (views.map(|view| counter.count(view)), counter.differences(views))
    };
    let counted = app.world_mut().run_system_cached_with(count, views);
    counted.map_err(|error| error.to_string())
}

fn take_switches(app: &mut App, views: [Entity; 2]) -> [usize; 2] {
    let mut switches = app.world_mut().resource_mut::<Switches>();
    views.map(|view| switches.take(view))
}

fn row(tally: &Tally, switches: usize) -> String {
    let [finest, plain, boxes, in_proxies] = tally.houses;
    format!(
        "{finest:>7} {plain:>4} {boxes:>4} {in_proxies:>6} {:>7} {:>5.1} % {switches:>9}",
        tally.shown,
        tally.percent()
    )
}
