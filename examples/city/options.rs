//! The command line.

use std::path::PathBuf;

use bevy::prelude::Resource;

use crate::{command_line::number, shared};

const HELP: &str = "\
Options of the city:
  --headless      no window: check everything with a synthetic pointer, and print a report
  --entities N    about so many things, from 1000 to 1000000 (17000)
  --plain         on Bevy's built-ins alone, for comparison
  --report        no window: fly through the city with bevy_sightline and with Bevy's built-ins, frame by frame in
                  turn, and print how long each stage takes
  --frames N      frames of the headless sweep, or of the flight (600)
  --json FILE     write what is reported as JSON too
  --picture FILE  where to put the headless picture (out/city.png)
  --help          this text";

/// The things in a block, and in a street along the whole city, roughly.
const IN_BLOCK: f32 = 64.0;
const IN_STREET: f32 = 44.0;

/// What the command line says.
#[derive(Resource, Clone, Debug)]
pub struct Options {
    pub headless: bool,
    pub plain: bool,
    pub report: bool,
    /// Along each side.
    pub blocks: u32,
    pub frames: u32,
    pub json: Option<PathBuf>,
    pub picture: PathBuf,
}

impl Options {
    /// Reads the arguments; `None` if they ask for help, which has been printed.
    pub fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Option<Self>, String> {
        let mut options = Self {
            headless: !shared::has_display(),
            plain: false,
            report: false,
            blocks: blocks_of(17_000),
            frames: 600,
            json: None,
            picture: "out/city.png".into(),
        };
        while let Some(argument) = arguments.next() {
            let mut value = || arguments.next().ok_or(format!("{argument} needs a value\n\n{HELP}"));
            match argument.as_str() {
                "--headless" => options.headless = true,
                "--entities" => match number(&value()?, HELP)? {
                    entities @ 1_000..=1_000_000 => options.blocks = blocks_of(entities),
                    other => return Err(format!("{other} is not between 1000 and 1000000\n\n{HELP}")),
                },
                "--plain" => options.plain = true,
                "--report" => options.report = true,
                "--frames" => options.frames = number(&value()?, HELP)?,
                "--json" => options.json = Some(value()?.into()),
                "--picture" => options.picture = value()?.into(),
                "--help" | "-h" => {
                    println!("{HELP}");
                    return Ok(None);
                }
                other => return Err(format!("unknown option {other}\n\n{HELP}")),
            }
        }
        options.headless |= options.report;
        Ok(Some(options))
    }
}

/// How many blocks along each side have about so many things, with a street more than blocks.
fn blocks_of(entities: u32) -> u32 {
    let others = entities as f32 - IN_STREET;
    let blocks = ((IN_STREET * IN_STREET + 4.0 * IN_BLOCK * others).sqrt() - IN_STREET) / (2.0 * IN_BLOCK);
    blocks.round().max(2.0) as u32
}
