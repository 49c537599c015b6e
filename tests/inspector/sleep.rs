//! Egui, while the panel is closed.

use bevy::{
    prelude::*,
    render::{RenderPlugin, settings::WgpuSettings},
    window::{CursorMoved, PrimaryWindow, WindowEvent},
};
use bevy_egui::{EguiContext, EguiPlugin, EguiPrimaryContextPass, input::EguiWantsInput};
use bevy_sightline::prelude::*;

use crate::common::headless_app_with;

/// How often egui has run.
#[derive(Resource, Default)]
struct Passes(usize);

/// An app with a renderer that has no GPU, a camera to draw the panel on, and a count of passes.
fn app_with(add_plugins: impl FnOnce(&mut App)) -> App {
    let mut app = headless_app_with(|app| {
        let no_gpu = WgpuSettings {
            backends: None,
            ..default()
        };
        app.add_plugins(RenderPlugin {
            render_creation: no_gpu.into(),
            ..default()
        });
        add_plugins(app);
        app.init_resource::<Passes>()
            .add_systems(EguiPrimaryContextPass, |mut passes: ResMut<Passes>| passes.0 += 1);
    });
    app.world_mut().spawn(Camera3d::default());
    app
}

fn app_with_inspector() -> App {
    app_with(|app| {
        app.add_plugins(SightlineInspectorPlugin);
    })
}

/// How many passes so many frames have.
fn passes(app: &mut App, frames: usize) -> usize {
    app.insert_resource(Passes(0));
    for _ in 0..frames {
        app.update();
    }
    app.world().resource::<Passes>().0
}

/// The same, with a panel that has been open for so many frames.
fn app_with_open_panel(frames: usize) -> App {
    let mut app = app_with_inspector();
    set_open(&mut app, true);
    passes(&mut app, frames);
    app
}

fn set_open(app: &mut App, open: bool) {
    app.world_mut().resource_mut::<SightlineInspector>().open = open;
}

#[test]
fn it_sleeps_while_the_panel_is_closed_and_wakes_when_it_opens() {
    let mut app = app_with_inspector();
    assert_eq!(passes(&mut app, 10), 0);
    set_open(&mut app, true);
    assert_eq!(passes(&mut app, 10), 10);
}

#[test]
fn it_goes_on_for_some_frames_after_the_panel_was_closed_and_then_sleeps() {
    let mut app = app_with_open_panel(3);
    set_open(&mut app, false);
    assert!((1..5).contains(&passes(&mut app, 10)));
    assert_eq!(passes(&mut app, 10), 0);
}

#[test]
fn the_pointer_is_free_again_after_the_panel_was_closed_under_it() {
    let mut app = app_with_open_panel(2);
    let mut windows = app.world_mut().query_filtered::<Entity, With<PrimaryWindow>>();
    let window = windows.single(app.world()).expect("there is one");
    app.world_mut().write_message(WindowEvent::CursorMoved(CursorMoved {
        window,
        position: Vec2::new(1100.0, 400.0),
        delta: None,
    }));
    passes(&mut app, 3);
    assert!(is_pointer_wanted(&mut app));
    set_open(&mut app, false);
    passes(&mut app, 10);
    assert!(!is_pointer_wanted(&mut app));
}

/// Whether egui has the pointer for itself.
fn is_pointer_wanted(app: &mut App) -> bool {
    let mut contexts = app.world_mut().query::<&mut EguiContext>();
    let mut context = contexts.single_mut(app.world_mut()).expect("there is one");
    let is_wanted = context.get_mut().egui_wants_pointer_input();
    assert_eq!(
        app.world().resource::<EguiWantsInput>().wants_any_pointer_input(),
        is_wanted
    );
    is_wanted
}

#[test]
fn the_egui_of_the_game_never_sleeps() {
    let mut app = app_with(|app| {
        app.add_plugins((EguiPlugin::default(), SightlineInspectorPlugin));
    });
    assert_eq!(passes(&mut app, 10), 10);
}

#[test]
#[should_panic(expected = "it has to be added after DefaultPlugins")]
fn to_be_added_before_the_renderer_is_an_error_that_says_so() {
    let _ = headless_app_with(|app| {
        app.add_plugins(SightlineInspectorPlugin);
        let no_gpu = WgpuSettings {
            backends: None,
            ..default()
        };
        app.add_plugins(RenderPlugin {
            render_creation: no_gpu.into(),
            ..default()
        });
    });
}
