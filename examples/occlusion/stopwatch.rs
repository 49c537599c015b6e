//! How long it takes to find what is in sight, in each frame.

use std::{collections::VecDeque, fmt, time::Instant};

use bevy::{camera::visibility::VisibilitySystems, prelude::*};
use bevy_sightline::prelude::*;

use crate::walk::Walker;

/// The frames of which the median is told.
const FRAMES: usize = 120;

/// Frames that are not counted after a switch: nearly everything comes into view or goes, and is repainted.
const UNTOLD: u32 = 3;

/// Times of the last frames.
#[derive(Resource, Default)]
pub struct Stopwatch {
    started: Option<Instant>,
    pub with_occlusion: Times,
    pub without: Times,
}

/// The times of some frames in milliseconds.
#[derive(Default)]
pub struct Times(VecDeque<f32>);

impl Times {
    fn add(&mut self, ms: f32) {
        if self.0.len() == FRAMES {
            self.0.pop_front();
        }
        self.0.push_back(ms);
    }

    /// NaN while there is none.
    pub fn median(&self) -> f32 {
        let mut sorted: Vec<f32> = self.0.iter().copied().collect();
        sorted.sort_unstable_by(f32::total_cmp);
        sorted.get(sorted.len() / 2).copied().unwrap_or(f32::NAN)
    }
}

impl fmt::Display for Times {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let median = self.median();
        if median.is_nan() {
            write!(f, "... ms (press O)")
        } else {
            write!(f, "{median:.2} ms")
        }
    }
}

impl Stopwatch {
    pub fn forget(&mut self) {
        *self = default();
    }
}

pub fn plugin(app: &mut App) {
    app.init_resource::<Stopwatch>().add_systems(
        PostUpdate,
        (
            begin
                .after(SpatialIndexSystems::Optimize)
                .after(OcclusionSystems::FollowOccluders)
                .after(VisibilitySystems::UpdateFrusta)
                .after(VisibilitySystems::VisibilityPropagate)
                .before(ViewCullingSystems::Find),
            end.after(ViewCullingSystems::Find)
                .before(VisibilitySystems::CheckVisibility),
        ),
    );
}

fn begin(mut watch: ResMut<Stopwatch>) {
    watch.started = Some(Instant::now());
}

fn end(
    mut watch: ResMut<Stopwatch>,
    occlusion: Query<(), (With<Walker>, With<SoftwareOcclusion>)>,
    mut was_on: Local<bool>,
    mut since_switch: Local<u32>,
) {
    let Some(started) = watch.started else {
        return;
    };
    let ms = started.elapsed().as_secs_f32() * 1e3;
    let is_on = !occlusion.is_empty();
    *since_switch += 1;
    if std::mem::replace(&mut *was_on, is_on) != is_on {
        *since_switch = 0;
    }
    if *since_switch < UNTOLD {
        return;
    }
    if is_on {
        watch.with_occlusion.add(ms);
    } else {
        watch.without.add(ms);
    }
}
