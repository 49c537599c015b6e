//! What lights with shadows see: a sun with four cascades, and in front of the camera eight lamps and eight spots.
//!
//! The time is that from when cameras are done to the end of the stage.

use std::{cell::RefCell, time::Duration};

use bevy::{
    camera::visibility::{CascadesVisibleEntities, CubemapVisibleEntities, VisibleMeshEntities},
    gizmos::GizmoPlugin,
    light::{CascadeShadowConfigBuilder, LightPlugin},
    prelude::*,
};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{
    PEER,
    scene::{Scene, point},
    set_up_threads,
    side::{Kind, Side},
};
use crate::{
    Effort,
    compare::{compare, median_ns},
};

/// So many of those that shine from a place.
const EACH: usize = 8;

pub(crate) fn run(effort: Effort) {
    set_up_threads("lights");
    let sizes: &[(&str, usize, usize)] = match effort {
        Effort::Quick => &[("10k", 10_000, 40)],
        Effort::Full => &[("10k", 10_000, 120), ("100k", 100_000, 40)],
    };
    for &(name, n, frames) in sizes {
        let scene = Scene::new(n);
        let mut sides = [Kind::Ours, Kind::Bevys].map(|kind| Lit::new(kind, &scene));
        for (motion, moving) in [("static", false), ("moving", true)] {
            let case = format!("lights/{name}-{motion}");
            let syncs = RefCell::new(Vec::new());
            let frame = |side: &mut Lit, frame: usize| {
                if moving {
                    side.side.move_all(&scene, frame);
                    side.move_lights(frame);
                }
                let times = side.side.frame();
                syncs.borrow_mut().extend((!times.sync.is_zero()).then_some(times.sync));
                let counted = if moving { times.sync } else { Duration::ZERO };
                (times.lights + counted, side.seen())
            };
            compare(
                &case,
                PEER,
                frames,
                &mut sides,
                |[ours, _], index| frame(ours, index),
                |[_, bevys], index| frame(bevys, index),
                |ours, bevys| (usize::from(ours != bevys), 1),
            );
            let counted = if moving { "included" } else { "besides" };
            println!(
                "# {case}: the index took {} ns, {counted}",
                median_ns(syncs.into_inner())
            );
        }
    }
}

/// A side with lights in front of its camera.
struct Lit {
    side: Side,
    lights: Vec<(Entity, Transform)>,
}

impl Lit {
    fn new(kind: Kind, scene: &Scene) -> Self {
        let mut side = Side::new(kind, scene, |app| _ = app.add_plugins((GizmoPlugin, LightPlugin)));
        let mut rng = ChaCha8Rng::seed_from_u64(8);
        let mut lights = Vec::new();
        let world = side.app.world_mut();
        let sun = DirectionalLight {
            shadow_maps_enabled: true,
            ..default()
        };
        let cascades = CascadeShadowConfigBuilder {
            num_cascades: 4,
            maximum_distance: scene.side / 2.0,
            ..default()
        };
        let down = Transform::IDENTITY.looking_to(Vec3::new(0.3, -1.0, 0.2), Vec3::Y);
        lights.push((world.spawn((sun, cascades.build(), down)).id(), down));
        for _ in 0..EACH {
            // Within what the camera sees, which is wider than the places are.
            let mut place = || {
                let depth = rng.random_range(0.1..0.4) * scene.side;
                let aside = point(&mut rng) * 0.7 * depth;
                Transform::from_translation(aside.with_z(-depth)).looking_to(point(&mut rng), Vec3::Y)
            };
            let (lamp, spot) = (place(), place());
            let point_light = PointLight {
                shadow_maps_enabled: true,
                range: scene.side / 8.0,
                ..default()
            };
            let spot_light = SpotLight {
                shadow_maps_enabled: true,
                range: scene.side / 4.0,
                ..default()
            };
            lights.push((world.spawn((point_light, lamp)).id(), lamp));
            lights.push((world.spawn((spot_light, spot)).id(), spot));
        }
        // What would propagate it has been taken out of the schedule.
        for (light, _) in &lights {
            world.entity_mut(*light).insert(InheritedVisibility::VISIBLE);
        }
        for _ in 0..2 {
            side.app.update();
        }
        Self { side, lights }
    }

    /// Turns all lights by a degree a frame, and moves those that have a place.
    fn move_lights(&mut self, frame: usize) {
        let angle = (frame as f32).to_radians();
        for &(light, start) in &self.lights {
            let mut place = self.side.app.world_mut().get_mut::<Transform>(light).expect("a light");
            place.rotation = Quat::from_rotation_y(angle) * start.rotation;
            place.translation = start.translation + 3.0 * Vec3::new(angle.sin(), 0.0, angle.cos());
        }
    }

    /// All lists of all lights, by the numbers in the scene.
    fn seen(&self) -> Vec<Vec<u32>> {
        let world = self.side.app.world();
        let mut seen = Vec::new();
        for &(light, _) in &self.lights {
            let light = world.entity(light);
            if let Some(cascades) = light.get::<CascadesVisibleEntities>() {
                seen.extend(cascades.entities.values().flatten().cloned());
            }
            if let Some(faces) = light.get::<CubemapVisibleEntities>() {
                seen.extend(faces.iter().cloned());
            }
            seen.extend(light.get::<VisibleMeshEntities>().cloned());
        }
        assert_eq!(
            seen.len(),
            4 + EACH * 7,
            "four cascades, and of each pair six faces and a cone"
        );
        seen.iter()
            .map(|list| self.side.numbers(&list.entities).collect())
            .collect()
    }
}
