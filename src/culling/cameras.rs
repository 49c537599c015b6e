//! What cameras see.

use std::any::TypeId;

use bevy::{
    camera::{
        Camera, Projection,
        primitives::Frustum,
        visibility::{NoCpuCulling, RenderLayers, VisibleEntities, VisibleEntityRanges},
    },
    ecs::{
        change_detection::{DetectChanges, DetectChangesMut, Mut, Res, ResMut},
        entity::{Entities, Entity, EntityHashSet},
        query::Has,
        system::{Commands, Local, Query},
    },
    transform::components::GlobalTransform,
};
use tracing::warn;

use super::{
    EnteredView, LeftView, ReportViewChanges, ViewCulling, ViewCullingStats, ViewKey, VisibleSet,
    candidates::{Candidates, ClassId, Record},
    marks::ViewVisibilities,
    shape::{ViewKind, ViewShape},
    sorted::amend,
    view::{Bounds, Change, Layers, Request, Sights, View, come, gone, look},
};
use crate::{
    index::{SpatialIndex, clip_from_view},
    lod::{LodChoices, LodView},
    occlusion::{Occluders, OcclusionBuffer, SoftwareOcclusion, Viewpoint},
    phase::phase,
};

/// A camera that looks in this frame.
#[derive(Debug)]
pub(super) struct Looking {
    camera: Entity,
    request: Request,
    view: View,
}

/// Finds what is in the sight of every active camera, before anything is written of it.
pub(super) fn find_visible(
    cameras: Query<(
        Entity,
        &VisibleEntities,
        &Frustum,
        Option<&RenderLayers>,
        &Camera,
        Has<NoCpuCulling>,
        Option<(&SoftwareOcclusion, &GlobalTransform, Option<&Projection>)>,
    )>,
    mut occlusion_buffers: Query<&mut OcclusionBuffer>,
    occluders: Option<Res<Occluders>>,
    lods: Option<Res<LodChoices>>,
    mut warned: Local<EntityHashSet>,
    index: Res<SpatialIndex>,
    bounds: Bounds,
    layers: Layers,
    mut visibilities: ViewVisibilities,
    mut culling: ResMut<ViewCulling>,
    mut stats: ResMut<ViewCullingStats>,
) {
    let phase = phase!("sightline/culling/find");
    let ViewCulling {
        candidates,
        views,
        marks,
        looking,
        index_is_current,
        turnover,
        ..
    } = &mut *culling;
    // What was found and never written.
    for Looking { camera, view, .. } in looking.drain(..) {
        views.insert(ViewKey::Camera(camera), view);
    }
    for (camera, _, frustum, layers, settings, sees_everywhere, occlusion) in &cameras {
        if settings.is_active {
            let viewpoint = occlusion.and_then(|(occlusion, place, projection)| {
                let clip_from_view = clip_from_view(settings, projection);
                let viewpoint =
                    Viewpoint::new(*occlusion, clip_from_view, place.to_matrix(), settings.invert_culling);
                if viewpoint.is_some() {
                    warned.remove(&camera);
                } else if warned.insert(camera) {
                    warn!(
                        "to the camera {camera} nothing is hidden: depth is not reversed, its near plane is very oblique, \
                         or its place is NaN or infinite"
                    );
                }
                viewpoint
            });
            let mut view = views.remove(&ViewKey::Camera(camera)).unwrap_or_default();
            if let Ok(mut buffer) = occlusion_buffers.get_mut(camera) {
                std::mem::swap(&mut view.occlusion, buffer.bypass_change_detection());
            }
            looking.push(Looking {
                camera,
                request: Request {
                    viewpoint,
                    viewer: camera,
                    shape: ViewShape::new(frustum, ViewKind::Camera),
                    layers: layers.unwrap_or_default().clone(),
                    audience: Record::FOR_CAMERAS,
                    sees_everywhere,
                    range_origin: Some(camera),
                    levels: Some(LodView::Camera(camera)),
                },
                view,
            });
        }
    }

    let sights = Sights {
        index: &index,
        index_is_current: *index_is_current,
        has_changed: index.is_changed() || !candidates.changed.is_empty(),
        candidates,
        bounds: &bounds,
        layers: &layers,
        occluders: occluders.as_deref(),
        lods: lods.as_deref(),
    };
    let mut pairs: Vec<_> = looking
        .iter_mut()
        .map(|looking| (&looking.request, &mut looking.view))
        .collect();
    // What is in which range is not known yet.
    look(&mut pairs, sights, |_, _| None);

    stats.views = looking.len();
    for looking in &mut *looking {
        stats.tested += looking.view.tested();
        if let Ok(mut buffer) = occlusion_buffers.get_mut(looking.camera) {
            let mut occlusion = std::mem::take(&mut looking.view.occlusion);
            if looking.request.viewpoint.is_some() {
                stats.occlusion += *occlusion.stats();
                let is_new = occlusion.take_new();
                *buffer.bypass_change_detection() = occlusion;
                if is_new {
                    buffer.set_changed();
                }
            } else if occlusion.is_drawn() {
                buffer.set_changed();
            }
        }
        turnover.count(&mut looking.view, Record::FOR_CAMERAS, candidates);
    }
    views.retain(|key, view| {
        let is_left = matches!(key, ViewKey::Camera(_));
        if is_left {
            turnover.drop_view(view, Record::FOR_CAMERAS, candidates);
        }
        !is_left
    });
    for entity in turnover.lost.drain(..) {
        marks.set_back(entity, &mut visibilities);
    }
    marks.set_back_shadows(candidates, &mut visibilities);
    for looking in &*looking {
        for &number in &looking.view.undecided {
            if looking.view.seen.contains(number) {
                marks.set_back(candidates.record(number).entity, &mut visibilities);
            }
        }
    }
    stats.find += phase.end();
}

/// Writes what cameras see to where Bevy has it.
pub(super) fn write_visible(
    mut cameras: Query<(&mut VisibleEntities, Option<&mut VisibleSet>, Has<ReportViewChanges>)>,
    ranges: Option<Res<VisibleEntityRanges>>,
    mut visibilities: ViewVisibilities,
    mut culling: ResMut<ViewCulling>,
    mut stats: ResMut<ViewCullingStats>,
    entities: &Entities,
    mut commands: Commands,
    mut lists: Local<Lists>,
) {
    let phase = phase!("sightline/culling/write");
    let ViewCulling {
        candidates,
        views,
        marks,
        looking,
        turnover,
        ..
    } = &mut *culling;
    for Looking { camera, mut view, .. } in looking.drain(..) {
        // Not drained, but kept for its memory.
        let undecided = std::mem::take(&mut view.undecided);
        for &number in &undecided {
            let entity = candidates.record(number).entity;
            let is_in_range = |ranges: &VisibleEntityRanges| ranges.entity_is_in_range_of_view(entity, camera);
            view.note(number, ranges.as_deref().is_none_or(is_in_range), candidates);
        }
        view.undecided = undecided;
        turnover.count(&mut view, Record::FOR_CAMERAS, candidates);
        view.changes.sort_unstable_by_key(|change| change.entity);
        stats.visible += view.seen_len();
        stats.entered += come(&view.changes).count();
        stats.left += gone(&view.changes).count();
        if let Ok((mut visible, set, reports)) = cameras.get_mut(camera) {
            if let Some(mut set) = set {
                VisibleSet::write(set.reborrow(), &view, candidates, &mut lists.buffer);
                if reports {
                    report(camera, &set, entities, &mut commands);
                }
            }
            lists.write(&mut view, candidates, &mut visible);
        }
        views.insert(ViewKey::Camera(camera), view);
    }
    // What was undecided has been set back, and may have been marked by others since.
    turnover.lost.clear();
    let appeared = turnover.appeared.drain(..);
    marks.mark(appeared, Record::FOR_CAMERAS, candidates, &mut visibilities);
    stats.write = phase.end();
}

/// Tells the observers of what has come into view and gone out of it.
fn report(view: Entity, set: &VisibleSet, entities: &Entities, commands: &mut Commands) {
    for &entity in set.entered() {
        commands.trigger(EnteredView { entity, view });
    }
    for &entity in set.left().iter().filter(|&&entity| entities.contains(entity)) {
        commands.trigger(LeftView { entity, view });
    }
}

/// Buffers for the lists of cameras, kept for their memory.
#[derive(Debug, Default)]
pub(super) struct Lists {
    changes: Vec<Change>,
    classes: Vec<TypeId>,
    buffer: Vec<Entity>,
}

impl Lists {
    /// Brings the lists of a camera up to date, each in ascending order.
    fn write(&mut self, view: &mut View, candidates: &Candidates, visible: &mut Mut<VisibleEntities>) {
        // Whoever has touched the lists has spoilt them, and a camera that was given new ones has nothing in them.
        let all: &[Change] = if view.written == Some(visible.last_changed()) {
            &view.changes
        } else {
            visible.clear_all();
            view.list_all(candidates, &mut self.changes);
            &self.changes
        };
        self.classes.clear();
        let mut last = None;
        for change in all {
            if last.replace((change.from, change.to)) == Some((change.from, change.to)) {
                continue;
            }
            for &class in candidates
                .classes(change.from)
                .iter()
                .chain(candidates.classes(change.to))
            {
                if !self.classes.contains(&class) {
                    self.classes.push(class);
                }
            }
        }
        for &class in &self.classes {
            let times = |id: ClassId| candidates.classes(id).iter().filter(|&&other| other == class).count();
            let removed = all.iter().filter(|change| times(change.from) > 0);
            let added = all
                .iter()
                .flat_map(|change| std::iter::repeat_n(change.entity, times(change.to)));
            amend(
                visible.get_mut(class),
                removed.map(|change| change.entity),
                added,
                &mut self.buffer,
            );
        }
        // As Bevy has it, which writes all lists anew.
        visible.set_changed();
        view.written = Some(visible.last_changed());
    }
}
