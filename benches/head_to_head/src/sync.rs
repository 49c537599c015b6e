//! Keeping the structures in step with a world of which a part moves each frame.
//!
//! Each side has a world of its own with the same boxes, and is timed for the stage alone, not for the frame around it:
//!
//! - ours from `Sync` to the end of `Optimize`, by its `SyncStats`: finding what has moved, the tree, its upkeep;
//! - avian3d by its `ColliderTreeDiagnostics`: bounding boxes, trees, their upkeep, which is set to be done in the frame
//!   rather than beside the rest of the physics, so that it is counted. What moves is kinematic and the rest static, and
//!   moves by its `Position`, so that no transform has to be propagated first. Avian leaves its tree as it is while a
//!   box stays within a margin;
//! - the method of `bevy_spatial` (0.11, for Bevy 0.16): a system that collects the places of all entities and builds
//!   a k-d tree of them each frame, on all threads, with the crate and the function that it uses. It knows points alone.

use std::time::Duration;

use avian3d::{
    collider_tree::{ColliderTreeDiagnostics, ColliderTreeOptimization},
    prelude::{Collider, ColliderAabb, PhysicsPlugins, Position, RigidBody},
};
use bevy::{ecs::system::SystemId, prelude::*, time::TimeUpdateStrategy};
use bevy_sightline::{index::SyncStats, prelude::*};
use kd_tree::{KdPoint, KdTree};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{
    Effort,
    compare::{compare, time},
    headless,
};

/// How many entities are compared in each frame.
const SAMPLES: usize = 64;

pub(crate) fn run(effort: Effort) {
    let sizes: &[(&str, usize, usize)] = match effort {
        Effort::Quick => &[("10k", 10_000, 60)],
        Effort::Full => &[("100k", 100_000, 60), ("1M", 1_000_000, 15)],
    };
    for &(name, n, frames) in sizes {
        for percent in [0, 1, 10, 100] {
            let scene = Scene::new(n, percent);
            let ours = Ours::new(&scene);
            let case = format!("sync/{percent}%-{name}");
            compare(
                &case,
                "avian3d 0.7.0",
                frames,
                &mut (ours, Avian::new(&scene)),
                |(ours, _), _| ours.frame(&scene),
                |(_, avian), _| avian.frame(&scene),
                |ours, peer| differences(ours, peer),
            );
            compare(
                &format!("{case}-kd-rebuild"),
                "kd-tree 0.6.2, as bevy_spatial 0.11.0 uses it",
                frames,
                &mut (Ours::new(&scene), Rebuilt::new(&scene)),
                |(ours, _), _| ours.frame(&scene),
                |(_, rebuilt), _| rebuilt.frame(&scene),
                |ours, peer| differences(ours, peer),
            );
        }
    }
}

/// How many of the sampled places differ.
fn differences(ours: &[Vec3], peer: &[Vec3]) -> (usize, usize) {
    let differ = ours.iter().zip(peer).filter(|(a, b)| !a.abs_diff_eq(**b, 1e-2));
    (differ.count(), ours.len())
}

/// Entities are spawned so many a frame: avian3d inserts them one by one into a tree that is balanced once a frame.
const BATCH: usize = 10_000;

/// Unit boxes in a cube, so that their density does not depend on their number.
struct Scene {
    places: Vec<Vec3>,
    moves: Vec<bool>,
}

impl Scene {
    fn new(n: usize, percent: u32) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(n as u64);
        let side = 4.0 * (n as f32).cbrt();
        let mut coordinate = || rng.random_range(-0.5..0.5) * side;
        let places = (0..n)
            .map(|_| Vec3::new(coordinate(), coordinate(), coordinate()))
            .collect();
        let moves = (0..n).map(|_| rng.random_range(0..100) < percent).collect();
        Self { places, moves }
    }

    fn len(&self) -> usize {
        self.places.len()
    }

    /// Where a box is in a frame: those that move do so by some 5 cm a frame, along wide curves.
    fn place(&self, index: usize, frame: u32) -> Vec3 {
        if !self.moves[index] {
            return self.places[index];
        }
        let phase = index as f32 + 0.01 * frame as f32;
        self.places[index] + 5.0 * Vec3::new(phase.sin(), (1.3 * phase).cos(), (0.7 * phase).sin())
    }

    /// What both sides are asked for.
    fn samples(&self) -> impl Iterator<Item = usize> + use<> {
        (0..self.len()).step_by(self.len() / SAMPLES)
    }
}

/// The number of an entity in the scene, for those that move.
#[derive(Component)]
struct Mover(usize);

/// A world with the plugins that every side needs, and the number of frames that it has seen.
struct Side {
    app: App,
    entities: Vec<Entity>,
    frame: u32,
}

impl Side {
    fn new<B: Bundle>(
        scene: &Scene,
        add_plugins: impl FnOnce(&mut App),
        mut bundle: impl FnMut(&mut App, usize) -> B,
    ) -> Self {
        let mut app = headless::app();
        app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(16)));
        add_plugins(&mut app);
        app.finish();
        app.cleanup();
        let mut entities = Vec::with_capacity(scene.len());
        for index in 0..scene.len() {
            let bundle = bundle(&mut app, index);
            let mut entity = app.world_mut().spawn(bundle);
            if scene.moves[index] {
                entity.insert(Mover(index));
            }
            entities.push(entity.id());
            if entities.len() % BATCH == 0 {
                app.update();
            }
        }
        for _ in 0..3 {
            app.update();
        }
        Self {
            app,
            entities,
            frame: 0,
        }
    }

    /// Moves what moves, and runs a frame.
    fn frame<C: Component<Mutability = bevy::ecs::component::Mutable>>(
        &mut self,
        scene: &Scene,
        set: impl Fn(&mut C, Vec3),
    ) {
        self.frame += 1;
        let world = self.app.world_mut();
        let mut movers = world.query::<(&Mover, &mut C)>();
        for (mover, mut place) in movers.iter_mut(world) {
            set(&mut place, scene.place(mover.0, self.frame));
        }
        self.app.update();
    }
}

fn put(transform: &mut Transform, place: Vec3) {
    transform.translation = place;
}

struct Ours(Side);

impl Ours {
    fn new(scene: &Scene) -> Self {
        let mut mesh = None;
        Self(Side::new(
            scene,
            |app| _ = app.add_plugins(SpatialIndexPlugin),
            |app, index| {
                let add = || app.world_mut().resource_mut::<Assets<Mesh>>().add(Cuboid::default());
                let mesh = mesh.get_or_insert_with(add).clone();
                (Mesh3d(mesh), Transform::from_translation(scene.place(index, 0)))
            },
        ))
    }

    fn frame(&mut self, scene: &Scene) -> (Duration, Vec<Vec3>) {
        self.0.frame(scene, put);
        let world = self.0.app.world();
        let (stats, index) = (world.resource::<SyncStats>(), world.resource::<SpatialIndex>());
        let center = |sample: usize| {
            let aabb = index.aabb(self.0.entities[sample]).expect("it is in the index");
            ((aabb.min + aabb.max) / 2.0).into()
        };
        (stats.total + stats.optimize, scene.samples().map(center).collect())
    }
}

struct Avian(Side);

impl Avian {
    fn new(scene: &Scene) -> Self {
        Self(Side::new(
            scene,
            |app| {
                app.add_plugins(PhysicsPlugins::new(PostUpdate))
                    .insert_resource(ColliderTreeOptimization {
                        use_async_tasks: false,
                        ..default()
                    });
            },
            |_, index| {
                let body = if scene.moves[index] {
                    RigidBody::Kinematic
                } else {
                    RigidBody::Static
                };
                let place = scene.place(index, 0);
                (
                    body,
                    Collider::cuboid(1.0, 1.0, 1.0),
                    Transform::from_translation(place),
                    Position(place),
                )
            },
        ))
    }

    fn frame(&mut self, scene: &Scene) -> (Duration, Vec<Vec3>) {
        *self.0.app.world_mut().resource_mut::<ColliderTreeDiagnostics>() = ColliderTreeDiagnostics::default();
        self.0.frame(scene, |position: &mut Position, place| position.0 = place);
        let world = self.0.app.world();
        let stats = world.resource::<ColliderTreeDiagnostics>();
        let center = |sample: usize| {
            let aabb = world.get::<ColliderAabb>(self.0.entities[sample]).expect("a collider");
            aabb.center()
        };
        (stats.update + stats.optimize, scene.samples().map(center).collect())
    }
}

/// A k-d tree that is built anew in each frame.
struct Rebuilt {
    side: Side,
    rebuild: SystemId,
}

#[derive(Resource)]
struct Tree(KdTree<Point>);

/// A place and whose it is, as `bevy_spatial` has it.
#[derive(Clone, Copy)]
#[expect(dead_code, reason = "what a user of the tree asks for")]
struct Point {
    place: [f32; 3],
    entity: Entity,
}

impl KdPoint for Point {
    type Scalar = f32;
    type Dim = typenum::U3;

    fn at(&self, axis: usize) -> f32 {
        self.place[axis]
    }
}

impl Rebuilt {
    fn new(scene: &Scene) -> Self {
        let mut side = Side::new(
            scene,
            |app| _ = app.insert_resource(Tree(KdTree::build_by_ordered_float(Vec::new()))),
            |_, index| Transform::from_translation(scene.place(index, 0)),
        );
        let rebuild = |places: Query<(Entity, Ref<GlobalTransform>)>, mut tree: ResMut<Tree>| {
            let points = places.iter().map(|(entity, place)| Point {
                place: place.translation().into(),
                entity,
            });
            tree.0 = KdTree::par_build_by_ordered_float(points.collect());
        };
        let rebuild = side.app.world_mut().register_system(rebuild);
        Self { side, rebuild }
    }

    fn frame(&mut self, scene: &Scene) -> (Duration, Vec<Vec3>) {
        self.side.frame(scene, put);
        let (duration, result) = time(|| self.side.app.world_mut().run_system(self.rebuild));
        result.expect("the system runs");
        let tree = &self.side.app.world().resource::<Tree>().0;
        let place = |sample: usize| {
            let place = scene.place(sample, self.side.frame);
            let nearest = tree.nearest(&Point {
                place: place.into(),
                entity: self.side.entities[sample],
            });
            Vec3::from(nearest.expect("the tree is not empty").item.place)
        };
        (duration, scene.samples().map(place).collect())
    }
}
