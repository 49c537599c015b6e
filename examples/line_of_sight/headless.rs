//! The courtyard without a window: who saw how much of the thief, and whether fans and lines of sight agree.

use std::{error::Error, path::PathBuf, time::Duration};

use bevy::{prelude::*, time::TimeUpdateStrategy};
use bevy_sightline::prelude::*;

use crate::{
    courtyard::{SKY, TO_SUN},
    drawing::{color, lines},
    guards::{CHEST, Effort, Guard, HALF_ANGLE, RANGE, Sight, State},
    options::Options,
    picture::{Daylight, Painter, Picture},
    shared,
    thief::Person,
};

/// Of the time between two frames, in seconds.
const STEP: f32 = 1.0 / 30.0;
/// The size of the picture in rays: four make a pixel.
const SIZE: UVec2 = UVec2::new(2560, 1440);
/// So that the stone is not white.
const EXPOSURE: f32 = 0.75;
/// How far short of their ends the rays of a fan must be in sight, in metres: at the very ends, rays that graze what
/// they hit are decided by rounding.
const SHORT: f32 = 0.01;

/// What one guard has seen of the thief.
#[derive(Clone, Default)]
struct Watch {
    frames_blocked: u32,
    shares: Vec<f32>,
}

/// Runs the scene and prints what was seen.
pub fn run(mut app: App) -> AppExit {
    if let Err(message) = shared::load(&mut app) {
        eprintln!("{message}");
        return AppExit::error();
    }
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f32(STEP)));
    let Options { frames, picture, .. } = app.world().resource::<Options>().clone();
    let mut watches: Vec<Watch> = Vec::new();
    let (mut times, mut busiest, mut frames_seen) = (Vec::new(), (0, 0), 0);
    for frame in 0..frames {
        app.update();
        let effort = app.world().resource::<Effort>();
        times.push(effort.took.as_secs_f64() * 1e6);
        let mut guards = app.world_mut().query::<(&Guard, &Sight)>();
        let (mut stir, mut is_seen) = (0, false);
        for (guard, sight) in guards.iter(app.world()) {
            watches.resize(watches.len().max(guard.number), Watch::default());
            let watch = &mut watches[guard.number - 1];
            match sight.state {
                State::Calm => {}
                State::Blocked => watch.frames_blocked += 1,
                State::Sees => watch.shares.push(sight.share),
            }
            is_seen |= sight.state == State::Sees;
            stir += match sight.state {
                State::Calm => 0,
                State::Blocked => 2,
                State::Sees => 3,
            };
        }
        frames_seen += u32::from(is_seen);
        if stir > busiest.0 {
            busiest = (stir, frame);
            if let Some(Err(error)) = picture.clone().map(|file| draw_now(&mut app, file)) {
                eprintln!("no picture: {error}");
                return AppExit::error();
            }
        }
        if frame % 10 == 0 && !matches!(app.world_mut().run_system_cached(fans_are_in_sight), Ok(true)) {
            eprintln!("frame {frame}: the end of a fan is out of sight");
            return AppExit::error();
        }
    }
    for (watch, number) in watches.iter().zip(1..) {
        let mean = watch.shares.iter().sum::<f32>() / watch.shares.len().max(1) as f32;
        println!(
            "guard {number}: saw the thief in {:>4} frames, {:>3.0}% of it on average; in {:>4} something was in the way",
            watch.shares.len(),
            100.0 * mean,
            watch.frames_blocked,
        );
    }
    times.sort_unstable_by(f64::total_cmp);
    let effort = app.world().resource::<Effort>();
    println!("seen in                {frames_seen:>8} of {frames} frames");
    println!("rays of fans a frame   {:>8}", effort.rays);
    println!("to look, median µs     {:>8.0}", times[times.len() / 2]);
    println!("fans and lines of sight agree");
    if frames_seen == 0 {
        eprintln!("nobody saw the thief");
        return AppExit::error();
    }
    AppExit::Success
}

/// Whether all that fans reach is in sight.
fn fans_are_in_sight(scene: SceneQuery, sights: Query<&Sight>, people: Query<(), With<Person>>) -> bool {
    let is_still = |entity| !people.contains(entity);
    // As the rays had it.
    let scenery = SceneQuerySettings::default()
        .with_backfaces(bevy_sightline::index::Backfaces::Cull)
        .filter(&is_still);
    sights.iter().all(|sight| {
        let from = sight.eye.with_y(CHEST);
        sight.fan.iter().all(|&end| {
            let short = from + (end - from).clamp_length_max(from.distance(end) - SHORT);
            scene.line_of_sight(from, short, &scenery)
        })
    })
}

fn draw_now(app: &mut App, file: PathBuf) -> Result<(), Box<dyn Error + Send + Sync>> {
    (app.world_mut().run_system_cached_with(draw, file)).map_err(|error| error.to_string())?
}

/// Draws what the camera sees, ray by ray, with the light of the guards on the ground: where the eye has a line of
/// sight.
fn draw(
    In(file): In<PathBuf>,
    painter: Painter,
    scene: SceneQuery,
    camera: Single<(&Camera, &GlobalTransform)>,
    guards: Query<(&Guard, &Sight)>,
    people: Query<(), With<Person>>,
) -> Result<(), Box<dyn Error + Send + Sync>> {
    let daylight = Daylight {
        sky: SKY,
        to_sun: TO_SUN,
        haze: 1e6,
    };
    let is_still = |entity| !people.contains(entity);
    let scenery = SceneQuerySettings::default().filter(&is_still);
    let mut picture = Picture::ray_cast(SIZE, *camera, |ray| {
        let (mut paint, along) = painter.shade(ray, &daylight);
        let place = ray.get_point(along);
        if along.is_finite() && place.y.abs() < 0.02 {
            for (guard, sight) in &guards {
                let way = (place - sight.eye).with_y(0.0);
                let looks = Vec3::new(guard.yaw.sin(), 0.0, guard.yaw.cos());
                let is_lit = way.length() < RANGE
                    && way.angle_between(looks) < HALF_ANGLE
                    && scene.line_of_sight(sight.eye.with_y(CHEST), place.with_y(CHEST), &scenery);
                if is_lit {
                    let brightness = 0.62 - 0.50 * way.length() / RANGE;
                    paint = paint.mix(&color(sight.state).into(), brightness);
                }
            }
        }
        (paint * EXPOSURE, along)
    });
    for (_, sight) in &guards {
        for line in lines(sight) {
            picture.line(line, color(sight.state));
        }
    }
    picture.save(&file)
}
