//! Egui, which sleeps while the panel is closed: awake it takes more of a frame than all else here.

use bevy::{
    app::{App, First, PostUpdate, PreUpdate},
    ecs::{
        change_detection::{Res, ResMut},
        resource::Resource,
        schedule::IntoScheduleConfigs,
    },
};
use bevy_egui::{EguiPostUpdateSet, EguiPreUpdateSet};

use super::SightlineInspector;

/// How many frames egui goes on after the panel was closed: until nothing of it is drawn, and it wants no input.
const LINGER: u8 = 3;

/// For how many frames egui is awake yet, with this one.
#[derive(Resource, Debug, Default)]
struct Awake(u8);

/// Has egui sleep while the panel is closed, if nobody else uses it.
pub(super) fn sleep_while_closed(app: &mut App) {
    use {EguiPostUpdateSet as Post, EguiPreUpdateSet as Pre};
    app.init_resource::<Awake>()
        // Once for all of a frame: a pass that has begun is ended.
        .add_systems(First, stay_awake)
        .configure_sets(
            PreUpdate,
            (Pre::InitContexts, Pre::ProcessInput, Pre::BeginPass).run_if(is_awake),
        )
        .configure_sets(
            PostUpdate,
            (Post::EndPass, Post::ProcessOutput, Post::PostProcessOutput).run_if(is_awake),
        );
}

fn stay_awake(inspector: Res<SightlineInspector>, mut awake: ResMut<Awake>) {
    awake.0 = if inspector.open {
        LINGER
    } else {
        awake.0.saturating_sub(1)
    };
}

fn is_awake(awake: Res<Awake>) -> bool {
    awake.0 > 0
}
