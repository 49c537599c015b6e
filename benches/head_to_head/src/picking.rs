//! Picking: the whole backend system against Bevy's whole backend system, for one pointer.
//!
//! Ours ends a ray at the first entity that blocks what is behind it, as all do here; the answers are compared up to
//! there, which is as far as any pointer event goes. The cases that end in `-all` make ours report all that Bevy's
//! reports, and compare everything.
//!
//! In a turn each side runs for [`TURN`] rays, one run of the system for each: a pointer that moves about. The cases
//! that end in `-cold` give each side one ray a turn, so that ours always runs just after Bevy's has gone through the
//! whole world and has driven everything else out of the caches.

use std::{f32::consts::TAU, time::Duration};

use bevy::{
    ecs::system::SystemId,
    math::Affine2,
    mesh::VertexAttributeValues,
    picking::{
        PickingPlugin,
        backend::{
            PointerHits,
            ray::{RayId, RayMap},
        },
        mesh_picking,
        pointer::PointerId,
    },
    prelude::*,
};
use bevy_sightline::{index::MeshBvhs, picking, prelude::*};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{
    Effort,
    compare::{compare, time},
    headless, sprites,
};

const PEER: &str = "bevy_picking 0.19.1";
/// Rays in a turn.
const TURN: usize = 16;

pub(crate) fn run(effort: Effort) {
    let sizes: &[(&str, usize)] = match effort {
        Effort::Quick => &[("1k", 1_000), ("10k", 10_000)],
        Effort::Full => &[("1k", 1_000), ("10k", 10_000), ("100k", 100_000)],
    };
    for (name, n) in sizes {
        Bench::with_entities(*n).run(&format!("picking/{name}"), 400);
    }
    for (name, n) in &sizes[1..] {
        sprites::run(&format!("picking/sprites-{name}"), *n);
    }
    if effort == Effort::Full {
        Bench::with_one_mesh().run("picking/one-mesh-1M", 100);
    }
}

/// What was picked, with its depth.
type Picks = Vec<(Entity, f32)>;

/// A world that both backends look at, and the rays of a pointer through it.
struct Bench {
    app: App,
    ours: SystemId,
    peer: SystemId,
    ray_id: RayId,
    rays: Vec<Ray3d>,
}

impl Bench {
    /// `n` shapes of several hundred triangles in a cube, so that their density does not depend on their number.
    fn with_entities(n: usize) -> Self {
        let side = 4.0 * (n as f32).cbrt();
        let mut rng = ChaCha8Rng::seed_from_u64(n as u64);
        let mut bench = Self::new(side, &mut rng);
        let shapes: [Mesh; 4] = [
            Sphere::default().mesh().ico(3).expect("few enough triangles"),
            Torus::default().mesh().build(),
            Capsule3d::default().mesh().build(),
            Cuboid::default().mesh().build(),
        ];
        let world = bench.app.world_mut();
        let shapes = shapes.map(|shape| world.resource_mut::<Assets<Mesh>>().add(shape));
        for i in 0..n {
            let mut number = |range: f32| rng.random_range(-range..range);
            let transform = Transform {
                translation: Vec3::new(number(side), number(side), number(side)) / 2.0,
                rotation: Quat::from_euler(EulerRot::XYZ, number(TAU), number(TAU), number(TAU)),
                scale: Vec3::new(number(0.5), number(0.5), number(0.5)) + 1.0,
            };
            world.spawn((Mesh3d(shapes[i % shapes.len()].clone()), transform));
        }
        bench.settle();
        bench
    }

    /// A ball with hills, of a million triangles.
    fn with_one_mesh() -> Self {
        let mut bench = Self::new(20.0, &mut ChaCha8Rng::seed_from_u64(1));
        let mut ball = Sphere::new(10.0).mesh().uv(1000, 501);
        if let Some(VertexAttributeValues::Float32x3(positions)) = ball.attribute_mut(Mesh::ATTRIBUTE_POSITION) {
            for position in positions {
                let p = Vec3::from(*position);
                let hills = Affine2::from_angle(0.5).transform_point2(p.xy() * 1.7).to_array();
                *position = (p * (1.0 + 0.05 * (hills[0].sin() * hills[1].cos() + (2.3 * p.z).sin()))).into();
            }
        }
        let world = bench.app.world_mut();
        let ball = world.resource_mut::<Assets<Mesh>>().add(ball);
        world.spawn(Mesh3d(ball));
        bench.settle();
        bench
    }

    /// An empty world with a camera that sees all of a cube with the given side around the origin.
    fn new(side: f32, rng: &mut ChaCha8Rng) -> Self {
        let mut app = headless::app();
        app.add_plugins((PickingPlugin, SightlinePlugins));
        app.init_resource::<mesh_picking::MeshPickingSettings>();
        app.finish();
        app.cleanup();

        let eye = Vec3::new(0.0, 0.0, 2.5 * side);
        let world = app.world_mut();
        let projection = PerspectiveProjection {
            far: 10.0 * side,
            ..default()
        };
        let camera = world
            .spawn((
                Camera3d::default(),
                Projection::from(projection),
                Transform::from_translation(eye),
            ))
            .id();
        let rays = (0..400).map(|_| {
            let target = Vec3::from_array(std::array::from_fn(|_| rng.random_range(-0.3..0.3) * side));
            Ray3d::new(eye, Dir3::new(target - eye).expect("the eye is outside"))
        });
        Self {
            rays: rays.collect(),
            ray_id: RayId::new(camera, PointerId::Mouse),
            ours: world.register_system(picking::update_hits),
            peer: world.register_system(mesh_picking::update_hits),
            app,
        }
    }

    /// Runs frames until the index knows everything and every hierarchy is built.
    fn settle(&mut self) {
        self.app.update();
        while self.app.world().resource::<MeshBvhs>().building() > 0 {
            self.app.update();
        }
        self.app.update();
    }

    fn run(mut self, case: &str, rays: usize) {
        self.compare(case, rays / TURN, TURN);
        self.compare(&format!("{case}-cold"), rays, 1);
        self.app
            .world_mut()
            .resource_mut::<SpatialPickingSettings>()
            .report_blocked = true;
        self.compare(&format!("{case}-all"), rays / TURN, TURN);
    }

    fn compare(&mut self, case: &str, turns: usize, rays_per_turn: usize) {
        let (ours, peer) = (self.ours, self.peer);
        let side =
            |backend| move |bench: &mut Self, turn| bench.pick_in_turn(backend, turn * rays_per_turn, rays_per_turn);
        let all = self.app.world().resource::<SpatialPickingSettings>().report_blocked;
        compare(case, PEER, turns, self, side(ours), side(peer), |ours, peer| {
            let reach = |picks: &Picks| if all { picks.len() } else { picks.len().min(1) };
            let differ = ours
                .iter()
                .zip(peer)
                .filter(|(ours, peer)| !same_picks(ours, &peer[..reach(peer)]));
            (differ.count(), ours.len())
        });
    }

    /// Runs a backend for each ray of a turn, and returns the mean time and the picks of each.
    fn pick_in_turn(&mut self, backend: SystemId, first: usize, rays: usize) -> (Duration, Vec<Picks>) {
        let (times, picks): (Vec<Duration>, Vec<Picks>) =
            (first..first + rays).map(|ray| self.pick(backend, ray)).unzip();
        (times.iter().sum::<Duration>() / rays as u32, picks)
    }

    /// Runs a backend for one ray, and returns its picks.
    fn pick(&mut self, backend: SystemId, ray: usize) -> (Duration, Picks) {
        let world = self.app.world_mut();
        let ray = self.rays[ray % self.rays.len()];
        world.resource_mut::<RayMap>().map.insert(self.ray_id, ray);
        world.resource_mut::<Messages<PointerHits>>().clear();
        let (duration, result) = time(|| world.run_system(backend));
        result.expect("the backend runs");
        let messages = world
            .resource_mut::<Messages<PointerHits>>()
            .drain()
            .collect::<Vec<_>>();
        let picks = messages.iter().flat_map(|hits| &hits.picks);
        (duration, picks.map(|(entity, data)| (*entity, data.depth)).collect())
    }
}

/// The same entities in the same order, at the same depths.
fn same_picks(ours: &[(Entity, f32)], peer: &[(Entity, f32)]) -> bool {
    ours.len() == peer.len()
        && ours
            .iter()
            .zip(peer)
            .all(|(ours, peer)| ours.0 == peer.0 && (ours.1 - peer.1).abs() <= 1e-4 * peer.1)
}
