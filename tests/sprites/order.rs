//! What is in front of what.

use bevy::prelude::*;
use bevy_sightline::prelude::*;

use crate::{common::*, scene::*};

fn spawn_at(app: &mut App, z: f32, scale: f32) -> Entity {
    let sprite = Sprite::from_color(Color::WHITE, Vec2::splat(10.0));
    let place = Transform::from_xyz(0.1, 0.2, z)
        .with_scale(Vec3::splat(scale))
        .with_rotation(Quat::from_rotation_z(scale));
    app.world_mut().spawn((sprite, place)).id()
}

fn all_at(app: &mut App, x: f32, y: f32) -> Vec<Entity> {
    query(app, |scene| {
        let mut hits = Vec::new();
        scene.cast_ray_all(down_at(x, y), &SceneQuerySettings::default(), &mut hits);
        hits.into_iter().map(|hit| hit.entity).collect()
    })
}

#[test]
fn the_sprite_with_the_higher_z_is_first_however_little_higher_and_whatever_the_scales() {
    for step in [1.0, 1e-3, 1e-5, 1e-7, 1e-12] {
        for order in [[0, 1, 2, 3, 4], [4, 2, 0, 1, 3]] {
            let mut app = app();
            let scales = [1.0, 2.5, 0.3, 7.77, 1.1];
            let mut sprites = order.map(|rank| (rank, spawn_at(&mut app, rank as f32 * step, scales[rank])));
            app.update();
            sprites.sort_by_key(|(rank, _)| std::cmp::Reverse(*rank));
            let expected = sprites.map(|(_, sprite)| sprite);
            assert_eq!(all_at(&mut app, 0.0, 0.0), expected, "{step} {order:?}");
            assert_eq!(entity_at(&mut app, 0.0, 0.0), Some(expected[0]), "{step} {order:?}");
        }
    }
}

#[test]
fn of_sprites_at_the_same_z_the_one_that_was_spawned_last_is_first() {
    let mut app = app();
    let sprites = [1.0, 2.5, 0.3, 7.77, 1.1].map(|scale| spawn_at(&mut app, 3.0, scale));
    app.update();
    let newest_first: Vec<_> = sprites.into_iter().rev().collect();
    assert_eq!(all_at(&mut app, 0.0, 0.0), newest_first);
    assert_eq!(entity_at(&mut app, 0.0, 0.0), Some(newest_first[0]));
}
