//! What one needs to see what the rest does.

pub mod diagnostics;
#[cfg(feature = "gizmos")]
pub mod gizmos;
#[cfg(feature = "inspector")]
pub mod inspector;
