//! What a walker in a city sees, with and without what is behind houses left out: both sides are ours.
//!
//! A ratio above one says that a frame's culling is quicker with occlusion than without, before anything is drawn.

use std::{cell::RefCell, time::Duration};

use bevy::prelude::*;
use bevy_sightline::{occlusion::Occluders, prelude::*};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{
    frames,
    scene::Scene,
    set_up_threads,
    side::{Kind, Number, Side},
};
use crate::{
    Effort,
    compare::{compare, median_ns},
};

/// A house, and what stands about it.
const EACH: usize = 10;

/// From one street to the next.
const BLOCK: f32 = 30.0;

/// So many houses move at a time.
const MOVING: usize = 1000;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Motion {
    /// Nothing.
    Standing,
    /// The camera, along a street, turning its head.
    Walking,
    /// So many houses, up and down.
    Houses,
}

const MOTIONS: [(&str, Motion); 3] = [
    ("standing", Motion::Standing),
    ("walking", Motion::Walking),
    ("moving-occluders", Motion::Houses),
];

pub(crate) fn run(effort: Effort) {
    set_up_threads("occlusion");
    frames::run(if effort == Effort::Quick { 5 } else { 101 });
    let sizes: &[(&str, usize, usize)] = match effort {
        Effort::Quick => &[("10k", 10_000, 60)],
        Effort::Full => &[("10k", 10_000, 240), ("100k", 100_000, 120), ("1M", 1_000_000, 40)],
    };
    for &(name, n, frames) in sizes {
        let scene = city(n);
        let mut sides = [true, false].map(|hides| walker(&scene, hides));
        for (motion_name, motion) in MOTIONS {
            let case = format!("occlusion/{name}-{motion_name}");
            let (seen, with) = (RefCell::new([0; 2]), RefCell::new(Vec::new()));
            let frame = |side: &mut Side, frame: usize| {
                side.place_camera(camera(motion, frame));
                if motion == Motion::Houses {
                    move_houses(side, frame);
                }
                let times = side.frame();
                (times.whole - times.sync, side.seen())
            };
            compare(
                &case,
                "the same without occlusion",
                frames,
                &mut sides,
                |[hiding, _], index| {
                    let (time, answer) = frame(hiding, index);
                    with.borrow_mut().push(time);
                    (time, answer)
                },
                |[_, plain], index| frame(plain, index),
                |hiding, plain| {
                    let mut seen = seen.borrow_mut();
                    *seen = [seen[0] + hiding.len(), seen[1] + plain.len()];
                    let mut plain = plain.clone();
                    plain.sort_unstable();
                    let extra = hiding.iter().filter(|number| plain.binary_search(number).is_err());
                    (extra.count(), hiding.len())
                },
            );
            let [hiding, plain] = seen.into_inner();
            let stats = sides[0].app.world().get::<OcclusionBuffer>(sides[0].camera);
            // Without the warm-up, in which the camera comes from elsewhere.
            let with = with.into_inner().split_off(frames.div_ceil(10));
            let slowest = with.iter().copied().fold(Duration::ZERO, Duration::max).as_nanos();
            println!(
                "# {case}: {:.1}% of what is in the frustum is left out; the slowest frame took {slowest} ns, {:.2} medians; \
                 lastly {:?}",
                100.0 * (1.0 - hiding as f64 / plain as f64),
                slowest as f64 / median_ns(with) as f64,
                stats.expect("the camera hides").stats(),
            );
        }
    }
}

/// Houses on a grid of streets, each with small things around it.
fn city(n: usize) -> Scene {
    let mut rng = ChaCha8Rng::seed_from_u64(n as u64);
    let blocks = (n / EACH) as f32;
    // Even, so that there is a crossing in the middle.
    let across = 2.0 * (blocks.sqrt() / 2.0).ceil();
    let places = (0..n).map(|number| {
        let block = (number / EACH) as f32;
        let middle = Vec3::new(
            block % across - across / 2.0,
            0.0,
            (block / across).floor() - across / 2.0,
        ) * BLOCK;
        if number % EACH == 0 {
            let size = Vec3::new(
                rng.random_range(16.0..24.0),
                rng.random_range(8.0..60.0),
                rng.random_range(16.0..24.0),
            );
            let middle = middle + Vec3::new(BLOCK, size.y, BLOCK) / 2.0;
            return Transform::from_translation(middle).with_scale(size);
        }
        let size = rng.random_range(0.3..2.0);
        let along = rng.random_range(0.0..BLOCK);
        let beside = rng.random_range(-2.0..2.0);
        let at = if rng.random_bool(0.5) {
            Vec3::new(along, size / 2.0, beside)
        } else {
            Vec3::new(beside, size / 2.0, along)
        };
        Transform::from_translation(middle + at).with_scale(Vec3::splat(size))
    });
    Scene {
        places: places.collect(),
        side: across * BLOCK,
    }
}

fn is_house(number: usize) -> bool {
    number.is_multiple_of(EACH)
}

/// An app with a city and a camera at eye level.
fn walker(scene: &Scene, hides: bool) -> Side {
    let mut side = Side::new(Kind::Ours, scene, |app| {
        app.add_plugins(OcclusionPlugin);
    });
    let world = side.app.world_mut();
    let houses: Vec<Entity> = world
        .query::<(Entity, &Number)>()
        .iter(world)
        .filter(|(_, number)| is_house(number.0))
        .map(|(entity, _)| entity)
        .collect();
    for house in houses {
        world.entity_mut(house).insert(Occluder::Auto);
    }
    let projection = PerspectiveProjection {
        aspect_ratio: 16.0 / 9.0,
        far: scene.side,
        ..default()
    };
    world.entity_mut(side.camera).insert(Projection::from(projection));
    if hides {
        world.entity_mut(side.camera).insert(SoftwareOcclusion::default());
    }
    side.app.update();
    while side.app.world().resource::<Occluders>().making() > 0 {
        side.app.update();
    }
    side
}

fn camera(motion: Motion, frame: usize) -> Transform {
    let frame = if motion == Motion::Walking { frame as f32 } else { 0.0 };
    let degrees = 8.0 + 40.0 * (0.05 * frame).sin();
    Transform::from_xyz(0.5, 1.7, 12.0 - 0.1 * frame).with_rotation(Quat::from_rotation_y(degrees.to_radians()))
}

/// Moves the houses nearest to the first one up and down.
fn move_houses(side: &mut Side, frame: usize) {
    let world = side.app.world_mut();
    let mut things = world.query::<(&Number, &mut Transform)>();
    for (number, mut place) in things
        .iter_mut(world)
        .filter(|(number, _)| is_house(number.0))
        .take(MOVING)
    {
        place.translation.y += 0.05 * (number.0 as f32 + 0.2 * frame as f32).sin();
    }
}
