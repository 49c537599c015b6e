//! Levels of detail against Bevy's `VisibilityRange`: who shows which level of each object, and what finding that out
//! takes in a frame.
//!
//! Ours is what [`LodSystems`] take, Bevy's what `check_visibility_ranges` takes, on as many threads as there are. The
//! systems of both run one after the other, so that no time is counted in which one waits for a thread to run it. What
//! culling then does with the answers is in neither.

use std::{
    f32::consts::FRAC_PI_4,
    time::{Duration, Instant},
};

use bevy::{
    camera::visibility::{VisibilityRange, VisibilitySystems, VisibleEntityRanges, check_visibility_ranges},
    ecs::schedule::SingleThreadedExecutor,
    prelude::*,
};
use bevy_sightline::prelude::*;

use super::{PEER, scene::Scene, set_up_threads, side::Kind};
use crate::{Effort, compare::compare, headless};

/// Where the second level begins, and the third, as fractions of the side of the world.
const BEGINS: [f32; 2] = [0.15, 0.35];

/// Objects are spawned so many a frame.
const BATCH: usize = 100_000;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Motion {
    /// Nothing.
    Still,
    /// The camera, by 10 cm a frame: a car in a town.
    Moving,
    /// The camera, by 1 m a frame: an aircraft.
    Fast,
    /// All objects, and the camera stands.
    Objects,
}

const MOTIONS: [(&str, Motion); 4] = [
    ("still", Motion::Still),
    ("moving", Motion::Moving),
    ("fast", Motion::Fast),
    ("moving-objects", Motion::Objects),
];

/// What levels take in a frame.
#[derive(Resource, Default)]
struct Spent {
    since: Option<Instant>,
    total: Duration,
}

struct Side {
    app: App,
    camera: Entity,
    /// Each with its levels.
    objects: Vec<(Entity, [Entity; 3])>,
    levels: Vec<u8>,
}

pub(crate) fn run(effort: Effort) {
    set_up_threads("lod");
    let sizes: &[(&str, usize, usize)] = match effort {
        Effort::Quick => &[("1k", 1_000, 60), ("10k", 10_000, 60)],
        Effort::Full => &[
            ("1k", 1_000, 240),
            ("10k", 10_000, 240),
            ("100k", 100_000, 120),
            ("300k", 300_000, 40),
        ],
    };
    for &(name, n, frames) in sizes {
        let scene = Scene::new(n);
        let mut sides = [Kind::Ours, Kind::Bevys].map(|kind| Side::new(kind, &scene));
        for (motion_name, motion) in MOTIONS {
            compare(
                &format!("lod/{name}-{motion_name}"),
                PEER,
                frames,
                &mut sides,
                |[ours, _], index| ours.frame(Kind::Ours, &scene, motion, index),
                |[_, bevys], index| bevys.frame(Kind::Bevys, &scene, motion, index),
                |ours, bevys| {
                    let different = ours.iter().zip(bevys).filter(|(ours, bevys)| ours != bevys);
                    (different.count(), ours.len())
                },
            );
        }
    }
}

impl Side {
    fn new(kind: Kind, scene: &Scene) -> Self {
        let mut app = headless::app();
        if kind == Kind::Ours {
            app.add_plugins(ProxyLodPlugin);
            // As Bevy has it.
            app.world_mut().resource_mut::<LodSettings>().hysteresis = 0.0;
        }
        add_marks(&mut app, kind);
        app.edit_schedule(PostUpdate, |schedule| {
            schedule.set_executor(SingleThreadedExecutor::new());
        });
        app.finish();
        app.cleanup();
        let cube = app.world_mut().resource_mut::<Assets<Mesh>>().add(Cuboid::default());
        let camera = app.world_mut().spawn((Camera3d::default(), scene.projection())).id();
        let begins = BEGINS.map(|begin| begin * scene.side);
        let mut objects = Vec::with_capacity(scene.places.len());
        for (number, &place) in scene.places.iter().enumerate() {
            let world = app.world_mut();
            let root = world.spawn((place, Visibility::default())).id();
            let ends = [(0.0, begins[0]), (begins[0], begins[1]), (begins[1], f32::INFINITY)];
            let levels = ends.map(|(begin, end)| {
                let mut level = world.spawn((Mesh3d(cube.clone()), ChildOf(root)));
                if kind == Kind::Bevys {
                    level.insert(VisibilityRange::abrupt(begin, end));
                }
                level.id()
            });
            if kind == Kind::Ours {
                let lod = ProxyLod::new(LodMetric::Distance, levels[0])
                    .then(begins[0], levels[1])
                    .then(begins[1], levels[2])
                    .measured_to(LodReference::Center);
                world.entity_mut(root).insert(lod);
            }
            objects.push((root, levels));
            if number % BATCH == BATCH - 1 {
                app.update();
            }
        }
        for _ in 0..3 {
            app.update();
        }
        Self {
            app,
            camera,
            levels: vec![0; objects.len()],
            objects,
        }
    }

    /// Runs a frame; returns what levels took, and which is shown of each object.
    fn frame(&mut self, kind: Kind, scene: &Scene, motion: Motion, index: usize) -> (Duration, Vec<u8>) {
        let world = self.app.world_mut();
        let speed = match motion {
            Motion::Still | Motion::Objects => 0.0,
            Motion::Moving => 0.1,
            Motion::Fast => 1.0,
        };
        // There and back, through the middle.
        let way = (index as f32 * speed).rem_euclid(scene.side) - scene.side / 2.0;
        let way = if speed == 0.0 { 0.0 } else { way };
        let place = Transform::from_xyz(way, 0.3 * way, 0.1).with_rotation(Quat::from_rotation_y(FRAC_PI_4));
        world
            .get_mut::<Transform>(self.camera)
            .expect("a camera")
            .set_if_neq(place);
        if motion == Motion::Objects {
            for (number, &(root, _)) in self.objects.iter().enumerate() {
                let mut place = world.get_mut::<Transform>(root).expect("an object");
                place.translation = scene.place(number, index);
            }
        }
        world.insert_resource(Spent::default());
        self.app.update();

        let world = self.app.world();
        let shown = self.objects.iter().map(|(root, levels)| match kind {
            Kind::Ours => {
                let choices = world.resource::<LodChoices>();
                choices.level(*root, self.camera).expect("a group") as u8
            }
            Kind::Bevys => {
                let ranges = world.resource::<VisibleEntityRanges>();
                let is_shown = |&level: &Entity| ranges.entity_is_in_range_of_view(level, self.camera);
                levels.iter().position(is_shown).expect("one is in range") as u8
            }
        });
        self.levels.clear();
        self.levels.extend(shown);
        (world.resource::<Spent>().total, self.levels.clone())
    }
}

/// Takes the time around the systems.
fn add_marks(app: &mut App, kind: Kind) {
    fn begin(mut spent: ResMut<Spent>) {
        spent.since = Some(Instant::now());
    }
    fn end(mut spent: ResMut<Spent>) {
        if let Some(since) = spent.since.take() {
            spent.total += since.elapsed();
        }
    }
    app.init_resource::<Spent>();
    match kind {
        Kind::Ours => app.add_systems(
            PostUpdate,
            (
                begin.after(TransformSystems::Propagate).before(LodSystems::Follow),
                end.after(LodSystems::Follow)
                    .before(VisibilitySystems::CalculateBounds)
                    .before(SpatialIndexSystems::Sync),
                begin.after(SpatialIndexSystems::Sync).before(LodSystems::Choose),
                end.after(LodSystems::Choose).before(VisibilitySystems::CheckVisibility),
            ),
        ),
        Kind::Bevys => app.add_systems(
            PostUpdate,
            (
                begin.after(TransformSystems::Propagate).before(check_visibility_ranges),
                end.after(check_visibility_ranges),
            ),
        ),
    };
}
