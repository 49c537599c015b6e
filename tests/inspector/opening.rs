//! Opening, closing, and what is selected.

use bevy::{
    input::{
        ButtonState,
        keyboard::{Key, KeyCode, KeyboardInput, NativeKey},
    },
    picking::{
        backend::HitData,
        events::{Click, Pointer},
        pointer::{Location, PointerButton, PointerId},
    },
    prelude::*,
    window::WindowRef,
};
use bevy_sightline::prelude::*;

use crate::{
    common::{headless_app, headless_app_with, spawn_cube},
    panel::Panel,
};

fn press(app: &mut App, key: KeyCode) {
    for state in [ButtonState::Pressed, ButtonState::Released] {
        app.world_mut().write_message(KeyboardInput {
            key_code: key,
            logical_key: Key::Unidentified(NativeKey::Unidentified),
            state,
            text: None,
            repeat: false,
            window: Entity::PLACEHOLDER,
        });
        app.update();
    }
}

fn is_open(app: &App) -> bool {
    app.world().resource::<SightlineInspector>().open
}

fn closed_app() -> App {
    headless_app_with(|app| {
        app.add_plugins(SightlineInspectorPlugin);
    })
}

fn click(app: &mut App, entity: Entity) {
    let camera = app.world_mut().spawn_empty().id();
    let window = app.world_mut().spawn(Window::default()).id();
    let location = Location {
        target: bevy::camera::NormalizedRenderTarget::Window(
            WindowRef::Entity(window).normalize(None).expect("it is named"),
        ),
        position: Vec2::ZERO,
    };
    let click = Click {
        button: PointerButton::Primary,
        hit: HitData::new(camera, 1.0, None, None),
        duration: std::time::Duration::ZERO,
        count: 1,
    };
    app.world_mut()
        .trigger(Pointer::new(PointerId::Mouse, location, click, entity));
    app.update();
}

#[test]
fn is_closed_at_first() {
    assert!(!is_open(&closed_app()));
}

#[test]
fn opens_and_closes_by_f1() {
    let mut app = closed_app();
    press(&mut app, KeyCode::F1);
    assert!(is_open(&app));
    press(&mut app, KeyCode::F1);
    assert!(!is_open(&app));
}

#[test]
fn opens_by_the_key_that_the_game_chooses_and_by_none_if_there_is_none() {
    let mut app = closed_app();
    app.world_mut().resource_mut::<SightlineInspector>().key = Some(KeyCode::Backquote);
    press(&mut app, KeyCode::F1);
    assert!(!is_open(&app));
    press(&mut app, KeyCode::Backquote);
    assert!(is_open(&app));
    app.world_mut().resource_mut::<SightlineInspector>().key = None;
    press(&mut app, KeyCode::Backquote);
    assert!(is_open(&app));
}

#[test]
fn tabs_are_changed_by_a_click() {
    let mut panel = Panel::new(InspectorTab::Index);
    panel.update();
    for tab in InspectorTab::ALL {
        panel.click(tab.title());
        assert_eq!(panel.inspector().tab, tab);
    }
}

#[test]
fn all_tabs_are_shown_of_an_empty_world() {
    for tab in InspectorTab::ALL {
        let mut panel = Panel::new(tab);
        panel.update();
        assert!(panel.says("Settings"), "{tab:?}");
        assert!(!panel.says("needs a plugin"), "{tab:?}");
    }
}

#[test]
fn without_the_plugin_the_panel_is_empty() {
    let mut app = headless_app();
    let context = bevy_sightline::debug::inspector::egui::Context::default();
    let world = app.world_mut();
    let mut output = context.run_ui(Default::default(), |ui| {
        bevy_sightline::debug::inspector::inspector_ui(ui, world);
    });
    output.textures_delta.clear();
    assert!(output.shapes.is_empty());
}

#[test]
fn the_plugin_may_be_added_beside_the_diagnostics() {
    let app = headless_app_with(|app| {
        app.add_plugins((SightlineDiagnosticsPlugin, SightlineInspectorPlugin));
    });
    assert!(app.world().contains_resource::<SightlineInspector>());
}

#[test]
fn a_click_in_the_scene_selects_while_the_panel_is_open() {
    let mut panel = Panel::new(InspectorTab::Index);
    let cube = spawn_cube(&mut panel.app, Vec3::ZERO);
    panel.update();
    click(&mut panel.app, cube);
    assert_eq!(panel.inspector().selected, Some(cube));
}

#[test]
fn a_click_selects_nothing_while_the_panel_is_closed_or_it_is_not_wanted() {
    let mut panel = Panel::new(InspectorTab::Index);
    let cube = spawn_cube(&mut panel.app, Vec3::ZERO);
    panel.update();
    panel.world().resource_mut::<SightlineInspector>().open = false;
    click(&mut panel.app, cube);
    assert_eq!(panel.inspector().selected, None);
    let mut inspector = panel.world().resource_mut::<SightlineInspector>();
    inspector.open = true;
    inspector.select_by_click = false;
    click(&mut panel.app, cube);
    assert_eq!(panel.inspector().selected, None);
}

#[test]
fn what_is_not_indexed_is_not_selected() {
    let mut panel = Panel::new(InspectorTab::Index);
    let button = panel.world().spawn(Transform::default()).id();
    panel.update();
    click(&mut panel.app, button);
    assert_eq!(panel.inspector().selected, None);
}

#[test]
fn what_is_selected_is_marked_while_the_panel_is_open() {
    let mut panel = Panel::new(InspectorTab::Index);
    let cube = spawn_cube(&mut panel.app, Vec3::ZERO);
    let other = spawn_cube(&mut panel.app, Vec3::X * 5.0);
    panel.update();
    panel.world().resource_mut::<SightlineInspector>().selected = Some(cube);
    panel.update();
    assert!(panel.world().entity(cube).contains::<ShowGizmos>());
    panel.world().resource_mut::<SightlineInspector>().selected = Some(other);
    panel.update();
    assert!(!panel.world().entity(cube).contains::<ShowGizmos>());
    assert!(panel.world().entity(other).contains::<ShowGizmos>());
    panel.world().resource_mut::<SightlineInspector>().open = false;
    panel.update();
    assert!(!panel.world().entity(other).contains::<ShowGizmos>());
}

#[test]
fn a_mark_that_was_there_before_stays_as_it_is() {
    let mut panel = Panel::new(InspectorTab::Index);
    let cube = spawn_cube(&mut panel.app, Vec3::ZERO);
    let mark = ShowGizmos {
        leaf: false,
        ..ShowGizmos::default()
    };
    panel.world().entity_mut(cube).insert(mark);
    panel.update();
    panel.world().resource_mut::<SightlineInspector>().selected = Some(cube);
    panel.update();
    panel.world().resource_mut::<SightlineInspector>().selected = None;
    panel.update();
    assert_eq!(panel.world().get::<ShowGizmos>(cube), Some(&mark));
}

#[test]
fn what_is_selected_may_be_despawned() {
    let mut panel = Panel::new(InspectorTab::Index);
    let cube = spawn_cube(&mut panel.app, Vec3::ZERO);
    panel.update();
    panel.world().resource_mut::<SightlineInspector>().selected = Some(cube);
    panel.update();
    panel.world().entity_mut(cube).despawn();
    panel.update();
    assert!(panel.says("is gone"));
}
