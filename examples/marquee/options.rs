//! The command line.

use bevy::prelude::Resource;

use crate::{command_line::number, shared};

const HELP: &str = "\
Options of marquee:
  --headless       no window: draw a box and a lasso, and check what they select
  --blocks N       N x N blocks of houses (16, or 4 without a window)
  --help           this text";

/// What the command line says.
#[derive(Resource, Clone, Debug)]
pub struct Options {
    pub headless: bool,
    pub blocks: u32,
}

impl Options {
    /// Reads the arguments; `None` if they ask for help, which has been printed.
    pub fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Option<Self>, String> {
        let mut headless = !shared::has_display();
        let mut blocks = None;
        while let Some(argument) = arguments.next() {
            let mut value = || arguments.next().ok_or(format!("{argument} needs a value\n\n{HELP}"));
            match argument.as_str() {
                "--headless" => headless = true,
                "--blocks" => blocks = Some(number(&value()?, HELP)?),
                "--help" | "-h" => {
                    println!("{HELP}");
                    return Ok(None);
                }
                other => return Err(format!("unknown option {other}\n\n{HELP}")),
            }
        }
        Ok(Some(Self {
            headless,
            // The check asks every triangle.
            blocks: blocks.unwrap_or(if headless { 4 } else { 16 }),
        }))
    }
}
