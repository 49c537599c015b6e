//! The command line.

use std::path::PathBuf;

use bevy::prelude::Resource;

use crate::shared;

const HELP: &str = "\
Options of auto_proxy:
  --headless       no window: make the levels and print them
  --model FILE     another glTF file (assets/statue.glb)
  --edges          begin with the edges of the triangles drawn
  --picture FILE   where to put the headless picture (out/auto_proxy.png)
  --help           this text";

/// What the command line says.
#[derive(Resource, Clone, Debug)]
pub struct Options {
    pub headless: bool,
    /// In the folder of the assets, if it is relative.
    pub model: PathBuf,
    pub edges: bool,
    pub picture: PathBuf,
}

impl Options {
    /// Reads the arguments; `None` if they ask for help, which has been printed.
    pub fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Option<Self>, String> {
        let mut options = Self {
            headless: !shared::has_display(),
            model: "statue.glb".into(),
            edges: false,
            picture: "out/auto_proxy.png".into(),
        };
        while let Some(argument) = arguments.next() {
            let mut value = || arguments.next().ok_or(format!("{argument} needs a value\n\n{HELP}"));
            match argument.as_str() {
                "--headless" => options.headless = true,
                "--edges" => options.edges = true,
                "--model" => {
                    let file = value()?;
                    options.model = std::path::absolute(&file).map_err(|error| format!("{file}: {error}"))?;
                }
                "--picture" => options.picture = value()?.into(),
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
