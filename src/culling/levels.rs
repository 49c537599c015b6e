//! Levels of detail in the lists of Bevy's own culling: what is not shown is taken out afterwards.

use bevy::{
    camera::visibility::{CascadesVisibleEntities, CubemapVisibleEntities, VisibleEntities, VisibleMeshEntities},
    ecs::{
        change_detection::{DetectChangesMut, Res},
        entity::Entity,
        system::Query,
    },
};

use super::lights::LightViews;
use crate::lod::{LodChoices, LodView};

/// Takes out of the lists of cameras what they do not show. Bevy writes them anew in every frame.
pub(super) fn leave_out_of_cameras(lods: Option<Res<LodChoices>>, mut cameras: Query<(Entity, &mut VisibleEntities)>) {
    let Some(lods) = lods.filter(|lods| !lods.is_empty()) else {
        return;
    };
    for (camera, mut visible) in &mut cameras {
        for list in visible.bypass_change_detection().entities.values_mut() {
            leave_out(&lods, LodView::Camera(camera), list);
        }
    }
}

/// The same for shadow maps.
pub(super) fn leave_out_of_lights(
    lods: Option<Res<LodChoices>>,
    mut views: LightViews,
    mut cascades: Query<&mut CascadesVisibleEntities>,
    mut cubemaps: Query<&mut CubemapVisibleEntities>,
    mut spots: Query<&mut VisibleMeshEntities>,
) {
    let Some(lods) = lods.filter(|lods| !lods.is_empty()) else {
        return;
    };
    for mut visible in &mut cascades {
        for (&camera, lists) in &mut visible.bypass_change_detection().entities {
            for list in lists {
                leave_out(&lods, LodView::Shadows(camera), &mut list.entities);
            }
        }
    }
    let Some(origin) = views.lod_origin() else {
        return;
    };
    for mut visible in &mut cubemaps {
        for list in visible.bypass_change_detection().iter_mut() {
            leave_out(&lods, LodView::Shadows(origin), &mut list.entities);
        }
    }
    for mut visible in &mut spots {
        leave_out(
            &lods,
            LodView::Shadows(origin),
            &mut visible.bypass_change_detection().entities,
        );
    }
}

fn leave_out(lods: &LodChoices, view: LodView, list: &mut Vec<Entity>) {
    let levels = lods.levels_of(view);
    list.retain(|&entity| !lods.is_member(entity) || lods.shows_in(Some(levels), entity.index_u32()));
}
