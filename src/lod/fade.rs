//! Cross-fades, by the dithering of Bevy's renderer.
//!
//! Bevy's shaders dither what has a [`VisibilityRange`] by how far its origin is from the camera. While a group fades, the
//! members of both levels have one, made in each frame such that at their distance they are dithered as far as the time
//! has come. So two levels fill each other's holes, and nothing has a `VisibilityRange` that does not fade.
//!
//! There is one range for all cameras: where several look, levels switch at once.

use std::time::Duration;

use bevy::{
    camera::visibility::VisibilityRange,
    ecs::{
        change_detection::{DetectChangesMut, Res, ResMut},
        entity::Entity,
        resource::Resource,
        system::{Commands, Query},
    },
    math::Vec3,
    time::Time,
    transform::components::GlobalTransform,
};

use super::{
    LodChoices, LodSettings, LodStats,
    choices::LodView,
    groups::{GroupId, Groups},
    view_levels::{Switch, ViewLevels},
};
use crate::phase::phase;

/// More than so many entities do not fade at a time: they switch at once.
const MOST_FADING: usize = 1024;

/// The renderer's steps from nothing to all.
const STEPS: f32 = 16.0;

/// Farther than anything.
const FAR: f32 = 1e30;

/// What is fading.
#[derive(Resource, Debug, Default)]
pub(super) struct Fades {
    fades: Vec<Fade>,
}

/// A group that fades from one level to another.
#[derive(Debug)]
struct Fade {
    group: GroupId,
    root: Entity,
    view: LodView,
    /// In the time of [`Time`].
    began: Duration,
    members: Vec<(Entity, Side)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    In,
    Out,
}

/// Whether anything is to be faded, or is.
pub(super) fn fades(settings: Res<LodSettings>, fades: Res<Fades>) -> bool {
    settings.cross_fade > Duration::ZERO || !fades.fades.is_empty()
}

/// Begins and ends fades, and brings those that go on forward.
pub(super) fn cross_fade(
    settings: Res<LodSettings>,
    time: Option<Res<Time>>,
    places: Query<&GlobalTransform>,
    mut ranges: Query<&mut VisibilityRange>,
    mut choices: ResMut<LodChoices>,
    mut fades: ResMut<Fades>,
    mut stats: ResMut<LodStats>,
    mut commands: Commands,
) {
    let _phase = phase!("sightline/lod/choose").adds_to(&mut stats.choose);
    let LodChoices {
        groups,
        views,
        versions,
        ..
    } = choices.bypass_change_detection();
    let fades = &mut fades.bypass_change_detection().fades;
    let now = time.map_or(Duration::ZERO, |time| time.elapsed());
    let mut cameras = views.keys().filter(|view| matches!(view, LodView::Camera(_)));
    let only = cameras.next().filter(|_| cameras.next().is_none()).copied();
    let only = only.filter(|_| settings.cross_fade > Duration::ZERO);

    // End those that are over, or for which there is no place any more.
    let mut released = Vec::new();
    fades.retain(|fade| {
        let levels = views.get_mut(&fade.view);
        let is_there = groups.get(fade.group).is_some_and(|group| group.root == fade.root);
        let is_over = now.saturating_sub(fade.began) >= settings.cross_fade;
        let stays = |levels: &&mut ViewLevels| levels.switches().iter().all(|switch| switch.group != fade.group);
        let goes_on = is_there && !is_over && only == Some(fade.view) && levels.as_ref().is_some_and(stays);
        if !goes_on {
            released.extend(fade.members.iter().map(|&(member, _)| member));
            if let Some(levels) = levels {
                levels.end_fade(fade.group, groups, versions);
            }
        }
        goes_on
    });

    if let Some((view, levels)) = only.and_then(|view| Some((view, views.get_mut(&view)?))) {
        let is_free = |member| (!ranges.contains(member) || released.contains(&member)) && places.contains(member);
        begin(fades, groups, view, levels, now, is_free);
        if let Some(eye) = levels.eye() {
            for fade in &*fades {
                released.retain(|member| fade.members.iter().all(|(other, _)| other != member));
                let come = now.saturating_sub(fade.began).div_duration_f32(settings.cross_fade);
                dither(fade, come, eye, &places, &mut ranges, &mut commands);
            }
        }
    }
    for member in released {
        commands.entity(member).try_remove::<VisibilityRange>();
    }
}

/// Begins to fade what has switched, as far as its members are free to.
fn begin(
    fades: &mut Vec<Fade>,
    groups: &Groups,
    view: LodView,
    levels: &mut ViewLevels,
    now: Duration,
    is_free: impl Fn(Entity) -> bool,
) {
    let mut fading: usize = fades.iter().map(|fade| fade.members.len()).sum();
    let switches: Vec<Switch> = levels.switches().to_vec();
    for switch in switches {
        let (Some(from), Some(group)) = (switch.from, groups.get(switch.group)) else {
            continue;
        };
        if groups.is_swapped(switch.group) {
            continue;
        }
        let members = members(groups, levels, switch, from);
        if fading + members.len() <= MOST_FADING && members.iter().all(|&(member, _)| is_free(member)) {
            fading += members.len();
            levels.begin_fade(switch.group, from);
            fades.push(Fade {
                group: switch.group,
                root: group.root,
                view,
                began: now,
                members,
            });
        }
    }
}

/// Gives the members of a group ranges by which they are dithered as far as the fade has come.
fn dither(
    fade: &Fade,
    come: f32,
    eye: Vec3,
    places: &Query<&GlobalTransform>,
    ranges: &mut Query<&mut VisibilityRange>,
    commands: &mut Commands,
) {
    // Rounded as the renderer does, so that nothing changes in between.
    let come = (come * STEPS).round().clamp(1.0, STEPS - 1.0) / STEPS;
    for &(member, side) in &fade.members {
        let Ok(place) = places.get(member) else {
            continue;
        };
        let range = range(side, come, eye.distance(place.translation()));
        match ranges.get_mut(member) {
            Ok(mut now) => {
                now.set_if_neq(range);
            }
            Err(_) => {
                commands.entity(member).try_insert(range);
            }
        }
    }
}

/// What comes and what goes with a switch. What is at both levels stays.
fn members(groups: &Groups, levels: &ViewLevels, switch: Switch, from: u8) -> Vec<(Entity, Side)> {
    let is_shown_at = |member: Entity, level: u8| {
        groups.is_at(member.index_u32(), |id, _| {
            if id == switch.group {
                1 << level
            } else {
                levels.shown(id)
            }
        })
    };
    let mut members = Vec::new();
    groups.visit_members(
        switch.group,
        &mut |member| match (is_shown_at(member, from), is_shown_at(member, switch.to)) {
            (true, false) => members.push((member, Side::Out)),
            (false, true) => members.push((member, Side::In)),
            _ => {}
        },
    );
    members
}

/// A range by which something is dithered in or out so far at this distance.
fn range(side: Side, come: f32, distance: f32) -> VisibilityRange {
    // Not so narrow that it is lost in rounding, and never begun before the camera.
    let width = distance.max(1e-3);
    let begin = distance - come * width;
    let band = begin..begin + width;
    match side {
        Side::In => VisibilityRange {
            start_margin: band,
            end_margin: FAR..FAR,
            use_aabb: false,
        },
        Side::Out => VisibilityRange {
            start_margin: -1.0..0.0,
            end_margin: band,
            use_aabb: false,
        },
    }
}
