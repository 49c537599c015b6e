//! Sprites: the whole picking backend system against Bevy's whole sprite backend, for one pointer, with the alpha test of
//! both. Each runs in a schedule of its own, for Bevy's system is private.

use std::{f32::consts::TAU, time::Duration};

use bevy::{
    camera::NormalizedRenderTarget,
    ecs::schedule::{Schedules, SingleThreadedExecutor},
    image::TextureAtlasPlugin,
    picking::{
        PickingPlugin,
        backend::{
            PointerHits,
            ray::{RayId, RayMap},
        },
        pointer::{Location, PointerId, PointerLocation},
    },
    prelude::*,
    sprite::{SpritePickingPlugin, SpritePlugin},
    window::{PrimaryWindow, WindowRef},
};
use bevy_sightline::{picking, prelude::*};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{
    compare::{compare, time},
    headless,
};

const PEER: &str = "bevy_sprite 0.19.1";
/// Rays in a turn.
const TURN: usize = 16;
/// Where the near plane of a 2D camera is.
const NEAR: f32 = 1000.0;

/// `n` sprites, of which about two lie on each other everywhere.
pub(crate) fn run(case: &str, n: usize) {
    let mut bench = Bench::new(n);
    compare(case, PEER, 25, &mut bench, Bench::ours, Bench::peers, |ours, peers| {
        let differ = ours.iter().zip(peers).filter(|(ours, peer)| ours != peer);
        (differ.count(), ours.len())
    });
}

struct Bench {
    app: App,
    ours: Schedule,
    peers: Schedule,
    ray_id: RayId,
    rays: Vec<Ray3d>,
}

impl Bench {
    fn new(n: usize) -> Self {
        let mut app = headless::app();
        app.add_plugins((TextureAtlasPlugin, PickingPlugin, SpritePlugin, SightlinePlugins));
        app.finish();
        app.cleanup();

        let half = 15.0 * (n as f32).sqrt();
        let rng = &mut ChaCha8Rng::seed_from_u64(n as u64);
        let world = app.world_mut();
        let projection = OrthographicProjection {
            area: Rect::from_center_half_size(Vec2::ZERO, Vec2::splat(half)),
            ..OrthographicProjection::default_2d()
        };
        let camera = world.spawn((Camera2d, Projection::from(projection))).id();
        let mut windows = world.query_filtered::<Entity, With<PrimaryWindow>>();
        let window = windows.single(world).expect("a window");
        let window = WindowRef::Primary.normalize(Some(window)).expect("a window");
        let location = Location {
            target: NormalizedRenderTarget::Window(window),
            position: Vec2::ZERO,
        };
        world.spawn((PointerId::Mouse, PointerLocation::new(location)));

        let image = disc();
        let image = world.resource_mut::<Assets<Image>>().add(image);
        for _ in 0..n {
            let place = Vec3::new(
                rng.random_range(-half..half),
                rng.random_range(-half..half),
                rng.random_range(-100.0..100.0),
            );
            let transform =
                Transform::from_translation(place).with_rotation(Quat::from_rotation_z(rng.random_range(0.0..TAU)));
            let custom_size = Some(Vec2::new(rng.random_range(30.0..60.0), rng.random_range(30.0..60.0)));
            let sprite = Sprite {
                custom_size,
                ..Sprite::from_image(image.clone())
            };
            world.spawn((sprite, transform, Pickable::default()));
        }
        let rays = (0..TURN * 25).map(|_| {
            let [x, y] = std::array::from_fn(|_| rng.random_range(-0.9..0.9) * half);
            Ray3d::new(Vec3::new(x, y, NEAR), Dir3::NEG_Z)
        });
        let rays = rays.collect();
        for _ in 0..3 {
            app.update();
        }

        let mut ours = Schedule::new(Update);
        ours.add_systems(picking::update_hits);
        let mut peers = App::empty();
        peers.add_plugins(SpritePickingPlugin);
        let mut schedules = peers.world_mut().resource_mut::<Schedules>();
        let mut peers = schedules.remove(PreUpdate).expect("the plugin has one system");
        for schedule in [&mut ours, &mut peers] {
            schedule.set_executor(SingleThreadedExecutor::new());
        }
        Self {
            app,
            ours,
            peers,
            ray_id: RayId::new(camera, PointerId::Mouse),
            rays,
        }
    }

    fn ours(&mut self, turn: usize) -> (Duration, Vec<Option<Entity>>) {
        Self::turn(
            &mut self.app,
            &mut self.ours,
            self.ray_id,
            &self.rays[turn * TURN..][..TURN],
        )
    }

    fn peers(&mut self, turn: usize) -> (Duration, Vec<Option<Entity>>) {
        Self::turn(
            &mut self.app,
            &mut self.peers,
            self.ray_id,
            &self.rays[turn * TURN..][..TURN],
        )
    }

    /// The mean time for a ray, and what each ray picks first.
    fn turn(app: &mut App, backend: &mut Schedule, id: RayId, rays: &[Ray3d]) -> (Duration, Vec<Option<Entity>>) {
        let world = app.world_mut();
        let (times, picks): (Vec<Duration>, Vec<_>) = (rays.iter())
            .map(|ray| {
                world.resource_mut::<RayMap>().map.insert(id, *ray);
                world.resource_mut::<Messages<PointerHits>>().clear();
                let (duration, ()) = time(|| backend.run(world));
                let mut messages = world.resource_mut::<Messages<PointerHits>>();
                let first = messages.drain().flat_map(|hits| hits.picks).next();
                (duration, first.map(|(entity, _)| entity))
            })
            .unzip();
        (times.iter().sum::<Duration>() / rays.len() as u32, picks)
    }
}

/// A disc in a square of 64 by 64 pixels.
fn disc() -> Image {
    let mut image = Image::default();
    image.texture_descriptor.size.width = 64;
    image.texture_descriptor.size.height = 64;
    let alpha = |x: i32, y: i32| if x * x + y * y < 32 * 32 { 255 } else { 0 };
    let pixels = (-32..32).flat_map(|y| (-32..32).map(move |x| [255, 255, 255, alpha(x, y)]));
    image.data = Some(pixels.flatten().collect());
    image
}
