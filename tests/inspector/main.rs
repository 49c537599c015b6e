//! The inspector, without a window.

#[path = "../common/mod.rs"]
#[expect(dead_code, reason = "it is for all tests")]
mod common;
mod culling;
mod index;
mod lod;
mod opening;
mod panel;
mod query;
#[path = "../readme/inspector.rs"]
#[rustfmt::skip]
#[expect(dead_code, reason = "that it compiles is what it is for")]
mod readme_inspector;
mod settings;
mod sleep;
mod structures;
