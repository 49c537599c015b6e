//! The command line.

use std::path::PathBuf;

use bevy::prelude::Resource;

use crate::{command_line::number, shared};

const HELP: &str = "\
Options of occlusion:
  --headless       no window: walk one round with occlusion and one without, and print figures
  --blocks N       N x N blocks of houses (16: 28,000 things)
  --frames N       frames of the headless round (240)
  --picture FILE   where to put a picture from above of the last frame of the headless round
  --help           this text";

/// What the command line says.
#[derive(Resource, Clone, Debug)]
pub struct Options {
    pub headless: bool,
    pub blocks: u32,
    pub frames: u32,
    pub picture: Option<PathBuf>,
}

impl Options {
    /// Reads the arguments; `None` if they ask for help, which has been printed.
    pub fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Option<Self>, String> {
        let mut options = Self {
            headless: !shared::has_display(),
            blocks: 16,
            frames: 240,
            picture: None,
        };
        while let Some(argument) = arguments.next() {
            let mut value = || arguments.next().ok_or(format!("{argument} needs a value\n\n{HELP}"));
            match argument.as_str() {
                "--headless" => options.headless = true,
                "--blocks" => options.blocks = number(&value()?, HELP)?,
                "--frames" => options.frames = number(&value()?, HELP)?,
                "--picture" => options.picture = Some(value()?.into()),
                "--help" | "-h" => {
                    println!("{HELP}");
                    return Ok(None);
                }
                other => return Err(format!("unknown option {other}\n\n{HELP}")),
            }
        }
        Ok(Some(options))
    }
}
