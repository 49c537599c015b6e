//! Swapping meshes.

use bevy::{
    ecs::{
        change_detection::{DetectChangesMut, Res, ResMut},
        query::{Has, Or, With},
        system::{Commands, Query},
    },
    mesh::{Mesh3d, morph::MeshMorphWeights, skinning::SkinnedMesh},
};

use super::{
    LodChoices, LodStats, LodSwapped,
    choices::LodView,
    groups::{Contents, MeshLevel},
    streaming::StreamedMeshes,
};
use crate::{
    index::{MeshSwaps, SimplifiedMesh},
    phase::phase,
};

/// Gives entities the meshes that the main camera is to show, which rays hit from then on too if they hit what is shown, and
/// triggers [`LodSwapped`] for them.
pub(super) fn swap_meshes(
    mut meshes: Query<(Option<&mut Mesh3d>, Has<SimplifiedMesh>)>,
    posed: Query<(), Or<(With<SkinnedMesh>, With<MeshMorphWeights>)>>,
    mut for_rays: MeshSwaps,
    streamed: Res<StreamedMeshes>,
    mut choices: ResMut<LodChoices>,
    mut stats: ResMut<LodStats>,
    mut commands: Commands,
) {
    let _phase = phase!("sightline/lod/choose").adds_to(&mut stats.choose);
    let LodChoices {
        groups,
        views,
        main,
        pending,
        ..
    } = choices.bypass_change_detection();
    let main = *main;
    let shown = main.and_then(|main| views.get(&LodView::Camera(main)));
    for &id in pending.ids() {
        let Some(group) = groups.get_mut(id) else {
            continue;
        };
        let level = shown.map_or(0, |shown| shown.level(id));
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
            Ok((Some(mut mesh), is_simplified)) if mesh.0 != *wanted => {
                // How it would be posed is found out by the next synchronisation.
                if !is_simplified && !posed.contains(group.root) {
                    for_rays.swap(group.root, mesh.0.id(), wanted.id());
                }
                mesh.0 = wanted.clone();
            }
            Ok((None, _)) => {
                commands.entity(group.root).try_insert(Mesh3d(wanted.clone()));
            }
            _ => {}
        }
    }
    pending.clear();
}
