//! Levels that fade into each other: both are shown, as the renderer's dithering has it, and then one.

use std::time::Duration;

use bevy::{camera::visibility::VisibilityRange, prelude::*, time::TimeUpdateStrategy};
use bevy_sightline::prelude::*;

use crate::common::{add_mesh, headless_app};

/// Half a second, in frames of a tenth of one.
const FADE: Duration = Duration::from_millis(500);

struct Scene {
    app: App,
    camera: Entity,
    levels: [Entity; 2],
}

/// Two levels at the origin, the second from 10 metres on, and a camera at 5.
fn scene() -> Scene {
    let mut app = headless_app();
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(100)));
    app.world_mut().resource_mut::<LodSettings>().cross_fade = FADE;
    let mesh = add_mesh(&mut app, Cuboid::default());
    let world = app.world_mut();
    let levels = [(); 2].map(|()| world.spawn(Mesh3d(mesh.clone())).id());
    let lod = ProxyLod::new(LodMetric::Distance, levels[0])
        .then(10.0, levels[1])
        .measured_to(LodReference::Center);
    let mut root = world.spawn((lod, Transform::default(), Visibility::default()));
    root.add_children(&levels);
    let camera = world
        .spawn((Camera3d::default(), Transform::from_xyz(0.0, 0.0, 5.0)))
        .id();
    let mut scene = Scene { app, camera, levels };
    scene.app.update();
    scene.app.update();
    scene
}

impl Scene {
    fn move_camera_to(&mut self, z: f32) {
        let mut place = self
            .app
            .world_mut()
            .get_mut::<Transform>(self.camera)
            .expect("a camera");
        place.translation.z = z;
        self.app.update();
    }

    /// Which levels the camera sees.
    fn seen(&self) -> [bool; 2] {
        let seen = self.app.world().get::<VisibleSet>(self.camera).expect("a camera");
        self.levels.map(|level| seen.contains(level))
    }

    /// How far each level is dithered by Bevy's shader: 0 is all, and 16 either way nothing.
    fn dithered(&self) -> [Option<i32>; 2] {
        let eye = self
            .app
            .world()
            .get::<GlobalTransform>(self.camera)
            .expect("a camera")
            .translation();
        self.levels.map(|level| {
            let range = self.app.world().get::<VisibilityRange>(level)?;
            let place = self
                .app
                .world()
                .get::<GlobalTransform>(level)
                .expect("a place")
                .translation();
            let distance = eye.distance(place);
            let is_far = distance >= range.end_margin.start;
            let (offset, band) = if is_far {
                (0, &range.end_margin)
            } else {
                (-16, &range.start_margin)
            };
            let step = ((distance - band.start) / (band.end - band.start) * 16.0).round() as i32;
            Some(offset + step.clamp(0, 16))
        })
    }
}

#[test]
fn both_levels_are_seen_as_long_as_they_fade() {
    let mut scene = scene();
    assert_eq!(scene.seen(), [true, false]);
    scene.move_camera_to(20.0);
    for _ in 0..4 {
        assert_eq!(scene.seen(), [true, true]);
        scene.app.update();
    }
    scene.app.update();
    assert_eq!(scene.seen(), [false, true]);
}

#[test]
fn what_one_level_leaves_out_the_other_fills() {
    let mut scene = scene();
    scene.move_camera_to(20.0);
    let mut last = 0;
    for z in [21.0, 25.0, 14.0] {
        let [Some(out), Some(come)] = scene.dithered() else {
            panic!("both have a range");
        };
        assert_eq!(out - come, 16);
        assert!(out > last, "it goes on, wherever the camera goes");
        last = out;
        scene.move_camera_to(z);
    }
}

#[test]
fn nothing_keeps_a_range_that_does_not_fade() {
    let mut scene = scene();
    assert_eq!(scene.dithered(), [None, None]);
    scene.move_camera_to(20.0);
    for _ in 0..6 {
        scene.app.update();
    }
    assert_eq!(scene.dithered(), [None, None]);
}

#[test]
fn a_switch_back_ends_a_fade_and_begins_another() {
    let mut scene = scene();
    scene.move_camera_to(20.0);
    scene.move_camera_to(5.0);
    assert_eq!(scene.seen(), [true, true]);
    for _ in 0..6 {
        scene.app.update();
    }
    assert_eq!(scene.seen(), [true, false]);
    assert_eq!(scene.dithered(), [None, None]);
}

#[test]
fn a_second_camera_ends_all_fades() {
    let mut scene = scene();
    scene.move_camera_to(20.0);
    scene
        .app
        .world_mut()
        .spawn((Camera3d::default(), Transform::from_xyz(0.0, 0.0, 5.0)));
    scene.app.update();
    assert_eq!(scene.seen(), [false, true]);
    assert_eq!(scene.dithered(), [None, None]);
}

#[test]
fn a_group_that_is_taken_apart_while_it_fades_shows_all_that_it_was() {
    let mut scene = scene();
    scene.move_camera_to(20.0);
    let root = scene
        .app
        .world()
        .get::<ChildOf>(scene.levels[0])
        .expect("a root")
        .parent();
    scene.app.world_mut().entity_mut(root).remove::<ProxyLod>();
    scene.app.update();
    scene.app.update();
    assert_eq!(scene.dithered(), [None, None]);
    assert_eq!(scene.seen(), [true, true]);
}

#[test]
fn what_has_a_range_of_its_own_switches_at_once() {
    let mut scene = scene();
    let own = VisibilityRange::abrupt(0.0, 1000.0);
    scene.app.world_mut().entity_mut(scene.levels[0]).insert(own.clone());
    scene.move_camera_to(20.0);
    assert_eq!(scene.seen(), [false, true]);
    assert!(scene.app.world().get::<VisibilityRange>(scene.levels[0]) == Some(&own));
}

#[test]
fn what_joins_a_level_while_it_fades_out_goes_with_it() {
    let mut scene = scene();
    scene.move_camera_to(20.0);
    let mesh = scene
        .app
        .world()
        .get::<Mesh3d>(scene.levels[0])
        .expect("a mesh")
        .clone();
    let late = scene.app.world_mut().spawn((mesh, ChildOf(scene.levels[0]))).id();
    for _ in 0..7 {
        scene.app.update();
    }
    assert_eq!(scene.seen(), [false, true]);
    let seen = scene.app.world().get::<VisibleSet>(scene.camera).expect("a camera");
    assert!(!seen.contains(late));
}
