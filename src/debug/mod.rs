//! What one needs to see what the rest does.

pub mod gizmos;
