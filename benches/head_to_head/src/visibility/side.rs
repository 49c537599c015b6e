//! An app that is timed at fixed points of its `PostUpdate`.

use std::{
    any::TypeId,
    time::{Duration, Instant},
};

use bevy::{
    app::MainScheduleOrder,
    asset::AssetEventSystems,
    camera::visibility::{
        VisibilityPlugin, VisibilitySystems, VisibleEntities, calculate_bounds, check_visibility_cpu_culling,
    },
    ecs::schedule::{InternedSystemSet, IntoSystemSet, ScheduleCleanupPolicy, ScheduleLabel, SystemSet},
    light::SimulationLightSystems,
    prelude::*,
    transform::TransformSystems,
};
use bevy_sightline::{index::SyncStats, prelude::*};

use super::scene::Scene;
use crate::headless;

/// Entities are spawned so many a frame.
const BATCH: usize = 100_000;

/// Which of the two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Ours,
    Bevys,
}

/// When the parts of a stage began and ended.
#[derive(Resource, Clone, Copy)]
struct Marks {
    begin: Instant,
    views_done: Instant,
    end: Instant,
}

/// Runs after `PostUpdate`, whatever has been added to that.
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Measured;

/// What the stages of a frame took.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Times {
    /// All of them.
    pub(super) whole: Duration,
    /// From when views are done: the lights, and the marking of what nobody saw.
    pub(super) lights: Duration,
    /// The index, which is in `whole`.
    pub(super) sync: Duration,
}

/// The number of an entity in the scene.
#[derive(Component)]
pub(super) struct Number(pub(super) usize);

/// An app with a scene and a camera in its middle.
pub(super) struct Side {
    pub(super) app: App,
    pub(super) camera: Entity,
    /// The numbers in the scene, by the indices of entities.
    numbers: Vec<u32>,
}

impl Side {
    pub(super) fn new(kind: Kind, scene: &Scene, add_plugins: impl FnOnce(&mut App)) -> Self {
        let mut app = headless::app();
        add_plugins(&mut app);
        if kind == Kind::Ours {
            app.add_plugins(ViewCullingPlugin);
        }
        add_marks(&mut app);
        app.finish();
        app.cleanup();

        let world = app.world_mut();
        let cube = world.resource_mut::<Assets<Mesh>>().add(Cuboid::default());
        let camera = world.spawn((Camera3d::default(), scene.projection())).id();
        let mut numbers = Vec::new();
        for (number, &place) in scene.places.iter().enumerate() {
            let entity = app.world_mut().spawn((Mesh3d(cube.clone()), place, Number(number)));
            let index = entity.id().index_u32() as usize;
            numbers.resize(numbers.len().max(index + 1), u32::MAX);
            numbers[index] = number as u32;
            if number % BATCH == BATCH - 1 {
                app.update();
            }
        }
        for _ in 0..3 {
            app.update();
        }
        let removed = app.remove_systems_in_set(PostUpdate, propagation(), ScheduleCleanupPolicy::RemoveSystemsOnly);
        assert_eq!(removed.expect("it is in the schedule"), 1);
        app.update();
        Self { app, camera, numbers }
    }

    /// Runs a frame.
    pub(super) fn frame(&mut self) -> Times {
        self.app.update();
        let world = self.app.world();
        let marks = world.resource::<Marks>();
        let stats = world.get_resource::<SyncStats>();
        Times {
            whole: marks.end - marks.begin,
            lights: marks.end - marks.views_done,
            sync: stats.map_or(Duration::ZERO, |stats| stats.total + stats.optimize),
        }
    }

    /// Turns the camera, and puts it elsewhere.
    pub(super) fn place_camera(&mut self, place: Transform) {
        let mut camera = self.app.world_mut().get_mut::<Transform>(self.camera);
        camera.as_mut().expect("a camera").set_if_neq(place);
    }

    /// Moves everything to where it is in a frame.
    pub(super) fn move_all(&mut self, scene: &Scene, frame: usize) {
        let world = self.app.world_mut();
        let mut things = world.query::<(&Number, &mut Transform)>();
        for (number, mut place) in things.iter_mut(world) {
            place.translation = scene.place(number.0, frame);
        }
    }

    /// What the camera sees, by the numbers in the scene.
    pub(super) fn seen(&self) -> Vec<u32> {
        let seen = self.app.world().get::<VisibleEntities>(self.camera).expect("a camera");
        self.numbers(seen.get(TypeId::of::<Mesh3d>())).collect()
    }

    /// The numbers of entities in the scene.
    pub(super) fn numbers(&self, entities: &[Entity]) -> impl Iterator<Item = u32> {
        let number = |entity: &Entity| self.numbers[entity.index_u32() as usize];
        entities.iter().map(number)
    }
}

/// Takes the time at fixed points.
fn add_marks(app: &mut App) {
    let now = Instant::now();
    app.insert_resource(Marks {
        begin: now,
        views_done: now,
        end: now,
    });
    let begin = |world: &mut World| world.resource_mut::<Marks>().begin = Instant::now();
    let views_done = |world: &mut World| world.resource_mut::<Marks>().views_done = Instant::now();
    let end = |world: &mut World| world.resource_mut::<Marks>().end = Instant::now();
    app.add_systems(
        PostUpdate,
        (
            begin
                .after(TransformSystems::Propagate)
                .after(AssetEventSystems)
                .after(SimulationLightSystems::UpdateDirectionalLightCascades)
                .after(VisibilitySystems::CalculateBounds)
                .after(VisibilitySystems::UpdateFrusta)
                .before(VisibilitySystems::VisibilityPropagate)
                .before(SpatialIndexSystems::Sync),
            views_done
                .after(VisibilitySystems::CheckVisibility)
                .after(SimulationLightSystems::UpdateLightFrusta)
                .before(SimulationLightSystems::CheckLightVisibility)
                .before(VisibilitySystems::MarkNewlyHiddenEntitiesInvisible),
        ),
    );
    app.init_schedule(Measured).add_systems(Measured, end);
    app.world_mut()
        .resource_mut::<MainScheduleOrder>()
        .insert_after(PostUpdate, Measured);
}

/// The set of nothing but the private system that propagates `Visibility`.
///
/// Names of systems are not to be had without a feature of Bevy's: it is the third that the plugin adds, between two
/// that are known.
fn propagation() -> InternedSystemSet {
    let mut app = App::empty();
    VisibilityPlugin.build(&mut app);
    let schedule = app.get_schedule(PostUpdate).expect("the plugin adds to it");
    let systems = schedule.graph().systems.iter();
    let sets: Vec<_> = systems.map(|(_, system, _)| system.default_system_sets()[0]).collect();
    assert!(
        sets[0] == calculate_bounds.into_system_set().intern()
            && sets[4] == check_visibility_cpu_culling.into_system_set().intern(),
        "Bevy adds other systems"
    );
    sets[2]
}
