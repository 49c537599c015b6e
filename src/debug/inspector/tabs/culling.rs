//! What cameras see, and why not the rest.

use std::time::Duration;

use bevy::{
    camera::visibility::{ViewVisibility, VisibilityClass},
    diagnostic::DiagnosticsStore,
    ecs::{
        change_detection::{DetectChangesMut, Res, ResMut},
        entity::Entity,
        query::With,
        system::{InMut, Local, Query},
    },
    image::Image,
};
use bevy_egui::egui::{Color32, ColorImage, ComboBox, Grid, TextureHandle, TextureOptions, Ui};
use smallvec::SmallVec;

use super::{Seldom, figures};
use crate::{
    culling::{VisibilityReason, VisibilityReasons, VisibleSet},
    debug::inspector::{
        SightlineInspector,
        census::{Census, REASONS, advice},
        link::Names,
        plot::{diagnostics, thousands},
    },
    occlusion::{OcclusionBuffer, SoftwareOcclusion},
};

/// The occlusion buffer as a picture.
#[derive(Default)]
pub(in crate::debug::inspector) struct Picture {
    image: Image,
    texture: Option<TextureHandle>,
}

pub(in crate::debug::inspector) fn show(
    InMut(ui): InMut<Ui>,
    views: Query<(Entity, &VisibleSet)>,
    occlusion: Query<&OcclusionBuffer, With<SoftwareOcclusion>>,
    all: Query<Entity, (With<ViewVisibility>, With<VisibilityClass>)>,
    reasons: VisibilityReasons,
    store: Option<Res<DiagnosticsStore>>,
    names: Names,
    mut inspector: ResMut<SightlineInspector>,
    mut census: Local<Census>,
    mut picture: Local<Seldom<Picture>>,
) {
    let mut edited = *inspector;
    let Some((view, seen)) = choose_view(ui, &views, &names, &mut edited.view) else {
        ui.weak("no camera has a VisibleSet: the app has none, or no ViewCullingPlugin");
        return;
    };
    inspector.set_if_neq(edited);
    figures(
        ui,
        "view",
        [
            ("in its list", thousands(seen.entities().len() as i64)),
            ("came into view in this frame", thousands(seen.entered().len() as i64)),
            ("went out of view", thousands(seen.left().len() as i64)),
        ],
    );
    if let Some(selected) = edited.selected
        && let Some(reason) = reasons.of(selected, view)
    {
        ui.separator();
        ui.strong(format!("Why is {} seen, or not?", names.of(selected)));
        let color = match reason {
            VisibilityReason::Visible => Color32::LIGHT_GREEN,
            _ => Color32::LIGHT_RED,
        };
        ui.colored_label(color, format!("{reason:?}"));
        ui.label(advice(reason));
    }
    ui.separator();
    ui.strong("All that can be drawn");
    match census.go_on(view, &reasons, all.iter()) {
        None => {
            ui.weak("is being counted");
        }
        Some(counts) => {
            let counts: SmallVec<[(&str, usize); REASONS.len()]> = counts.collect();
            let total = counts.iter().map(|(_, count)| count).sum::<usize>().max(1);
            Grid::new("census").num_columns(3).striped(true).show(ui, |ui| {
                for (name, count) in counts {
                    ui.label(name);
                    ui.monospace(thousands(count as i64));
                    ui.monospace(format!("{:5.1}%", 100.0 * count as f64 / total as f64));
                    ui.end_row();
                }
            });
        }
    }
    if let Ok(buffer) = occlusion.get(view) {
        show_occlusion(ui, buffer, &mut picture);
    }
    ui.separator();
    ui.strong("Each frame");
    if let Some(store) = store {
        diagnostics(ui, &store, &["culling", "occlusion"]);
    }
}

/// Has a view chosen, and tells of it; the first if the one that was chosen is gone.
pub(super) fn choose_view<'a, T>(
    ui: &mut Ui,
    views: &'a Query<(Entity, &T)>,
    names: &Names,
    chosen: &mut Option<Entity>,
) -> Option<(Entity, &'a T)>
where
    T: bevy::ecs::component::Component,
{
    let current = chosen
        .and_then(|chosen| views.get(chosen).ok())
        .or_else(|| views.iter().next())?;
    ui.horizontal(|ui| {
        ui.label("view");
        ComboBox::from_id_salt("view")
            .selected_text(names.of(current.0))
            .show_ui(ui, |ui| {
                for (view, _) in views {
                    ui.selectable_value(chosen, Some(view), names.of(view));
                }
            });
    });
    chosen.and_then(|chosen| views.get(chosen).ok()).or(Some(current))
}

fn show_occlusion(ui: &mut Ui, buffer: &OcclusionBuffer, picture: &mut Seldom<Picture>) {
    ui.separator();
    ui.strong("What hides: the nearer, the brighter");
    let context = ui.ctx().clone();
    let picture = picture.get(Duration::from_millis(250), |picture| {
        buffer.depth().write_to_image(&mut picture.image);
        let size = picture.image.size().as_usizevec2().to_array();
        let pixels = picture.image.data.as_deref().unwrap_or_default();
        // An empty buffer has no pixels.
        if size[0] * size[1] * 4 != pixels.len() || pixels.is_empty() {
            picture.texture = None;
            return;
        }
        let image = ColorImage::from_rgba_unmultiplied(size, pixels);
        match &mut picture.texture {
            Some(texture) => texture.set(image, TextureOptions::NEAREST),
            None => picture.texture = Some(context.load_texture("occlusion", image, TextureOptions::NEAREST)),
        }
    });
    if let Some(texture) = &picture.texture {
        let width = ui.available_width().min(440.0);
        let size = texture.size_vec2();
        ui.image((texture.id(), size * (width / size.x)));
    }
    let stats = buffer.stats();
    figures(
        ui,
        "occlusion",
        [
            ("occluders drawn", thousands(stats.occluders as i64)),
            ("their triangles", thousands(stats.triangles as i64)),
            ("occluders over the budget", thousands(stats.over_budget as i64)),
            ("boxes tested", thousands(stats.tested as i64)),
            ("entities passed over", thousands(stats.hidden as i64)),
        ],
    );
}
