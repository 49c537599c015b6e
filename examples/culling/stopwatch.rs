//! How long culling takes in each frame, with either method.

use std::time::Instant;

use bevy::{camera::visibility::VisibilitySystems, prelude::*};
use bevy_sightline::{
    culling::{ViewCullingSettings, ViewCullingSystems},
    prelude::*,
};

use crate::times::Times;

/// Who culls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    Bevy,
    Sightline,
}

/// Times of the last frames in milliseconds.
#[derive(Resource, Default)]
pub struct Stopwatch {
    started: Option<Instant>,
    /// Of the frame so far.
    culling: f32,
    indexing: f32,
    bevy: Times,
    sightline: Times,
    index: Times,
}

impl Stopwatch {
    /// What culling takes with a method.
    pub fn culling(&self, method: Method) -> &Times {
        match method {
            Method::Bevy => &self.bevy,
            Method::Sightline => &self.sightline,
        }
    }

    /// What it takes to keep the index up to date, on which picking and all other queries draw too.
    pub fn index(&self) -> &Times {
        &self.index
    }

    pub fn forget(&mut self) {
        *self = default();
    }

    fn lap(&mut self) -> f32 {
        let ms = self
            .started
            .map_or(0.0, |started| started.elapsed().as_secs_f32() * 1e3);
        self.started = Some(Instant::now());
        ms
    }
}

/// Looks at the watch before and after the systems that decide what is visible, of both methods, and of the index between
/// them.
pub fn plugin(app: &mut App) {
    app.init_resource::<Stopwatch>().add_systems(
        PostUpdate,
        (
            begin
                .after(TransformSystems::Propagate)
                .after(VisibilitySystems::CalculateBounds)
                .after(VisibilitySystems::UpdateFrusta)
                .before(VisibilitySystems::VisibilityPropagate),
            end_of_reset
                .after(VisibilitySystems::VisibilityPropagate)
                .before(SpatialIndexSystems::Sync),
            end_of_index
                .after(SpatialIndexSystems::Optimize)
                .before(ViewCullingSystems::Find)
                .before(VisibilitySystems::CheckVisibility),
            end.after(VisibilitySystems::MarkNewlyHiddenEntitiesInvisible),
        ),
    );
}

fn begin(mut watch: ResMut<Stopwatch>) {
    watch.started = Some(Instant::now());
}

fn end_of_reset(mut watch: ResMut<Stopwatch>) {
    watch.culling = watch.lap();
}

fn end_of_index(mut watch: ResMut<Stopwatch>) {
    watch.indexing = watch.lap();
}

fn end(mut watch: ResMut<Stopwatch>, settings: Res<ViewCullingSettings>) {
    let (culling, indexing) = (watch.culling + watch.lap(), watch.indexing);
    watch.index.add(indexing);
    if settings.enabled {
        watch.sightline.add(culling);
    } else {
        watch.bevy.add(culling);
    }
}
