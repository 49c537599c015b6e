//! A pointer that follows a script, where there is no mouse.

use bevy::{
    camera::NormalizedRenderTarget,
    picking::pointer::{Location, PointerAction, PointerId, PointerInput},
    prelude::*,
    window::{PrimaryWindow, WindowRef},
};

/// One frame of a script: where the pointer is, from (0, 0) at the top left of the window to (1, 1), and what it does.
pub type Step = (Vec2, Option<PointerAction>);

/// Runs a headless app for one frame per step.
pub fn play(app: &mut App, steps: impl IntoIterator<Item = Step>) {
    for step in steps {
        act(app.world_mut(), step);
        app.update();
    }
}

/// Has the pointer do something in the next frame.
pub fn act(world: &mut World, (place, action): Step) {
    let mut windows = world.query_filtered::<(Entity, &Window), With<PrimaryWindow>>();
    let (window, size) = windows
        .single(world)
        .map(|(entity, window)| (entity, window.size()))
        .expect("the window plugin makes one window");
    let window = WindowRef::Entity(window).normalize(None).expect("a window entity");
    let location = Location {
        target: NormalizedRenderTarget::Window(window),
        position: place * size,
    };
    let moved = PointerAction::Move { delta: Vec2::ONE };
    for action in std::iter::once(moved).chain(action) {
        world.write_message(PointerInput::new(PointerId::Mouse, location.clone(), action));
    }
}

/// The steps of a click, with the pointer resting before and after.
pub fn click(place: Vec2) -> [Step; 4] {
    [
        (place, None),
        (place, Some(PointerAction::Press(PointerButton::Primary))),
        (place, Some(PointerAction::Release(PointerButton::Primary))),
        (place, None),
    ]
}
