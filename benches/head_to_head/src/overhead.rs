//! What the tools for debugging cost while nobody looks: whole frames with and without them.
//!
//! Both sides are the same app with all other plugins, an app of its own with the same world: one camera, and one
//! thing in a hundred moves in each frame. *Ours* has [`SightlineGizmosPlugin`] with everything switched off,
//! [`SightlineDiagnosticsPlugin`], and with the feature `inspector` the panel, closed, with the egui that it brings; the *peer* has none of them. So
//! the ratio is the frame without over the frame with them, and 0.98 is an overhead of 2%. Where both are equal, it is
//! 1.00.

use std::{f32::consts::TAU, time::Duration};

use bevy::{diagnostic::DiagnosticsPlugin, gizmos::GizmoPlugin, light::LightPlugin, prelude::*};
use bevy_sightline::prelude::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{
    Effort,
    compare::{compare, time},
    headless,
};

const PEER: &str = "without";

/// One of so many things moves in a frame.
const MOVING: usize = 100;

struct Side {
    app: App,
    camera: Entity,
    things: Vec<Entity>,
}

pub(crate) fn run(effort: Effort) {
    let sizes: &[(&str, usize, usize)] = match effort {
        Effort::Quick => &[("1k", 1_000, 400), ("10k", 10_000, 400)],
        Effort::Full => &[("10k", 10_000, 4_000), ("100k", 100_000, 2_000)],
    };
    for &(name, n, frames) in sizes {
        let mut sides = [true, false].map(|debugs| Side::new(debugs, n));
        compare(
            &format!("overhead/{name}"),
            PEER,
            frames,
            &mut sides,
            |[with, _], index| with.frame(index),
            |[_, without], index| without.frame(index),
            |with, without| (usize::from(with != without), 1),
        );
    }
}

impl Side {
    /// Unit cubes in a cube around the camera, so that their density does not depend on their number.
    fn new(debugs: bool, n: usize) -> Self {
        let mut app = headless::app();
        // Bevy's own of both are on both sides.
        app.add_plugins((DiagnosticsPlugin, GizmoPlugin, LightPlugin));
        #[cfg(feature = "inspector")]
        app.add_plugins(renderer_without_gpu());
        if debugs {
            app.add_plugins((SightlinePlugins, SightlineDiagnosticsPlugin));
            #[cfg(feature = "inspector")]
            app.add_plugins(SightlineInspectorPlugin);
        } else {
            app.add_plugins(SightlinePlugins.build().disable::<SightlineGizmosPlugin>());
        }
        app.finish();
        app.cleanup();
        let cube = app.world_mut().resource_mut::<Assets<Mesh>>().add(Cuboid::default());
        let mut rng = ChaCha8Rng::seed_from_u64(n as u64);
        let side = 4.0 * (n as f32).cbrt();
        let things = (0..n).map(|_| {
            let place = Vec3::from_array(std::array::from_fn(|_| rng.random_range(-side..side) / 2.0));
            let turn = Quat::from_rotation_y(rng.random_range(0.0..TAU));
            let place = Transform::from_translation(place).with_rotation(turn);
            app.world_mut().spawn((Mesh3d(cube.clone()), place)).id()
        });
        let things = things.collect();
        let camera = app.world_mut().spawn(Camera3d::default()).id();
        Self { app, camera, things }
    }

    /// Runs a frame; returns what it took, and how much the camera sees.
    fn frame(&mut self, index: usize) -> (Duration, usize) {
        let world = self.app.world_mut();
        for &thing in self.things.iter().skip(index % MOVING).step_by(MOVING) {
            let mut place = world.get_mut::<Transform>(thing).expect("a thing");
            place.translation.y += if (index / MOVING).is_multiple_of(2) {
                0.05
            } else {
                -0.05
            };
        }
        let (took, ()) = time(|| self.app.update());
        let set = self.app.world().get::<VisibleSet>(self.camera).expect("a camera");
        (took, set.entities().len())
    }
}

/// What the panel would be drawn by, if there were a GPU.
#[cfg(feature = "inspector")]
fn renderer_without_gpu() -> bevy::render::RenderPlugin {
    let settings = bevy::render::settings::WgpuSettings {
        backends: None,
        ..default()
    };
    bevy::render::RenderPlugin {
        render_creation: settings.into(),
        ..default()
    }
}
