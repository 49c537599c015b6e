//! The command line.

use bevy::prelude::Resource;

use crate::shared;

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
            match argument.as_str() {
                "--headless" => headless = true,
                "--blocks" => {
                    let number = arguments.next().and_then(|number| number.parse().ok());
                    blocks = Some(
                        number
                            .filter(|&number| number > 0)
                            .ok_or(format!("--blocks needs a number above zero\n\n{HELP}"))?,
                    );
                }
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
