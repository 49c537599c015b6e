//! The command line.

use std::path::PathBuf;

use bevy::prelude::Resource;

use crate::{command_line::number, shared};

const HELP: &str = "\
Options of gizmos:
  --headless      no window: draw each kind for itself, and print figures
  --blocks N      N x N blocks of houses (8: 4,300 things)
  --limit N       the most lines of each kind (12000)
  --pictures DIR  where to put a picture of each kind in the headless run
  --help          this text";

/// What the command line says.
#[derive(Resource, Clone, Debug)]
pub struct Options {
    pub headless: bool,
    pub blocks: u32,
    pub limit: u32,
    pub pictures: Option<PathBuf>,
}

impl Options {
    /// Reads the arguments; `None` if they ask for help, which has been printed.
    pub fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Option<Self>, String> {
        let mut options = Self {
            headless: !shared::has_display(),
            blocks: 8,
            limit: 12_000,
            pictures: None,
        };
        while let Some(argument) = arguments.next() {
            let mut value = || arguments.next().ok_or(format!("{argument} needs a value\n\n{HELP}"));
            match argument.as_str() {
                "--headless" => options.headless = true,
                "--blocks" => options.blocks = number(&value()?, HELP)?,
                "--limit" => options.limit = number(&value()?, HELP)?,
                "--pictures" => options.pictures = Some(value()?.into()),
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
