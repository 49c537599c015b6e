//! What cameras see.

use std::{cell::RefCell, time::Duration};

use bevy::prelude::*;

use super::{
    PEER,
    scene::Scene,
    set_up_threads,
    side::{Kind, Side},
};
use crate::{
    Effort,
    compare::{compare, median_ns},
};

/// What moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Motion {
    /// Nothing.
    Static,
    /// The camera turns a degree a frame.
    Turning,
    /// The camera is outside, looks away, and turns a little.
    Away,
    /// Everything but the camera.
    Moving,
}

const MOTIONS: [(&str, Motion); 4] = [
    ("static", Motion::Static),
    ("turning", Motion::Turning),
    ("away", Motion::Away),
    ("moving", Motion::Moving),
];

pub(crate) fn run(effort: Effort) {
    set_up_threads("culling");
    let sizes: &[(&str, usize, usize)] = match effort {
        Effort::Quick => &[("1k", 1_000, 120), ("10k", 10_000, 60)],
        Effort::Full => &[
            ("1k", 1_000, 360),
            ("10k", 10_000, 180),
            ("100k", 100_000, 60),
            ("1M", 1_000_000, 20),
        ],
    };
    for &(name, n, frames) in sizes {
        let scene = Scene::new(n);
        let mut sides = [Kind::Ours, Kind::Bevys].map(|kind| Side::new(kind, &scene, |_| ()));
        for (motion_name, motion) in MOTIONS {
            let case = format!("culling/{name}-{motion_name}");
            let syncs = RefCell::new(Vec::new());
            let frame = |side: &mut Side, frame: usize| {
                side.place_camera(camera(&scene, motion, frame));
                if motion == Motion::Moving {
                    side.move_all(&scene, frame);
                }
                let times = side.frame();
                syncs.borrow_mut().extend((!times.sync.is_zero()).then_some(times.sync));
                let not_counted = if motion == Motion::Moving {
                    Duration::ZERO
                } else {
                    times.sync
                };
                (times.whole - not_counted, side.seen())
            };
            compare(
                &case,
                PEER,
                frames,
                &mut sides,
                |[ours, _], index| frame(ours, index),
                |[_, bevys], index| frame(bevys, index),
                |ours, bevys| (usize::from(ours != bevys), 1),
            );
            let counted = if motion == Motion::Moving {
                "included"
            } else {
                "besides"
            };
            println!(
                "# {case}: the index took {} ns, {counted}",
                median_ns(syncs.into_inner())
            );
        }
    }
}

fn camera(scene: &Scene, motion: Motion, frame: usize) -> Transform {
    let degrees = |degrees: f32| Quat::from_rotation_y(degrees.to_radians());
    match motion {
        Motion::Static | Motion::Moving => Transform::IDENTITY,
        Motion::Turning => Transform::from_rotation(degrees(frame as f32)),
        Motion::Away => Transform {
            translation: Vec3::NEG_Z * scene.side,
            rotation: degrees((frame % 40) as f32 - 20.0),
            ..default()
        },
    }
}
