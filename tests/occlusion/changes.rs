//! What changes takes effect in the frame in which it changes.

use bevy::prelude::*;
use bevy_sightline::prelude::*;
use rand::Rng;

use super::*;

/// A camera, a wall, and a cube behind it.
fn behind_a_wall() -> (App, Entity, Entity, Entity) {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    let (wall, behind) = (spawn_wall(&mut app), spawn_ahead(&mut app, 20.0));
    assert!(!sees(&mut app, camera, behind));
    assert!(!sees(&mut app, camera, behind), "nor in a frame without a change");
    (app, camera, wall, behind)
}

#[test]
fn an_occluder_that_moves_hides_where_it_is() {
    let (mut app, camera, wall, behind) = behind_a_wall();
    insert(&mut app, wall, Transform::from_xyz(30.0, 0.0, -10.0));
    assert!(sees(&mut app, camera, behind));
    insert(&mut app, wall, Transform::from_xyz(0.0, 0.0, -12.0));
    assert!(!sees(&mut app, camera, behind));
}

#[test]
fn an_occluder_that_is_gone_hides_nothing() {
    for end in [
        |app: &mut App, wall: Entity| _ = app.world_mut().despawn(wall),
        |app: &mut App, wall: Entity| remove::<Occluder>(app, wall),
        |app: &mut App, wall: Entity| insert(app, wall, Visibility::Hidden),
        |app: &mut App, wall: Entity| remove::<Mesh3d>(app, wall),
        |app: &mut App, wall: Entity| insert(app, wall, bevy::ecs::entity_disabling::Disabled),
        |app: &mut App, wall: Entity| insert(app, wall, NoSpatialIndex),
    ] {
        let (mut app, camera, wall, behind) = behind_a_wall();
        remove::<bevy::camera::primitives::Aabb>(&mut app, wall);
        end(&mut app, wall);
        assert!(sees(&mut app, camera, behind));
    }
}

#[test]
fn an_occluder_that_comes_hides_at_once() {
    let mut app = headless_app();
    let camera = spawn_camera(&mut app);
    let behind = spawn_ahead(&mut app, 20.0);
    assert!(sees(&mut app, camera, behind));
    let wall = spawn_wall(&mut app);
    assert!(!sees(&mut app, camera, behind));
    insert(&mut app, wall, Visibility::Hidden);
    assert!(sees(&mut app, camera, behind));
    insert(&mut app, wall, Visibility::Inherited);
    assert!(!sees(&mut app, camera, behind));
}

#[test]
fn what_comes_out_from_behind_an_occluder_is_seen_at_once() {
    let (mut app, camera, _, behind) = behind_a_wall();
    insert(&mut app, behind, Transform::from_xyz(0.0, 7.2, -20.0));
    assert!(sees(&mut app, camera, behind));
    insert(&mut app, behind, Transform::from_xyz(0.0, 0.0, -20.0));
    assert!(!sees(&mut app, camera, behind));
}

#[test]
fn a_camera_that_moves_sees_from_where_it_is() {
    let (mut app, camera, _, behind) = behind_a_wall();
    insert(
        &mut app,
        camera,
        Transform::from_xyz(20.0, 0.0, 0.0).looking_at(Vec3::new(0.0, 0.0, -20.0), Vec3::Y),
    );
    assert!(sees(&mut app, camera, behind));
    insert(&mut app, camera, Transform::IDENTITY);
    assert!(!sees(&mut app, camera, behind));
}

#[test]
fn other_settings_are_those_of_this_frame() {
    let (mut app, camera, _, behind) = behind_a_wall();
    let resolution = UVec2::new(256, 128);
    insert(
        &mut app,
        camera,
        SoftwareOcclusion {
            resolution,
            ..default()
        },
    );
    assert!(!sees(&mut app, camera, behind));
    let buffer = app.world().get::<OcclusionBuffer>(camera).unwrap();
    assert_eq!(buffer.depth().size(), resolution);
}

/// Walls, crates, and cameras that come, go and move: in every frame a camera that has been there sees what one sees
/// that has just come to the same place, which is never more than one without occlusion, and nothing is missing of what
/// is before all occluders.
#[test]
fn a_camera_that_has_been_there_sees_what_a_new_one_does() {
    let mut left_out = 0;
    for seed in 0..12 {
        let mut rng = rng(seed);
        let mut app = headless_app();
        let mut things = Vec::new();
        let place = |rng: &mut rand_chacha::ChaCha8Rng| {
            Transform::from_translation(random_point(rng, 30.0)).with_rotation(random_rotation(rng))
        };
        let camera = spawn_camera(&mut app);
        for frame in 0..60 {
            for _ in 0..rng.random_range(0..6) {
                match rng.random_range(0..8) {
                    0 | 1 => {
                        let size = Vec3::from_array(std::array::from_fn(|_| rng.random_range(0.2..12.0)));
                        let wall = spawn_mesh(&mut app, Cuboid::from_size(size), place(&mut rng));
                        insert(
                            &mut app,
                            wall,
                            if rng.random_bool(0.5) {
                                Occluder::Box
                            } else {
                                Occluder::Auto
                            },
                        );
                        things.push(wall);
                    }
                    2 | 3 => {
                        let at = random_point(&mut rng, 30.0);
                        things.push(spawn_cube(&mut app, at));
                    }
                    4 if !things.is_empty() => {
                        let thing = things.swap_remove(rng.random_range(0..things.len()));
                        app.world_mut().despawn(thing);
                    }
                    5 if !things.is_empty() => {
                        let thing = things[rng.random_range(0..things.len())];
                        let place = place(&mut rng);
                        insert(&mut app, thing, place);
                    }
                    6 if !things.is_empty() => {
                        let thing = things[rng.random_range(0..things.len())];
                        let visibility = [Visibility::Hidden, Visibility::Inherited][rng.random_range(0..2)];
                        insert(&mut app, thing, visibility);
                    }
                    7 => {
                        let place = place(&mut rng);
                        insert(&mut app, camera, place);
                    }
                    _ => {}
                }
            }
            let at = *app.world().get::<Transform>(camera).unwrap();
            let fresh = spawn(&mut app, (Camera3d::default(), SoftwareOcclusion::default(), at));
            let plain = spawn(&mut app, (Camera3d::default(), at));
            app.update();
            // Boxes are found in the background: in which frame, chance decides.
            while app.world().resource::<Occluders>().making() > 0 {
                app.update();
            }
            let (seen, fresh_seen, all) = (listed(&app, camera), listed(&app, fresh), listed(&app, plain));
            assert_eq!(seen, fresh_seen, "seed {seed}, frame {frame}");
            assert!(
                seen.iter().all(|entity| all.contains(entity)),
                "seed {seed}, frame {frame}"
            );
            left_out += all.len() - seen.len();
            app.world_mut().despawn(fresh);
            app.world_mut().despawn(plain);
        }
    }
    assert!(left_out > 100, "only {left_out}");
}
