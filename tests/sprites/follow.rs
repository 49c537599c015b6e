//! The surface of a sprite follows the sprite: every way in has its way out.

use bevy::{ecs::entity_disabling::Disabled, prelude::*, sprite::Anchor};
use bevy_sightline::prelude::*;

use crate::{common::*, scene::*};

fn square() -> Sprite {
    Sprite::from_color(Color::WHITE, Vec2::splat(10.0))
}

#[test]
fn a_sprite_is_hit_within_its_rectangle_from_both_sides() {
    let mut app = app();
    let sprite = app.world_mut().spawn(square()).id();
    app.update();
    let found = hit(&mut app, 4.9, -4.9).expect("inside");
    assert_eq!((found.entity, found.distance, found.normal), (sprite, 1000.0, Vec3::Z));
    assert_eq!(found.triangle, None);
    assert_eq!(entity_at(&mut app, 5.1, 0.0), None);
    assert_eq!(entity_at(&mut app, 0.0, -5.1), None);
    let from_behind = cast(&mut app, Ray3d::new(Vec3::NEG_Z * 3.0, Dir3::Z)).expect("sprites have no back");
    assert_eq!((from_behind.entity, from_behind.distance), (sprite, 3.0));
}

#[test]
fn a_sprite_that_is_despawned_is_gone() {
    let mut app = app();
    let sprite = app.world_mut().spawn(square()).id();
    app.update();
    assert_eq!(entity_at(&mut app, 0.0, 0.0), Some(sprite));
    app.world_mut().despawn(sprite);
    app.update();
    assert_eq!(entity_at(&mut app, 0.0, 0.0), None);
}

#[test]
fn what_is_no_longer_a_sprite_is_no_longer_hit() {
    let mut app = app();
    let sprite = app.world_mut().spawn(square()).id();
    app.update();
    app.world_mut().entity_mut(sprite).remove::<Sprite>();
    app.update();
    assert_eq!(entity_at(&mut app, 0.0, 0.0), None);
    app.world_mut().entity_mut(sprite).insert(square());
    app.update();
    assert_eq!(entity_at(&mut app, 0.0, 0.0), Some(sprite));
}

#[test]
fn a_sprite_that_is_resized_or_anchored_anew_is_hit_where_it_is_now() {
    let mut app = app();
    let sprite = app.world_mut().spawn(square()).id();
    app.update();
    app.world_mut().get_mut::<Sprite>(sprite).expect("a sprite").custom_size = Some(Vec2::new(40.0, 10.0));
    app.update();
    assert_eq!(entity_at(&mut app, 19.0, 0.0), Some(sprite));
    app.world_mut().entity_mut(sprite).insert(Anchor::CENTER_LEFT);
    app.update();
    assert_eq!(entity_at(&mut app, 39.0, 0.0), Some(sprite));
    assert_eq!(entity_at(&mut app, -1.0, 0.0), None);
}

#[test]
fn a_sprite_without_a_size_of_its_own_is_hit_when_its_image_is_loaded_and_until_it_is_gone() {
    let mut app = app();
    let images = app.world().resource::<Assets<Image>>();
    let handle = images.reserve_handle();
    let sprite = app.world_mut().spawn(Sprite::from_image(handle.clone())).id();
    app.update();
    assert_eq!(entity_at(&mut app, 0.5, 0.5), None);
    let solid = image(UVec2::new(20, 10), |_| 255);
    let mut images = app.world_mut().resource_mut::<Assets<Image>>();
    images.insert(&handle, solid).expect("the handle lives");
    app.update();
    assert_eq!(entity_at(&mut app, 9.5, 4.5), Some(sprite));
    assert_eq!(entity_at(&mut app, 9.5, 5.5), None);
    app.world_mut().resource_mut::<Assets<Image>>().remove(&handle);
    app.update();
    assert_eq!(entity_at(&mut app, 9.5, 4.5), None);
}

#[test]
fn an_atlas_that_is_changed_changes_its_sprites() {
    let mut app = app();
    let board = add_image(&mut app, image(UVec2::splat(32), |_| 255));
    let layout = add_atlas(&mut app, UVec2::splat(8), 4, 4);
    let sprite = Sprite::from_atlas_image(board, layout.clone().into());
    let sprite = app.world_mut().spawn(sprite).id();
    app.update();
    assert_eq!(entity_at(&mut app, 3.9, 0.0), Some(sprite));
    assert_eq!(entity_at(&mut app, 7.9, 0.0), None);
    let mut layouts = app.world_mut().resource_mut::<Assets<TextureAtlasLayout>>();
    layouts.get_mut(&layout).expect("a layout").textures[0] = URect::new(0, 0, 16, 8);
    app.update();
    assert_eq!(entity_at(&mut app, 7.9, 0.0), Some(sprite));
}

#[test]
fn a_shape_of_the_users_goes_before_the_sprite_and_gives_way_when_it_is_removed() {
    let mut app = app();
    let sprite = app.world_mut().spawn((square(), PickShape::new(Sphere::new(1.0)))).id();
    app.update();
    assert_eq!(hit(&mut app, 0.0, 0.0).map(|hit| hit.distance), Some(999.0));
    assert_eq!(entity_at(&mut app, 4.0, 4.0), None);
    app.world_mut().get_mut::<Sprite>(sprite).expect("a sprite").color = Color::BLACK;
    app.update();
    assert_eq!(entity_at(&mut app, 4.0, 4.0), None);
    app.world_mut().entity_mut(sprite).remove::<PickShape>();
    app.update();
    assert_eq!(entity_at(&mut app, 4.0, 4.0), Some(sprite));
}

#[test]
fn what_changes_while_a_sprite_is_disabled_counts_when_it_is_enabled() {
    let mut app = app();
    let sprite = app.world_mut().spawn(square()).id();
    app.update();
    app.world_mut().entity_mut(sprite).insert(Disabled);
    app.update();
    app.world_mut().get_mut::<Sprite>(sprite).expect("a sprite").custom_size = Some(Vec2::splat(2.0));
    app.update();
    app.update();
    assert_eq!(entity_at(&mut app, 0.0, 0.0), None);
    app.world_mut().entity_mut(sprite).remove::<Disabled>();
    app.update();
    assert_eq!(entity_at(&mut app, 4.0, 0.0), None);
    assert_eq!(entity_at(&mut app, 0.5, 0.0), Some(sprite));
}

#[test]
fn sprites_without_an_area_are_not_hit_and_come_back_with_one() {
    let mut app = app();
    for size in [
        Vec2::ZERO,
        Vec2::new(10.0, 0.0),
        Vec2::splat(f32::NAN),
        Vec2::splat(f32::INFINITY),
    ] {
        let sprite = app.world_mut().spawn(Sprite::from_color(Color::WHITE, size)).id();
        app.update();
        assert_eq!(entity_at(&mut app, 0.0, 0.0), None, "{size}");
        app.world_mut().get_mut::<Sprite>(sprite).expect("a sprite").custom_size = Some(Vec2::ONE);
        app.update();
        assert_eq!(entity_at(&mut app, 0.0, 0.0), Some(sprite), "after {size}");
        app.world_mut().despawn(sprite);
    }
}

#[test]
fn a_change_of_colour_alone_leaves_the_index_alone() {
    let mut app = app();
    let sprite = app.world_mut().spawn(square()).id();
    app.update();
    app.update();
    app.world_mut().get_mut::<Sprite>(sprite).expect("a sprite").color = Color::BLACK;
    app.update();
    let stats = app.world().resource::<bevy_sightline::index::SyncStats>();
    assert_eq!((stats.reconciled, stats.moved), (0, 0));
}
