//! A picture of the window, with one thing selected and another under the mouse.

use bevy::{
    prelude::*,
    render::view::screenshot::{Screenshot, save_to_disk},
};
use bevy_sightline::prelude::*;

use crate::{
    blocks::ProxiesAreUp,
    options::Options,
    pointer::{self, Step},
};

/// Frames before the picture, in which the renderer makes its pipelines and the figures are told, and after it, in
/// which it is written.
const BEFORE: usize = 30;
const AFTER: usize = 10;

/// Clicks on one tower and comes to rest on another.
pub fn select_and_hover() -> impl Iterator<Item = Step> {
    let (tower, other_tower) = (Vec2::new(0.195, 0.55), Vec2::new(0.68, 0.5));
    pointer::click(tower).into_iter().chain([(other_tower, None); 2])
}

pub fn plugin(app: &mut App) {
    let is_complete = |proxies: Res<ProxiesAreUp>, occluders: Option<Res<Occluders>>| {
        proxies.0 && occluders.is_none_or(|occluders| occluders.making() == 0)
    };
    app.add_systems(Last, play.run_if(is_complete));
}

/// One frame of the script.
fn play(world: &mut World, mut frame: Local<usize>) {
    let steps = select_and_hover().count();
    let step = select_and_hover().nth(*frame).or(select_and_hover().last());
    if let Some(step) = step {
        pointer::act(world, step);
    }
    if *frame == steps + BEFORE
        && let Some(file) = world.resource::<Options>().screenshot.clone()
    {
        world.spawn(Screenshot::primary_window()).observe(save_to_disk(file));
    }
    if *frame == steps + BEFORE + AFTER {
        world.write_message(AppExit::Success);
    }
    *frame += 1;
}
