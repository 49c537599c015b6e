//! Guides: how to begin, what to choose, how to come from elsewhere, and what to do when something is wrong.
//!
//! | guide | for whom |
//! |---|---|
//! | [`getting_started`] | whoever wants to know what is under the mouse, or what a ray hits, and begins now |
//! | [`choosing_a_structure`] | whoever keeps boxes or points of their own, with or without Bevy's ECS |
//! | [`servers`] | whoever has no window and no GPU: servers, tests, tools |
//! | [`migrating`] | whoever has used `MeshPickingPlugin`, bevy_mod_raycast or `VisibilityRange` |
//! | [`troubleshooting`] | whoever picks nothing, picks the wrong thing, misses something, sees levels pop, or waits |
//!
//! There is no code here. Every snippet is compiled with the tests, and those that open no window are run.

pub mod choosing_a_structure;
pub mod getting_started;
pub mod migrating;
pub mod servers;
pub mod troubleshooting;
