//! What the command lines of the examples have in common.

use bevy::app::AppExit;

/// What the arguments of the program say, or how it is to end if they ask for help, which has been printed, or cannot be
/// read.
pub fn read<T>(parse: impl FnOnce(std::iter::Skip<std::env::Args>) -> Result<Option<T>, String>) -> Result<T, AppExit> {
    match parse(std::env::args().skip(1)) {
        Ok(Some(options)) => Ok(options),
        Ok(None) => Err(AppExit::Success),
        Err(message) => {
            eprintln!("{message}");
            Err(AppExit::error())
        }
    }
}

/// A number above zero; if it is none, says so above the help.
pub fn number(text: &str, help: &str) -> Result<u32, String> {
    match text.parse() {
        Ok(number) if number > 0 => Ok(number),
        _ => Err(format!("{text} is not a number above zero\n\n{help}")),
    }
}
