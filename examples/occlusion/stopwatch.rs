//! How long it takes to find what is in sight, in each frame.

use std::time::Instant;

use bevy::{camera::visibility::VisibilitySystems, prelude::*};
use bevy_sightline::prelude::*;

use crate::{times::Times, walk::Walker};

/// Frames that are not counted after a switch: nearly everything comes into view or goes, and is repainted.
const UNTOLD: u32 = 3;

/// Times of the last frames.
#[derive(Resource, Default)]
pub struct Stopwatch {
    started: Option<Instant>,
    pub with_occlusion: Times,
    pub without: Times,
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
