//! Queries in `FixedUpdate`.

use bevy::{prelude::*, time::TimeUpdateStrategy};
use bevy_sightline::prelude::*;

use crate::common::*;

/// What was hit in each fixed step.
#[derive(Resource, Default)]
struct Hits(Vec<Option<f32>>);

/// An app that casts a ray along -z in each fixed step, and a cube that moves by one along +z in each frame.
fn app() -> App {
    fn cast(scene: SceneQuery, mut hits: ResMut<Hits>) {
        let ray = Ray3d::new(Vec3::Z * 100.0, Dir3::NEG_Z);
        let hit = scene.cast_ray(ray, &SceneQuerySettings::default());
        hits.0.push(hit.map(|hit| hit.distance));
    }
    fn approach(mut cubes: Query<&mut Transform, With<Mesh3d>>) {
        cubes.iter_mut().for_each(|mut place| place.translation.z += 1.0);
    }
    let mut app = headless_app();
    app.init_resource::<Hits>()
        .add_systems(FixedUpdate, cast)
        .add_systems(PreUpdate, approach);
    app
}

/// What is hit in a frame of so many fixed steps.
fn hits_in_frame(app: &mut App, steps: u32) -> Vec<Option<f32>> {
    app.insert_resource(TimeUpdateStrategy::FixedTimesteps(steps));
    app.update();
    std::mem::take(&mut app.world_mut().resource_mut::<Hits>().0)
}

#[test]
fn every_step_of_a_frame_sees_the_end_of_the_frame_before() {
    let mut app = app();
    spawn_cube(&mut app, Vec3::ZERO);
    // Time begins with the first frame.
    hits_in_frame(&mut app, 0);
    assert_eq!(hits_in_frame(&mut app, 3), [Some(98.5); 3]);
    assert_eq!(hits_in_frame(&mut app, 0), []);
    assert_eq!(hits_in_frame(&mut app, 2), [Some(96.5); 2]);
}

#[test]
fn a_step_before_the_first_sync_sees_nothing() {
    let mut app = app();
    app.insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    spawn_cube(&mut app, Vec3::ZERO);
    app.world_mut().run_schedule(FixedUpdate);
    assert_eq!(app.world().resource::<Hits>().0, [None]);
}
