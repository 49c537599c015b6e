//! Choosing levels for every view, and telling of what has switched.

use bevy::{
    camera::{Camera, Camera3d, Projection, ShadowLodOrigin},
    ecs::{
        change_detection::{DetectChanges, DetectChangesMut, Res, ResMut},
        entity::{Entity, EntityHashSet},
        query::{Has, With, Without},
        system::{Commands, Local, Query},
    },
    math::Mat4,
    mesh::Mesh3d,
    time::Time,
    transform::components::GlobalTransform,
};
use tracing::warn;

use super::{
    LodBias, LodChoices, LodSettings, LodSwapped,
    choices::LodView,
    groups::{Contents, GroupId, Groups, MeshLevel},
    lens::Lens,
    place::{Change, Movements, Places},
    streaming::StreamedMeshes,
    view_levels::{Sight, ViewLevels},
};
use crate::index::{DetailLevel, NoSpatialIndex, SpatialIndex, clip_from_view};

/// Buffers, kept for their memory, and what was told.
#[derive(Default)]
pub(super) struct Memory {
    views: Vec<(LodView, Sight)>,
    warned: EntityHashSet,
    /// How often the index was synchronised.
    syncs: u64,
}

/// Chooses the levels for every view, and triggers [`LodSwapped`] for those that are entities.
pub(super) fn choose_levels(
    settings: Res<LodSettings>,
    time: Option<Res<Time>>,
    index: Res<SpatialIndex>,
    cameras: Query<(
        Entity,
        &Camera,
        &GlobalTransform,
        Option<&Projection>,
        Option<&LodBias>,
        Has<Camera3d>,
    )>,
    other_origins: Query<(Entity, &GlobalTransform), (With<ShadowLodOrigin>, Without<Camera>)>,
    movements: Movements,
    unindexed: Query<(), (With<DetailLevel>, With<NoSpatialIndex>)>,
    places: Places,
    mut choices: ResMut<LodChoices>,
    mut commands: Commands,
    mut memory: Local<Memory>,
) {
    let Memory { views, warned, syncs } = &mut *memory;
    // Whatever has bounds and has moved has moved in the index, if that was asked; and so has what is below a root.
    let is_synchronised = index.syncs() != *syncs;
    *syncs = index.syncs();
    let choices = &mut *choices;
    if choices.groups.len() == 0 && choices.pending.ids().is_empty() {
        choices.views.clear();
        return;
    }
    if index.is_changed() || !is_synchronised || !unindexed.is_empty() || choices.groups.has_loose() {
        let LodChoices { groups, pending, .. } = choices;
        movements.visit(|entity, by_itself| groups.note_movement(entity, by_itself, pending));
    }
    choices.groups.place(&mut choices.pending, &places);

    views.clear();
    choices.shadows_follow_cameras = shadow_bias(&settings) == 1.0;
    let mut main: Option<(isize, Entity)> = None;
    for (camera, view, place, projection, bias, is_3d) in &cameras {
        if !view.is_active {
            continue;
        }
        let height = view
            .physical_viewport_size()
            // Of a window that is minimised.
            .filter(|size| size.y > 0)
            .map_or(settings.viewport_height, |size| size.y as f32);
        let clip_from_view = clip_from_view(view, projection);
        let bias = bias.map_or(1.0, |bias| bias.0);
        let is_seen = look(
            LodView::Camera(camera),
            place,
            &clip_from_view,
            height,
            bias,
            &settings,
            views,
        );
        if is_seen {
            warned.remove(&camera);
        } else if warned.insert(camera) {
            warn!(
                "for the camera {camera} all is shown in full detail: its place, its projection or a bias is no good"
            );
        }
        if is_seen && is_3d && main.is_none_or(|first| (view.order, camera) < first) {
            main = Some((view.order, camera));
        }
    }
    for (origin, place) in &other_origins {
        // As if through a usual camera.
        let clip_from_view = Projection::default().get_clip_from_view();
        let height = settings.viewport_height;
        look(
            LodView::Camera(origin),
            place,
            &clip_from_view,
            height,
            1.0,
            &settings,
            views,
        );
    }
    let named = (settings.main_camera).filter(|&main| views.iter().any(|&(view, _)| view == LodView::Camera(main)));
    let main = named.or(main.map(|(_, camera)| camera));
    let has_other_main = std::mem::replace(&mut choices.main, main) != main;

    let now = time.map_or(0.0, |time| time.elapsed_secs_f64());
    let LodChoices {
        groups,
        views: levels,
        others,
        pending,
        versions,
        ..
    } = choices;
    levels.retain(|view, _| views.iter().any(|(other, _)| other == view));
    for &(view, sight) in &*views {
        let levels = levels.entry(view).or_default();
        levels.update(sight, &groups.reaches, pending.ids(), now);
        levels.list_members(groups);
        if let LodView::Camera(view) = view {
            tell(view, levels, groups, &mut commands);
        }
    }
    // Meshes are swapped for all views, and so is what is shown of none.
    let swapped: Vec<GroupId> = match main.and_then(|main| levels.get(&LodView::Camera(main))) {
        Some(levels) => levels
            .switches()
            .iter()
            .map(|switch| switch.group)
            .filter(|&id| groups.is_swapped(id))
            .collect(),
        None => Vec::new(),
    };
    others.list_members(groups);
    for levels in levels.values_mut().chain([others]) {
        levels.list_members_of(&swapped, groups);
        levels.settle(has_other_main, versions);
    }
    swapped.into_iter().for_each(|id| pending.note(id, Change::Displaced));
    if has_other_main {
        let swapped = groups.ids().filter(|&id| groups.is_swapped(id));
        swapped.for_each(|id| pending.note(id, Change::Displaced));
    }
}

/// The bias of shadow maps, if it is one.
fn shadow_bias(settings: &LodSettings) -> f32 {
    let bias = settings.shadow_bias;
    if bias > 0.0 && bias.is_finite() { bias } else { 1.0 }
}

/// Adds what a camera sees, and if that is something else what it has shadow maps see. Returns whether it sees anything.
fn look(
    view: LodView,
    place: &GlobalTransform,
    clip_from_view: &Mat4,
    viewport_height: f32,
    bias: f32,
    settings: &LodSettings,
    views: &mut Vec<(LodView, Sight)>,
) -> bool {
    let eye = place.translation();
    let stay = 1.0 + settings.hysteresis.max(0.0);
    let mut add = |view, bias| {
        let lens = Lens::new(clip_from_view, viewport_height, bias * settings.bias);
        let lens = lens.filter(|_| eye.is_finite() && stay.is_finite());
        views.extend(lens.map(|lens| {
            let dwell = settings.min_dwell.as_secs_f64();
            (view, Sight { eye, lens, stay, dwell })
        }));
        lens.is_some()
    };
    if let LodView::Camera(camera) = view
        && shadow_bias(settings) != 1.0
    {
        add(LodView::Shadows(camera), bias * shadow_bias(settings));
    }
    add(view, bias)
}

/// Tells the observers of what has switched for a camera.
fn tell(view: Entity, levels: &ViewLevels, groups: &Groups, commands: &mut Commands) {
    for switch in levels.switches() {
        if let Some(from) = switch.from
            && let Some(group) = groups.get(switch.group)
            && !groups.is_swapped(switch.group)
        {
            commands.trigger(LodSwapped {
                entity: group.root,
                view,
                from: from.into(),
                to: switch.to.into(),
            });
        }
    }
}

/// Gives entities the meshes that the main camera is to show, and triggers [`LodSwapped`] for them.
pub(super) fn swap_meshes(
    mut meshes: Query<Option<&mut Mesh3d>>,
    streamed: Res<StreamedMeshes>,
    mut choices: ResMut<LodChoices>,
    mut commands: Commands,
) {
    let choices = choices.bypass_change_detection();
    let main = choices.main;
    for &id in choices.pending.ids() {
        let levels = main.and_then(|main| choices.views.get(&LodView::Camera(main)));
        let level = levels.map_or(0, |levels| levels.level(id));
        let Some(group) = choices.groups.get_mut(id) else {
            continue;
        };
        let Contents::Meshes(levels) = &group.contents else {
            continue;
        };
        if group.applied == Some(level) {
            continue;
        }
        let wanted = match levels.get(usize::from(level)) {
            Some(MeshLevel::Mesh(mesh)) => Some(mesh),
            Some(MeshLevel::Streamed(path)) => match streamed.loaded(path) {
                Some(mesh) => Some(mesh),
                // Nothing is loaded that could stand in for it.
                None => continue,
            },
            Some(MeshLevel::Nothing) | None => None,
        };
        let before = group.applied.replace(level);
        if let (Some(from), Some(view)) = (before, main) {
            commands.trigger(LodSwapped {
                entity: group.root,
                view,
                from: from.into(),
                to: level.into(),
            });
        }
        let Some(wanted) = wanted else {
            continue;
        };
        match meshes.get_mut(group.root) {
            Ok(Some(mut mesh)) if mesh.0 != *wanted => mesh.0 = wanted.clone(),
            Ok(None) => {
                commands.entity(group.root).try_insert(Mesh3d(wanted.clone()));
            }
            _ => {}
        }
    }
    choices.pending.clear();
}
