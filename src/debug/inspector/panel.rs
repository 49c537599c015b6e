//! The panel, and what is in it whatever the tab.

use bevy::{
    ecs::change_detection::DetectChangesMut,
    ecs::{
        query::{QueryState, With},
        system::{InMut, IntoSystem},
        world::{Mut, World},
    },
};
use bevy_egui::{
    EguiContext, PrimaryEguiContext,
    egui::{Align2, CollapsingHeader, Color32, ScrollArea, Ui, Window, vec2},
};

use super::{
    InspectorTab, SightlineInspector,
    settings::{edit_components, edit_settings},
    tabs,
};

/// How far the panel is from the edges of the window at first, in points.
const MARGIN: f32 = 12.0;

/// Shows the panel on the camera that egui draws to.
pub(super) fn show_panel(world: &mut World, contexts: &mut QueryState<&mut EguiContext, With<PrimaryEguiContext>>) {
    let Ok(mut context) = contexts.single_mut(world) else {
        return;
    };
    let context = context.get_mut().clone();
    let mut is_open = true;
    Window::new("Sightline")
        .open(&mut is_open)
        .pivot(Align2::RIGHT_TOP)
        .default_pos(context.content_rect().right_top() + vec2(-MARGIN, MARGIN))
        .default_size([460.0, 640.0])
        .show(&context, |ui| inspector_ui(ui, world));
    if !is_open {
        world.resource_mut::<SightlineInspector>().open = false;
    }
}

/// Shows the tabs of the inspector: for a window of your own. Needs
/// [`SightlineInspectorPlugin`](super::SightlineInspectorPlugin), and shows nothing without it.
pub fn inspector_ui(ui: &mut Ui, world: &mut World) {
    let Some(mut inspector) = world.get_resource_mut::<SightlineInspector>() else {
        return;
    };
    let tab = choose_tab(ui, &mut inspector);
    ui.separator();
    ScrollArea::vertical().auto_shrink(false).id_salt(tab).show(ui, |ui| {
        match tab {
            InspectorTab::Index => run(ui, world, tabs::index::show),
            InspectorTab::Query => run(ui, world, tabs::query::show),
            InspectorTab::Culling => run(ui, world, tabs::culling::show),
            InspectorTab::Lod => run(ui, world, tabs::lod::show),
            InspectorTab::Structures => run(ui, world, tabs::structures::show),
        }
        ui.separator();
        CollapsingHeader::new("Settings").show(ui, |ui| {
            // What cannot run was said by the tab.
            let _ = world.run_system_cached_with(edit_settings, (ui, modules_of(tab)));
        });
        CollapsingHeader::new("Selected entity")
            .default_open(true)
            .show(ui, |ui| run(ui, world, show_selected));
    });
}

fn choose_tab(ui: &mut Ui, inspector: &mut Mut<SightlineInspector>) -> InspectorTab {
    let mut chosen = **inspector;
    ui.horizontal(|ui| {
        for tab in InspectorTab::ALL {
            ui.selectable_value(&mut chosen.tab, tab, tab.title());
        }
    });
    inspector.set_if_neq(chosen);
    chosen.tab
}

/// Runs a part of the panel as a system; one that cannot run, as a plugin that it tells of is missing, says so.
pub(super) fn run<M, S: IntoSystem<InMut<'static, Ui>, (), M> + 'static>(ui: &mut Ui, world: &mut World, part: S) {
    if let Err(error) = world.run_system_cached_with(part, ui) {
        ui.colored_label(
            Color32::LIGHT_RED,
            format!("this needs a plugin that is missing: {error}"),
        );
    }
}

/// The modules of this crate whose settings a tab has.
const fn modules_of(tab: InspectorTab) -> &'static [&'static str] {
    match tab {
        InspectorTab::Index => &["index", "sprite"],
        InspectorTab::Query => &["picking", "selection"],
        InspectorTab::Culling => &["culling", "occlusion"],
        InspectorTab::Lod => &["lod"],
        InspectorTab::Structures => &["debug"],
    }
}

fn show_selected(InMut(ui): InMut<Ui>, world: &mut World) {
    let selected = world.resource::<SightlineInspector>().selected;
    let Some(selected) = selected else {
        ui.weak("none: click on something in the scene, or on a name above");
        return;
    };
    run(ui, world, tabs::selected::show);
    let _ = world.run_system_cached_with(edit_components, (ui, selected));
}
