//! The keys, and the mouse that aims.

use bevy::{prelude::*, window::PrimaryWindow};

use crate::{
    boxes::{Boxes, ray},
    explorer::Explorer,
    options::Options,
    structure::Kind,
    view::Eye,
};

/// Pixels that the pointer goes before it aims.
const LEAST_DRAG: f32 = 6.0;

const DIGITS: [KeyCode; Kind::MAIN.len()] = [
    KeyCode::Digit1,
    KeyCode::Digit2,
    KeyCode::Digit3,
    KeyCode::Digit4,
    KeyCode::Digit5,
];

pub fn plugin(app: &mut App) {
    app.add_systems(Update, (press, aim));
}

fn press(keys: Res<ButtonInput<KeyCode>>, mut options: ResMut<Options>, mut explorer: ResMut<Explorer>) {
    // Nothing is written to where nothing is pressed.
    if keys.get_just_pressed().len() == 0 {
        return;
    }
    for (key, kind) in DIGITS.into_iter().zip(Kind::MAIN) {
        if keys.just_pressed(key) {
            explorer.choose(kind);
        }
    }
    if keys.just_pressed(KeyCode::KeyB) {
        let next = explorer.kind.next_strategy();
        explorer.choose(next);
    }
    if keys.any_just_pressed([KeyCode::Tab, KeyCode::KeyN]) {
        options.seed = options.seed.wrapping_add(keys.just_pressed(KeyCode::KeyN).into());
        options.three_d ^= keys.just_pressed(KeyCode::Tab);
        let kind = explorer.kind;
        *explorer = Explorer::new(Boxes::new(options.boxes, options.seed, options.three_d));
        explorer.choose(kind);
    }
    if keys.just_pressed(KeyCode::KeyR) {
        let first = explorer.boxes.first_ray();
        explorer.aim(first);
    }
    let last = explorer.trace.steps.len();
    if keys.just_pressed(KeyCode::Space) {
        explorer.playing ^= true;
        if explorer.playing && explorer.step == last {
            explorer.step = 0;
        }
    }
    let step = explorer.step;
    for (key, to) in [
        (KeyCode::ArrowRight, (step + 1).min(last)),
        (KeyCode::ArrowLeft, step.saturating_sub(1)),
        (KeyCode::Home, 0),
        (KeyCode::End, last),
    ] {
        if keys.just_pressed(key) {
            explorer.step = to;
            explorer.playing = false;
        }
    }
}

/// Aims from where the left button was pressed to where the pointer is, in the plane that the view faces, through the
/// middle of the boxes.
fn aim(
    buttons: Res<ButtonInput<MouseButton>>,
    window: Single<&Window, With<PrimaryWindow>>,
    camera: Single<(&Camera, &GlobalTransform), With<Eye>>,
    mut start: Local<Option<Vec2>>,
    mut explorer: ResMut<Explorer>,
) {
    let Some(pointer) = window.cursor_position() else {
        return;
    };
    if buttons.just_pressed(MouseButton::Left) {
        *start = Some(pointer);
    }
    let Some(from) = start.filter(|from| from.distance(pointer) > LEAST_DRAG) else {
        return;
    };
    let (camera, place) = *camera;
    let plane = InfinitePlane3d::new(place.back());
    let at = |pixel| {
        let sight = camera.viewport_to_world(place, pixel).ok()?;
        let along = sight.intersect_plane(explorer.boxes.size() / 2.0, plane)?;
        Some(sight.get_point(along))
    };
    if buttons.pressed(MouseButton::Left)
        && let (Some(from), Some(to)) = (at(from), at(pointer))
        && let Some(ray) = ray(from, to - from)
        && ray != explorer.ray
    {
        explorer.aim(ray);
        // All at once while it is dragged, and step by step from then on.
        explorer.step = explorer.trace.steps.len();
    }
    if buttons.just_released(MouseButton::Left) {
        *start = None;
    }
}
