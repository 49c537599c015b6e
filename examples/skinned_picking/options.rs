//! The command line.

use std::path::PathBuf;

use bevy::prelude::Resource;

use crate::{command_line::number, shared};

const HELP: &str = "\
Options of skinned_picking:
  --headless       no window: cast rays at the foxes and print a report
  --compare        a window: hold the animations at several times, and compare the outline that is drawn with the one
                   that rays meet, pixel by pixel
  --model FILE     another glTF file with animations (assets/fox.glb)
  --foxes N        how many (5)
  --frames N       frames of the headless run (120)
  --picture FILE   where to put the headless picture (out/skinned_picking.png), or that of the comparison
  --help           this text";

/// What the example does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    Window,
    Headless,
    Compare,
}

/// What the command line says.
#[derive(Resource, Clone, Debug)]
pub struct Options {
    pub mode: Mode,
    /// In the folder of the assets, if it is relative.
    pub model: PathBuf,
    pub foxes: u32,
    pub frames: u32,
    pub picture: PathBuf,
}

impl Options {
    /// Reads the arguments; `None` if they ask for help, which has been printed.
    pub fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Option<Self>, String> {
        let mut options = Self {
            mode: Mode::Window,
            model: "fox.glb".into(),
            foxes: 5,
            frames: 120,
            picture: "out/skinned_picking.png".into(),
        };
        while let Some(argument) = arguments.next() {
            let mut value = || arguments.next().ok_or(format!("{argument} needs a value\n\n{HELP}"));
            match argument.as_str() {
                "--headless" => options.mode = Mode::Headless,
                "--compare" => options.mode = Mode::Compare,
                "--model" => {
                    let file = value()?;
                    options.model = std::path::absolute(&file).map_err(|error| format!("{file}: {error}"))?;
                }
                "--foxes" => options.foxes = number(&value()?, HELP)?,
                "--frames" => options.frames = number(&value()?, HELP)?,
                "--picture" => options.picture = value()?.into(),
                "--help" | "-h" => {
                    println!("{HELP}");
                    return Ok(None);
                }
                other => return Err(format!("unknown option {other}\n\n{HELP}")),
            }
        }
        if options.mode == Mode::Window && !shared::has_display() {
            options.mode = Mode::Headless;
        }
        Ok(Some(options))
    }
}
