//! A picture of the window, and the end.

use bevy::{
    prelude::*,
    render::view::screenshot::{Screenshot, ScreenshotCaptured, save_to_disk},
};

use crate::options::Options;

/// Frames until all has been drawn.
const FRAMES: u32 = 120;

pub fn plugin(app: &mut App) {
    app.add_systems(Update, take);
}

fn take(mut commands: Commands, options: Res<Options>, mut frame: Local<u32>) {
    *frame += 1;
    if let Some(file) = options.screenshot.as_ref().filter(|_| *frame == FRAMES) {
        commands
            .spawn(Screenshot::primary_window())
            .observe(save_to_disk(file.clone()))
            .observe(|_: On<ScreenshotCaptured>, mut exit: MessageWriter<AppExit>| {
                exit.write(AppExit::Success);
            });
    }
}
