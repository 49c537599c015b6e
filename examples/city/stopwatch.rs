//! How long each stage of a frame takes, with `bevy_sightline` and with Bevy's built-ins.

use std::time::Instant;

use bevy::{
    camera::visibility::{VisibilitySystems, check_visibility_cpu_culling, check_visibility_ranges},
    picking::PickingSystems,
    prelude::*,
    time::TimeSystems,
};
use bevy_sightline::prelude::*;

use crate::{options::Options, times::Times};

/// A stage of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// What is under the pointer.
    Picking,
    /// `GlobalTransform`s.
    Transforms,
    /// The spatial index, which all but the transforms draw on.
    Index,
    /// Levels of detail.
    Levels,
    /// What cameras see, and what is hidden from them.
    Visibility,
    /// Everything that the app does.
    Frame,
}

impl Stage {
    pub const ALL: [Self; 6] = [
        Self::Picking,
        Self::Transforms,
        Self::Index,
        Self::Levels,
        Self::Visibility,
        Self::Frame,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Picking => "picking",
            Self::Transforms => "transforms",
            Self::Index => "index",
            Self::Levels => "levels of detail",
            Self::Visibility => "visibility",
            Self::Frame => "whole frame",
        }
    }
}

/// Times of the last frames.
#[derive(Resource)]
pub struct Stopwatch {
    lap_began: Instant,
    frame_began: Instant,
    /// Of the frame so far, in milliseconds.
    now: [f32; Stage::ALL.len()],
    times: [Times; Stage::ALL.len()],
}

impl Default for Stopwatch {
    fn default() -> Self {
        Self::of_last(120)
    }
}

impl Stopwatch {
    /// Remembers so many frames, from now on.
    pub fn of_last(frames: usize) -> Self {
        Self {
            lap_began: Instant::now(),
            frame_began: Instant::now(),
            now: default(),
            times: Stage::ALL.map(|_| Times::of_last(frames)),
        }
    }

    /// Begins anew.
    pub fn forget(&mut self) {
        *self = Self::default();
    }

    pub fn times(&self, stage: Stage) -> &Times {
        &self.times[stage as usize]
    }

    /// Adds what has passed since the last lap to a stage.
    fn lap(&mut self, stage: Option<Stage>) {
        let now = Instant::now();
        if let Some(stage) = stage {
            self.now[stage as usize] += (now - self.lap_began).as_secs_f32() * 1e3;
        }
        self.lap_began = now;
    }

    fn begin_frame(&mut self) {
        self.now = default();
        self.frame_began = Instant::now();
    }

    fn end_frame(&mut self) {
        self.now[Stage::Frame as usize] = self.frame_began.elapsed().as_secs_f32() * 1e3;
        for (times, ms) in self.times.iter_mut().zip(self.now) {
            times.add(ms);
        }
    }
}

/// Looks at the watch between the stages, which so follow upon each other: what else there is runs beside them.
pub fn plugin(app: &mut App) {
    app.init_resource::<Stopwatch>()
        .add_systems(
            First,
            (|mut watch: ResMut<Stopwatch>| watch.begin_frame()).before(TimeSystems),
        )
        .add_systems(
            PreUpdate,
            (
                rest.after(PickingSystems::ProcessInput).before(PickingSystems::Backend),
                lap(Stage::Picking)
                    .after(PickingSystems::Backend)
                    .before(PickingSystems::Hover),
            ),
        )
        .add_systems(
            PostUpdate,
            (
                rest.before(TransformSystems::Propagate),
                lap(Stage::Transforms)
                    .after(TransformSystems::Propagate)
                    .before(LodSystems::Follow)
                    .before(VisibilitySystems::CalculateBounds)
                    .before(VisibilitySystems::UpdateFrusta),
                rest.after(VisibilitySystems::CalculateBounds)
                    .after(VisibilitySystems::UpdateFrusta)
                    .before(VisibilitySystems::VisibilityPropagate),
                lap(Stage::Visibility).after(VisibilitySystems::MarkNewlyHiddenEntitiesInvisible),
            ),
        )
        .add_systems(Last, |mut watch: ResMut<Stopwatch>| watch.end_frame());
    if app.world().resource::<Options>().plain {
        app.add_systems(
            PostUpdate,
            (
                lap(Stage::Visibility)
                    .after(VisibilitySystems::VisibilityPropagate)
                    .before(check_visibility_ranges),
                lap(Stage::Levels)
                    .after(check_visibility_ranges)
                    .before(check_visibility_cpu_culling),
            ),
        );
    } else {
        app.add_systems(
            PostUpdate,
            (
                lap(Stage::Levels)
                    .after(LodSystems::Follow)
                    .before(VisibilitySystems::CalculateBounds),
                lap(Stage::Visibility)
                    .after(VisibilitySystems::VisibilityPropagate)
                    .before(SpatialIndexSystems::Sync),
                lap(Stage::Index)
                    .after(SpatialIndexSystems::Optimize)
                    .before(LodSystems::Choose),
                lap(Stage::Levels)
                    .after(LodSystems::Choose)
                    .before(OcclusionSystems::FollowOccluders)
                    .before(ViewCullingSystems::Find)
                    .before(VisibilitySystems::CheckVisibility),
            ),
        );
    }
}

fn lap(stage: Stage) -> impl FnMut(ResMut<Stopwatch>) {
    move |mut watch| watch.lap(Some(stage))
}

/// What has passed is of no stage.
fn rest(mut watch: ResMut<Stopwatch>) {
    watch.lap(None);
}
