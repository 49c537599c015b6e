//! What the command lines of the examples have in common.

use bevy::app::AppExit;

use crate::shared::script;

/// What the arguments of the program say, or how it is to end if they ask for help, which has been printed, or cannot be
/// read.
pub fn read<T>(parse: impl FnOnce(std::vec::IntoIter<String>) -> Result<Option<T>, String>) -> Result<T, AppExit> {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    if let Some(at) = arguments.iter().position(|argument| argument == script::OPTION) {
        arguments.drain(at..arguments.len().min(at + 2));
    }
    match parse(arguments.into_iter()) {
        Ok(Some(options)) => Ok(options),
        Ok(None) => {
            println!("{}", script::HELP);
            Err(AppExit::Success)
        }
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
