//! The command line.

use std::path::PathBuf;

use bevy::prelude::Resource;

use crate::{command_line::number, shared};

const HELP: &str = "\
Options of line_of_sight:
  --headless       no window: let guards and thief walk, and print who saw how much
  --frames N       frames of the headless run (900, half a minute)
  --picture FILE   draw a picture of the headless run
  --help           this text";

/// What the command line says.
#[derive(Resource, Clone, Debug)]
pub struct Options {
    pub headless: bool,
    pub frames: u32,
    pub picture: Option<PathBuf>,
}

impl Options {
    /// Reads the arguments; `None` if they ask for help, which has been printed.
    pub fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Option<Self>, String> {
        let mut options = Self {
            headless: !shared::has_display(),
            frames: 900,
            picture: None,
        };
        while let Some(argument) = arguments.next() {
            let mut value = || arguments.next().ok_or(format!("{argument} needs a value\n\n{HELP}"));
            match argument.as_str() {
                "--headless" => options.headless = true,
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
