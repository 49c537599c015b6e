//! The command line.

use std::path::PathBuf;

use bevy::prelude::Resource;

const HELP: &str = "\
Options of the city:
  --headless       no window: sweep a synthetic pointer and print a report
  --blocks N       N x N blocks of houses (16: 17,000 things)
  --frames N       frames of the headless sweep (600)
  --report FILE    write the report as JSON too
  --picture FILE   where to put the headless picture (out/city.png)
  --help           this text";

/// What the command line says.
#[derive(Resource, Clone, Debug)]
pub struct Options {
    pub headless: bool,
    pub blocks: u32,
    pub frames: u32,
    pub report: Option<PathBuf>,
    pub picture: PathBuf,
}

impl Options {
    /// Reads the arguments; `None` if they ask for help, which has been printed.
    pub fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Option<Self>, String> {
        let mut options = Self {
            headless: !has_display(),
            blocks: 16,
            frames: 600,
            report: None,
            picture: "out/city.png".into(),
        };
        while let Some(argument) = arguments.next() {
            let mut value = || arguments.next().ok_or(format!("{argument} needs a value\n\n{HELP}"));
            match argument.as_str() {
                "--headless" => options.headless = true,
                "--blocks" => options.blocks = number(&value()?)?,
                "--frames" => options.frames = number(&value()?)?,
                "--report" => options.report = Some(value()?.into()),
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

fn number(text: &str) -> Result<u32, String> {
    match text.parse() {
        Ok(number) if number > 0 => Ok(number),
        _ => Err(format!("{text} is not a number above zero\n\n{HELP}")),
    }
}

/// Whether a window could be opened: elsewhere than on Linux and its kin there always is a display.
fn has_display() -> bool {
    let needs_server = cfg!(all(
        unix,
        not(any(target_os = "macos", target_os = "ios", target_os = "android"))
    ));
    !needs_server
        || ["DISPLAY", "WAYLAND_DISPLAY"]
            .iter()
            .any(|name| std::env::var_os(name).is_some())
}
