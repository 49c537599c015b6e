//! The command line.

use std::path::PathBuf;

use bevy::prelude::Resource;

use crate::{command_line::number, shared};

const HELP: &str = "\
Options of lod:
  --headless       no window: fly once around and print what both cameras show
  --blocks N       N x N blocks of houses (8: 640 houses)
  --seconds N      how long a flight around takes (32)
  --picture FILE   where to put a picture of both views, of the headless flight
  --measure N      in the window: fly around in N frames with levels, and once more with everything at the finest,
                   print the median times of frames, and quit
  --help           this text";

/// What the command line says.
#[derive(Resource, Clone, Debug)]
pub struct Options {
    pub headless: bool,
    pub blocks: u32,
    pub seconds: u32,
    pub picture: Option<PathBuf>,
    pub measure: Option<u32>,
}

impl Options {
    /// Reads the arguments; `None` if they ask for help, which has been printed.
    pub fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Option<Self>, String> {
        let mut options = Self {
            headless: !shared::has_display(),
            blocks: 8,
            seconds: 32,
            picture: None,
            measure: None,
        };
        while let Some(argument) = arguments.next() {
            let mut value = || arguments.next().ok_or(format!("{argument} needs a value\n\n{HELP}"));
            match argument.as_str() {
                "--headless" => options.headless = true,
                "--blocks" => options.blocks = number(&value()?, HELP)?,
                "--seconds" => options.seconds = number(&value()?, HELP)?,
                "--picture" => options.picture = Some(value()?.into()),
                "--measure" => options.measure = Some(number(&value()?, HELP)?),
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
