//! How long frames take, with levels and with everything at the finest.

use std::fmt;

use bevy::{
    prelude::*,
    time::Real,
    window::{PresentMode, PrimaryWindow},
};
use bevy_sightline::{index::MeshBvhs, prelude::*};

use crate::{
    controls::{has_levels, set_levels},
    flight::Flight,
    options::Options,
    times::Times,
};

/// Frames that are not counted after a switch: pipelines are made and meshes go to the GPU.
const UNTOLD: u32 = 4;
/// In the place of a time that was not measured yet.
const UNKNOWN: &str = "not measured";

/// Times of the last frames.
#[derive(Resource, Default)]
pub struct Stopwatch {
    with_levels: Times,
    all_finest: Times,
    since_switch: u32,
}

impl fmt::Display for Stopwatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "frames: {} with levels, {} all at the finest",
            self.with_levels.tell(1, UNKNOWN),
            self.all_finest.tell(1, UNKNOWN)
        )
    }
}

pub fn plugin(app: &mut App) {
    app.init_resource::<Stopwatch>().add_systems(First, note_frame);
    let is_measuring = |options: Res<Options>| options.measure.is_some();
    app.add_systems(Startup, free_run.run_if(is_measuring))
        .add_systems(Update, measure.run_if(is_measuring));
}

fn note_frame(
    time: Res<Time<Real>>,
    settings: Res<LodSettings>,
    mut watch: ResMut<Stopwatch>,
    mut before: Local<bool>,
) {
    let are_on = has_levels(&settings);
    watch.since_switch += 1;
    if std::mem::replace(&mut *before, are_on) != are_on {
        watch.since_switch = 0;
    }
    if watch.since_switch <= UNTOLD {
        return;
    }
    let ms = time.delta_secs() * 1e3;
    if are_on {
        watch.with_levels.add(ms);
    } else {
        watch.all_finest.add(ms);
    }
}

/// Has frames not wait for the screen.
fn free_run(mut window: Single<&mut Window, With<PrimaryWindow>>) {
    window.present_mode = PresentMode::AutoNoVsync;
}

/// Flies around once with levels and once without, in the same steps, and quits.
fn measure(
    options: Res<Options>,
    bvhs: Res<MeshBvhs>,
    mut frame: Local<u32>,
    mut flight: ResMut<Flight>,
    mut settings: ResMut<LodSettings>,
    mut watch: ResMut<Stopwatch>,
    mut exit: MessageWriter<AppExit>,
) {
    let Some(frames) = options.measure.filter(|_| bvhs.building() == 0) else {
        return;
    };
    match *frame {
        0 => *watch = default(),
        frame if frame == frames => set_levels(&mut settings, false),
        frame if frame == 2 * frames => {
            println!("{}", *watch);
            exit.write(AppExit::Success);
        }
        _ => {}
    }
    flight.along = (*frame % frames) as f32 / frames as f32;
    *frame += 1;
}
