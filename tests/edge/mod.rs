//! What surrounds the plugins in a game: other plugins, tools, scenes, states, other worlds.

#[cfg(feature = "gizmos")]
mod diagnostics;
mod fixed;
mod pausing;
#[cfg(feature = "gizmos")]
mod plugins;
mod reflection;
mod scenes;
#[cfg(feature = "gizmos")]
mod spans;
mod stats;
mod worlds;
