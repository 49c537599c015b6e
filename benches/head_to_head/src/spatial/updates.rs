//! Boxes that move, frame after frame, and what that leaves of the queries.
//!
//! Only what keeps its queries fast is a peer here: refitting alone is cheap, and soon useless. All upkeep is in the
//! figures, in one thread. Each box counts as given to the structure in each frame in which it moves; the margins with
//! which the peers pass over small movements are theirs.

use bevy_sightline::geometry::ray::Ray;

use super::{
    OURS,
    motion::{Motion, Move, Movement},
    ours,
    peers::{
        avian::{self, Avian},
        rapier::{self, Rapier},
        rebuilt::{self, Rebuilt},
    },
    queries::{RayQueries, same_parameter},
    race::{Side, race, report},
    rays::TURN,
    scenes::{MakeScene, Scene},
};
use crate::{
    Effort,
    compare::{median_ns, time},
};

/// Takes part in frames.
pub(crate) trait Upkeep {
    /// Brings the moves into the form that the structure takes them in: what a caller would have had anyway.
    fn prepare(&mut self, _moves: &[Move]) {}

    /// Takes the moves of a frame, and does all that keeps queries fast.
    fn frame(&mut self, moves: &[Move]);

    /// See [`RayQueries::closest`].
    fn closest(&self, ray: &Ray) -> Option<f32>;
}

pub(crate) fn run(effort: Effort) {
    let motions = [
        ("1%", Motion::Drift(0.01)),
        ("10%", Motion::Drift(0.1)),
        ("100%", Motion::Drift(1.0)),
        ("teleport-1%", Motion::Teleport(0.01)),
    ];
    for make in [Scene::uniform as MakeScene, Scene::city] {
        for &(size, n) in effort.sizes() {
            let scene = make(n);
            for (name, motion) in motions {
                let names = format!("{name}-{}-{size}", scene.name);
                run_in(&scene, motion, &names, frames(n, motion, effort), effort);
            }
        }
    }
}

/// Ten seconds at sixty frames each; fewer where frames take long.
fn frames(n: usize, motion: Motion, effort: Effort) -> usize {
    let (Motion::Drift(share) | Motion::Teleport(share)) = motion;
    match effort {
        Effort::Quick => 600.min(6_000_000 / n),
        Effort::Full if n < 1_000_000 => 600,
        Effort::Full => {
            if share > 0.5 {
                20
            } else {
                60
            }
        }
    }
}

fn run_in(scene: &Scene, motion: Motion, names: &str, frames: usize, effort: Effort) {
    let mut movement = Movement::new(scene, motion);
    let mut all: Vec<(&str, Box<dyn Upkeep>)> = vec![
        (OURS, Box::new(ours::moving_tree(&scene.boxes))),
        (avian::NAME, Box::new(Avian::build(&scene.boxes))),
        (rapier::NAME, Box::new(Rapier::build(&scene.boxes))),
        (rebuilt::NAME, Box::new(Rebuilt::build(&scene.boxes))),
    ];
    report(&format!("updates/{names}"), run_frames(&mut all, &mut movement, frames));

    let fresh = ours::tree(movement.boxes());
    let rays = scene.random_rays(TURN * effort.turns() / 2);
    let mut sides: Vec<Side<Ray, Option<f32>>> = (all.iter())
        .map(|(name, structure)| Side::new(name, |ray: &Ray| structure.closest(ray)))
        .collect();
    let case = format!("updates/closest-after-{frames}-{names}");
    race(&case, TURN, &rays, &mut sides, same_parameter);
    let mut sides = [
        Side::new(OURS, |ray: &Ray| all[0].1.closest(ray)),
        Side::new("our tree, built anew", |ray: &Ray| RayQueries::closest(&fresh, ray)),
    ];
    race(&(case + "-fresh"), TURN, &rays, &mut sides, same_parameter);
}

/// Lets all take the same frames in turn, and gives the median of the time that each took, in nanoseconds.
pub(crate) fn run_frames<T: Upkeep + ?Sized>(
    all: &mut [(&'static str, Box<T>)],
    movement: &mut Movement,
    frames: usize,
) -> Vec<(&'static str, f64)> {
    let number = all.len();
    let mut times = vec![Vec::with_capacity(frames); number];
    for frame in 0..frames {
        let moves = movement.frame();
        for side in (0..number).map(|side| (side + frame) % number) {
            let (_, structure) = &mut all[side];
            structure.prepare(&moves);
            let (duration, ()) = time(|| structure.frame(&moves));
            if frame >= frames / 10 {
                times[side].push(duration);
            }
        }
    }
    let medians = times.into_iter().map(|times| median_ns(times) as f64);
    all.iter().map(|(name, _)| *name).zip(medians).collect()
}
