//! The command line.

use bevy::prelude::Resource;

use crate::{command_line::number, shared};

const HELP: &str = "\
Options of structures:
  --headless     no window: compare all structures, and print figures
  --boxes N      so many boxes (240)
  --seed N       other boxes (1)
  --rays N       rays of the headless comparison (1000)
  --structure N  begin with structure N: 1 tree, 2 grid, 3 k-d tree, 4 octree, 5 list
  --three-d      begin in three dimensions
  --step N       begin after N visits
  --help         this text";

/// What the command line says.
#[derive(Resource, Clone, Debug)]
pub struct Options {
    pub headless: bool,
    pub boxes: u32,
    pub seed: u32,
    pub rays: u32,
    pub structure: usize,
    pub three_d: bool,
    pub step: usize,
}

impl Options {
    /// Reads the arguments; `None` if they ask for help, which has been printed.
    pub fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Option<Self>, String> {
        let mut options = Self {
            headless: !shared::has_display(),
            boxes: 240,
            seed: 1,
            rays: 1000,
            structure: 1,
            three_d: false,
            step: 0,
        };
        while let Some(argument) = arguments.next() {
            let mut value = || arguments.next().ok_or(format!("{argument} needs a value\n\n{HELP}"));
            match argument.as_str() {
                "--headless" => options.headless = true,
                "--boxes" => options.boxes = number(&value()?, HELP)?,
                "--seed" => options.seed = number(&value()?, HELP)?,
                "--rays" => options.rays = number(&value()?, HELP)?,
                "--structure" => options.structure = number(&value()?, HELP)? as usize,
                "--three-d" => options.three_d = true,
                "--step" => options.step = number(&value()?, HELP)? as usize,
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
