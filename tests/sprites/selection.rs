//! Sprites are selected on the screen by their rectangles, as they lie.

use std::f32::consts::FRAC_PI_4;

use bevy::{
    camera::{CameraProjection, ComputedCameraValues, RenderTargetInfo},
    prelude::*,
};
use bevy_sightline::prelude::*;

use crate::{common::*, scene::*};

/// A pixel to the unit, with the origin at (100, 100).
fn camera() -> Camera {
    let projection = OrthographicProjection {
        area: Rect::from_center_half_size(Vec2::ZERO, Vec2::splat(100.0)),
        ..OrthographicProjection::default_2d()
    };
    Camera {
        computed: ComputedCameraValues {
            clip_from_view: projection.get_clip_from_view(),
            target_info: Some(RenderTargetInfo {
                physical_size: UVec2::splat(200),
                scale_factor: 1.0,
            }),
            ..default()
        },
        ..default()
    }
}

#[test]
fn a_turned_sprite_is_selected_by_its_rectangle_and_not_by_its_box() {
    let mut app = app();
    let turned = Transform::from_rotation(Quat::from_rotation_z(FRAC_PI_4));
    let sprite = Sprite::from_color(Color::WHITE, Vec2::new(80.0, 40.0));
    let sprite = app.world_mut().spawn((sprite, turned)).id();
    app.update();
    let mut select = |a: [f32; 2], b: [f32; 2], mode| {
        let region = ScreenRegion::rect(a.into(), b.into());
        let selection = SelectionSettings::default().with_mode(mode);
        let (camera, eye, settings) = (camera(), GlobalTransform::IDENTITY, SceneQuerySettings::default());
        let mut found = Vec::new();
        query(&mut app, |scene| {
            scene.select_on_screen(&camera, &eye, &region, &selection, &settings, &mut found);
        });
        found == [sprite]
    };
    // Its corners are 60 / √2 = 42.4 and 20 / √2 = 14.1 from the middle, along either axis.
    assert!(!select([60.0, 60.0], [75.0, 75.0], SelectionMode::Touching));
    assert!(select([60.0, 60.0], [90.0, 90.0], SelectionMode::Touching));
    assert!(select([57.0, 57.0], [143.0, 143.0], SelectionMode::Enclosed));
    assert!(!select([58.0, 58.0], [142.0, 142.0], SelectionMode::Enclosed));
}
