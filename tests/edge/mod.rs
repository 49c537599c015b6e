//! What surrounds the plugins in a game: other plugins, tools, scenes, states, other worlds.

#[cfg(feature = "gizmos")]
mod diagnostics;
#[cfg(feature = "gizmos")]
mod spans;
mod stats;
