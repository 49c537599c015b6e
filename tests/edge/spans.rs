//! What traces show.

use std::{
    collections::BTreeSet,
    sync::{Arc, Mutex},
};

use bevy::{ecs::schedule::SingleThreadedExecutor, gizmos::GizmoPlugin, light::LightPlugin, prelude::*};
use bevy_sightline::prelude::*;
use tracing::{
    Event, Level, Metadata, Subscriber,
    span::{Attributes, Id, Record},
};

use crate::common::*;

/// Notes the names of all spans of this crate that are entered, up to a level.
#[derive(Clone)]
struct Names {
    level: Level,
    of_spans: Arc<Mutex<Vec<&'static str>>>,
    entered: Arc<Mutex<BTreeSet<&'static str>>>,
}

impl Names {
    fn new(level: Level) -> Self {
        Self {
            level,
            of_spans: Arc::default(),
            entered: Arc::default(),
        }
    }

    /// The spans of frames in which there is something to do: a cube comes into view, and goes.
    fn of_frames(self) -> BTreeSet<&'static str> {
        let mut app = app();
        let cube = spawn_cube(&mut app, Vec3::NEG_Z * 10.0);
        tracing::subscriber::with_default(self.clone(), || {
            app.update();
            app.world_mut().entity_mut(cube).insert(Visibility::Hidden);
            app.update();
        });
        self.entered.lock().expect("nobody panicked").clone()
    }
}

impl Subscriber for Names {
    fn enabled(&self, metadata: &Metadata) -> bool {
        metadata.is_span() && metadata.target().starts_with("bevy_sightline") && *metadata.level() <= self.level
    }

    fn new_span(&self, span: &Attributes) -> Id {
        let mut names = self.of_spans.lock().expect("nobody panicked");
        names.push(span.metadata().name());
        Id::from_u64(names.len() as u64)
    }

    fn enter(&self, span: &Id) {
        let names = self.of_spans.lock().expect("nobody panicked");
        let name = names[span.into_u64() as usize - 1];
        self.entered.lock().expect("nobody panicked").insert(name);
    }

    fn exit(&self, _: &Id) {}
    fn record(&self, _: &Id, _: &Record) {}
    fn record_follows_from(&self, _: &Id, _: &Id) {}
    fn event(&self, _: &Event) {}
}

/// An app whose systems run in the thread of the test, with a camera and a light.
fn app() -> App {
    let mut app = headless_app_with(|app| {
        #[cfg(feature = "sprite")]
        app.add_plugins((
            bevy::image::TextureAtlasPlugin,
            bevy::text::TextPlugin,
            bevy::sprite::SpritePlugin,
        ));
        app.add_plugins((GizmoPlugin, LightPlugin));
    });
    app.edit_schedule(PreUpdate, |schedule| {
        schedule.set_executor(SingleThreadedExecutor::new());
    })
    .edit_schedule(PostUpdate, |schedule| {
        schedule.set_executor(SingleThreadedExecutor::new());
    });
    app.world_mut().spawn(Camera3d::default());
    app.world_mut().spawn(SpotLight::default());
    let mut store = app.world_mut().resource_mut::<GizmoConfigStore>();
    store.config_mut::<SightlineGizmos>().1.leaves = true;
    app
}

#[test]
fn every_phase_is_a_span() {
    let mut expected = BTreeSet::from([
        "sightline/index/meshes",
        "sightline/index/sync",
        "sightline/index/find",
        "sightline/index/posing",
        "sightline/index/structures",
        "sightline/index/optimize",
        "sightline/lod/follow",
        "sightline/lod/choose",
        "sightline/occlusion/follow",
        "sightline/culling/find",
        "sightline/culling/write",
        "sightline/culling/lights",
        "sightline/culling/hide",
        "sightline/picking/backend",
        "sightline/gizmos/draw",
    ]);
    if cfg!(feature = "sprite") {
        expected.insert("sightline/sprite/follow");
    }
    if cfg!(feature = "simplify") {
        expected.insert("sightline/simplify/make");
    }
    assert_eq!(Names::new(Level::DEBUG).of_frames(), expected);
}

#[test]
fn at_the_level_of_bevys_log_plugin_there_are_none() {
    assert_eq!(Names::new(Level::INFO).of_frames(), BTreeSet::new());
}
