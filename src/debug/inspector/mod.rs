//! The inspector: a panel that shows what the index, the views and the levels of detail are doing, and why.
//!
//! ```no_run
//! # use bevy::prelude::*;
//! # use bevy_sightline::prelude::*;
//! App::new().add_plugins((DefaultPlugins, SightlinePlugins, SightlineInspectorPlugin)).run();
//! ```
//!
//! `F1` opens and closes it; what it shows is in [`SightlineInspector`], which a game may change. While it is closed
//! nothing is done but to [measure](crate::debug::diagnostics).
//!
//! | tab | shows |
//! |---|---|
//! | Index | what is indexed and what is not, with the reason; how good the tree is; the time of each phase, with the last seconds |
//! | Query | the ray under the mouse: what it visits, what is tested, and what it hits, in order |
//! | Culling | what each camera sees, and of the rest how many things are where; the occlusion buffer; why the selected entity is not seen |
//! | LOD | how many groups are at which level, how often they switch, and what that saves; biases |
//! | Structures | what is drawn of the structures, and other structures over the same entities, with their cost |
//!
//! What is clicked, in the panel or in the scene, is selected: all tabs tell of it, it is marked in the scene, and its
//! components of this crate can be edited, as can all settings.
//!
//! The pointer over the panel picks nothing below it. Systems that read the mouse or the keyboard by themselves ask
//! [`EguiWantsInput`](bevy_egui::input::EguiWantsInput), or
//! [`egui_wants_any_pointer_input`](bevy_egui::input::egui_wants_any_pointer_input) as a run condition.
//!
//! [`inspector_ui`] shows the same in a window of your own: see [`SightlineInspector::panel`].

mod census;
mod comparison;
mod link;
mod mouse_ray;
mod panel;
mod plot;
mod reflect;
mod selection;
mod settings;
mod sleep;
mod state;
mod tabs;

pub use bevy_egui::egui;
pub use panel::inspector_ui;
pub use state::{InspectorTab, SightlineInspector};

use bevy::{
    app::{App, Plugin, PreUpdate, Update},
    ecs::{
        change_detection::{Res, ResMut},
        schedule::{
            IntoScheduleConfigs,
            common_conditions::{resource_changed, resource_exists},
        },
    },
    input::{ButtonInput, InputSystems, keyboard::KeyCode},
    picking::PickingSystems,
    render::RenderPlugin,
};
use bevy_egui::{EguiPlugin, EguiPrimaryContextPass};

use crate::{debug::diagnostics::SightlineDiagnosticsPlugin, index::SpatialIndexPlugin};

/// Adds the panel: see [`inspector`](self). Adds [`SpatialIndexPlugin`], [`SightlineDiagnosticsPlugin`] and, if there is a
/// renderer, `EguiPlugin`, unless they are there. An `EguiPlugin` of your own has to be added before; without one, egui
/// sleeps while the panel is closed, and takes nothing of a frame.
///
/// Without a renderer there is no panel, and [`inspector_ui`] works as ever.
///
/// # Panics
///
/// If it is added before Bevy's `RenderPlugin`, which is among the `DefaultPlugins`.
#[derive(Clone, Copy, Debug, Default)]
pub struct SightlineInspectorPlugin;

impl Plugin for SightlineInspectorPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(SpatialIndexPlugin);
        if !app.is_plugin_added::<SightlineDiagnosticsPlugin>() {
            app.add_plugins(SightlineDiagnosticsPlugin);
        }
        app.init_resource::<SightlineInspector>()
            .init_resource::<mouse_ray::MouseRay>()
            .register_type::<SightlineInspector>()
            .add_observer(selection::select_clicked)
            .add_systems(
                PreUpdate,
                toggle
                    .after(InputSystems)
                    .run_if(resource_exists::<ButtonInput<KeyCode>>),
            )
            .add_systems(
                PreUpdate,
                mouse_ray::follow_mouse.after(PickingSystems::Backend).run_if(is_open),
            )
            .add_systems(
                Update,
                selection::mark_selected.run_if(resource_changed::<SightlineInspector>),
            );
        if can_render(app) && !app.is_plugin_added::<EguiPlugin>() {
            app.add_plugins(EguiPlugin::default());
            sleep::sleep_while_closed(app);
        }
        if app.is_plugin_added::<EguiPlugin>() {
            app.add_systems(EguiPrimaryContextPass, panel::show_panel.run_if(has_panel));
        }
    }

    fn finish(&self, app: &mut App) {
        assert!(
            !can_render(app) || app.is_plugin_added::<EguiPlugin>(),
            "SightlineInspectorPlugin was added before Bevy's RenderPlugin; it has to be added after DefaultPlugins"
        );
    }
}

fn can_render(app: &App) -> bool {
    app.is_plugin_added::<RenderPlugin>()
}

fn is_open(inspector: Res<SightlineInspector>) -> bool {
    inspector.open
}

fn has_panel(inspector: Res<SightlineInspector>) -> bool {
    inspector.open && inspector.panel
}

fn toggle(keys: Res<ButtonInput<KeyCode>>, mut inspector: ResMut<SightlineInspector>) {
    if inspector.key.is_some_and(|key| keys.just_pressed(key)) {
        inspector.open ^= true;
    }
}
