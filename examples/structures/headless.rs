//! All structures against each other, without a window.

use bevy::app::AppExit;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::{
    boxes::Boxes,
    options::Options,
    structure::{Kind, Structure},
};

/// Sends rays through all structures, and prints what they visit.
pub fn run(options: &Options) -> AppExit {
    for three_d in [false, true] {
        let boxes = Boxes::new(options.boxes, options.seed, three_d);
        if let Err(message) = compare(&boxes, options) {
            eprintln!("{message}");
            return AppExit::error();
        }
    }
    AppExit::Success
}

fn compare(boxes: &Boxes, options: &Options) -> Result<(), String> {
    let list = Structure::new(Kind::List, &boxes.boxes);
    let mut rng = ChaCha8Rng::seed_from_u64(options.seed.into());
    let rays: Vec<_> = (0..options.rays).map(|_| boxes.random_ray(&mut rng)).collect();
    let hits: Vec<_> = rays.iter().map(|ray| list.closest(ray)).collect();
    println!(
        "{} boxes in {} dimensions, {} rays, of which {} hit; all agree. A ray on average:",
        boxes.boxes.len(),
        if boxes.three_d { "three" } else { "two" },
        rays.len(),
        hits.iter().flatten().count()
    );
    println!(
        "{:<20}{:>7}{:>8}{:>8}   {:>8}{:>8}{:>9}",
        "", "parts", "levels", "bytes", "visits", "tests", "entered"
    );
    for kind in Kind::ALL {
        let structure = Structure::new(kind, &boxes.boxes);
        let (mut visits, mut tests, mut entered) = (0, 0, 0);
        for (ray, expected) in rays.iter().zip(&hits) {
            let (hit, trace) = structure.trace(ray);
            if hit != *expected || structure.closest(ray) != *expected {
                return Err(format!("{}: {ray:?} hits {hit:?}, not {expected:?}", kind.name()));
            }
            visits += trace.nodes().count();
            tests += trace.boxes_tested();
            entered += trace.leaves().count();
        }
        let built = structure.built();
        let mean = |count: usize| count as f32 / rays.len() as f32;
        println!(
            "{:<20}{:>7}{:>8}{:>8}   {:>8.1}{:>8.1}{:>9.2}",
            kind.name(),
            built.parts,
            built.depth,
            built.bytes,
            mean(visits),
            mean(tests),
            mean(entered)
        );
    }
    println!();
    Ok(())
}
